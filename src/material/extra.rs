//! Further maps of a chain, for engines that read more than a normal and a roughness.

use serde::Serialize;

use super::Encoding;
use crate::error::{Error, Result};
use crate::ndf::Form;

/// A map that a build writes on demand, at every level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Extra {
    /// Both widths, and the angle of the larger
    Axes,
    /// Disney's parameters: roughness, anisotropy, rotation
    Burley,
    /// Root of the roughness tensor: two widths in a form that can be filtered
    Tensor,
    /// Scale on the specular term for renderers without multiple scattering
    Energy,
    /// Scale on the diffuse term: length of the mean normal
    Diffuse,
    /// What the mesh adds, as the root of its tensor; of a baked material only
    #[value(skip)]
    Curvature,
    /// Where flakes are: their density and their share of the surface; of a material with flakes only
    #[value(skip)]
    Flakes,
}

/// `energy` over this is what unsigned textures hold: 1 is a whole byte (102), and nothing is larger, since a GGX lobe
/// reflects 0.409 or more.
pub const LARGEST_ENERGY: f32 = 2.5;

impl Extra {
    /// All there are.
    pub const ALL: [Extra; 7] =
        [Extra::Axes, Extra::Burley, Extra::Tensor, Extra::Energy, Extra::Diffuse, Extra::Curvature, Extra::Flakes];

    /// In options, in file names, and the map's role in the manifest.
    pub fn name(self) -> &'static str {
        match self {
            Extra::Axes => "axes",
            Extra::Burley => "burley",
            Extra::Tensor => "tensor",
            Extra::Energy => "energy",
            Extra::Diffuse => "diffuse",
            Extra::Curvature => "curvature",
            Extra::Flakes => "flakes",
        }
    }

    /// The one of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|extra| extra.name() == name)
    }

    /// Whether a chain of this form, with so many lobes a texel, has what the map shows.
    ///
    /// # Errors
    /// One width where two are shown; several lobes where one is.
    pub fn check(self, form: Form, lobes: usize) -> Result<()> {
        let option = format!("--extra {}", self.name());
        let wide = matches!(self, Extra::Axes | Extra::Burley | Extra::Tensor);
        if lobes > 1 && !matches!(self, Extra::Energy | Extra::Curvature | Extra::Flakes) {
            return Err(Error::invalid_option(&option, format!("{lobes} lobes a texel"), "--lobes iso or aniso"));
        }
        if wide && form == Form::Isotropic {
            return Err(Error::invalid_option(&option, "lobes of one width", "two widths: --lobes aniso"));
        }
        Ok(())
    }

    /// Name of each channel in float files, and what it is.
    pub fn channels(self, encoding: Encoding) -> &'static [(&'static str, &'static str)] {
        match (self, encoding) {
            (Extra::Axes, Encoding::Signed) => &[("alpha.x", "alpha.x"), ("alpha.y", "alpha.y"), ("angle", "angle")],
            (Extra::Axes, Encoding::Unsigned) => &[
                ("roughness.x", "perceptual-roughness.x"),
                ("roughness.y", "perceptual-roughness.y"),
                ("turn", "angle.turn"),
            ],
            (Extra::Burley, _) => &[
                ("roughness", "perceptual-roughness"),
                ("anisotropy", "burley.anisotropy"),
                ("rotation", "burley.rotation"),
            ],
            (Extra::Tensor, _) => &[("s.xx", "tensor-root.xx"), ("s.yy", "tensor-root.yy"), ("s.xy", "tensor-root.xy")],
            (Extra::Energy, _) => &[("energy", "specular-scale")],
            (Extra::Diffuse, _) => &[("diffuse", "diffuse-scale")],
            (Extra::Flakes, Encoding::Signed) => &[("density", "flake-density"), ("mask", "flake-mask")],
            // Two channels of a PNG would be gray and alpha.
            (Extra::Flakes, Encoding::Unsigned) => {
                &[("density", "flake-density"), ("mask", "flake-mask"), ("unused", "unused")]
            }
            (Extra::Curvature, Encoding::Signed) => {
                &[("k.xx", "added-tensor.xx"), ("k.yy", "added-tensor.yy"), ("k.xy", "added-tensor.xy")]
            }
            (Extra::Curvature, Encoding::Unsigned) => {
                &[("s.xx", "added-tensor-root.xx"), ("s.yy", "added-tensor-root.yy"), ("s.xy", "added-tensor-root.xy")]
            }
        }
    }

    /// How a shader gets what the channels stand for, in terms of the channels r, g, b in their order.
    pub fn decode(self, encoding: Encoding) -> &'static str {
        match (self, encoding) {
            (Extra::Axes, Encoding::Signed) => "alpha_x = r; alpha_y = g; angle = b",
            (Extra::Axes, Encoding::Unsigned) => "alpha_x = r*r; alpha_y = g*g; angle = 2*pi*b",
            (Extra::Burley, _) => {
                "aspect = sqrt(1 - 0.9*g); alpha_x = r*r / aspect; alpha_y = r*r * aspect; angle = 2*pi*b"
            }
            (Extra::Tensor, Encoding::Signed) => "S = [r b; b g]; R = S*S",
            (Extra::Tensor, Encoding::Unsigned) => "c = (255*b - 128) / 254; S = [r c; c g]; R = S*S",
            (Extra::Energy, Encoding::Signed) => "specular *= r",
            (Extra::Energy, Encoding::Unsigned) => "specular *= 2.5*r",
            (Extra::Diffuse, _) => "diffuse = albedo/pi * r * max(0, dot(n, l))",
            (Extra::Flakes, _) => {
                "variation = sqrt((1 + size_variation^2) / max(r, 0.001) - 1); D *= 1 + g*(glint(variation) - 1)"
            }
            (Extra::Curvature, Encoding::Signed) => "K = [r b; b g], to be added to R in projected space",
            (Extra::Curvature, Encoding::Unsigned) => {
                "c = (255*b - 128) / 254; S = [r c; c g]; K = S*S, to be added to R in projected space"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_options() {
        for extra in Extra::ALL {
            let value = clap::ValueEnum::to_possible_value(&extra);
            let of_a_build = !matches!(extra, Extra::Curvature | Extra::Flakes);
            assert_eq!(value.is_some(), of_a_build, "{}", extra.name());
            assert!(value.is_none_or(|value| value.get_name() == extra.name()));
            assert_eq!(Extra::by_name(extra.name()), Some(extra));
            for encoding in [Encoding::Signed, Encoding::Unsigned] {
                assert!([1, 2, 3].contains(&extra.channels(encoding).len()));
            }
        }
        // As the README and the decode formulas have it.
        assert_eq!(255.0 / LARGEST_ENERGY, 102.0);
    }

    #[test]
    fn two_widths_and_one_lobe_are_asked_for() {
        for extra in [Extra::Axes, Extra::Burley, Extra::Tensor] {
            let message = extra.check(Form::Isotropic, 1).unwrap_err().to_string();
            assert!(message.contains("--lobes aniso") && message.contains(extra.name()), "{message}");
            assert!(extra.check(Form::Anisotropic, 1).is_ok() && extra.check(Form::Anisotropic, 2).is_err());
        }
        assert!(Extra::Diffuse.check(Form::Isotropic, 1).is_ok() && Extra::Diffuse.check(Form::Isotropic, 2).is_err());
        assert!(Extra::Energy.check(Form::Isotropic, 4).is_ok());
    }
}
