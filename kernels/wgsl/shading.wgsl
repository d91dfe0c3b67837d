// Reflection by the lobes of ndf: specular and diffuse terms, energy that single reflections lose, and where to look up an
// environment.
// Needs: roughness, ndf
//
// l, v: unit, towards light and viewer, in the tangent frame of the lobe, z its normal. BRDFs are per steradian, without the
// cosine; black from below. f0: reflectance at normal incidence, 0 to 1. alpha 0 to 1; tensors as in ndf.

// Schlick's Fresnel term, f0 + (1 - f0) (1 - v.h)^5 (Schlick 1994, eq. 15); v.h 0 to 1.
fn mf_schlick(f0: vec3f, v_h: f32) -> vec3f {
    let x: f32 = clamp(1.0 - v_h, 0.0, 1.0);
    let x2: f32 = x * x;
    return f0 + (vec3f(1.0, 1.0, 1.0) - f0) * (x2 * x2 * x);
}

// Unit half vector of l and v; z where they are opposite.
fn mf_half_vector(l: vec3f, v: vec3f) -> vec3f {
    let sum: vec3f = l + v;
    let length2: f32 = dot(sum, sum);
    if (length2 < 1.0e-12) {
        return vec3f(0.0, 0.0, 1.0);
    }
    return sum * inverseSqrt(length2);
}

// Specular BRDF of a round GGX lobe: F D G2 / (4 n.l n.v), height-correlated (Walter et al. 2007, eq. 20; Heitz 2014, eq. 99).
fn mf_specular_ggx(l: vec3f, v: vec3f, f0: vec3f, alpha: f32) -> vec3f {
    if (l.z <= 0.0 || v.z <= 0.0) {
        return vec3f(0.0, 0.0, 0.0);
    }
    let h: vec3f = mf_half_vector(l, v);
    return (mf_d_ggx_tangent(h, alpha) * mf_v_smith_ggx(l.z, v.z, alpha)) * mf_schlick(f0, dot(v, h));
}

// The same of a tensor.
fn mf_specular_ggx_tensor(l: vec3f, v: vec3f, f0: vec3f, r: vec3f) -> vec3f {
    if (l.z <= 0.0 || v.z <= 0.0) {
        return vec3f(0.0, 0.0, 0.0);
    }
    let h: vec3f = mf_half_vector(l, v);
    return (mf_d_ggx_tensor(h, r) * mf_v_smith_ggx_tensor(l, v, r)) * mf_schlick(f0, dot(v, h));
}

// Share of light that a white (f0 = 1) GGX lobe does not reflect at once, 1 - E for the directional albedo E, n.v 0 to 1: a
// function of t = n.v / alpha, alpha and n.v fitted to quadrature, within 0.008. Of a tensor, take alpha^2 = (xx + yy) / 2:
// that is within 0.1 of a lobe twice as wide as thin, 0.015 on average. The geometric mean and the width along v are worse.
fn mf_energy_loss_ggx(n_v: f32, alpha: f32) -> f32 {
    let a: f32 = clamp(alpha, MF_SMOOTHEST, 1.0);
    let z: f32 = clamp(n_v, 0.0, 1.0);
    let t: f32 = z / a;
    let cubic: f32 = t * (-0.6346 + t * (0.5886 + t * 0.3574));
    let below: f32 = 1.0 + 1.0023 * sqrt(t) + cubic + z * (5.6488 - 1.4708 * t);
    return t * (0.2683 + 4.1529 * a * a + 0.1285 * z * z) / below;
}

// Its mean over n.v weighted by n.v, 1 - E_avg with E_avg = 2 integral E mu dmu, within 0.004.
fn mf_energy_loss_ggx_mean(alpha: f32) -> f32 {
    let a: f32 = clamp(alpha, MF_SMOOTHEST, 1.0);
    let below: f32 = 1.0 + 17.313 * sqrt(a) + a * (-11.192 + a * 32.897);
    return a * a * (14.537 + 9.128 * a) / below;
}

