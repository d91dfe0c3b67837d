//! Twins of `kernels/wgsl/geometric_aa.wgsl` and `geometric_aa_screen.wgsl`.
//!
//! Tensors are (xx, xy, yy) with eigenvalues alpha^2; derivatives are per pixel.

use glam::{DMat2, DVec2, DVec3};

/// Variance of a box of one pixel.
pub const SIGMA2_BOX: f64 = 1.0 / 12.0;

/// `1 / (2 pi)`: the Gaussian with the peak of a unit box.
pub const SIGMA2_PEAK: f64 = 0.5 * std::f64::consts::FRAC_1_PI;

/// A standard deviation of half a pixel.
pub const SIGMA2_HALF: f64 = 0.25;

/// Most that is added to alpha^2 along an axis.
pub const MOST_ADDED: f64 = 0.18;

/// Most of the half extent of a pixel in slopes.
pub const EXTENT_2016: f64 = 0.7;

/// Least cosine that a half vector's slope is told for.
pub const LEAST_HALF_COSINE: f64 = 0.02;

/// A tensor as a matrix.
pub fn matrix(t: DVec3) -> DMat2 {
    DMat2::from_cols_array(&[t.x, t.y, t.y, t.z])
}

/// A symmetric matrix as a tensor.
pub fn tensor(m: DMat2) -> DVec3 {
    DVec3::new(m.x_axis.x, 0.5 * (m.x_axis.y + m.y_axis.x), m.y_axis.y)
}

/// A tensor with `f` of its eigenvalues.
pub fn with_eigenvalues(t: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    let (mean, side) = (0.5 * (t.x + t.z), 0.5 * (t.x - t.z));
    let spread = side.hypot(t.y);
    let (high, low) = (f(mean + spread), f(mean - spread));
    let scale = if spread > 0.0 { 0.5 * (high - low) / spread } else { 0.0 };
    let middle = 0.5 * (high + low);
    DVec3::new(middle + side * scale, t.y * scale, middle - side * scale)
}

/// Derivative of `(v + l) / |v + l|`.
pub fn half_vector_derivative(v: DVec3, l: DVec3, dv: DVec3, dl: DVec3) -> DVec3 {
    let inverse = 1.0 / (v + l).length().max(1e-6);
    let (h, d) = ((v + l) * inverse, (dv + dl) * inverse);
    d - h * h.dot(d)
}

/// Derivative of h's components along t and b in a frame that turns with its normal: t changes by `-(t . dn) n`.
pub fn projected_derivative(h: DVec3, dh: DVec3, n: DVec3, dn: DVec3, t: DVec3, b: DVec3) -> DVec2 {
    let along = |axis: DVec3| dh.dot(axis) + h.dot(-axis.dot(dn) * n);
    DVec2::new(along(t), along(b))
}

/// Derivative of `-h.xy / h.z`, by the quotient rule.
pub fn slope_derivative(h: DVec3, dh: DVec3) -> DVec2 {
    let z = h.z.max(LEAST_HALF_COSINE);
    (h.truncate() * dh.z - dh.truncate() * z) / (z * z)
}

/// `2 sigma2 (a a^T + b b^T)` (Tokuyoshi & Kaplanyan 2021).
pub fn kernel(a: DVec2, b: DVec2, sigma2: f64) -> DVec3 {
    let delta = DMat2::from_cols(a, b);
    tensor(2.0 * sigma2 * (delta * delta.transpose()))
}

/// `2 sigma2 (|a| + |b|)^2` for each axis.
pub fn kernel_rectangle(a: DVec2, b: DVec2, sigma2: f64) -> DVec3 {
    let extent = a.abs() + b.abs();
    2.0 * sigma2 * DVec3::new(extent.x * extent.x, 0.0, extent.y * extent.y)
}

/// Half the trace of the kernel of normals (Tokuyoshi & Kaplanyan 2021).
pub fn kernel_mean(dndx: DVec3, dndy: DVec3, sigma2: f64) -> f64 {
    sigma2 * (dndx.length_squared() + dndy.length_squared())
}

/// Its trace.
pub fn kernel_bound(dndx: DVec3, dndy: DVec3, sigma2: f64) -> f64 {
    2.0 * kernel_mean(dndx, dndy, sigma2)
}

/// No eigenvalue above `most`.
pub fn kernel_clamp(k: DVec3, most: f64) -> DVec3 {
    with_eigenvalues(k, |e| e.min(most))
}

/// `R + K`, no width above 1.
pub fn add_kernel(r: DVec3, k: DVec3) -> DVec3 {
    if k.x + k.z <= 0.0 { r } else { kernel_clamp(r + k, 1.0) }
}

/// The same for a round lobe.
pub fn add_kernel_mean(alpha2: f64, k: f64) -> f64 {
    (alpha2 + k).min(1.0)
}

