//! What containers and engines ask of the sides of a texture.

use super::Size;

/// A rule for both sides of level 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Sides {
    /// None
    #[default]
    #[value(name = "keep")]
    Any,
    /// Multiples of 4, as the blocks of compressed textures are
    #[value(name = "4")]
    MultipleOf4,
    /// Powers of two
    #[value(name = "pot")]
    PowerOfTwo,
}

impl Sides {
    /// The next larger size of these sides, or the same.
    pub fn fit(self, size: Size) -> Size {
        let side = |side: usize| match self {
            Sides::Any => side,
            Sides::MultipleOf4 => side.next_multiple_of(4),
            Sides::PowerOfTwo => side.next_power_of_two(),
        };
        Size::new(side(size.width), side(size.height))
    }

    /// Whether a size has them.
    pub fn holds(self, size: Size) -> bool {
        self.fit(size) == size
    }

    /// In words: "multiples of 4".
    pub fn describe(self) -> &'static str {
        match self {
            Sides::Any => "any",
            Sides::MultipleOf4 => "multiples of 4",
            Sides::PowerOfTwo => "powers of two",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_grow_to_the_next_that_fits() {
        let size = Size::new(685, 400);
        assert_eq!(Sides::Any.fit(size), size);
        assert_eq!(Sides::MultipleOf4.fit(size), Size::new(688, 400));
        assert_eq!(Sides::PowerOfTwo.fit(size), Size::new(1024, 512));
        assert!(Sides::MultipleOf4.holds(Size::new(4, 400)) && !Sides::PowerOfTwo.holds(Size::new(4, 400)));
    }
}
