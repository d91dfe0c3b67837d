use glam::DVec2;

use super::*;
use crate::glint::texels::{Block, Pyramid, Tails};

/// What the pyramid says about a block holds for every point under it.
#[test]
fn blocks_hold_their_slopes() {
    let glints = glints(&maps::spikes(19, 0.5), 0.1);
    for (k, level) in glints.pyramid().levels().iter().enumerate() {
        let (columns, side) = (level.size().0, 2usize << k);
        for (b, block) in level.blocks().iter().enumerate() {
            let (x, y) = (b % columns * side, b / columns * side);
            let (w, h) = ((x + side).min(19) - x, (y + side).min(19) - y);
            let n = 8;
            let (mut sum, mut squares) = (DVec2::ZERO, [0.0; 3]);
            for i in 0..w * n {
                for j in 0..h * n {
                    let at = DVec2::new(x as f64, y as f64) + (DVec2::new(i as f64, j as f64) + 0.5) / n as f64;
                    let s = glints.slopes().at(at).0;
                    let (min, max) = (block.min.as_dvec2(), block.max.as_dvec2());
                    assert!(s.cmpge(min - 1e-12).all() && s.cmple(max + 1e-12).all(), "{s} in {block:?}");
                    sum += s;
                    squares = [squares[0] + s.x * s.x, squares[1] + s.x * s.y, squares[2] + s.y * s.y];
                }
            }
            let count = (w * h * n * n) as f64;
            let mean = sum / count;
            assert!((mean - block.mean.as_dvec2()).length() < 1e-6);
            for (i, product) in [mean.x * mean.x, mean.x * mean.y, mean.y * mean.y].into_iter().enumerate() {
                let cov = squares[i] / count - product;
                // Midpoints of n parts miss 1 / n^2 of the variance within a cell.
                assert!((cov - f64::from(block.cov[i])).abs() < 2e-3, "{cov} {block:?}");
            }
        }
    }
}

#[test]
fn levels_halve_and_round_up_and_planes_follow() {
    let glints = glints(&maps::spikes(13, 0.3), 0.1);
    let sizes: Vec<_> = glints.pyramid().levels().iter().map(|l| l.size()).collect();
    assert_eq!(sizes, [(7, 7), (4, 4), (2, 2), (1, 1)]);
    let cells = Pyramid::cells(glints.slopes());
    assert_eq!(cells.size(), (13, 13));
    let (planes, Block { max, cov, alpha, .. }) = (cells.planes(), cells.blocks()[13 * 5 + 7]);
    assert_eq!([planes[[3, 5, 7]], planes[[8, 5, 7]], planes[[10, 5, 7]]], [max.y, cov[2], alpha[1]]);
    let slopes = glints.slopes().planes();
    assert_eq!(slopes.dim(), (3, 13, 13));
    assert_eq!(f64::from(slopes[[1, 5, 7]]), glints.slopes().at(DVec2::new(7.0, 5.0)).0.y);
}

/// Blocks that are left out have nothing in reach.
#[test]
fn pruning_changes_nothing() {
    // Of noise there is little to leave out: any two texels have slopes on all sides of h between them.
    for (name, map, share) in [
        ("bumps", maps::bumps(64, 0.2), 0.5),
        ("spikes", maps::spikes(61, 0.3), 0.99),
        ("scratches", maps::scratches(64, 0.3), 0.55),
    ] {
        let glints = glints(&map, 0.01).with_tails(Tails::Cut(12.0));
        let (mut all, mut few) = (Visits::default(), Visits::default());
        for k in 0..60 {
            let r = |i| maps::noise(11, k, i);
            let h = half_vector(0.35 * (2.0 * DVec2::new(r(0), r(1)) - 1.0));
            let j = jacobian((0.5 + 12.0 * r(2), 0.5 + 12.0 * r(3)), 3.0 * r(4), glints.slopes().size());
            let footprint = glints.footprint(DVec2::new(r(5), r(6)), j).unwrap();
            let on = Ways { moments: false, ..Ways::BEST };
            let (full, a) = ask(&glints, &footprint, h, Ways { prune: false, ..on });
            let (pruned, f) = ask(&glints, &footprint, h, on);
            assert!((full - pruned).abs() <= 1e-12 * full, "{name}: {full} {pruned}");
            (all, few) = (add(all, a), add(few, f));
        }
        println!("{name}: texels {} of {}", few.texels, all.texels);
        assert!((few.texels as f64) < share * all.texels as f64, "{name} {few:?} {all:?}");
        assert!(few.closed + few.points > 0);
    }
}

/// What is lost with the tails is what lies beyond the cut.
#[test]
fn cut_tails_are_a_bound() {
    let map = maps::spikes(64, 0.3);
    let whole = glints(&map, 0.02);
    let cut = whole.clone().with_tails(Tails::Cut(10.0));
    let (mut most, mut lost) = (0.0f64, 0.0f64);
    for k in 0..100 {
        let h = half_vector(0.3 * (2.0 * DVec2::new(maps::noise(1, k, 0), maps::noise(2, k, 0)) - 1.0));
        let j = jacobian((6.0, 6.0), 0.0, (64, 64));
        let footprint = whole.footprint(DVec2::splat(0.3), j).unwrap();
        let (a, b) = (ask(&whole, &footprint, h, Ways::BEST).0, ask(&cut, &footprint, h, Ways::BEST).0);
        assert!(b <= a * (1.0 + 1e-9));
        (most, lost) = (most.max(a), lost.max(a - b));
    }
    let peak = 1.0 / (std::f64::consts::PI * 0.02f64.powi(2));
    println!("lost {:.1e} of the peak of one lobe, {:.1e} of the highest", lost / peak, lost / most);
    assert!(lost < 1.2e-4 * peak);
}

fn add(mut a: Visits, b: Visits) -> Visits {
    a += b;
    a
}
