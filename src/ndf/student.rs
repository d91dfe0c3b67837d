//! The Student-t lobe: a tail between GGX's and Beckmann's, or heavier than GGX's.
//!
//! # Smith's Lambda for any exponent
//!
//! The slopes of the round lobe of unit width are a bivariate Student-t with `nu = 2 (gamma - 1)` degrees of freedom
//! and scale `I / 2`. A marginal of a multivariate t is a t with the same nu, so along every direction a slope x has
//! the density
//!
//! ```text
//! P(x) = C (1 + c x^2)^(-gamma + 1/2),   c = 1 / (gamma - 1),   C = Gamma(gamma - 1/2) / (Gamma(gamma - 1) sqrt(pi (gamma - 1)))
//! ```
//!
//! and Smith's Lambda of a direction with `a = 1 / tan theta` (Heitz 2014, section 4) is
//!
//! ```text
//! Lambda = 1/a integral_a^inf (x - a) P(x) dx = (1 + c a^2) P(a) / ((2 - c) a) - Q(a)
//! ```
//!
//! with the upper tail Q of P, an incomplete beta function: `I_y(1/2, gamma - 1) = 1 - 2 Q(a)` for
//! `y = c a^2 / (1 + c a^2)`. The first term is elementary, since `x P(x)` has the antiderivative
//! `-(1 + c x^2) P(x) / (2 - c)`, which vanishes at infinity for gamma above 3/2 only. Written in c, everything has
//! Beckmann's form as its limit c = 0 (Q becomes `erfc(a) / 2`), and GGX's at c = 1.

use std::f64::consts::PI;

use glam::Vec3;

use super::{Lobe, RoughnessTensor, ShapeInvariant};

/// Exponent gamma of the tail of a Student-t lobe, over 1: the density of steep slopes falls like `|s|^(-2 gamma)`.
/// 2 is GGX, infinity Beckmann. Between 1 and 3/2 the mean slope diverges: such a lobe has a density, but Smith's
/// masking is total.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct TailExponent(pub f32);

impl TailExponent {
    /// The exponent of GGX.
    pub const GGX: Self = Self(2.0);

    /// The limit of a Gaussian.
    pub const BECKMANN: Self = Self(f32::INFINITY);

    /// The heaviest tail that is fitted. At 3/2 Smith's Lambda diverges; here the mean slope, and Lambda at grazing
    /// angles, is still below three times that of GGX of the same width.
    pub const HEAVIEST: Self = Self(1.6);

    /// Degrees of freedom of the Student-t, `nu = 2 (gamma - 1)`.
    pub fn degrees_of_freedom(self) -> f64 {
        2.0 / self.weight()
    }

    /// `c = 1 / (gamma - 1)`: how heavy the tail is. 0 for Beckmann, 1 for GGX, 2 where the mean slope diverges.
    pub fn weight(self) -> f64 {
        1.0 / (f64::from(self.0) - 1.0)
    }

    /// The exponent for a weight of 0 or more.
    pub fn from_weight(c: f64) -> Self {
        Self((1.0 + 1.0 / c) as f32)
    }

    /// `gamma ln(1 + c q)`, the logarithm by which the density has fallen at the squared radius q; `q` for Beckmann.
    pub(crate) fn fall(self, q: f64) -> f64 {
        let c = self.weight();
        // To first order in c below: the difference is of the order of c q^2.
        if c == 0.0 { q } else { (1.0 + 1.0 / c) * (c * q).ln_1p() }
    }

    /// Density of one component of the slopes at 0, the C of the module's text. From the series of
    /// `Gamma(z + 1/2) / (Gamma(z) sqrt(z))` in 1/z (Abramowitz & Stegun 1964, from 6.1.37), after stepping z up.
    fn peak_of_marginal(self) -> f64 {
        // From this z on the terms that are left out are below 1e-11.
        const ENOUGH: f64 = 20.0;
        let z = 1.0 / self.weight();
        if z.is_infinite() {
            return 1.0 / PI.sqrt();
        }
        // Gamma(z + 1/2) / Gamma(z) is z / (z + 1/2) times the same at z + 1.
        let steps = (ENOUGH - z).ceil().max(0.0);
        let product: f64 = (0..steps as usize).map(|k| (z + k as f64) / (z + k as f64 + 0.5)).product();
        let up = z + steps;
        const TERMS: [f64; 6] = [1.0, -1.0 / 8.0, 1.0 / 128.0, 5.0 / 1024.0, -21.0 / 32768.0, -399.0 / 262_144.0];
        let series = TERMS.iter().rev().fold(0.0, |sum, term| sum / up + term);
        product * series * (up / z).sqrt() / PI.sqrt()
    }

