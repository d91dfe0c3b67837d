//! Frames to look at: panes side by side, enlarged without smoothing, with captions.

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use crate::font;
use crate::renderer::Picture;

/// Pixels along a side of a pane.
pub const PANE: usize = 240;
const GAP: usize = 6;
/// Heights of the lines above and below the panes.
const LINE: usize = 26;
/// Pixels along a side of a letter's dot.
const DOT: usize = 2;
/// Radiance beside the sphere, linear.
const BACKGROUND: f32 = 0.012;
const PAPER: u8 = 26;
const INK: u8 = 200;

/// 8-bit RGB, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Three bytes a pixel.
    pub bytes: Vec<u8>,
}

impl Frame {
    /// Panes with a caption each, and a line below. Radiances are multiplied by `exposure`; sides of pictures divide
    /// [`PANE`].
    pub fn new(panes: &[(&str, &Picture)], below: &str, exposure: f32) -> Self {
        let (width, height) = (panes.len() * (PANE + GAP) + GAP, PANE + 2 * LINE);
        let mut frame = Self { width, height, bytes: vec![PAPER; 3 * width * height] };
        for (i, (caption, picture)) in panes.iter().enumerate() {
            let left = GAP + i * (PANE + GAP);
            frame.write(caption, left + PANE / 2, 0);
            let size = PANE / picture.side;
            for (at, pixel) in picture.pixels.iter().enumerate() {
                let colour = displayed(*pixel, exposure);
                frame.fill(left + at % picture.side * size, LINE + at / picture.side * size, size, colour);
            }
        }
        frame.write(below, width / 2, LINE + PANE);
        frame
    }

    fn fill(&mut self, x: usize, y: usize, size: usize, colour: [u8; 3]) {
        for row in y..y + size {
            let from = 3 * (row * self.width + x);
            self.bytes[from..from + 3 * size].chunks_exact_mut(3).for_each(|pixel| pixel.copy_from_slice(&colour));
        }
    }

    /// A line of text around this middle.
    fn write(&mut self, text: &str, middle: usize, top: usize) {
        let left = middle - text.len() * font::ADVANCE * DOT / 2;
        let top = top + (LINE - font::GLYPH.1 * DOT) / 2;
        for (x, y) in font::dots(text) {
            self.fill(left + x * DOT, top + y * DOT, DOT, [INK; 3]);
        }
    }
}

/// The colour of a pixel on a display.
fn displayed([red, green, blue, share]: [f32; 4], exposure: f32) -> [u8; 3] {
    [red, green, blue].map(|v| {
        let toned = filmic(exposure * v + (1.0 - share) * BACKGROUND);
        let encoded = if toned <= 0.003_130_8 { 12.92 * toned } else { 1.055 * toned.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    })
}

/// Narkowicz 2015, ACES Filmic Tone Mapping Curve: a rational function that nears white slowly.
fn filmic(x: f32) -> f32 {
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

/// An animated PNG that repeats without end; one frame makes an ordinary PNG.
pub fn write(path: &Path, frames: &[Frame], milliseconds: u16) -> Result<(), Box<dyn Error>> {
    let about = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let first = frames.first().ok_or("no frames")?;
    let file = BufWriter::new(File::create(path).map_err(|e| about(&e))?);
    let mut encoder = png::Encoder::new(file, first.width as u32, first.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    if frames.len() > 1 {
        encoder.set_animated(frames.len() as u32, 0)?;
        encoder.set_frame_delay(milliseconds, 1000)?;
    }
    let mut writer = encoder.write_header().map_err(|e| about(&e))?;
    for frame in frames {
        writer.write_image_data(&frame.bytes).map_err(|e| about(&e))?;
    }
    writer.finish().map_err(|e| about(&e).into())
}
