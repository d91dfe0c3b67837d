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
        ("bumps", 0.02, [[55, 124, 91, 78], [1000, 739, 213, 1356], [7374, 6137, 1461, 10229]]),
        ("bumps", 0.1, [[55, 124, 62, 76], [972, 783, 68, 1402], [5299, 3003, 92, 7909]]),
        ("scratches", 0.02, [[55, 124, 338, 214], [1012, 962, 460, 1758], [12281, 15611, 7452, 22146]]),
        ("scratches", 0.1, [[55, 124, 238, 220], [942, 833, 245, 1569], [10958, 11163, 1650, 21408]]),
        ("spikes", 0.02, [[55, 124, 483, 426], [1460, 2510, 1037, 3903], [16643, 34812, 12843, 41237]]),
        ("spikes", 0.1, [[55, 124, 505, 339], [1086, 1561, 679, 3018], [14756, 28961, 7852, 42895]]),
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
