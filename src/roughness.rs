//! The units of width, as types, and the only conversions between them.
//!
//! Public tools mix these up often (a file's perceptual value used as alpha, a variance added to the wrong
//! square), so widths have types of their own here. Where rows of plain numbers are
//! handed over for speed, their name says what they are: `perceptual`, or `alpha2` for a square.

/// GGX or Beckmann width in slope units, 0 (mirror) to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Alpha(pub f32);

/// What textures hold: `alpha = perceptual^2` (Burley 2012), 0 to 1. glTF, Unreal, Godot and Filament store it
/// as it is; Unity stores `1 - perceptual` and calls it smoothness; others call the same gloss.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct PerceptualRoughness(pub f32);

/// Variance of the slopes of a Beckmann surface along one axis. GGX has none: its second moment diverges.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct SlopeVariance(pub f32);

/// Concentration kappa of a von Mises-Fisher distribution of normals (not of reflected directions, whose
/// sharpness is a quarter of it at normal incidence).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Concentration(pub f32);

impl Alpha {
    /// The smoothest width that the NDFs are evaluated at: a mirror (alpha 0) has no density to evaluate.
    /// It keeps the peak `1/(pi alpha^2)` below 3.2e7, far inside the range of f32.
    pub const SMOOTHEST: Alpha = Alpha(1e-4);

    /// The width whose square is `alpha2`; squares below zero (rounding) count as zero.
    pub fn from_squared(alpha2: f32) -> Self {
        Self(alpha2.max(0.0).sqrt())
    }

    /// `alpha^2`: the quantity that variances are added to.
    pub fn squared(self) -> f32 {
        self.0 * self.0
    }

    /// What a texture stores: `sqrt(alpha)`.
    pub fn perceptual(self) -> PerceptualRoughness {
        PerceptualRoughness(self.0.max(0.0).sqrt())
    }

    /// Slope variance of a Beckmann lobe of this width, `alpha^2 / 2` (Heitz 2014).
    pub fn beckmann_variance(self) -> SlopeVariance {
        SlopeVariance(0.5 * self.squared())
    }
}

impl PerceptualRoughness {
    /// `alpha = perceptual^2`.
    pub fn alpha(self) -> Alpha {
        Alpha(self.0 * self.0)
    }

    /// From gloss or smoothness, `1 - perceptual`.
    pub fn from_smoothness(smoothness: f32) -> Self {
        Self(1.0 - smoothness)
    }

    /// To gloss or smoothness, `1 - perceptual`.
    pub fn smoothness(self) -> f32 {
        1.0 - self.0
    }
}

impl SlopeVariance {
    /// Width of the Beckmann lobe with this slope variance per axis, `sqrt(2 variance)`.
    pub fn beckmann_alpha(self) -> Alpha {
        Alpha::from_squared(2.0 * self.0)
    }
}

impl Concentration {
    /// From the length of the mean of unit normals, 0 to 1: Banerjee et al. 2005, eq. 4.4,
    /// `kappa = (3 r - r^3) / (1 - r^2)`, within 5 percent of the exact inverse (worst near kappa 5) of `coth kappa - 1/kappa`.
    pub fn from_mean_length(r: f32) -> Self {
        let r = r.clamp(0.0, 1.0);
        Self(r * (3.0 - r * r) / ((1.0 - r) * (1.0 + r)))
    }

    /// Width of the lobe with the same peak, `alpha^2 = 2 / kappa`: the constant that is right to first order.
    pub fn alpha(self) -> Alpha {
        Alpha::from_squared(2.0 / self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_worked_by_hand() {
        assert_eq!(PerceptualRoughness(0.5).alpha(), Alpha(0.25));
        assert_eq!(Alpha(0.25).perceptual(), PerceptualRoughness(0.5));
        assert_eq!(PerceptualRoughness::from_smoothness(0.25), PerceptualRoughness(0.75));
        assert_eq!(PerceptualRoughness(0.75).smoothness(), 0.25);
        assert_eq!(Alpha(0.2).beckmann_variance().beckmann_alpha(), Alpha(0.2));
        assert_eq!(Concentration(50.0).alpha(), Alpha(0.2));
        assert_eq!(Alpha::from_squared(-1e-9), Alpha(0.0));
    }

    #[test]
    fn banerjee_is_within_five_percent_of_the_exact_inverse() {
        let mut worst = 0.0f64;
        for i in 1..2000 {
            let kappa = 0.05 * 1.005f64.powi(i);
            if kappa > 500.0 {
                break;
            }
            let r = 1.0 / kappa.tanh() - 1.0 / kappa;
            worst = worst.max((f64::from(Concentration::from_mean_length(r as f32).0) / kappa - 1.0).abs());
        }
        assert!(worst > 0.04 && worst < 0.05, "worst {worst}");
    }

    #[test]
    fn smoothest_alpha_keeps_the_peak_finite() {
        let peak = 1.0 / (std::f32::consts::PI * Alpha::SMOOTHEST.squared());
        assert!(peak > 3.1e7 && peak < 3.2e7);
    }
}
