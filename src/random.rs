//! Seeded random numbers and evenly spread ones.

/// The finaliser of SplitMix64 (Steele et al. 2014).
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A stream of random numbers (SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Streams of one seed are independent of each other.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(mix(seed.wrapping_add(mix(stream.wrapping_add(0x9E37_79B9_7F4A_7C15)))))
    }

    /// A stream for one texel of a level and one of the purposes that it needs numbers for.
    pub fn for_texel(seed: u64, purpose: u64, level: usize, (x, y): (usize, usize)) -> Self {
        let stream = [level as u64, y as u64, x as u64].iter().fold(purpose, |stream, v| mix(stream ^ mix(*v)));
        Self::new(seed, stream)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        mix(self.0)
    }

    /// Uniform in 0..1.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Points that fill the unit cube of four dimensions evenly, shifted by a random amount: each alone is uniform (Roberts
/// 2018, the powers of 1/g with `g^5 = g + 1`).
#[derive(Clone, Debug)]
pub struct Spread {
    shift: [f64; 4],
    count: u32,
}

impl Spread {
    /// A sequence of its own for each state of `random`.
    pub fn new(random: &mut Random) -> Self {
        Self { shift: std::array::from_fn(|_| random.uniform()), count: 0 }
    }

    /// The next point.
    pub fn point(&mut self) -> [f64; 4] {
        const G: f64 = 1.167_303_978_261_418_6;
        self.count += 1;
        std::array::from_fn(|i| (self.shift[i] + f64::from(self.count) * G.powi(-(i as i32) - 1)).fract())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fill_every_cell_of_a_grid() {
        let mut spread = Spread::new(&mut Random::new(1, 2));
        let mut cells = [0; 81];
        for _ in 0..81 * 16 {
            let cell = spread.point().iter().fold(0, |cell, u| 3 * cell + (u * 3.0) as usize);
            cells[cell] += 1;
        }
        // Independent points would make this 80 on average, with a standard deviation of 13.
        let chi2: f64 = cells.iter().map(|n| (f64::from(*n) - 16.0).powi(2) / 16.0).sum();
        assert!(chi2 < 60.0, "{chi2}");
        let g = 1.167_303_978_261_418_6_f64;
        assert!((g.powi(5) - g - 1.0).abs() < 1e-14);
    }
}
