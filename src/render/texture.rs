//! Texture look-ups as graphics hardware does them: bilinear, trilinear, repeating.

use glam::{Vec2, Vec3};

use crate::image::{Size, Wrap};
use crate::ndf::{Lobe, Lobes, RoughnessTensor};

/// Normal x y z, then R.xx R.xy R.yy.
type Texel = [f32; 6];

/// One level, texels side by side in memory.
struct Level {
    size: Size,
    texels: Vec<Texel>,
}

/// A mip chain ready to be looked up.
pub(super) struct Texture {
    levels: Vec<Level>,
}

fn lerp(a: Texel, b: Texel, t: f32) -> Texel {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

impl Level {
    fn new(lobes: &Lobes) -> Self {
        let size = lobes.size();
        let texel = |i: usize| {
            let Lobe { normal: n, roughness: r } = lobes.at(i % size.width, i / size.width);
            [n.x, n.y, n.z, r.xx, r.xy, r.yy]
        };
        Self { size, texels: (0..size.texels()).map(texel).collect() }
    }

    /// The four nearest texels, by distance.
    fn bilinear(&self, uv: Vec2) -> Texel {
        let Size { width, height } = self.size;
        // v points up, rows down.
        let place = Vec2::new(uv.x, 1.0 - uv.y) * Vec2::new(width as f32, height as f32) - 0.5;
        let (corner, t) = (place.floor(), place - place.floor());
        let index = |i: f32, n: usize| {
            let i = Wrap::Repeat.index(i as isize, n);
            (i, if i + 1 == n { 0 } else { i + 1 })
        };
        let ((x0, x1), (y0, y1)) = (index(corner.x, width), index(corner.y, height));
        let at = |x: usize, y: usize| self.texels[y * width + x];
        lerp(lerp(at(x0, y0), at(x1, y0), t.x), lerp(at(x0, y1), at(x1, y1), t.x), t.y)
    }
}

/// Normals and tensors are averaged apart; the normal is made unit again, as every shader does.
fn lobe([x, y, z, xx, xy, yy]: Texel) -> Lobe {
    Lobe { normal: Vec3::new(x, y, z).normalize_or(Vec3::Z), roughness: RoughnessTensor { xx, xy, yy } }
}

impl Texture {
    /// Level 0 first; at least one level.
    pub fn new(levels: &[Lobes]) -> Self {
        assert!(!levels.is_empty(), "a chain has at least one level");
        Self { levels: levels.iter().map(Level::new).collect() }
    }

    /// Level 0, bilinear.
    pub fn base(&self, uv: Vec2) -> Lobe {
        lobe(self.levels[0].bilinear(uv))
    }

    /// Trilinear, at the level whose texels have the area of a square `footprint` wide in texture coordinates.
    pub fn mipped(&self, uv: Vec2, footprint: f32) -> Lobe {
        let texels = footprint * (self.levels[0].size.texels() as f32).sqrt();
        let level = texels.log2().clamp(0.0, (self.levels.len() - 1) as f32);
        let (fine, t) = (level as usize, level.fract());
        let near = self.levels[fine].bilinear(uv);
        if t == 0.0 {
            return lobe(near);
        }
        lobe(lerp(near, self.levels[fine + 1].bilinear(uv), t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf::Form;
    use crate::roughness::Alpha;

    /// Levels of 4x2 and 2x1 and 1x1 texels, told apart by their width.
    fn chain() -> Vec<Lobes> {
        let level = |width, height, base: f32| {
            Lobes::from_fn(Form::Isotropic, Size::new(width, height), |x, y| {
                Lobe::isotropic(Vec3::Z, Alpha::from_squared(base + 0.1 * x as f32 + 0.01 * y as f32))
            })
        };
        vec![level(4, 2, 0.0), level(2, 1, 1.0), level(1, 1, 2.0)]
    }

    #[test]
    fn bilinear_worked_by_hand() {
        let texture = Texture::new(&chain());
        let at = |u, v| texture.base(Vec2::new(u, v)).roughness.xx;
        // Centres of the texels in column 1 of the top and the bottom row.
        assert!((at(0.375, 0.75) - 0.1).abs() < 1e-6 && (at(0.375, 0.25) - 0.11).abs() < 1e-6);
        // The middle of four texels, and the border, where columns 3 and 0 meet.
        assert!((at(0.5, 0.5) - 0.155).abs() < 1e-6);
        assert!((at(0.0, 0.75) - 0.15).abs() < 1e-6 && (at(-3.0, 0.75) - 0.15).abs() < 1e-6);
    }

    #[test]
    fn levels_follow_the_footprint() {
        let texture = Texture::new(&chain());
        let at = |footprint| texture.mipped(Vec2::new(0.25, 0.75), footprint).roughness.xx;
        let texel = 1.0 / 8f32.sqrt();
        assert!((at(texel) - 0.05).abs() < 1e-6 && (at(0.1 * texel) - 0.05).abs() < 1e-6);
        assert!((at(2.0 * texel) - 1.0).abs() < 1e-5);
        assert!((at(2f32.sqrt() * texel) - 0.525).abs() < 1e-5);
        assert!((at(1e9) - 2.0).abs() < 1e-6);
    }
}
