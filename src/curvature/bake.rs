//! The normals of a mesh that fall under each texel, at every level, as roughness.
//!
//! **What is baked.** The shading normals of a dense mesh differ within a pixel; a renderer that takes one sample sees one
//! of them, and the highlight sparkles. For each texel of each level the bake takes the part of the surface under that
//! texel and gives `K = 2 Cov`, twice the covariance of the normals' tangent-plane components: what that spread adds
//! to the roughness tensor `R`, as alpha^2 of a Beckmann lobe is twice its slope variance. A renderer shades level k where a
//! pixel is about as large as one of its texels, so level k holds the spread within its own texels, and level 0
//! already that within the finest ones. Its kernel is the texel itself, a box of variance 1/12; the kernels of
//! run-time filters are wider (variance 0.16 to 0.25 of a pixel), and their added widths accordingly.
//!
//! **Weights** are areas of the surface, not of the texture: a pixel that covers a texel sees surface, and the result
//! then depends less on how evenly the texture is spread over it. Within a texel of one chart the two hardly differ.
//!
//! **Frames.** Normals are merged as vectors of object space and only read out in the tangent plane of their mean: x along +u
//! on the surface, y across it on the side where v grows, as a renderer builds its frame. So a curved surface turns
//! no frame that would have to be carried from texel to texel.
//!
//! **Islands.** Charts of the texture that share no vertex, or that show it mirrored and not, are merged one by one, and a
//! texel that several have part in takes the mean of their tensors. What their means differ by is left out: charts lie beside
//! each other for reasons of packing, and a cut through a smooth surface must not look like an edge. Where charts lie on top
//! of each other (mirrored halves and repeats of the texture do) the result is the mean over them; [`Summary::overlapped`]
//! counts such texels. The price: edges that are also cuts, such as those of a box of six charts, add nothing. Faces of one
//! chart that lie on each other are merged with all their spread.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use ndarray::Array2;
use rayon::prelude::*;

use super::Mesh;
use super::grid::{Grid, Pool};
use super::moments::NormalMoments;
use super::pad::dilate;
use super::surface::{Surface, Tile};
use crate::error::Result;
use crate::image::Size;
use crate::ndf::RoughnessTensor;
use crate::roughness::Alpha;

/// Texels that a band may have, what a thread works on at a time: so many, or so many rows of a wide texture.
const BAND_TEXELS: usize = 1 << 17;
const BAND_ROWS: usize = 32;

/// How a mesh is baked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakeOptions {
    /// Texels beside the surface that are filled from their neighbours, at every level, so that texture filters see
    /// no hole. Texels further away are 0.
    pub padding: usize,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self { padding: 8 }
    }
}

/// What [`bake`] gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// Level 0 first, down to 1x1.
    pub levels: Vec<Level>,
    /// What was found on the way.
    pub summary: Summary,
}

/// One level.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// What to add to a texel's [`RoughnessTensor`], axes (row, column), row 0 at v = 1; in the frame of the surface there.
    /// Not capped: eigenvalues reach from 0 to 2. A texel that holds a whole hemisphere has 2/3 on both axes, one that
    /// holds half a cylinder 1 around it and 0 along it.
    pub added: Array2<RoughnessTensor>,
    /// Share of each texel that surface lies on: 0 none (padded or 0), 1 all of it, more where surfaces overlap.
    pub coverage: Array2<f32>,
}

impl Level {
    /// Width and height.
    pub fn size(&self) -> Size {
        let (height, width) = self.added.dim();
        Size::new(width, height)
    }

    /// The one width whose square is to be added to alpha^2 where a renderer knows no direction: the mean of both axes.
    pub fn isotropic(&self, x: usize, y: usize) -> Alpha {
        Alpha::from_squared(self.added[[y, x]].mean())
    }
}

