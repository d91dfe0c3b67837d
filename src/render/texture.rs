//! Texture look-ups as graphics hardware does them: bilinear, trilinear, anisotropic, repeating.

use glam::{Vec2, Vec3};
use ndarray::{Array3, Axis};

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

/// One lobe of a texel: normal x y z, then R.xx R.xy R.yy, then the weight.
type Texel = [f32; 7];

/// One level of pictures of `N` channels, the pictures of a texel and then texels side by side in memory.
struct Level<const N: usize> {
    size: Size,
    count: usize,
    texels: Vec<[f32; N]>,
}

/// Pictures ready to be looked up, `count` of them side by side.
struct Mips<const N: usize> {
    levels: Vec<Level<N>>,
    count: usize,
}

/// A mip chain ready to be looked up. Lobe `j` of a texel is mixed with lobe `j` of the others, as if each had textures of
/// its own.
pub(super) struct Texture(Mips<7>);

/// Mip maps of pairs of numbers, ready to be looked up.
pub struct Pairs(Mips<2>);

fn lerp<const N: usize>(a: [f32; N], b: [f32; N], t: f32) -> [f32; N] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

impl<const N: usize> Level<N> {
    /// Picture `j` of the four nearest texels, by distance.
    fn bilinear(&self, uv: Vec2, j: usize) -> [f32; N] {
        let Size { width, height } = self.size;
        // v points up, rows down.
        let place = Vec2::new(uv.x, 1.0 - uv.y) * Vec2::new(width as f32, height as f32) - 0.5;
        let (corner, t) = (place.floor(), place - place.floor());
        let index = |i: f32, n: usize| {
            let i = Wrap::Repeat.index(i as isize, n);
            (i, if i + 1 == n { 0 } else { i + 1 })
        };
        let ((x0, x1), (y0, y1)) = (index(corner.x, width), index(corner.y, height));
        let at = |x: usize, y: usize| self.texels[(y * width + x) * self.count + j];
        lerp(lerp(at(x0, y0), at(x1, y0), t.x), lerp(at(x0, y1), at(x1, y1), t.x), t.y)
    }
}

impl<const N: usize> Mips<N> {
    /// Texels of level 0.
    fn size(&self) -> Size {
        self.levels[0].size
    }

    /// Picture `j` at the level whose texels are `texels` of level 0 wide.
    fn trilinear(&self, uv: Vec2, texels: f32, j: usize) -> [f32; N] {
        let level = texels.log2().clamp(0.0, (self.levels.len() - 1) as f32);
        let (fine, t) = (level as usize, level.fract());
        let near = self.levels[fine].bilinear(uv, j);
        if t == 0.0 { near } else { lerp(near, self.levels[fine + 1].bilinear(uv, j), t) }
    }

    /// The level whose texels have the area of a square `footprint` wide in texture coordinates.
    fn fitting(&self, uv: Vec2, footprint: f32, j: usize) -> [f32; N] {
        self.trilinear(uv, footprint * (self.size().texels() as f32).sqrt(), j)
    }
}

impl Pairs {
    /// Axes (row, column, number), two numbers; level 0 first; at least one level.
    pub fn new(levels: &[Array3<f32>]) -> Self {
        assert!(!levels.is_empty(), "a chain has at least one level");
        let level = |level: &Array3<f32>| {
            let (height, width, _) = level.dim();
            let texels = level.lanes(Axis(2)).into_iter().map(|pair| [pair[0], pair[1]]).collect();
            Level { size: Size::new(width, height), count: 1, texels }
        };
        Self(Mips { levels: levels.iter().map(level).collect(), count: 1 })
    }

    /// Trilinear, as [`Texture::mipped`].
    pub(super) fn mipped(&self, uv: Vec2, footprint: f32) -> [f32; 2] {
        self.0.fitting(uv, footprint, 0)
    }
}

