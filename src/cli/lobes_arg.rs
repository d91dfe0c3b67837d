//! What `--lobes` says: how many lobes a texel has, and what shape.

use clap::ValueEnum;

use crate::error::{Error, Result};
use crate::fold::{FOLDS, Fold};
use crate::ndf::Form;

/// The lobes of a texel. A mixture has one width a lobe, which any shader can add up, unless two are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LobesArg {
    /// One lobe of one width: drop-in roughness
    Iso,
    /// One lobe of two widths and a direction
    Aniso,
    /// Two lobes, each with a normal, a roughness and a weight
    #[value(name = "2")]
    Two,
    /// Three lobes
    #[value(name = "3")]
    Three,
    /// Four lobes
    #[value(name = "4")]
    Four,
    /// Two lobes of two widths each
    #[value(name = "2-aniso")]
    TwoAniso,
    /// Three lobes of two widths each
    #[value(name = "3-aniso")]
    ThreeAniso,
    /// Four lobes of two widths each
    #[value(name = "4-aniso")]
    FourAniso,
    /// Two lobes that share a normal: a second roughness and its weight, for engines with two specular lobes
    Haze,
}

impl LobesArg {
    /// One width or two.
    pub fn form(self) -> Form {
        match self {
            Self::Iso | Self::Two | Self::Three | Self::Four | Self::Haze => Form::Isotropic,
            Self::Aniso | Self::TwoAniso | Self::ThreeAniso | Self::FourAniso => Form::Anisotropic,
        }
    }

    /// Lobes a texel.
    pub fn count(self) -> usize {
        match self {
            Self::Iso | Self::Aniso => 1,
            Self::Two | Self::TwoAniso | Self::Haze => 2,
            Self::Three | Self::ThreeAniso => 3,
            Self::Four | Self::FourAniso => 4,
        }
    }

    /// Whether the lobes differ in width alone.
    pub fn shared_normal(self) -> bool {
        self == Self::Haze
    }

    /// The option as it is written.
    pub fn option(self) -> String {
        let name = self.to_possible_value().expect("none is hidden").get_name().to_owned();
        format!("--lobes {name}")
    }

    /// Whether a fold gives such lobes.
    pub fn fits(self, fold: &Fold) -> bool {
        (self.form() == Form::Isotropic || fold.has_two_widths()) && (self.count() == 1 || fold.has_mixtures())
    }

    /// Refuses a fold that does not give such lobes.
    pub fn check(self, fold: &Fold) -> Result<()> {
        if self.fits(fold) {
            return Ok(());
        }
        let what = if self.count() > 1 && !fold.has_mixtures() { "lobe" } else { "width" };
        let names: Vec<_> = FOLDS.iter().filter(|fold| self.fits(fold)).map(|fold| fold.name).collect();
        let expected = match names.len() {
            0 => "another form: no fold gives this one".into(),
            1 => format!("--fold {}", names[0]),
            _ => format!("one of {}", names.join(", ")),
        };
        Err(Error::invalid_option(self.option(), format!("fold '{}', which has one {what} only", fold.name), expected))
    }
}