// BRDF of the light reflected more than once, to be added to mf_specular_ggx: (1 - E(l)) (1 - E(v)) / (pi (1 - E_avg)) (Kulla &
// Conty 2017) times F^2 E_avg / (1 - F (1 - E_avg)) (Hill 2018), with the mean of Schlick's term F = (1 + 20 f0) / 21. A
// white lobe then reflects 1, within 0.013.
fn mf_multiscatter_ggx(n_l: f32, n_v: f32, f0: vec3f, alpha: f32) -> vec3f {
    let lost: f32 = mf_energy_loss_ggx_mean(alpha);
    let both: f32 = mf_energy_loss_ggx(n_l, alpha) * mf_energy_loss_ggx(n_v, alpha) / (MF_PI * lost);
    let f: vec3f = (vec3f(1.0, 1.0, 1.0) + 20.0 * f0) / 21.0;
    return both * (1.0 - lost) * (f * f / (vec3f(1.0, 1.0, 1.0) - lost * f));
}

// Scale on mf_specular_ggx instead, 1 + f0 (1 - E(v)) / E(v) (Turquin 2019). White reflects 1, within 0.03; l and v
// are not interchangeable.
fn mf_turquin_scale(n_v: f32, f0: vec3f, alpha: f32) -> vec3f {
    let lost: f32 = mf_energy_loss_ggx(n_v, alpha);
    return vec3f(1.0, 1.0, 1.0) + (lost / (1.0 - lost)) * f0;
}

// Diffuse BRDF for Smith GGX surfaces (Hammon 2017, PBR Diffuse Lighting for GGX+Smith Microsurfaces), albedo 0 to 1. Here
// facing = |l + v|^2 / 4 and (1/2 + n.h) / n.h = 1 + sqrt(facing) / (n.l + n.v), so that nothing is 0/0. A white surface
// reflects up to 1.03 for alpha 0.25 and up to 1.17 for alpha 1: lower the albedo where that matters.
fn mf_diffuse_hammon(l: vec3f, v: vec3f, albedo: vec3f, alpha: f32) -> vec3f {
    if (l.z <= 0.0 || v.z <= 0.0) {
        return vec3f(0.0, 0.0, 0.0);
    }
    let sum: vec3f = l + v;
    let facing: f32 = 0.25 * dot(sum, sum);
    let rough: f32 = facing * (0.9 - 0.4 * facing) * (1.0 + sqrt(facing) / max(sum.z, MF_GRAZING));
    // 1 - (1 - x)^5, multiplied out.
    let from_l: f32 = l.z * (5.0 + l.z * (-10.0 + l.z * (10.0 + l.z * (l.z - 5.0))));
    let from_v: f32 = v.z * (5.0 + v.z * (-10.0 + v.z * (10.0 + v.z * (v.z - 5.0))));
    let once: f32 = mix(1.05 * from_l * from_v, rough, alpha) / MF_PI;
    return albedo * (vec3f(once, once, once) + (0.1159 * alpha) * albedo);
}

// Diffuse cosine of a footprint from its mean normal, not made unit (its length as a map of mean normals holds it): the mean of
// n.l, exact while l is above every texel's horizon. In the place of n.l in albedo / pi n.l.
fn mf_diffuse_mean_normal(mean: vec3f, l: vec3f) -> f32 {
    return max(dot(mean, l), 0.0);
}

// The same per area of the mean plane, from the mean and covariance (xx, xy, yy) of Gaussian slopes, below the horizon too: the
// mean of max(0, l.z - s.l.xy), which is c Phi(c / tau) + tau phi(c / tau) with c = l.z - mean.l.xy, tau^2 = l.xy^T C l.xy
// (Dupuy et al. 2013), within 1e-6 (1 + tau). No shadows. For GGX slopes it is mf_sigma_slope_lobe.
fn mf_diffuse_gaussian(l: vec3f, mean: vec2f, covariance: vec3f) -> f32 {
    let c: f32 = l.z - mean.x * l.x - mean.y * l.y;
    let tau: f32 = sqrt(mf_tensor_quadratic(covariance, vec2f(l.x, l.y)));
    let lit: f32 = max(c, 0.0);
    if (abs(c) >= 13.0 * tau) {
        return lit;
    }
    // What the facets that face away would take off: as much as facets facing the light below the horizon get.
    let x: f32 = 0.70710678 * abs(c) / tau;
    return lit + tau * exp(-x * x) * max(0.39894228 - 0.70710678 * x * mf_erfc_scaled(x), 0.0);
}

