//! Twins of `kernels/wgsl/footprint.wgsl`.

use glam::{DMat2, DVec2, DVec3};

use super::geometric_aa::{add_kernel_projected, kernel, kernel_clamp, matrix, tensor};
use super::moments::{Lobe, bent, tensor_positive};
use super::shading::specular_ggx_tensor;

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Of the mip chain's lobe: unit, in the surface's tangent frame.
    pub normal: DVec3,
    /// Its tensor in its bent frame.
    pub tensor: DVec3,
    /// The material's own tensor before folding, or 0.
    pub base: DVec3,
    /// Derivative of the mesh normal, or of the half vector, along screen x.
    pub dndx: DVec3,
    /// The same along screen y.
    pub dndy: DVec3,
    /// Derivative of the lobe's normal in the tangent frame along screen x.
    pub dmdx: DVec3,
    /// The same along screen y.
    pub dmdy: DVec3,
    /// Variance of the pixel's filter, pixels squared.
    pub sigma2: f64,
    /// Most that either source adds to alpha^2.
    pub most: f64,
    /// Width of a texel in pixels; 0 where nothing is folded.
    pub texel: f64,
}

/// Components along the bent frame of n.
pub fn bent_components(n: DVec3, d: DVec3) -> DVec2 {
    let (t, b) = bent(n);
    DVec2::new(d.dot(t), d.dot(b))
}

/// `(z x dn) x n`.
pub fn carried_derivative(n: DVec3, dn: DVec3) -> DVec3 {
    DVec3::Z.cross(dn).cross(n)
}

/// `M k M^T`, with the turns of n for unit turns of the mesh normal as the columns of M.
pub fn carried_kernel(n: DVec3, k: DVec3) -> DVec3 {
    let columns = [DVec3::X, DVec3::Y].map(|turn| bent_components(n, carried_derivative(n, turn)));
    let m = DMat2::from_cols(columns[0], columns[1]);
    tensor(m * matrix(k) * m.transpose())
}

/// `w^2 / (12 sigma2)`, at most 1.
pub fn folded_share(sigma2: f64, texel: f64) -> f64 {
    (texel * texel / (12.0 * sigma2).max(1e-12)).min(1.0)
}

/// The least tensor not below `V + (1 - share) K` nor below K, without V: `max(V + K - O, K) - V`.
pub fn residual_kernel(k: DVec3, folded: DVec3, share: f64) -> DVec3 {
    if k.x + k.z <= 0.0 {
        return DVec3::ZERO;
    }
    let folded = tensor_positive(folded);
    let (chain, derivatives) = (folded + (1.0 - share) * k, k);
    chain + tensor_positive(derivatives - chain) - folded
}

/// The lobe with kernels of the mesh and of the normal map.
pub fn footprint_lobe(f: Footprint, a: DVec2, b: DVec2) -> Lobe {
    let [c, d] = [f.dmdx, f.dmdy].map(|dm| bent_components(f.normal, dm));
    let mesh = kernel_clamp(kernel(a, b, f.sigma2), f.most);
    let map = kernel_clamp(kernel(c, d, f.sigma2), f.most);
    let more = residual_kernel(map, f.tensor - f.base, folded_share(f.sigma2, f.texel));
    Lobe { normal: f.normal, tensor: add_kernel_projected(f.tensor, mesh + more) }
}

/// With derivatives of the mesh normal.
pub fn footprint_normals(f: Footprint) -> Lobe {
    let [a, b] = [f.dndx, f.dndy].map(|dn| bent_components(f.normal, carried_derivative(f.normal, dn)));
    footprint_lobe(f, a, b)
}

/// With derivatives of the half vector.
pub fn footprint_half_vectors(f: Footprint) -> Lobe {
    let [a, b] = [f.dndx, f.dndy].map(|dh| bent_components(f.normal, dh));
    footprint_lobe(f, a, b)
}

/// `tau ln(1 + e^(mean / tau))`, tau the deviation over `sqrt(2 pi) ln 2`: at a mean of 0, the mean of max(0, x) over a
/// Gaussian x.
pub fn diffuse_cosine(scale: f64, cosine: f64) -> f64 {
    let variance = 0.5 * (1.0 - scale * scale) * (1.0 - cosine * cosine);
    let (mean, tau) = (scale * cosine, variance.max(1e-12).sqrt() / 1.7375);
    mean.max(0.0) + tau * (-mean.abs() / tau).exp().ln_1p()
}

/// Light that a pixel reflects from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflection {
    /// `F D V n.l`.
    pub specular: DVec3,
    /// In place of `n.l`.
    pub diffuse: f64,
}

/// GGX with height-correlated Smith masking, D times the glint ratio; and the softened cosine.
pub fn footprint_shade(lobe: Lobe, v: DVec3, l: DVec3, f0: DVec3, glint: f64, scale: f64) -> Reflection {
    let local = |d: DVec3| bent_components(lobe.normal, d).extend(d.dot(lobe.normal));
    let (v, l) = (local(v), local(l));
    let specular = glint * l.z.max(0.0) * specular_ggx_tensor(l, v, f0, lobe.tensor);
    Reflection { specular, diffuse: diffuse_cosine(scale, l.z) }
}

#[cfg(test)]
mod tests;