/// Counts of a bake; texels are those of level 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Triangles that were baked.
    pub triangles: usize,
    /// Charts of the texture that are merged one by one.
    pub islands: usize,
    /// Triangles left out since they have no texture coordinates.
    pub without_uvs: usize,
    /// Triangles left out since they have no area in the texture.
    pub without_texture_area: usize,
    /// Triangles left out since they have no area in space.
    pub without_area: usize,
    /// Share of the surface's area that was left out, 0 to 1.
    pub left_out: f64,
    /// Area of all triangles in the texture, in textures; above 1 there must be overlaps.
    pub cover: f64,
    /// Texels with any surface.
    pub covered: usize,
    /// Texels with parts of several islands, beside or on top of each other.
    pub shared: usize,
    /// Texels with more surface than they have area: surfaces on top of each other.
    pub overlapped: usize,
}

/// Bakes a mesh (or [some parts](Mesh::select) of it) into a texture of this size. Texture coordinates repeat beyond
/// 0 to 1. `progress` gets the share of work done, 0 to 1, from any thread. The result is the same to the bit on any
/// number of threads.
///
/// # Errors
/// [`crate::Error::Unsupported`] for a mesh without texture coordinates, for coordinates that cover the texture more than
/// [`super::MOST_COVERS`] times, and above [`super::LONGEST_SIDE`].
pub fn bake(mesh: &Mesh, size: Size, options: &BakeOptions, progress: &(dyn Fn(f64) + Sync)) -> Result<Baked> {
    let surface = Surface::new(mesh, size)?;
    let [without_uvs, without_texture_area, without_area] = surface.skipped;
    let mut summary = Summary {
        triangles: surface.order.len(),
        islands: surface.islands,
        without_uvs,
        without_texture_area,
        without_area,
        left_out: surface.skipped_area,
        cover: surface.cover,
        ..Summary::default()
    };
    let sizes: Vec<Size> = (0..size.level_count()).map(|k| size.level(k)).collect();
    let groups = nested(&sizes);
    let work: usize = groups.iter().map(|group| sizes[group.start].texels()).sum();
    let done = AtomicUsize::new(0);
    let advance = |texels: usize| {
        let done = texels + done.fetch_add(texels, Ordering::Relaxed);
        progress(done as f64 / work as f64);
    };
    let mut levels = Vec::with_capacity(sizes.len());
    for group in groups {
        let (baked, shared) = bake_group(&surface, &sizes[group.clone()], &advance);
        if group.start == 0 {
            summary.shared = shared;
        }
        levels.extend(baked);
    }
    let coverage = levels[0].coverage.iter();
    (summary.covered, summary.overlapped) = coverage.fold((0, 0), |(covered, overlapped), &c| {
        (covered + usize::from(c > 0.0), overlapped + usize::from(c > 1.0 + 1e-3))
    });
    for level in &mut levels {
        let size = level.size();
        if let (Some(added), Some(coverage)) = (level.added.as_slice_mut(), level.coverage.as_slice()) {
            dilate(size, added, coverage, options.padding);
        }
    }
    progress(1.0);
    Ok(Baked { levels, summary })
}

/// Whether [`bake`] would, without baking.
///
/// # Errors
/// Those of [`bake`].
pub fn check(mesh: &Mesh, size: Size) -> Result<()> {
    Surface::new(mesh, size).map(drop)
}

/// Runs of levels of which each texel is made of whole texels of the level before. Levels of a run are merged from its
/// first, without loss; a level that cuts texels of the one before starts a run of its own and is drawn anew.
fn nested(sizes: &[Size]) -> Vec<Range<usize>> {
    let mut groups = Vec::new();
    let mut start = 0;
    for k in 1..=sizes.len() {
        let whole = k < sizes.len() && {
            let (fine, coarse) = (sizes[k - 1], sizes[k]);
            fine.width % coarse.width == 0 && fine.height % coarse.height == 0
        };
        if !whole {
            groups.push(start..k);
            start = k;
        }
    }
    groups
}

/// Columns and rows of a level that make one of a coarser one.
fn ratio(fine: Size, coarse: Size) -> [usize; 2] {
    [fine.width / coarse.width, fine.height / coarse.height]
}

/// A triangle in one repeat of the texture.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Placed {
    island: u32,
    tile: Tile,
    triangle: u32,
}

impl Placed {
    /// What is merged into one: an island in one repeat of the texture.
    fn chart(&self) -> Chart {
        (self.island, self.tile)
    }
}

type Chart = (u32, Tile);

