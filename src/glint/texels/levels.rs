//! All that queries need as planes, level by level, and back.

use ndarray::{Array3, Axis, Slice, concatenate};

use super::pyramid::{BLOCK_CHANNELS, Level, Pyramid};
use super::slopes::{SLOPE_CHANNELS, SlopeMap};
use super::{InvalidTexels, Tails, TexelGlints};

/// Channels of [`TexelGlints::levels`]: [`SLOPE_CHANNELS`], then [`BLOCK_CHANNELS`].
pub const LEVEL_CHANNELS: [&str; 14] = {
    let mut all = [""; 14];
    let mut k = 0;
    while k < 14 {
        all[k] = if k < 3 { SLOPE_CHANNELS[k] } else { BLOCK_CHANNELS[k - 3] };
        k += 1;
    }
    all
};

impl TexelGlints {
    /// For files: planes with axes (channel, row, column), channels [`LEVEL_CHANNELS`], from the map's size down to one
    /// texel, sizes halved and rounded up.
    ///
    /// Level 0 has the texels' slopes and widths, and the blocks of single cells. In a level above, slopes and widths are
    /// the means over its blocks (of widths: of the least and the largest), so that the slopes are a mip chain too.
    pub fn levels(&self) -> Vec<Array3<f32>> {
        let join = |slopes: &Array3<f32>, blocks: &Array3<f32>| {
            concatenate(Axis(0), &[slopes.view(), blocks.view()]).expect("of one size")
        };
        let mut levels = vec![join(&self.slopes().planes(), &Pyramid::cells(self.slopes()).planes())];
        for level in self.pyramid().levels() {
            let blocks = level.planes();
            let (_, rows, columns) = blocks.dim();
            let slopes = Array3::from_shape_fn((3, rows, columns), |(c, y, x)| match c {
                0 | 1 => blocks[[4 + c, y, x]],
                _ => 0.5 * (blocks[[9, y, x]] + blocks[[10, y, x]]),
            });
            levels.push(join(&slopes, &blocks));
        }
        levels
    }

    /// From what [`TexelGlints::levels`] gives. Ranges, variances and widths that no slopes have are refused; whether the
    /// blocks are those of these slopes is not looked into.
    pub fn from_levels(levels: &[Array3<f32>]) -> Result<Self, InvalidTexels> {
        let channels = LEVEL_CHANNELS.len();
        let (_, rows, columns) = levels.first().map_or((0, 0, 0), Array3::dim);
        if rows == 0 || columns == 0 {
            return Err(InvalidTexels::LevelShape(0, [0, rows, columns], [channels, 1, 1]));
        }
        let (mut rows, mut columns, mut blocks) = (rows, columns, Vec::new());
        for (k, planes) in levels.iter().enumerate() {
            let (a, b, c) = planes.dim();
            if [a, b, c] != [channels, rows, columns] {
                return Err(InvalidTexels::LevelShape(k, [a, b, c], [channels, rows, columns]));
            }
            if planes.iter().any(|v| !v.is_finite()) {
                return Err(InvalidTexels::NotFinite(k));
            }
            let level = Level::from_planes(planes.slice_axis(Axis(0), Slice::from(SLOPE_CHANNELS.len()..)));
            for (n, block) in level.blocks().iter().enumerate() {
                let place = [n / columns, n % columns];
                block.check().map_err(|what| InvalidTexels::Block(k, place, what))?;
            }
            if k > 0 {
                blocks.push(level);
            }
            (rows, columns) = (rows.div_ceil(2), columns.div_ceil(2));
        }
        // A map of one texel has a level 1 of one block too, which a file may leave out.
        let side = levels[0].dim().1.max(levels[0].dim().2);
        let count = side.next_power_of_two().ilog2() as usize + 1;
        if levels.len() < count || levels.len() > count.max(2) {
            return Err(InvalidTexels::LevelCount(levels.len(), count));
        }
        let slopes = SlopeMap::from_planes(levels[0].slice_axis(Axis(0), Slice::from(..SLOPE_CHANNELS.len())));
        let pyramid = if blocks.is_empty() { Pyramid::new(&slopes) } else { Pyramid::from_levels(blocks) };
        Ok(Self { slopes, pyramid, tails: Tails::default() })
    }
}
