//! From the spiky distribution to the folded lobe.

use super::TexelWidth;

/// Where the folded lobe takes over, by the longer width of the pixel in texels.
///
/// Both distributions integrate to 1 over projected solid angle, and so does any blend of them, at any width: the
/// energy is that of the parts. The share runs with the logarithm of the width, so that a zoom of one octave moves it
/// as much near either end, with zero slope at both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// Up to here all is spiky.
    pub from: TexelWidth,
    /// From here on all is folded.
    pub to: TexelWidth,
}

impl Default for Transition {
    /// 16 to 64 texels: one texel has 0.2 percent of the pixel where the folded lobe comes in, 0.01 percent where it is all.
    fn default() -> Self {
        Self { from: TexelWidth(16.0), to: TexelWidth(64.0) }
    }
}

impl Transition {
    /// Share of the folded lobe, 0 to 1. A transition whose ends are not in order steps at its far end.
    pub fn folded_share(self, width: TexelWidth) -> f64 {
        let TexelWidth(width) = width;
        let (from, to) = (self.from.0.max(f64::MIN_POSITIVE), self.to.0);
        if width >= to {
            1.0
        } else if width > from {
            let t = (width / from).ln() / (to / from).ln();
            t * t * (3.0 - 2.0 * t)
        } else {
            0.0
        }
    }
}
