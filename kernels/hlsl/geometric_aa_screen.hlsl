// Generated from kernels/wgsl/geometric_aa_screen.wgsl: change that file, not this one.
#ifndef MF_GEOMETRIC_AA_SCREEN_HLSL
#define MF_GEOMETRIC_AA_SCREEN_HLSL

// Geometric specular anti-aliasing with the screen's own derivatives, for fragment shaders; see geometric_aa for which to
// use when. Call these outside of branches: derivatives compare neighbouring pixels.
// Needs: geometric_aa

// alpha^2 of a round lobe after the curvature of the mesh (Tokuyoshi & Kaplanyan 2021, listing 5). n is the interpolated
// normal of the mesh, unit, in any space; sigma2 as MF_SIGMA2_PEAK (pixels^2), most as MF_MOST_ADDED.
float mf_aa_screen_normal(float alpha2, float3 n, float sigma2, float most) {
    return mf_aa_2021_normals(alpha2, ddx(n), ddy(n), sigma2, most);
}

// The same with the trace of the kernel, for engines that match 2019 (Tokuyoshi & Kaplanyan 2019; MF_SIGMA2_HALF).
float mf_aa_screen_normal_bound(float alpha2, float3 n, float sigma2, float most) {
    return mf_aa_2019_normals(alpha2, ddx(n), ddy(n), sigma2, most);
}

// A lobe's tensor after the turning of the half vector h (unit, in the tangent frame; once for each light), in projected
// space (Tokuyoshi & Kaplanyan 2021, listing 1; MF_SIGMA2_PEAK).
float3 mf_aa_screen_half_vector(float3 r, float3 h, float sigma2) {
    float2 p = float2(h.x, h.y);
    return mf_aa_2021(r, ddx(p), ddy(p), sigma2);
}

// The same along the tangent frame's axes, with a clamp (Tokuyoshi 2017; MF_SIGMA2_HALF, MF_MOST_ADDED).
float3 mf_aa_screen_half_vector_axes(float3 r, float3 h, float sigma2, float most) {
    float2 p = float2(h.x, h.y);
    return mf_aa_2019_axes(r, ddx(p), ddy(p), sigma2, most);
}

// Kaplanyan et al. 2016: the same in slopes; extent as MF_EXTENT_2016.
float3 mf_aa_screen_slope(float3 r, float3 h, float extent) {
    float2 s = float2(-h.x, -h.y) / max(h.z, MF_LEAST_HALF_COSINE);
    return mf_aa_2016(r, ddx(s), ddy(s), extent);
}

#endif
