//! What a file holds: samples by row, column and channel, in the file's own depth.

use ndarray::Array3;

use super::Size;

/// Samples with axes (row, column, channel).
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Unsigned, 0..255 standing for 0..1.
    U8(Array3<u8>),
    /// Unsigned, 0..65535 standing for 0..1.
    U16(Array3<u16>),
    /// As stored: half and float files, signed where the file is.
    F32(Array3<f32>),
}

impl Samples {
    /// Multiplies one channel by a factor, 0 to 1; integers are rounded.
    pub fn scale(&mut self, channel: usize, factor: f32) {
        let axis = ndarray::Axis(2);
        match self {
            Self::U8(a) => a.index_axis_mut(axis, channel).mapv_inplace(|v| (f32::from(v) * factor).round() as u8),
            Self::U16(a) => a.index_axis_mut(axis, channel).mapv_inplace(|v| (f32::from(v) * factor).round() as u16),
            Self::F32(a) => a.index_axis_mut(axis, channel).mapv_inplace(|v| v * factor),
        }
    }
}

/// A decoded picture: linear samples and the names of its channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// The samples, axes (row, column, channel).
    pub samples: Samples,
    /// One name a channel: `R G B A`, `Y`, `Y A`, or an EXR file's own names.
    pub channels: Vec<String>,
}

impl Raster {
    /// A raster whose channels are named by their number: `Y`, `Y A`, `R G B` or `R G B A`.
    pub fn new(samples: Samples) -> Self {
        let names: &[&str] = match samples.channels() {
            1 => &["Y"],
            2 => &["Y", "A"],
            3 => &["R", "G", "B"],
            4 => &["R", "G", "B", "A"],
            n => panic!("{n} channels need names of their own"),
        };
        Self { channels: names.iter().map(|s| s.to_string()).collect(), samples }
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        let (height, width, _) = self.samples.dim();
        Size::new(width, height)
    }

    /// The first channel as red, green and blue; a second one is dropped.
    pub fn gray_as_rgb(&self) -> Self {
        fn three<T: Copy>(a: &Array3<T>) -> Array3<T> {
            let (height, width, _) = a.dim();
            Array3::from_shape_fn((height, width, 3), |(y, x, _)| a[(y, x, 0)])
        }
        Self::new(match &self.samples {
            Samples::U8(a) => Samples::U8(three(a)),
            Samples::U16(a) => Samples::U16(three(a)),
            Samples::F32(a) => Samples::F32(three(a)),
        })
    }

    /// Bits a sample: 8 or 16 (unsigned integer), or 32 (float).
    pub fn bits(&self) -> u8 {
        match self.samples {
            Samples::U8(_) => 8,
            Samples::U16(_) => 16,
            Samples::F32(_) => 32,
        }
    }

    /// Part of one row of one channel, from column `x`, as long as `out`: integers scaled to 0..1 (divided by
    /// 255 or 65535), floats as they are.
    pub fn read(&self, channel: usize, y: usize, x: usize, out: &mut [f32]) {
        match &self.samples {
            Samples::U8(s) => copy(s, channel, y, x, out, |v| UNORM8[usize::from(v)]),
            Samples::U16(s) => copy(s, channel, y, x, out, |v| f32::from(v) / 65535.0),
            Samples::F32(s) => copy(s, channel, y, x, out, |v| v),
        }
    }

    /// One sample, scaled as [`Raster::read`] does.
    pub fn at(&self, x: usize, y: usize, channel: usize) -> f32 {
        let mut out = [0.0];
        self.read(channel, y, x, &mut out);
        out[0]
    }
}

/// Samples in floats, axes (row, column, channel): `read(channel, y, row)` fills row `y` of a channel.
pub fn from_rows(size: Size, channels: usize, read: impl Fn(usize, usize, &mut [f32])) -> Array3<f32> {
    let mut samples = Array3::zeros((size.height, size.width, channels));
    let mut row = vec![0.0; size.width];
    for (y, mut texels) in samples.outer_iter_mut().enumerate() {
        for channel in 0..channels {
            read(channel, y, &mut row);
            texels.column_mut(channel).iter_mut().zip(&row).for_each(|(out, v)| *out = *v);
        }
    }
    samples
}