    /// Smith's Lambda of the round lobe of unit width, as the module's text derives it.
    pub(super) fn unit_lambda(self, tan2: f64) -> f64 {
        let c = self.weight();
        if tan2 == 0.0 {
            return 0.0;
        }
        if c >= 2.0 || tan2.is_infinite() {
            return f64::INFINITY;
        }
        let a2 = 1.0 / tan2;
        let a = a2.sqrt();
        // P(a) = C (1 + c a^2)^(-gamma + 1/2).
        let fall = self.fall(a2) - 0.5 * (c * a2).ln_1p();
        // Nothing of 1 + Lambda is left of this in f64. (It also ends the series below: they only see a^2 < 64.)
        if fall > 44.0 {
            return 0.0;
        }
        let density = self.peak_of_marginal() * (-fall).exp();
        let mean = (1.0 + c * a2) * density / ((2.0 - c) * a);
        (mean - upper_tail(c, a2, a * density)).max(0.0)
    }
}

/// Share of the slopes above a; `ap` is `a P(a)`. By the series of the incomplete beta function from the nearer end,
/// all of whose terms are positive (Abramowitz & Stegun 1964, 26.5.4).
fn upper_tail(c: f64, a2: f64, ap: f64) -> f64 {
    let series = |ratio: &dyn Fn(f64) -> f64| {
        let (mut sum, mut term, mut k) = (1.0, 1.0, 0.0);
        while term > 1e-17 * sum {
            term *= ratio(k);
            sum += term;
            k += 1.0;
        }
        sum
    };
    let x = 1.0 / (1.0 + c * a2);
    if x >= 0.5 {
        // Of what lies between 0 and a. For c = 0 this is the series of erf.
        0.5 - ap * series(&|k| a2 * x * (1.0 + c * (0.5 + k)) / (1.5 + k))
    } else {
        0.5 * c * ap * series(&|k| x * (1.0 + c * (0.5 + k)) / (1.0 + c * (1.0 + k)))
    }
}

/// A lobe of Student-t slopes: `P22(s) = (1 + s^T R^-1 s / (gamma - 1))^-gamma / (pi sqrt(det R))` (STD, Ribardiere
/// et al. 2017), whose tail has an exponent of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Student {
    /// Unit, z out of the surface.
    pub normal: Vec3,
    /// Width, in the bent frame of the normal ([`super::Frame::bent`]).
    pub roughness: RoughnessTensor,
    /// How fast steep slopes get rare.
    pub tail: TailExponent,
}

impl From<Lobe> for Student {
    fn from(Lobe { normal, roughness }: Lobe) -> Self {
        Self { normal, roughness, tail: TailExponent::GGX }
    }
}

impl ShapeInvariant for Student {
    fn normal(&self) -> Vec3 {
        self.normal
    }

    fn roughness(&self) -> RoughnessTensor {
        self.roughness
    }

    fn unit_d(&self, p2: f64, z: f64) -> f64 {
        (-self.tail.fall(p2 / (z * z)) - 4.0 * z.ln()).exp() / PI
    }

    /// `1 - u = (1 + c r^2)^(-1 / c)`.
    fn unit_radius(&self, u: f64) -> f64 {
        let (c, fall) = (self.tail.weight(), -(-u).ln_1p());
        if c == 0.0 { fall.sqrt() } else { ((c * fall).exp_m1() / c).sqrt() }
    }

    fn unit_lambda(&self, tan2: f64) -> f64 {
        self.tail.unit_lambda(tan2)
    }
}
