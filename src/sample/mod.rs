//! The project's own materials, made by code: each shows one kind of lost normal variance.
//!
//! A sample depends on its size and seed alone. Only additions, multiplications, divisions and square roots are
//! used, which IEEE 754 rounds alike everywhere, so the bytes are the same on every machine.

mod brushed;
mod cloth;
mod flakes;
mod hammered;
mod maps;
mod noise;
mod relief;
mod scratched;
mod tiles;

pub use maps::Maps;

/// A material that can be made at any size.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// What the command line calls it: lower case, words joined by hyphens.
    pub name: &'static str,
    /// What it is and what it shows, in one line.
    pub about: &'static str,
    /// Makes the maps, `size` x `size` texels. Features are fixed parts of the texture's side, so another size is
    /// the same surface at another resolution; they are well resolved from 256 up.
    pub make: fn(size: usize, seed: u64) -> Maps,
}

/// Every sample.
pub const SAMPLES: &[Sample] =
    &[brushed::SAMPLE, scratched::SAMPLE, hammered::SAMPLE, tiles::SAMPLE, cloth::SAMPLE, flakes::SAMPLE];

/// The sample of this name.
pub fn by_name(name: &str) -> Option<&'static Sample> {
    SAMPLES.iter().find(|sample| sample.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Raster, Samples, Size};
    use glam::Vec3;

    const SIDE: usize = 256;

    fn normal(raster: &Raster, x: usize, y: usize) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|c| 2.0 * raster.at(x, y, c) - 1.0))
    }

    #[test]
    fn are_found_by_name() {
        for sample in SAMPLES {
            assert_eq!(by_name(sample.name).map(|found| found.about), Some(sample.about));
        }
        assert!(by_name("unobtainium").is_none());
    }

    #[test]
    fn depend_on_size_and_seed_alone() {
        for sample in SAMPLES {
            let maps = (sample.make)(64, 7);
            assert_eq!(maps, (sample.make)(64, 7), "{}", sample.name);
            assert_ne!(maps.normal, (sample.make)(64, 8).normal, "{}", sample.name);
            for size in [1, 2, 3, 100] {
                let maps = (sample.make)(size, 7);
                assert_eq!(maps.normal.size(), Size::new(size, size));
                assert_eq!(maps.orm.size(), Size::new(size, size));
            }
        }
    }

    /// FNV-1a of all bytes: a machine that computes others, or a material that was changed, fails here.
    #[test]
    fn are_the_same_bytes_on_every_machine() {
        let mut hash = 0xCBF2_9CE4_8422_2325u64;
        for maps in SAMPLES.iter().map(|sample| (sample.make)(64, 1)) {
            for raster in [&maps.normal, &maps.orm] {
                let Samples::U8(bytes) = &raster.samples else { panic!("8-bit") };
                hash = bytes.iter().fold(hash, |hash, &b| (hash ^ u64::from(b)).wrapping_mul(0x100_0000_01B3));
            }
        }
        assert_eq!(hash, 0xEF7D_B440_F31F_A9FB);
    }

    /// The normals change across the border no more than between some two neighbouring columns (rows) inside.
    #[test]
    fn tile_without_a_seam() {
        for sample in SAMPLES {
            let maps = (sample.make)(SIDE, 1);
            let jump = |i: usize, columns: bool| -> f32 {
                let next = (i + 1) % SIDE;
                let jumps = (0..SIDE).map(|j| {
                    let (a, b) = if columns { ((i, j), (next, j)) } else { ((j, i), (j, next)) };
                    (normal(&maps.normal, a.0, a.1) - normal(&maps.normal, b.0, b.1)).length()
                });
                jumps.sum::<f32>() / SIDE as f32
            };
            for columns in [true, false] {
                let inside = (0..SIDE - 1).map(|i| jump(i, columns)).fold(0.0, f32::max);
                let seam = jump(SIDE - 1, columns);
                assert!(seam <= inside, "{}: {seam} across the border, at most {inside} inside", sample.name);
            }
        }
    }

    #[test]
    fn normals_are_unit_and_slopes_are_moderate() {
        for sample in SAMPLES {
            let maps = (sample.make)(SIDE, 1);
            let (mut slope2, mut roughest, mut smoothest) = (0.0, 0.0f32, 1.0f32);
            for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
                let n = normal(&maps.normal, x, y);
                assert!((n.length() - 1.0).abs() < 0.008 && n.z > 0.2, "{} {n}", sample.name);
                slope2 += f64::from((n.x * n.x + n.y * n.y) / (n.z * n.z));
                let roughness = maps.orm.at(x, y, 1);
                (roughest, smoothest) = (roughest.max(roughness), smoothest.min(roughness));
            }
            let rms = (slope2 / (SIDE * SIDE) as f64).sqrt();
            assert!((0.1..0.6).contains(&rms), "{}: slopes of {rms} rms", sample.name);
            assert!((0.1..0.45).contains(&smoothest), "{}: smoothest {smoothest}", sample.name);
            assert!(roughest - smoothest > 0.08, "{}: roughness {smoothest} to {roughest}", sample.name);
        }
    }
}