/// Changes the channels of every texel; axes as in [`from_rows`].
pub fn each_texel(samples: &mut Array3<f32>, change: impl FnMut(&mut [f32])) {
    let channels = samples.dim().2;
    let samples = samples.as_slice_mut().expect("samples are in standard layout");
    samples.chunks_exact_mut(channels).for_each(change);
}

/// `v / 255` for every byte: a look-up is quicker than a division.
const UNORM8: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut v = 0;
    while v < 256 {
        table[v] = v as f32 / 255.0;
        v += 1;
    }
    table
};

/// Part of one row of one channel. The usual numbers of channels are known to the compiler.
#[inline(always)]
fn copy<T: Copy>(samples: &Array3<T>, channel: usize, y: usize, x: usize, out: &mut [f32], f: impl Fn(T) -> f32) {
    fn strided<T: Copy, const N: usize>(row: &[T], channel: usize, out: &mut [f32], f: impl Fn(T) -> f32) {
        assert!(channel < N);
        for (out, texel) in out.iter_mut().zip(row.as_chunks::<N>().0) {
            *out = f(texel[channel]);
        }
    }
    let (_, width, channels) = samples.dim();
    let samples = samples.as_slice().expect("rasters are in standard layout");
    let row = &samples[(y * width + x) * channels..(y * width + width) * channels];
    match channels {
        1 => strided::<T, 1>(row, channel, out, f),
        2 => strided::<T, 2>(row, channel, out, f),
        3 => strided::<T, 3>(row, channel, out, f),
        4 => strided::<T, 4>(row, channel, out, f),
        n => out.iter_mut().zip(row.chunks_exact(n)).for_each(|(out, texel)| *out = f(texel[channel])),
    }
}

impl Samples {
    /// (rows, columns, channels).
    pub fn dim(&self) -> (usize, usize, usize) {
        match self {
            Samples::U8(s) => s.dim(),
            Samples::U16(s) => s.dim(),
            Samples::F32(s) => s.dim(),
        }
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.dim().2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_part_of_a_row_of_one_channel() {
        let samples = Array3::from_shape_fn((2, 3, 2), |(y, x, c)| (100 * y + 10 * x + c) as u8);
        let raster = Raster::new(Samples::U8(samples));
        assert_eq!(raster.size(), Size::new(3, 2));
        let mut out = [0.0; 2];
        raster.read(1, 1, 1, &mut out);
        assert_eq!(out, [111.0 / 255.0, 121.0 / 255.0]);
        let all = from_rows(raster.size(), 2, |channel, y, row| raster.read(channel, y, 0, row));
        assert!(all.indexed_iter().all(|((y, x, c), v)| *v == raster.at(x, y, c)));
    }

    #[test]
    fn a_factor_scales_one_channel_and_gray_becomes_three() {
        let halved = |mut samples: Samples, channel| {
            samples.scale(channel, 0.5);
            samples
        };
        let of = |values: [u8; 3]| Samples::U8(Array3::from_shape_fn((1, 1, 3), |(_, _, c)| values[c]));
        assert_eq!(halved(of([200, 100, 50]), 1), of([200, 50, 50]));
        assert_eq!(
            halved(Samples::U16(Array3::from_elem((1, 1, 1), 1001)), 0),
            Samples::U16(Array3::from_elem((1, 1, 1), 501))
        );
        assert_eq!(
            halved(Samples::F32(Array3::from_elem((1, 1, 1), 0.5)), 0),
            Samples::F32(Array3::from_elem((1, 1, 1), 0.25))
        );
        let gray = Raster::new(Samples::U8(Array3::from_shape_fn((1, 1, 2), |(_, _, c)| [7, 255][c])));
        assert_eq!(gray.gray_as_rgb(), Raster::new(of([7, 7, 7])));
    }
}
