//! Texture look-ups as graphics hardware does them: bilinear, trilinear, anisotropic, repeating.

use glam::{Vec2, Vec3};

use crate::image::{Size, Wrap};
use crate::ndf::{Lobe, Lobes, RoughnessTensor};

/// How mips are looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// One probe at the level whose texels have the area of the pixel's footprint.
    #[default]
    Trilinear,
    /// Several trilinear probes along the longer axis of the footprint, at the level that fits the shorter one: the
    /// scheme of OpenGL's `EXT_texture_filter_anisotropic`.
    Anisotropic {
        /// The most probes; a footprint longer than so many times its width takes a coarser level. 0 counts as 1.
        taps: usize,
    },
}

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
        lobe(self.trilinear(uv, footprint * (self.levels[0].size.texels() as f32).sqrt()))
    }

    /// The mean of up to `taps` trilinear probes, for a pixel over which `uv` changes by `steps`, right and up.
    pub fn anisotropic(&self, uv: Vec2, steps: [Vec2; 2], taps: usize) -> Lobe {
        let Size { width, height } = self.levels[0].size;
        let size = Vec2::new(width as f32, height as f32);
        // Axes of the ellipse inscribed in the footprint, in texels: J J^T for the Jacobian J = [a b].
        let [a, b] = steps.map(|step| step * size);
        let (xx, xy, yy) = (a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
        let (mean, spread) = (0.5 * (xx + yy), (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt());
        let (long, short) = ((mean + spread).sqrt(), (mean - spread).max(0.0).sqrt());
        // Texels that are larger than the footprint need one probe.
        let most = (taps.max(1) as f32).min(long.ceil().max(1.0));
        let count = (long / short.max(f32::MIN_POSITIVE)).ceil().clamp(1.0, most);
        let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
        let axis = long * Vec2::new(cos, sin) / size;
        let mut sum: Texel = [0.0; 6];
        for k in 0..count as usize {
            let along = (k as f32 + 0.5) / count - 0.5;
            let probe = self.trilinear(uv + along * axis, long / count);
            sum.iter_mut().zip(probe).for_each(|(sum, probe)| *sum += probe / count);
        }
        lobe(sum)
    }

    /// At the level whose texels are `texels` of level 0 wide.
    fn trilinear(&self, uv: Vec2, texels: f32) -> Texel {
        let level = texels.log2().clamp(0.0, (self.levels.len() - 1) as f32);
        let (fine, t) = (level as usize, level.fract());
        let near = self.levels[fine].bilinear(uv);
        if t == 0.0 { near } else { lerp(near, self.levels[fine + 1].bilinear(uv), t) }
    }

    /// Texels of level 0.
    pub fn size(&self) -> Size {
        self.levels[0].size
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

    /// A footprint of 4 texels by 1, along u, along v, and aslant, over a ramp that repeats.
    #[test]
    fn anisotropic_probes_worked_by_hand() {
        let size = Size::new(16, 16);
        let texel = |x: usize, y: usize| Lobe::isotropic(Vec3::Z, Alpha::from_squared((x * x + 100 * y) as f32));
        let level = |k| {
            Lobes::from_fn(
                Form::Isotropic,
                size.level(k),
                if k == 0 { texel } else { |_, _| Lobe::isotropic(Vec3::Z, Alpha(9.0)) },
            )
        };
        let texture = Texture::new(&[level(0), level(1), level(2)]);
        // The middle of texels 7 and 8, row 4 from the top.
        let (uv, step) = (Vec2::new(8.0, 11.5) / 16.0, 1.0 / 16.0);
        let at = |right: Vec2, up: Vec2, taps| texture.anisotropic(uv, [right * step, up * step], taps).roughness.xx;
        // Probes in the middles of texels 6, 7, 8 and 9.
        let along_u = (36.0 + 49.0 + 64.0 + 81.0) / 4.0 + 400.0;
        assert!((at(4.0 * Vec2::X, Vec2::Y, 16) - along_u).abs() < 1e-2);
        assert!((at(Vec2::Y, -4.0 * Vec2::X, 4) - along_u).abs() < 1e-2);
        // Up: the same column, between rows: a linear ramp keeps its middle.
        let along_v = (49.0 + 64.0) / 2.0 + 400.0;
        assert!((at(Vec2::X, 4.0 * Vec2::Y, 16) - along_v).abs() < 1e-2);
        // A square footprint and a single probe are trilinear: 2 texels wide is level 1, of alpha 9.
        assert!((at(2.0 * Vec2::X, 2.0 * Vec2::Y, 16) - 81.0).abs() < 1e-3);
        assert_eq!(at(4.0 * Vec2::X, Vec2::Y, 1), texture.mipped(uv, 4.0 * step).roughness.xx);
        assert_eq!(at(4.0 * Vec2::X, Vec2::Y, 0), at(4.0 * Vec2::X, Vec2::Y, 1));
        // 4 by 1 with two probes: half as long each, so level 1.
        assert!((at(4.0 * Vec2::X, Vec2::Y, 2) - 81.0).abs() < 1e-3);
        // Aslant, and smaller than a texel.
        let diagonal = Vec2::splat(0.5f32.sqrt());
        let aslant = at(4.0 * diagonal, Vec2::new(-1.0, 1.0) * 0.5f32.sqrt(), 16);
        let other = at(4.0 * Vec2::new(-diagonal.x, diagonal.y), diagonal, 16);
        assert!((aslant - 456.5).abs() < 3.0 && (other - 456.5).abs() < 3.0, "{aslant} {other}");
        assert_eq!(at(1e-3 * Vec2::X, 1e-4 * Vec2::Y, 16), texture.base(uv).roughness.xx);
        assert!(at(Vec2::ZERO, Vec2::ZERO, 16).is_finite());
    }
}