fn level(lobes: &Lobes, count: usize) -> Level<7> {
    let size = lobes.size();
    let texel = |i: usize| {
        let (place, j) = (i / count, i % count);
        let (Lobe { normal: n, roughness: r }, weight) = lobes.slot(j, place % size.width, place / size.width);
        [n.x, n.y, n.z, r.xx, r.xy, r.yy, weight]
    };
    Level { size, count, texels: (0..count * size.texels()).map(texel).collect() }
}

/// Normals, tensors and weights are averaged apart; the normal is made unit again, as every shader does.
fn lobe([x, y, z, xx, xy, yy, weight]: Texel) -> (Lobe, f32) {
    (Lobe { normal: Vec3::new(x, y, z).normalize_or(Vec3::Z), roughness: RoughnessTensor { xx, xy, yy } }, weight)
}

impl Texture {
    /// Level 0 first; at least one level.
    pub fn new(levels: &[Lobes]) -> Self {
        assert!(!levels.is_empty(), "a chain has at least one level");
        let count = levels.iter().map(Lobes::count).max().unwrap_or(1);
        Self(Mips { levels: levels.iter().map(|lobes| level(lobes, count)).collect(), count })
    }

    /// What a probe finds of each lobe. A single one needs no weight.
    fn lobes(&self, probe: impl Fn(usize) -> Texel) -> impl Iterator<Item = (Lobe, f32)> {
        let alone = self.0.count == 1;
        (0..self.0.count)
            .map(move |j| lobe(probe(j)))
            .map(move |(lobe, weight)| (lobe, if alone { 1.0 } else { weight }))
    }

    /// Level 0, bilinear: lobes and their weights.
    pub fn base(&self, uv: Vec2) -> impl Iterator<Item = (Lobe, f32)> {
        self.lobes(move |j| self.0.levels[0].bilinear(uv, j))
    }

    /// Trilinear, at the level whose texels have the area of a square `footprint` wide in texture coordinates.
    pub fn mipped(&self, uv: Vec2, footprint: f32) -> impl Iterator<Item = (Lobe, f32)> {
        self.lobes(move |j| self.0.fitting(uv, footprint, j))
    }

    /// The mean of up to `taps` trilinear probes, for a pixel over which `uv` changes by `steps`, right and up.
    pub fn anisotropic(&self, uv: Vec2, steps: [Vec2; 2], taps: usize) -> impl Iterator<Item = (Lobe, f32)> {
        let Size { width, height } = self.size();
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
        self.lobes(move |j| {
            let mut sum = Texel::default();
            for k in 0..count as usize {
                let along = (k as f32 + 0.5) / count - 0.5;
                let probe = self.0.trilinear(uv + along * axis, long / count, j);
                sum.iter_mut().zip(probe).for_each(|(sum, probe)| *sum += probe / count);
            }
            sum
        })
    }

    /// Texels of level 0.
    pub fn size(&self) -> Size {
        self.0.size()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf::Form;
    use crate::roughness::Alpha;

    /// xx of the first lobe.
    fn first(mut lobes: impl Iterator<Item = (Lobe, f32)>) -> f32 {
        lobes.next().unwrap().0.roughness.xx
    }

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
        let at = |u, v| first(texture.base(Vec2::new(u, v)));
        // Centres of the texels in column 1 of the top and the bottom row.
        assert!((at(0.375, 0.75) - 0.1).abs() < 1e-6 && (at(0.375, 0.25) - 0.11).abs() < 1e-6);
        // The middle of four texels, and the border, where columns 3 and 0 meet.
        assert!((at(0.5, 0.5) - 0.155).abs() < 1e-6);
        assert!((at(0.0, 0.75) - 0.15).abs() < 1e-6 && (at(-3.0, 0.75) - 0.15).abs() < 1e-6);
    }

