//! Random numbers, smooth noise and scattered cells, all from integer hashes and all periodic.

/// A stream of random numbers in single precision.
pub(super) struct Random(crate::random::Random);

impl Random {
    /// Streams of one seed are independent of each other.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(crate::random::Random::new(seed, stream))
    }

    /// Uniform in `low..high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.0.bits() >> 40) as f32 / (1u64 << 24) as f32)
    }

    /// Nearly Gaussian, mean 0, variance 1: a sum of uniforms, for the logarithm of the usual ways is not rounded
    /// alike everywhere.
    pub fn bell(&mut self) -> f32 {
        (0..12).map(|_| self.between(-0.5, 0.5)).sum()
    }

    /// Uniform on the unit circle, by rejection.
    pub fn direction(&mut self) -> [f32; 2] {
        loop {
            let (x, y) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let length2 = x * x + y * y;
            if (0.01..=1.0).contains(&length2) {
                let length = length2.sqrt();
                return [x / length, y / length];
            }
        }
    }
}

/// The lattice point or cell that position `x` (in cells) lies in, wrapped, and the place in it, 0 to 1.
fn split(x: f32, cells: usize) -> (usize, f32) {
    let floor = x.floor();
    ((floor as isize).rem_euclid(cells as isize) as usize, x - floor)
}

/// Value noise on a periodic lattice: smooth, -1 to 1.
pub(super) struct Noise {
    cells: [usize; 2],
    values: Vec<f32>,
}

impl Noise {
    /// Cells along u and v; more along one axis make streaks along the other.
    pub fn new(seed: u64, stream: u64, cells: [usize; 2]) -> Self {
        let mut random = Random::new(seed, stream);
        Self { cells, values: (0..cells[0] * cells[1]).map(|_| random.between(-1.0, 1.0)).collect() }
    }

    /// The noise at texture coordinates.
    pub fn at(&self, [u, v]: [f32; 2]) -> f32 {
        let [columns, rows] = self.cells;
        let (x, s) = split(u * columns as f32, columns);
        let (y, t) = split(v * rows as f32, rows);
        let fade = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let value = |x: usize, y: usize| self.values[y % rows * columns + x % columns];
        let (s, t) = (fade(s), fade(t));
        lerp(lerp(value(x, y), value(x + 1, y), s), lerp(value(x, y + 1), value(x + 1, y + 1), s), t)
    }
}

/// Random points, one in each cell of a periodic square grid.
pub(super) struct Points {
    cells: usize,
    places: Vec<[f32; 2]>,
}

/// The nearest of [`Points`].
pub(super) struct Nearest {
    /// Which point.
    pub index: usize,
    /// Squared distance to it, in cells.
    pub first: f32,
    /// Squared distance to the second nearest, in cells.
    pub second: f32,
}

impl Points {
    /// `cells` x `cells` points.
    pub fn new(seed: u64, stream: u64, cells: usize) -> Self {
        let mut random = Random::new(seed, stream);
        let places = (0..cells * cells).map(|_| [random.between(0.0, 1.0), random.between(0.0, 1.0)]).collect();
        Self { cells, places }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// The two nearest points: the first is at most sqrt(2) cells away, so two rings of cells hold it.
    pub fn nearest(&self, [u, v]: [f32; 2]) -> Nearest {
        let cells = self.cells;
        let (x, s) = split(u * cells as f32, cells);
        let (y, t) = split(v * cells as f32, cells);
        let mut nearest = Nearest { index: 0, first: f32::MAX, second: f32::MAX };
        for (i, j) in (0..5).flat_map(|j| (0..5).map(move |i| (i, j))) {
            // Offset by a whole period, so that nothing is below zero.
            let index = (y + 2 * cells - 2 + j) % cells * cells + (x + 2 * cells - 2 + i) % cells;
            let [px, py] = self.places[index];
            let (dx, dy) = (px + i as f32 - 2.0 - s, py + j as f32 - 2.0 - t);
            let distance2 = dx * dx + dy * dy;
            if distance2 < nearest.first {
                nearest = Nearest { index, first: distance2, second: nearest.first };
            } else if distance2 < nearest.second {
                nearest.second = distance2;
            }
        }
        nearest
    }
}
