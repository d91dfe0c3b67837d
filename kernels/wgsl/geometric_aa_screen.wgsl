// Geometric specular anti-aliasing with the screen's own derivatives, for fragment shaders; see geometric_aa for which to
// use when. Call these outside of branches: derivatives compare neighbouring pixels.
// Needs: geometric_aa

// alpha^2 of a round lobe after the curvature of the mesh (Tokuyoshi & Kaplanyan 2021, listing 5). n is the interpolated
// normal of the mesh, unit, in any space; sigma2 as MF_SIGMA2_PEAK (pixels^2), most as MF_MOST_ADDED.
fn mf_aa_screen_normal(alpha2: f32, n: vec3f, sigma2: f32, most: f32) -> f32 {
    return mf_aa_2021_normals(alpha2, dpdx(n), dpdy(n), sigma2, most);
}

// The same with the trace of the kernel, for engines that match 2019 (Tokuyoshi & Kaplanyan 2019; MF_SIGMA2_HALF).
fn mf_aa_screen_normal_bound(alpha2: f32, n: vec3f, sigma2: f32, most: f32) -> f32 {
    return mf_aa_2019_normals(alpha2, dpdx(n), dpdy(n), sigma2, most);
}

// A lobe's tensor after the turning of the half vector h (unit, in the tangent frame; once for each light), in projected
// space (Tokuyoshi & Kaplanyan 2021, listing 1; MF_SIGMA2_PEAK).
fn mf_aa_screen_half_vector(r: vec3f, h: vec3f, sigma2: f32) -> vec3f {
    let p: vec2f = vec2f(h.x, h.y);
    return mf_aa_2021(r, dpdx(p), dpdy(p), sigma2);
}

// The same along the tangent frame's axes, with a clamp (Tokuyoshi 2017; MF_SIGMA2_HALF, MF_MOST_ADDED).
fn mf_aa_screen_half_vector_axes(r: vec3f, h: vec3f, sigma2: f32, most: f32) -> vec3f {
    let p: vec2f = vec2f(h.x, h.y);
    return mf_aa_2019_axes(r, dpdx(p), dpdy(p), sigma2, most);
}

// Kaplanyan et al. 2016: the same in slopes; extent as MF_EXTENT_2016.
fn mf_aa_screen_slope(r: vec3f, h: vec3f, extent: f32) -> vec3f {
    let s: vec2f = vec2f(-h.x, -h.y) / max(h.z, MF_LEAST_HALF_COSINE);
    return mf_aa_2016(r, dpdx(s), dpdy(s), extent);
}