/// A band of rows, its triangles, and where its results go, by level.
struct Band<'a> {
    first_row: usize,
    triangles: &'a mut [Placed],
    out: Vec<(&'a mut [RoughnessTensor], &'a mut [f32])>,
}

/// The moments of a chart in one texel of the last level that bands make: column, row.
type Kept = (Chart, usize, usize, NormalMoments);

/// Bakes a run of levels; also the number of texels of its first level that several islands have part in.
fn bake_group(surface: &Surface, sizes: &[Size], advance: &(dyn Fn(usize) + Sync)) -> (Vec<Level>, usize) {
    // Bands are as high as a row of the coarsest level that they can make on their own.
    let rows_of = |k: usize| sizes[0].height / sizes[k].height;
    let most = BAND_ROWS.max(BAND_TEXELS / sizes[0].width).min(sizes[0].height.div_ceil(16));
    let fits = |&k: &usize| k == 0 || rows_of(k) <= most;
    let last = (0..sizes.len()).take_while(fits).last().unwrap_or(0);
    let rows = rows_of(last);
    let (first, mut triangles) = binned(surface, sizes[0], rows);

    let zeros = |size: &Size| (vec![RoughnessTensor::default(); size.texels()], vec![0f32; size.texels()]);
    let mut planes: Vec<_> = sizes.iter().map(zeros).collect();
    let mut rest = triangles.as_mut_slice();
    let mut bands: Vec<Band> = (0..sizes[last].height)
        .map(|i| Band {
            first_row: i * rows,
            triangles: rest.split_off_mut(..first[i + 1] - first[i]).expect("bands share out all triangles"),
            out: Vec::new(),
        })
        .collect();
    for (size, (added, coverage)) in sizes[..=last].iter().zip(&mut planes) {
        let band = size.width * (size.height / sizes[last].height);
        for (place, out) in bands.iter_mut().zip(added.chunks_mut(band).zip(coverage.chunks_mut(band))) {
            place.out.push(out);
        }
    }
    let scratch = || -> Vec<Grid> { (0..=last).map(|_| Grid::default()).collect() };
    let results: Vec<(Vec<Kept>, usize)> = bands
        .into_par_iter()
        .map_init(scratch, |grids, band| {
            let result = bake_band(surface, &sizes[..=last], rows, band, grids);
            advance(rows * sizes[0].width);
            result
        })
        .collect();
    let shared = results.iter().map(|(_, shared)| shared).sum();
    let kept: Vec<Kept> = results.into_iter().flat_map(|(kept, _)| kept).collect();
    merge_above(kept, &sizes[last..], &mut planes[last..]);
    let shaped = |(size, (added, coverage)): (&Size, (Vec<RoughnessTensor>, Vec<f32>))| {
        let shape = (size.height, size.width);
        let array = "one value a texel";
        Level {
            added: Array2::from_shape_vec(shape, added).expect(array),
            coverage: Array2::from_shape_vec(shape, coverage).expect(array),
        }
    };
    (sizes.iter().zip(planes).map(shaped).collect(), shared)
}

/// The triangles of each band of `rows` rows: where each band's begin, and all of them.
fn binned(surface: &Surface, size: Size, rows: usize) -> (Vec<usize>, Vec<Placed>) {
    let bands = size.height / rows;
    let places = || {
        surface.order.iter().flat_map(|&(island, triangle)| {
            surface.tiles(triangle).flat_map(move |tile| {
                let reach = surface.rows(triangle, tile, size);
                let placed = Placed { island, tile, triangle };
                (reach.start / rows..reach.end.div_ceil(rows)).map(move |band| (band, placed))
            })
        })
    };
    let mut first = vec![0; bands + 1];
    places().for_each(|(band, _)| first[band + 1] += 1);
    for band in 0..bands {
        first[band + 1] += first[band];
    }
    let mut next = first.clone();
    let mut triangles = vec![Placed { island: 0, tile: Tile { x: 0, y: 0 }, triangle: 0 }; first[bands]];
    for (band, placed) in places() {
        triangles[next[band]] = placed;
        next[band] += 1;
    }
    (first, triangles)
}