// v reflected by the plane of n, any length above 0.
fn mf_reflected(v: vec3f, n: vec3f) -> vec3f {
    return (2.0 * dot(v, n) / max(dot(n, n), 1.0e-20)) * n - v;
}

// Where engines look up an environment for an anisotropic lobe: v reflected by the normal mixed with v's part across the thin
// axis, by |anisotropy| min(1, 5 perceptual) (McAuley 2015; Filament, getReflectedVector). anisotropy -1 to 1: wider along x
// above 0, along y below. Smooth lobes are bent as well.
fn mf_reflection_filament(v: vec3f, anisotropy: f32, perceptual: f32) -> vec3f {
    var across: vec3f = vec3f(v.x, 0.0, v.z);
    if (anisotropy < 0.0) {
        across = vec3f(0.0, v.y, v.z);
    }
    let bend: f32 = abs(anisotropy) * clamp(5.0 * perceptual, 0.0, 1.0);
    let n: vec3f = mix(vec3f(0.0, 0.0, 1.0), across, bend);
    return mf_reflected(v, vec3f(n.x, n.y, max(n.z, MF_GRAZING)));
}

// Unit mean direction of the light that a GGX lobe reflects to v. Where the lobe is a sphere, normals that v sees are v plus a
// point of a cap (Dupuy & Benyoub 2023), whose mean is v + z (1 - v.z) / 2: stretched back, (R v.xy, sigma) with
// sigma = (v.z + sqrt(v.z^2 + v.xy^T R v.xy)) / 2. That normal reflects v; a factor 1 + (xx + yy) / 2 on sigma stands for the
// light that is lost below the horizon. Against quadrature, for perceptual roughness 0.1 to 0.8, anisotropy 0.5 and 0.9 (widths
// alpha (1 +- anisotropy)) and v up to 75 degrees from z: off by 3 degrees on average, 11 at most. The mirror direction is off
// by 16 and 98, mf_reflection_filament by 22 and 133. For round lobes: 1.3 and 5.7, the mirror direction 13 and 57.
fn mf_mean_reflection_ggx(v: vec3f, r: vec3f) -> vec3f {
    let z: f32 = max(v.z, 0.0);
    let sigma: f32 = 0.5 * (z + sqrt(z * z + mf_tensor_quadratic(r, vec2f(v.x, v.y))));
    let n: vec2f = vec2f(r.x * v.x + r.y * v.y, r.y * v.x + r.z * v.y);
    return mf_reflected(v, vec3f(n.x, n.y, max(sigma * (1.0 + 0.5 * (r.x + r.z)), MF_GRAZING)));
}

// The same for engines that look up round lobes along the mirror direction: R without its smaller eigenvalue bends, so
// that nothing does for round or smooth lobes. Off by 3.5 degrees on average and 23 at most, as above.
fn mf_bent_reflection_ggx(v: vec3f, r: vec3f) -> vec3f {
    let z: f32 = max(v.z, 0.0);
    let sigma: f32 = 0.5 * (z + sqrt(z * z + mf_tensor_quadratic(r, vec2f(v.x, v.y))));
    let side: f32 = 0.5 * (r.x - r.z);
    let spread: f32 = sqrt(side * side + r.y * r.y);
    let n: vec2f = vec2f((spread + side) * v.x + r.y * v.y, r.y * v.x + (spread - side) * v.y);
    return mf_reflected(v, vec3f(n.x, n.y, max(sigma * (1.0 + 0.5 * (r.x + r.z)), MF_GRAZING)));
}
