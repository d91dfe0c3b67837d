//! A rectangle of samples, wrap modes, mip levels, and the footprint of a mip texel with its weights.
//!
//! Row 0 is the top row, as in every file format here; `v` points up, so it falls as rows rise.

mod raster;
mod sides;
mod span;

pub use raster::{Raster, Samples, each_texel, from_rows};
pub use sides::Sides;
pub use span::{Span, span, spans};

/// Width and height in texels, both at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Size {
    /// Texels along +u.
    pub width: usize,
    /// Texels along v (rows).
    pub height: usize,
}

impl Size {
    /// A size; both sides must be at least 1.
    pub fn new(width: usize, height: usize) -> Self {
        debug_assert!(width > 0 && height > 0);
        Self { width, height }
    }

    /// Number of texels.
    pub fn texels(self) -> usize {
        self.width * self.height
    }

    /// Size of mip level `k`: each side halved `k` times, rounded down, never below 1 (as OpenGL, Vulkan,
    /// Direct3D and EXR's default do).
    pub fn level(self, k: usize) -> Self {
        let side = |n: usize| n.checked_shr(k as u32).unwrap_or(0).max(1);
        Self { width: side(self.width), height: side(self.height) }
    }

    /// Number of levels down to and including 1x1.
    pub fn level_count(self) -> usize {
        self.width.max(self.height).ilog2() as usize + 1
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// What lies beyond the border of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wrap {
    /// The texture again: the default of glTF and of most engines.
    #[default]
    Repeat,
    /// The texture mirrored at its border.
    Mirror,
    /// The border texel.
    Clamp,
}

impl Wrap {
    /// As OpenImageIO calls it, in the attribute `wrapmodes` and in `maketx --wrap`.
    pub fn oiio(self) -> &'static str {
        match self {
            Wrap::Repeat => "periodic",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
        }
    }

    /// The texel inside `0..n` that stands for index `i`.
    pub fn index(self, i: isize, n: usize) -> usize {
        let side = n as isize;
        match self {
            Wrap::Repeat => i.rem_euclid(side) as usize,
            Wrap::Clamp => i.clamp(0, side - 1) as usize,
            Wrap::Mirror => {
                let j = i.rem_euclid(2 * side);
                (if j < side { j } else { 2 * side - 1 - j }) as usize
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_round_down_and_stop_at_one() {
        let size = Size::new(10, 3);
        let sides: Vec<_> = (0..size.level_count()).map(|k| (size.level(k).width, size.level(k).height)).collect();
        assert_eq!(sides, [(10, 3), (5, 1), (2, 1), (1, 1)]);
        assert_eq!(Size::new(1, 1).level_count(), 1);
        assert_eq!(Size::new(4096, 4096).level_count(), 13);
        assert_eq!(Size::new(3, 3).level(200), Size::new(1, 1));
    }

    #[test]
    fn wrap_modes_worked_by_hand() {
        let at = |wrap: Wrap| (-4..7).map(|i| wrap.index(i, 3)).collect::<Vec<_>>();
        assert_eq!(at(Wrap::Repeat), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(at(Wrap::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
        assert_eq!(at(Wrap::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
    }
}
