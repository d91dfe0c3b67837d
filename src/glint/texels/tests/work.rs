//! What queries visit: the tables of the documentation.

use super::*;

/// Mean visits of a query at half vectors all over the slopes of a map.
fn visits(glints: &TexelGlints, width: f64, reach: f64) -> [usize; 4] {
    let j = jacobian((width, width), 0.4, glints.slopes().size());
    let count = 8;
    let mut all = Visits::default();
    for k in 0..count as i64 {
        let r = |i| maps::noise(41, k, i);
        let h = half_vector(reach * (2.0 * DVec2::new(r(0), r(1)) - 1.0));
        all += glints.ndf_counted(DVec2::new(r(2), r(3)), j, h).1;
    }
    [all.nodes, all.texels, all.closed, all.points].map(|n| n / count)
}

#[test]
fn queries_visit_what_is_said() {
    // Blocks, cells, closed forms (four triangles each), points; as the documentation of `texels` has them, rounded.
    let table: [(&str, f32, [[usize; 4]; 3]); 6] = [
        ("bumps", 0.02, [[55, 124, 91, 78], [994, 739, 219, 1356], [7278, 6060, 1485, 10070]]),
        ("bumps", 0.1, [[55, 124, 62, 76], [963, 709, 68, 1319], [5207, 2857, 110, 7676]]),
        ("scratches", 0.02, [[55, 124, 338, 214], [1007, 948, 466, 1736], [12256, 15556, 7477, 22110]]),
        ("scratches", 0.1, [[55, 124, 238, 220], [929, 806, 257, 1546], [10770, 10979, 1768, 21188]]),
        ("spikes", 0.02, [[55, 124, 483, 426], [1454, 2484, 1033, 3865], [16615, 34739, 12860, 40976]]),
        ("spikes", 0.1, [[55, 124, 505, 339], [1073, 1542, 676, 3001], [14651, 28798, 8124, 42862]]),
    ];
    for (name, alpha, expected) in table {
        let (map, reach) = match name {
            "bumps" => (maps::bumps(256, 0.2), 0.2),
            "scratches" => (maps::scratches(256, 0.3), 0.2),
            _ => (maps::spikes(256, 0.3), 0.3),
        };
        let glints = glints(&map, alpha);
        for (width, most) in [4.0, 16.0, 64.0].into_iter().zip(expected) {
            let found = visits(&glints, width, reach);
            println!("{name:9} {alpha:4} {width:4}: {found:?}");
            for (found, most) in found.into_iter().zip(most) {
                assert!(found <= most + most / 5 + 10, "{name} alpha {alpha} width {width}: {found} for {most}");
            }
        }
    }
}
