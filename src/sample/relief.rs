//! A periodic height field and its normals.

use glam::Vec3;

use super::maps::uv;

/// Heights at texel centres, in units of the texture's side, so that slopes do not depend on the resolution.
pub(super) struct Relief {
    size: usize,
    heights: Vec<f32>,
}

impl Relief {
    /// Asks `height` for texture coordinates.
    pub fn from_fn(size: usize, height: impl Fn([f32; 2]) -> f32) -> Self {
        let heights = (0..size * size).map(|i| height(uv(size, i % size, i / size))).collect();
        Self { size, heights }
    }

    /// Keeps the lower of the height and `height` at the texel that column and row wrap round to.
    pub fn lower(&mut self, x: isize, y: isize, height: f32) {
        let side = self.size as isize;
        let old = &mut self.heights[(y.rem_euclid(side) * side + x.rem_euclid(side)) as usize];
        *old = old.min(height);
    }

    /// Height of a texel.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        self.heights[y * self.size + x]
    }

    /// Slopes along u and v (up), by central differences across the border.
    fn slopes(&self, x: usize, y: usize) -> [f32; 2] {
        let (n, scale) = (self.size, 0.5 * self.size as f32);
        let (left, right) = (self.at((x + n - 1) % n, y), self.at((x + 1) % n, y));
        let (above, below) = (self.at(x, (y + n - 1) % n), self.at(x, (y + 1) % n));
        [(right - left) * scale, (above - below) * scale]
    }

    /// Heights scaled so that the slopes' length has this root mean square; a flat relief stays flat.
    pub fn with_slopes(mut self, rms: f32) -> Self {
        let mut sum = 0.0;
        for (y, x) in (0..self.size).flat_map(|y| (0..self.size).map(move |x| (y, x))) {
            sum += self.slopes(x, y).iter().map(|&s| f64::from(s * s)).sum::<f64>();
        }
        if sum > 0.0 {
            let scale = rms / (sum / self.heights.len() as f64).sqrt() as f32;
            self.heights.iter_mut().for_each(|h| *h *= scale);
        }
        self
    }

    /// Unit normal of a texel.
    pub fn normal(&self, x: usize, y: usize) -> Vec3 {
        let [sx, sy] = self.slopes(x, y);
        Vec3::new(-sx, -sy, 1.0).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_up_the_texture_tilts_the_normal_down() {
        // A ramp along v, away from the border: its normal leans towards -y.
        let relief = Relief::from_fn(8, |[_, v]| 0.5 * v);
        let n = relief.normal(4, 4);
        assert!((n - Vec3::new(0.0, -0.5, 1.0).normalize()).length() < 1e-6, "{n}");
    }

    #[test]
    fn slopes_are_scaled_to_their_root_mean_square() {
        let relief = Relief::from_fn(16, |[u, v]| (u - 0.5) * (u - 0.5) + 0.3 * v * (1.0 - v)).with_slopes(0.25);
        let squares = (0..256).map(|i| relief.slopes(i % 16, i / 16)).map(|[a, b]| a * a + b * b);
        assert!(((squares.sum::<f32>() / 256.0).sqrt() - 0.25).abs() < 1e-5);
    }
}