/// `B' = B + K` for `B = R (I - R)^-1` (Tokuyoshi & Kaplanyan 2021), as `R' = (R + K P)(I + K P)^-1` with
/// `P = I - R`, which has the limit where R is 1.
pub fn add_kernel_projected(r: DVec3, k: DVec3) -> DVec3 {
    let kp = matrix(k) * (DMat2::IDENTITY - matrix(r));
    tensor((matrix(r) + kp) * (DMat2::IDENTITY + kp).inverse())
}

/// The same for a round lobe.
pub fn add_kernel_projected_mean(alpha2: f64, k: f64) -> f64 {
    let p = 1.0 - alpha2;
    // alpha^2 alone in B' = B + k, B = alpha^2 / p, R' = B' / (1 + B').
    (alpha2 + k * p) / (1.0 + k * p)
}

/// Kaplanyan et al. 2016, the rectangle.
pub fn aa_2016(r: DVec3, a: DVec2, b: DVec2, extent: f64) -> DVec3 {
    let e = (0.5 * (a.abs() + b.abs())).min(DVec2::splat(extent));
    add_kernel(r, 2.0 * DVec3::new(e.x * e.x, 0.0, e.y * e.y))
}

/// Kaplanyan et al. 2016, the parallelogram.
pub fn aa_2016_full(r: DVec3, a: DVec2, b: DVec2, sigma2: f64) -> DVec3 {
    add_kernel(r, kernel(a, b, sigma2))
}

/// Tokuyoshi 2017, the rectangle of h.xy.
pub fn aa_2019_axes(r: DVec3, a: DVec2, b: DVec2, sigma2: f64, most: f64) -> DVec3 {
    add_kernel(r, kernel_rectangle(a, b, sigma2).min(DVec3::new(most, 0.0, most)))
}

/// Tokuyoshi & Kaplanyan 2019, the parallelogram of h.xy.
pub fn aa_2019(r: DVec3, a: DVec2, b: DVec2, sigma2: f64) -> DVec3 {
    add_kernel(r, kernel(a, b, sigma2))
}

/// Tokuyoshi & Kaplanyan 2019, from normals.
pub fn aa_2019_normals(alpha2: f64, dndx: DVec3, dndy: DVec3, sigma2: f64, most: f64) -> f64 {
    add_kernel_mean(alpha2, kernel_bound(dndx, dndy, sigma2).min(most))
}

/// Tokuyoshi & Kaplanyan 2021, listing 1.
pub fn aa_2021(r: DVec3, a: DVec2, b: DVec2, sigma2: f64) -> DVec3 {
    add_kernel_projected(r, kernel(a, b, sigma2))
}

/// Tokuyoshi & Kaplanyan 2021, listing 5.
pub fn aa_2021_normals(alpha2: f64, dndx: DVec3, dndy: DVec3, sigma2: f64, most: f64) -> f64 {
    add_kernel_mean(alpha2, kernel_mean(dndx, dndy, sigma2).min(most))
}

/// [`aa_2021_normals`] at a pixel where n grows by dndx and dndy.
pub fn aa_screen_normal(alpha2: f64, dndx: DVec3, dndy: DVec3, sigma2: f64, most: f64) -> f64 {
    aa_2021_normals(alpha2, dndx, dndy, sigma2, most)
}

/// [`aa_2019_normals`], the same.
pub fn aa_screen_normal_bound(alpha2: f64, dndx: DVec3, dndy: DVec3, sigma2: f64, most: f64) -> f64 {
    aa_2019_normals(alpha2, dndx, dndy, sigma2, most)
}

/// [`aa_2021`] at a pixel where h grows by dhdx and dhdy.
pub fn aa_screen_half_vector(r: DVec3, dhdx: DVec3, dhdy: DVec3, sigma2: f64) -> DVec3 {
    aa_2021(r, dhdx.truncate(), dhdy.truncate(), sigma2)
}

/// [`aa_2019_axes`], the same.
pub fn aa_screen_half_vector_axes(r: DVec3, dhdx: DVec3, dhdy: DVec3, sigma2: f64, most: f64) -> DVec3 {
    aa_2019_axes(r, dhdx.truncate(), dhdy.truncate(), sigma2, most)
}

/// [`aa_2016`] with differences of slopes between the pixel and the next ones.
pub fn aa_screen_slope(r: DVec3, h: DVec3, dhdx: DVec3, dhdy: DVec3, extent: f64) -> DVec3 {
    let slope = |h: DVec3| -h.truncate() / h.z.max(LEAST_HALF_COSINE);
    aa_2016(r, slope(h + dhdx) - slope(h), slope(h + dhdy) - slope(h), extent)
}

#[cfg(test)]
mod tests;