/// Bakes a band of the levels that it can make alone; also the number of its texels that several charts have part in.
fn bake_band(surface: &Surface, sizes: &[Size], rows: usize, band: Band, grids: &mut [Grid]) -> (Vec<Kept>, usize) {
    let texels = sizes[0].texels() as f64;
    let heights: Vec<usize> = sizes.iter().map(|size| rows * size.height / sizes[0].height).collect();
    let mut pools: Vec<Vec<Pool>> = Vec::with_capacity(sizes.len());
    for (k, size) in sizes.iter().enumerate() {
        grids[k].resize(size.width, heights[k]);
        pools.push(vec![Pool::default(); size.width * heights[k]]);
    }
    let last = sizes.len() - 1;
    let mut kept = Vec::new();
    band.triangles.sort_unstable();
    for chart in band.triangles.chunk_by(|a, b| a.chart() == b.chart()) {
        for placed in chart {
            let reach = surface.rows(placed.triangle, placed.tile, sizes[0]);
            let here = reach.start.max(band.first_row)..reach.end.min(band.first_row + rows);
            surface.patch(placed.triangle, placed.tile, sizes[0]).pieces(here, texels, |column, row, moments| {
                grids[0].add(column, row - band.first_row, moments);
            });
        }
        for k in 0..=last {
            for (column, row, moments) in grids[k].texels() {
                pools[k][row * sizes[k].width + column].add(moments);
                if k == last {
                    kept.push((chart[0].chart(), column, band.first_row / rows + row, *moments));
                }
            }
            if k < last {
                let (fine, coarse) = grids.split_at_mut(k + 1);
                fine[k].coarsen(ratio(sizes[k], sizes[k + 1]), &mut coarse[0]);
            }
            grids[k].clear();
        }
    }
    for ((size, pools), (added, coverage)) in sizes.iter().zip(&pools).zip(band.out) {
        read_out(pools, size.texels(), added, coverage);
    }
    let shared = pools[0].iter().filter(|pool| pool.is_shared()).count();
    (kept, shared)
}

fn read_out(pools: &[Pool], texels: usize, added: &mut [RoughnessTensor], coverage: &mut [f32]) {
    for (pool, (added, coverage)) in pools.iter().zip(added.iter_mut().zip(coverage)) {
        (*added, *coverage) = pool.read(texels);
    }
}

/// The levels above those that bands make: `kept` is the first of `sizes`, whose planes are there already.
fn merge_above(mut kept: Vec<Kept>, sizes: &[Size], planes: &mut [(Vec<RoughnessTensor>, Vec<f32>)]) {
    if sizes.len() == 1 {
        return;
    }
    kept.sort_by_key(|kept| kept.0);
    let mut grids: Vec<Grid> = sizes.iter().map(|_| Grid::default()).collect();
    let mut pools: Vec<Vec<Pool>> = vec![Vec::new(); sizes.len()];
    for k in 1..sizes.len() {
        grids[k].resize(sizes[k].width, sizes[k].height);
        pools[k].resize(sizes[k].texels(), Pool::default());
    }
    for chart in kept.chunk_by(|a, b| a.0 == b.0) {
        let [wide, high] = ratio(sizes[0], sizes[1]);
        for (_, column, row, moments) in chart {
            grids[1].add(column / wide, row / high, moments);
        }
        for k in 1..sizes.len() {
            for (column, row, moments) in grids[k].texels() {
                pools[k][row * sizes[k].width + column].add(moments);
            }
            if k + 1 < sizes.len() {
                let (fine, coarse) = grids.split_at_mut(k + 1);
                fine[k].coarsen(ratio(sizes[k], sizes[k + 1]), &mut coarse[0]);
            }
            grids[k].clear();
        }
    }
    for k in 1..sizes.len() {
        let (added, coverage) = &mut planes[k];
        read_out(&pools[k], sizes[k].texels(), added, coverage);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_end_where_texels_would_be_cut() {
        let sizes: Vec<Size> = (0..10).map(|k| Size::new(1000, 1000).level(k)).collect();
        assert_eq!(nested(&sizes), [0..4, 4..6, 6..7, 7..8, 8..10]);
        let sizes: Vec<Size> = (0..8).map(|k| Size::new(128, 32).level(k)).collect();
        assert_eq!(nested(&sizes), vec![0..8; 1]);
    }
}
