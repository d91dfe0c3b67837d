// Generated from kernels/wgsl/shading.wgsl: change that file, not this one.
// In GLSL ES, include it after `precision highp float;` and `precision highp int;`.
#ifndef MF_SHADING_GLSL
#define MF_SHADING_GLSL

// Reflection by the lobes of ndf: specular and diffuse terms, energy that single reflections lose, and where to look up an
// environment.
// Needs: roughness, ndf
//
// l, v: unit, towards light and viewer, in the tangent frame of the lobe, z its normal. BRDFs are per steradian, without the
// cosine; black from below. f0: reflectance at normal incidence, 0 to 1. alpha 0 to 1; tensors as in ndf.

// Schlick's Fresnel term, f0 + (1 - f0) (1 - v.h)^5 (Schlick 1994, eq. 15); v.h 0 to 1.
vec3 mf_schlick(vec3 f0, float v_h) {
    float x = clamp(1.0 - v_h, 0.0, 1.0);
    float x2 = x * x;
    return f0 + (vec3(1.0, 1.0, 1.0) - f0) * (x2 * x2 * x);
}

// Unit half vector of l and v; z where they are opposite.
vec3 mf_half_vector(vec3 l, vec3 v) {
    vec3 sum = l + v;
    float length2 = dot(sum, sum);
    if (length2 < 1.0e-12) {
        return vec3(0.0, 0.0, 1.0);
    }
    return sum * inversesqrt(length2);
}

// Specular BRDF of a round GGX lobe: F D G2 / (4 n.l n.v), height-correlated (Walter et al. 2007, eq. 20; Heitz 2014, eq. 99).
vec3 mf_specular_ggx(vec3 l, vec3 v, vec3 f0, float alpha) {
    if (l.z <= 0.0 || v.z <= 0.0) {
        return vec3(0.0, 0.0, 0.0);
    }
    vec3 h = mf_half_vector(l, v);
    return (mf_d_ggx_tangent(h, alpha) * mf_v_smith_ggx(l.z, v.z, alpha)) * mf_schlick(f0, dot(v, h));
}

// The same of a tensor.
vec3 mf_specular_ggx_tensor(vec3 l, vec3 v, vec3 f0, vec3 r) {
    if (l.z <= 0.0 || v.z <= 0.0) {
        return vec3(0.0, 0.0, 0.0);
    }
    vec3 h = mf_half_vector(l, v);
    return (mf_d_ggx_tensor(h, r) * mf_v_smith_ggx_tensor(l, v, r)) * mf_schlick(f0, dot(v, h));
}

// Share of light that a white (f0 = 1) GGX lobe does not reflect at once, 1 - E for the directional albedo E, n.v 0 to 1: a
// function of t = n.v / alpha, alpha and n.v fitted to quadrature, within 0.008. Of a tensor, take alpha^2 = (xx + yy) / 2:
// that is within 0.1 of a lobe twice as wide as thin, 0.015 on average. The geometric mean and the width along v are worse.
float mf_energy_loss_ggx(float n_v, float alpha) {
    float a = clamp(alpha, MF_SMOOTHEST, 1.0);
    float z = clamp(n_v, 0.0, 1.0);
    float t = z / a;
    float cubic = t * (-0.6346 + t * (0.5886 + t * 0.3574));
    float below = 1.0 + 1.0023 * sqrt(t) + cubic + z * (5.6488 - 1.4708 * t);
    return t * (0.2683 + 4.1529 * a * a + 0.1285 * z * z) / below;
}

// Its mean over n.v weighted by n.v, 1 - E_avg with E_avg = 2 integral E mu dmu, within 0.004.
float mf_energy_loss_ggx_mean(float alpha) {
    float a = clamp(alpha, MF_SMOOTHEST, 1.0);
    float below = 1.0 + 17.313 * sqrt(a) + a * (-11.192 + a * 32.897);
    return a * a * (14.537 + 9.128 * a) / below;
}

// BRDF of the light reflected more than once, to be added to mf_specular_ggx: (1 - E(l)) (1 - E(v)) / (pi (1 - E_avg)) (Kulla &
// Conty 2017) times F^2 E_avg / (1 - F (1 - E_avg)) (Hill 2018), with the mean of Schlick's term F = (1 + 20 f0) / 21. A
// white lobe then reflects 1, within 0.013.
vec3 mf_multiscatter_ggx(float n_l, float n_v, vec3 f0, float alpha) {
    float lost = mf_energy_loss_ggx_mean(alpha);
    float both = mf_energy_loss_ggx(n_l, alpha) * mf_energy_loss_ggx(n_v, alpha) / (MF_PI * lost);
    vec3 f = (vec3(1.0, 1.0, 1.0) + 20.0 * f0) / 21.0;
    return both * (1.0 - lost) * (f * f / (vec3(1.0, 1.0, 1.0) - lost * f));
}

// Scale on mf_specular_ggx instead, 1 + f0 (1 - E(v)) / E(v) (Turquin 2019). White reflects 1, within 0.03; l and v
// are not interchangeable.
vec3 mf_turquin_scale(float n_v, vec3 f0, float alpha) {
    float lost = mf_energy_loss_ggx(n_v, alpha);
    return vec3(1.0, 1.0, 1.0) + (lost / (1.0 - lost)) * f0;
}

