//! Rows of level 0 as prepared lobes.

use glam::{Vec2, Vec3};

use super::Interpolation;
use super::lobe::PreparedLobe;
use crate::image::Wrap;
use crate::material::Texels;
use crate::ndf::{Lobe, RoughnessTensor};
use crate::roughness::PerceptualRoughness;

/// Weight of a texel whose normal cannot be used, in texels: none beside any other, all where there is no other.
const UNUSABLE_WEIGHT: f64 = 1e-12;

/// A texel as read.
#[derive(Clone, Copy)]
struct Texel {
    normal: Vec3,
    perceptual: f32,
    tensor: RoughnessTensor,
    /// 1 where the normal can be used, else 0.
    coverage: f32,
}

/// Part of a row of texels.
fn read(texels: &dyn Texels, y: usize, x: usize, n: usize) -> Vec<Texel> {
    let mut rows = vec![vec![0.0; n]; 8];
    let [nx, ny, nz, coverage, r, xx, xy, yy] = &mut rows[..] else { unreachable!("eight rows") };
    texels.normals(y, x, [&mut *nx, &mut *ny, &mut *nz], coverage);
    texels.perceptual(y, x, r);
    if texels.is_anisotropic() {
        texels.tensors(y, x, r, [&mut *xx, &mut *xy, &mut *yy]);
    } else {
        xx.iter_mut().zip(&*r).for_each(|(xx, r)| *xx = PerceptualRoughness(*r).alpha().squared());
        yy.copy_from_slice(xx);
    }
    let texel = |i: usize| Texel {
        normal: Vec3::new(nx[i], ny[i], nz[i]),
        perceptual: r[i],
        tensor: RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] },
        coverage: coverage[i],
    };
    (0..n).map(texel).collect()
}

fn prepare(texel: &Texel, weight: f64) -> PreparedLobe {
    let lobe = Lobe { normal: texel.normal, roughness: texel.tensor };
    PreparedLobe::new(&lobe, weight * f64::from(texel.coverage).max(UNUSABLE_WEIGHT))
}

/// Appends the lobes of columns `x` to `x + weights.len()` of row `y`; each weighs its column's weight times `weight`.
pub(super) fn append(
    texels: &dyn Texels,
    interpolation: Interpolation,
    y: usize,
    weight: f64,
    x: usize,
    weights: &[f32],
    out: &mut Vec<PreparedLobe>,
) {
    let n = weights.len();
    match interpolation {
        Interpolation::Constant => {
            let row = read(texels, y, x, n);
            out.extend(row.iter().zip(weights).map(|(texel, w)| prepare(texel, weight * f64::from(*w))));
        }
        Interpolation::Bilinear { per_side, wrap } => {
            let rows = [-1, 0, 1].map(|dy| neighbours(texels, wrap, y as isize + dy, x, n));
            let places = per_side.max(1);
            let share = weight / (places * places) as f64;
            for (i, w) in weights.iter().enumerate() {
                for k in 0..places * places {
                    // From the texel's centre, rows down.
                    let offset = |k: usize| (k as f32 + 0.5) / places as f32 - 0.5;
                    let texel = interpolate(&rows, i + 1, Vec2::new(offset(k % places), offset(k / places)));
                    out.push(prepare(&texel, share * f64::from(*w)));
                }
            }
        }
    }
}

/// A row from one column before `x` to one after, and beyond the border as the renderer reads it.
fn neighbours(texels: &dyn Texels, wrap: Wrap, y: isize, x: usize, n: usize) -> Vec<Texel> {
    let size = texels.size();
    let y = wrap.index(y, size.height);
    let one = |x: isize| read(texels, y, wrap.index(x, size.width), 1);
    let mut row = one(x as isize - 1);
    row.extend(read(texels, y, x, n));
    row.extend(one((x + n) as isize));
    row
}

/// The texel at `offset` (-0.5 to 0.5) from the centre of column `i` of the middle row, as a shader filters it: normals
/// and roughness apart. Unusable normals take no part where others do.
fn interpolate(rows: &[Vec<Texel>; 3], i: usize, offset: Vec2) -> Texel {
    let side = |v: f32| if v < 0.0 { 0 } else { 2 };
    let (column, row) = (i + side(offset.x) - 1, side(offset.y));
    let (s, t) = (offset.x.abs(), offset.y.abs());
    let corners = [
        (&rows[1][i], (1.0 - s) * (1.0 - t)),
        (&rows[1][column], s * (1.0 - t)),
        (&rows[row][i], (1.0 - s) * t),
        (&rows[row][column], s * t),
    ];
    let sum = |f: &dyn Fn(&Texel) -> f32| corners.iter().map(|(texel, w)| w * f(texel)).sum::<f32>();
    let normal: Vec3 = corners.iter().map(|(texel, w)| w * texel.coverage * texel.normal).sum();
    let perceptual = sum(&|t| t.perceptual);
    let isotropic = corners.iter().all(|(texel, _)| texel.tensor.xy == 0.0 && texel.tensor.xx == texel.tensor.yy);
    let tensor = if isotropic {
        RoughnessTensor::isotropic(PerceptualRoughness(perceptual).alpha())
    } else {
        RoughnessTensor { xx: sum(&|t| t.tensor.xx), xy: sum(&|t| t.tensor.xy), yy: sum(&|t| t.tensor.yy) }
    };
    Texel { normal: normal.normalize_or(Vec3::Z), perceptual, tensor, coverage: sum(&|t| t.coverage) }
}