    #[test]
    fn levels_follow_the_footprint() {
        let texture = Texture::new(&chain());
        let at = |footprint| first(texture.mipped(Vec2::new(0.25, 0.75), footprint));
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
        let at = |right: Vec2, up: Vec2, taps| first(texture.anisotropic(uv, [right * step, up * step], taps));
        // Probes in the middles of texels 6, 7, 8 and 9.
        let along_u = (36.0 + 49.0 + 64.0 + 81.0) / 4.0 + 400.0;
        assert!((at(4.0 * Vec2::X, Vec2::Y, 16) - along_u).abs() < 1e-2);
        assert!((at(Vec2::Y, -4.0 * Vec2::X, 4) - along_u).abs() < 1e-2);
        // Up: the same column, between rows: a linear ramp keeps its middle.
        let along_v = (49.0 + 64.0) / 2.0 + 400.0;
        assert!((at(Vec2::X, 4.0 * Vec2::Y, 16) - along_v).abs() < 1e-2);
        // A square footprint and a single probe are trilinear: 2 texels wide is level 1, of alpha 9.
        assert!((at(2.0 * Vec2::X, 2.0 * Vec2::Y, 16) - 81.0).abs() < 1e-3);
        assert_eq!(at(4.0 * Vec2::X, Vec2::Y, 1), first(texture.mipped(uv, 4.0 * step)));
        assert_eq!(at(4.0 * Vec2::X, Vec2::Y, 0), at(4.0 * Vec2::X, Vec2::Y, 1));
        // 4 by 1 with two probes: half as long each, so level 1.
        assert!((at(4.0 * Vec2::X, Vec2::Y, 2) - 81.0).abs() < 1e-3);
        // Aslant, and smaller than a texel.
        let diagonal = Vec2::splat(0.5f32.sqrt());
        let aslant = at(4.0 * diagonal, Vec2::new(-1.0, 1.0) * 0.5f32.sqrt(), 16);
        let other = at(4.0 * Vec2::new(-diagonal.x, diagonal.y), diagonal, 16);
        assert!((aslant - 456.5).abs() < 3.0 && (other - 456.5).abs() < 3.0, "{aslant} {other}");
        assert_eq!(at(1e-3 * Vec2::X, 1e-4 * Vec2::Y, 16), first(texture.base(uv)));
        assert!(at(Vec2::ZERO, Vec2::ZERO, 16).is_finite());
    }

    /// Level 0 has one lobe, level 1 two: half-way between them the second has half its weight, and a width between that
    /// of the first at level 0 and its own.
    #[test]
    fn lobes_are_mixed_with_their_like() {
        let [a, b, c] = [0.1, 0.3, 0.7].map(|a2| Lobe::isotropic(Vec3::Z, Alpha::from_squared(a2)));
        let base = Lobes::from_fn(Form::Isotropic, Size::new(2, 2), |_, _| a);
        let top = Lobes::mixed_from_fn(Form::Isotropic, 2, Size::new(1, 1), |j, _, _| [(b, 0.25), (c, 0.75)][j]);
        let texture = Texture::new(&[base, top]);
        let uv = Vec2::splat(0.5);
        let seen = |footprint: f32| texture.mipped(uv, footprint).map(|(l, w)| (l.roughness.xx, w)).collect::<Vec<_>>();
        let close = |found: &[(f32, f32)], expected: [(f32, f32); 2]| {
            found.len() == 2
                && found.iter().zip(expected).all(|(f, e)| (f.0 - e.0).abs() < 1e-6 && (f.1 - e.1).abs() < 1e-6)
        };
        assert!(close(&seen(0.5), [(0.1, 1.0), (0.1, 0.0)]), "{:?}", seen(0.5));
        assert!(close(&seen(0.5 * 2f32.sqrt()), [(0.2, 0.625), (0.4, 0.375)]), "{:?}", seen(0.5 * 2f32.sqrt()));
        assert!(close(&seen(1.0), [(0.3, 0.25), (0.7, 0.75)]), "{:?}", seen(1.0));
        let steps = [Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.9)];
        let probes: Vec<_> = texture.anisotropic(uv, steps, 4).map(|(l, w)| (l.roughness.xx, w)).collect();
        let sum: f32 = probes.iter().map(|probe| probe.1).sum();
        assert!(probes.len() == 2 && (sum - 1.0).abs() < 1e-6, "{probes:?}");
    }
}