// Diffuse BRDF for Smith GGX surfaces (Hammon 2017, PBR Diffuse Lighting for GGX+Smith Microsurfaces), albedo 0 to 1. Here
// facing = |l + v|^2 / 4 and (1/2 + n.h) / n.h = 1 + sqrt(facing) / (n.l + n.v), so that nothing is 0/0. A white surface
// reflects up to 1.03 for alpha 0.25 and up to 1.17 for alpha 1: lower the albedo where that matters.
vec3 mf_diffuse_hammon(vec3 l, vec3 v, vec3 albedo, float alpha) {
    if (l.z <= 0.0 || v.z <= 0.0) {
        return vec3(0.0, 0.0, 0.0);
    }
    vec3 sum = l + v;
    float facing = 0.25 * dot(sum, sum);
    float rough = facing * (0.9 - 0.4 * facing) * (1.0 + sqrt(facing) / max(sum.z, MF_GRAZING));
    // 1 - (1 - x)^5, multiplied out.
    float from_l = l.z * (5.0 + l.z * (-10.0 + l.z * (10.0 + l.z * (l.z - 5.0))));
    float from_v = v.z * (5.0 + v.z * (-10.0 + v.z * (10.0 + v.z * (v.z - 5.0))));
    float once = mix(1.05 * from_l * from_v, rough, alpha) / MF_PI;
    return albedo * (vec3(once, once, once) + (0.1159 * alpha) * albedo);
}

// Diffuse cosine of a footprint from its mean normal, not made unit (its length as a map of mean normals holds it): the mean of
// n.l, exact while l is above every texel's horizon. In the place of n.l in albedo / pi n.l.
float mf_diffuse_mean_normal(vec3 mean, vec3 l) {
    return max(dot(mean, l), 0.0);
}

// The same per area of the mean plane, from the mean and covariance (xx, xy, yy) of Gaussian slopes, below the horizon too: the
// mean of max(0, l.z - s.l.xy), which is c Phi(c / tau) + tau phi(c / tau) with c = l.z - mean.l.xy, tau^2 = l.xy^T C l.xy
// (Dupuy et al. 2013), within 1e-6 (1 + tau). No shadows. For GGX slopes it is mf_sigma_slope_lobe.
float mf_diffuse_gaussian(vec3 l, vec2 mean, vec3 covariance) {
    float c = l.z - mean.x * l.x - mean.y * l.y;
    float tau = sqrt(mf_tensor_quadratic(covariance, vec2(l.x, l.y)));
    float lit = max(c, 0.0);
    if (abs(c) >= 13.0 * tau) {
        return lit;
    }
    // What the facets that face away would take off: as much as facets facing the light below the horizon get.
    float x = 0.70710678 * abs(c) / tau;
    return lit + tau * exp(-x * x) * max(0.39894228 - 0.70710678 * x * mf_erfc_scaled(x), 0.0);
}

// v reflected by the plane of n, any length above 0.
vec3 mf_reflected(vec3 v, vec3 n) {
    return (2.0 * dot(v, n) / max(dot(n, n), 1.0e-20)) * n - v;
}

// Where engines look up an environment for an anisotropic lobe: v reflected by the normal mixed with v's part across the thin
// axis, by |anisotropy| min(1, 5 perceptual) (McAuley 2015; Filament, getReflectedVector). anisotropy -1 to 1: wider along x
// above 0, along y below. Smooth lobes are bent as well.
vec3 mf_reflection_filament(vec3 v, float anisotropy, float perceptual) {
    vec3 across = vec3(v.x, 0.0, v.z);
    if (anisotropy < 0.0) {
        across = vec3(0.0, v.y, v.z);
    }
    float bend = abs(anisotropy) * clamp(5.0 * perceptual, 0.0, 1.0);
    vec3 n = mix(vec3(0.0, 0.0, 1.0), across, bend);
    return mf_reflected(v, vec3(n.x, n.y, max(n.z, MF_GRAZING)));
}

// Unit mean direction of the light that a GGX lobe reflects to v. Where the lobe is a sphere, normals that v sees are v plus a
// point of a cap (Dupuy & Benyoub 2023), whose mean is v + z (1 - v.z) / 2: stretched back, (R v.xy, sigma) with
// sigma = (v.z + sqrt(v.z^2 + v.xy^T R v.xy)) / 2. That normal reflects v; a factor 1 + (xx + yy) / 2 on sigma stands for the
// light that is lost below the horizon. Against quadrature, for perceptual roughness 0.1 to 0.8, anisotropy 0.5 and 0.9 (widths
// alpha (1 +- anisotropy)) and v up to 75 degrees from z: off by 3 degrees on average, 11 at most. The mirror direction is off
// by 16 and 98, mf_reflection_filament by 22 and 133. For round lobes: 1.3 and 5.7, the mirror direction 13 and 57.
vec3 mf_mean_reflection_ggx(vec3 v, vec3 r) {
    float z = max(v.z, 0.0);
    float sigma = 0.5 * (z + sqrt(z * z + mf_tensor_quadratic(r, vec2(v.x, v.y))));
    vec2 n = vec2(r.x * v.x + r.y * v.y, r.y * v.x + r.z * v.y);
    return mf_reflected(v, vec3(n.x, n.y, max(sigma * (1.0 + 0.5 * (r.x + r.z)), MF_GRAZING)));
}

// The same for engines that look up round lobes along the mirror direction: R without its smaller eigenvalue bends, so
// that nothing does for round or smooth lobes. Off by 3.5 degrees on average and 23 at most, as above.
vec3 mf_bent_reflection_ggx(vec3 v, vec3 r) {
    float z = max(v.z, 0.0);
    float sigma = 0.5 * (z + sqrt(z * z + mf_tensor_quadratic(r, vec2(v.x, v.y))));
    float side = 0.5 * (r.x - r.z);
    float spread = sqrt(side * side + r.y * r.y);
    vec2 n = vec2((spread + side) * v.x + r.y * v.y, r.y * v.x + (spread - side) * v.y);
    return mf_reflected(v, vec3(n.x, n.y, max(sigma * (1.0 + 0.5 * (r.x + r.z)), MF_GRAZING)));
}

#endif
