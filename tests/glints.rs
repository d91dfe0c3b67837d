//! The library's glints beside published methods, at the same queries.
#![allow(clippy::print_stdout)]

#[path = "glints/figures.rs"]
mod known;
#[path = "glints/measure.rs"]
mod measure;
#[path = "glints/published/mod.rs"]
mod published;

use measure::{Figures, figures};
use published::Contender;
use published::cases::Case;

#[test]
fn table() {
    for c in Contender::all() {
        for anisotropy in [1.0, 8.0] {
            for n_eff in [0.1, 1.0, 10.0] {
                let f =
                    figures(&c, Case { n_eff, anisotropy }, std::env::var("N").map_or(20000, |n| n.parse().unwrap()));
                println!(
                    "{:22} {anisotropy} {n_eff:4} mean {:.3}±{:.3} V {:.3}±{:.3} pan {:.3}/{:.3} zoom {:.3}/{:.3} turn {:.3}/{:.3} nb {:.3} mir {:.3}",
                    c.name,
                    f.mean[0],
                    f.mean[1],
                    f.variance[0],
                    f.variance[1],
                    f.pan.rare,
                    f.pan.most,
                    f.zoom.rare,
                    f.zoom.most,
                    f.turn.rare,
                    f.turn.most,
                    f.neighbour,
                    f.mirrored
                );
            }
        }
    }
}
