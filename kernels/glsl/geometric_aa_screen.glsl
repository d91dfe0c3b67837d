// Generated from kernels/wgsl/geometric_aa_screen.wgsl: change that file, not this one.
// In GLSL ES, include it after `precision highp float;` and `precision highp int;`.
#ifndef MF_GEOMETRIC_AA_SCREEN_GLSL
#define MF_GEOMETRIC_AA_SCREEN_GLSL

// Geometric specular anti-aliasing with the screen's own derivatives, for fragment shaders; see geometric_aa for which to
// use when. Call these outside of branches: derivatives compare neighbouring pixels.
// Needs: geometric_aa

// alpha^2 of a round lobe after the curvature of the mesh (Tokuyoshi & Kaplanyan 2021, listing 5). n is the interpolated
// normal of the mesh, unit, in any space; sigma2 as MF_SIGMA2_PEAK (pixels^2), most as MF_MOST_ADDED.
float mf_aa_screen_normal(float alpha2, vec3 n, float sigma2, float most) {
    return mf_aa_2021_normals(alpha2, dFdx(n), dFdy(n), sigma2, most);
}

// The same with the trace of the kernel, for engines that match 2019 (Tokuyoshi & Kaplanyan 2019; MF_SIGMA2_HALF).
float mf_aa_screen_normal_bound(float alpha2, vec3 n, float sigma2, float most) {
    return mf_aa_2019_normals(alpha2, dFdx(n), dFdy(n), sigma2, most);
}

// A lobe's tensor after the turning of the half vector h (unit, in the tangent frame; once for each light), in projected
// space (Tokuyoshi & Kaplanyan 2021, listing 1; MF_SIGMA2_PEAK).
vec3 mf_aa_screen_half_vector(vec3 r, vec3 h, float sigma2) {
    vec2 p = vec2(h.x, h.y);
    return mf_aa_2021(r, dFdx(p), dFdy(p), sigma2);
}

// The same along the tangent frame's axes, with a clamp (Tokuyoshi 2017; MF_SIGMA2_HALF, MF_MOST_ADDED).
vec3 mf_aa_screen_half_vector_axes(vec3 r, vec3 h, float sigma2, float most) {
    vec2 p = vec2(h.x, h.y);
    return mf_aa_2019_axes(r, dFdx(p), dFdy(p), sigma2, most);
}

// Kaplanyan et al. 2016: the same in slopes; extent as MF_EXTENT_2016.
vec3 mf_aa_screen_slope(vec3 r, vec3 h, float extent) {
    vec2 s = vec2(-h.x, -h.y) / max(h.z, MF_LEAST_HALF_COSINE);
    return mf_aa_2016(r, dFdx(s), dFdy(s), extent);
}

#endif
