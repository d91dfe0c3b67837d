//! Twins of `kernels/wgsl/glint_chance.wgsl`: the library's own functions, in f64.

use crate::glint;

/// Four words from four.
pub fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    glint::pcg4d(v)
}

/// A uniform number from 23 bits.
pub fn unit(bits: u32) -> f64 {
    glint::unit(bits)
}

/// A fifth uniform number of a hash.
pub fn fifth(h: [u32; 4]) -> f64 {
    glint::fifth(h)
}

/// The standard normal number that is not passed with probability u.
pub fn normal_quantile(u: f64) -> f64 {
    glint::normal_quantile(u)
}

/// `1 - erf(x)`.
pub fn erfc(x: f64) -> f64 {
    glint::erfc(x)
}

/// The error function.
pub fn erf(x: f64) -> f64 {
    glint::erf(x)
}

/// `ln(1 - p)`.
pub fn ln_one_minus(p: f64) -> f64 {
    (-p).ln_1p()
}

/// `1 - exp(-x)`.
pub fn one_minus_exp(x: f64) -> f64 {
    -(-x).exp_m1()
}

/// First terms of Cornish & Fisher 1938.
pub fn skewed_normal(mean: f64, deviation: f64, skew: f64, z: f64) -> f64 {
    mean + deviation * z + skew * (z * z - 1.0) / 6.0
}

/// A Poisson count.
pub fn poisson(mean: f64, u: f64) -> f64 {
    glint::poisson(mean, u)
}

/// A count of n trials of chance p.
pub fn binomial(n: f64, p: f64, u: f64) -> f64 {
    glint::binomial(n, p, u)
}
