//! Levels to be packed; lobes and moments as mip-mapped OpenEXR.

use std::io::{Seek, Write};

use crate::codec::{Channel, Depth, write_exr};
use crate::fold::Chain;
use crate::material::{FurtherMap, FurtherView, LevelView, Material, NormalY, Role, Texels, lobe_channels};
use crate::ndf::{Axes, Form, RoughnessTensor};

/// Level `k` of a material, to be packed.
pub fn view<'a>(material: &'a Material, chain: &'a Chain, k: usize) -> LevelView<'a> {
    view_of(material, chain, k, 0)
}

/// The same for lobe `j`.
fn view_of<'a>(material: &'a Material, chain: &'a Chain, k: usize, j: usize) -> LevelView<'a> {
    let folded = k.checked_sub(1).map(|i| (&chain.levels[i].lobes, &chain.levels[i].extras));
    // The coarsest level speaks for the whole texture.
    let axis = chain.levels.last().map_or(0.0, |top| top.lobes.slot(j, 0, 0).0.axes().angle);
    LevelView { material, folded, main_axis: material.sided(axis) }
}

/// Level `k` of a map of a further lobe, to be packed.
pub fn further<'a>(material: &'a Material, chain: &'a Chain, k: usize, map: FurtherMap) -> FurtherView<'a> {
    let form = chain.levels.first().map_or(Form::Isotropic, |level| level.lobes.form());
    FurtherView { level: view_of(material, chain, k, map.lobe()), map, form }
}

/// The lobes of all levels in full, 32 bit. Level 0 has one lobe: the others are that again, of weight 0.
pub fn write_lobes(out: impl Write + Seek, material: &Material, chain: &Chain) -> std::io::Result<()> {
    let count = lobe_count(chain);
    let names = lobe_channels(count);
    let each = names.len() / count;
    let channels: Vec<_> = names.into_iter().map(|name| Channel { name, depth: Depth::Float }).collect();
    write_exr(out, &channels, material.size, material.wrap, &|level, channel, y, x, row| {
        let (j, channel) = (channel / each, channel % each);
        let lobes = level.checked_sub(1).map(|i| &chain.levels[i].lobes);
        let there = lobes.filter(|lobes| j < lobes.count());
        if channel == WEIGHT {
            match there {
                Some(lobes) if lobes.count() > 1 => {
                    let plane = j * lobes.stride() + lobes.form().planes();
                    row.copy_from_slice(&lobes.row(plane, y)[x..x + row.len()]);
                }
                _ => row.fill(if j == 0 { 1.0 } else { 0.0 }),
            }
        } else if let Some(lobes) = lobes {
            let first = if there.is_some() { j * lobes.stride() } else { 0 };
            let part = |plane: usize| &lobes.row(first + plane, y)[x..x + row.len()];
            if channel < 3 {
                row.copy_from_slice(part(channel));
            } else if lobes.form() == Form::Isotropic {
                let a2 = part(3);
                row.iter_mut().zip(a2).for_each(|(out, a2)| *out = if channel == 5 { 0.0 } else { a2.sqrt() });
            } else {
                let [xx, xy, yy] = [3, 4, 5].map(part);
                for (i, out) in row.iter_mut().enumerate() {
                    *out = read_out(RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] }, channel);
                }
            }
        } else {
            base_lobe_row(material, channel, y, x, row);
        }
    })
}

/// Behind the six channels of a lobe.
const WEIGHT: usize = 6;

/// Lobes a texel of a chain's lobes file.
pub fn lobe_count(chain: &Chain) -> usize {
    chain.levels.iter().map(|level| level.lobes.count()).max().unwrap_or(1)
}

fn read_out(tensor: RoughnessTensor, channel: usize) -> f32 {
    let Axes { alpha_x, alpha_y, angle } = tensor.axes();
    match channel {
        3 => alpha_x.0,
        4 => alpha_y.0,
        _ => angle,
    }
}

/// Part of a row of a lobe channel of level 0.
fn base_lobe_row(material: &Material, channel: usize, y: usize, x: usize, row: &mut [f32]) {
    let n = row.len();
    if channel < 3 {
        let [mut a, mut b, mut coverage] = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        let mut rows = [&mut *row, &mut a, &mut b];
        // The wanted component lands in `row`.
        rows.rotate_right(channel);
        material.normals(y, x, rows, &mut coverage);
        return;
    }
    material.perceptual(y, x, row);
    if material.is_anisotropic() {
        let perceptual = row.to_vec();
        let [mut xx, mut xy, mut yy] = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        material.tensors(y, x, &perceptual, [&mut xx, &mut xy, &mut yy]);
        for (i, out) in row.iter_mut().enumerate() {
            *out = read_out(RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] }, channel);
        }
    } else {
        row.iter_mut().for_each(|r| *r = if channel == 5 { 0.0 } else { *r * *r });
    }
}

/// The channels that `maketx --bumpslopes` writes, so that shaders made for it read ours: height (-1: none), mean
/// slopes, and raw second moments.
pub const MOMENT_CHANNELS: [&str; 6] = ["b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"];

/// Raw LEAN moments of all levels, 32 bit: a variance is the difference of two of them, which half floats lose.
///
/// As `maketx` does, slopes are `-n.xy / n.z` of the normal **as written**: for a DirectX map dh/dt runs down the rows,
/// for an OpenGL map up.
pub fn write_moments(
    out: impl Write + Seek,
    material: &Material,
    chain: &Chain,
    normal_y: NormalY,
) -> std::io::Result<()> {
    let channels = MOMENT_CHANNELS.map(|name| Channel { name: name.into(), depth: Depth::Float });
    let sign = normal_y.sign();
    write_exr(out, &channels, material.size, material.wrap, &|level, channel, y, x, row| {
        let n = row.len();
        if channel == 0 {
            row.fill(-1.0);
            return;
        }
        // Both the mean slope along v and the mixed moment change sign with v.
        let sign = if channel == 2 || channel == 5 { sign } else { 1.0 };
        match level.checked_sub(1) {
            Some(i) => {
                let moments = chain.levels[i].slope_moments.as_ref().expect("folded with slope moments");
                let moments = moments.index_axis(ndarray::Axis(0), channel - 1);
                let values = moments.index_axis_move(ndarray::Axis(0), y);
                row.iter_mut().zip(values.iter().skip(x)).for_each(|(out, v)| *out = sign * v);
            }
            None => {
                let [mut nx, mut ny, mut nz, mut coverage] = [vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]];
                material.normals(y, x, [&mut nx, &mut ny, &mut nz], &mut coverage);
                for (i, out) in row.iter_mut().enumerate() {
                    let s = crate::moments::slope(glam::Vec3::new(nx[i], ny[i], nz[i]));
                    *out = sign * [s.x, s.y, s.x * s.x, s.y * s.y, s.x * s.y][channel - 1];
                }
            }
        }
    })
}

/// What the channels of a map mean, for the manifest.
pub fn role_name(role: Role) -> &'static str {
    match role {
        Role::NormalX => "normal.x",
        Role::NormalY => "normal.y",
        Role::NormalZ => "normal.z",
        Role::Roughness => "perceptual-roughness",
        Role::Smoothness => "smoothness",
        Role::AnisotropyX => "anisotropy.direction.x",
        Role::AnisotropyY => "anisotropy.direction.y",
        Role::AnisotropyStrength => "anisotropy.strength",
        Role::Other(_) => "other",
    }
}
