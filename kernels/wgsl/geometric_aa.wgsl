// Geometric specular anti-aliasing: widens a lobe by how far normals or half vectors turn across a pixel. Derivatives are
// arguments, per pixel, so that compute and ray-tracing shaders can use it; geometric_aa_screen takes them from the screen.
// Needs: nothing
//
// A pixel sees the lobe smeared by a kernel of slopes, twice whose covariance is K = 2 sigma2 (a a^T + b b^T) for the
// derivatives a and b along the screen's axes and the variance sigma2 of the pixel's filter (pixels^2). Tensors are
// (xx, xy, yy) with eigenvalues alpha^2, in the tangent frame of the derivatives. Zero derivatives give back what came in,
// bit by bit.
//
// Which to use when:
//   you have                             | and want                     | call
//   interpolated normals, one roughness  | least blur                   | mf_aa_2021_normals, MF_SIGMA2_PEAK (the default)
//   the same                             | least haze in the dark       | mf_aa_2021_normals, MF_SIGMA2_BOX
//   the same                             | to match several engines     | mf_aa_2019_normals, MF_SIGMA2_HALF: flat highlights
//   the same, two widths                 | streaks along the curvature  | mf_kernel of dn.t and dn.b, mf_add_kernel_projected
//   half vectors, forward shading        | right, also at grazing views | mf_aa_2021, MF_SIGMA2_PEAK
//   the same, cheaper                    | no conversion                | mf_aa_2019
//   the same, no cross term in the lobe  | two widths along the tangent | mf_aa_2019_axes
//   slopes of half vectors               | to match older renderers     | mf_aa_2016, mf_aa_2016_full
// Half vectors see lights and viewers that are near, normals do not. Use interpolated normals, not those of a normal map,
// whose variance belongs to its mip chain (footprint tells how to use them nevertheless), and no centroid interpolation.
// Clamp to the smallest alpha that you shade after, not before.

// Variance of a box of one pixel: what the mean over the pixel has.
const MF_SIGMA2_BOX: f32 = 0.083333333;

// 1 / (2 pi): the Gaussian with the peak of a unit box (Tokuyoshi & Kaplanyan 2021). The default.
const MF_SIGMA2_PEAK: f32 = 0.15915494;

// A standard deviation of half a pixel: twice that covers it (Kaplanyan et al. 2016; Tokuyoshi 2017).
const MF_SIGMA2_HALF: f32 = 0.25;

// Most that is added to alpha^2 along an axis (kappa in Tokuyoshi 2017): beyond it a first-order kernel tells nothing.
const MF_MOST_ADDED: f32 = 0.18;

// Most of the half extent of a pixel in slopes (Kaplanyan et al. 2016; 0.1 to 1 are in use).
const MF_EXTENT_2016: f32 = 0.7;

// Least cosine that a half vector's slope is told for.
const MF_LEAST_HALF_COSINE: f32 = 0.02;

// Derivative of the unit half vector h = (v + l) / |v + l| where the unit view v and light l change by dv and dl (per
// pixel; both 0 for a distant viewer and light). 0 where v and l are opposite.
fn mf_half_vector_derivative(v: vec3f, l: vec3f, dv: vec3f, dl: vec3f) -> vec3f {
    let sum: vec3f = v + l;
    let inverse: f32 = 1.0 / max(length(sum), 1.0e-6);
    let h: vec3f = sum * inverse;
    let d: vec3f = (dv + dl) * inverse;
    return d - h * dot(h, d);
}

// Derivative of a unit vector's components along t and b where the vector h changes by dh and the frame (t, b, n) turns
// with its normal, by dn and not about it; all per pixel and in one space. Of a half vector this is the derivative in the
// projected space of Tokuyoshi & Kaplanyan 2019.
fn mf_projected_derivative(h: vec3f, dh: vec3f, n: vec3f, dn: vec3f, t: vec3f, b: vec3f) -> vec2f {
    let up: f32 = dot(h, n);
    return vec2f(dot(dh, t) - up * dot(dn, t), dot(dh, b) - up * dot(dn, b));
}

// Derivative of the slope -h.xy / h.z of a half vector h in the tangent frame, which changes by dh (per pixel): the space
// of Kaplanyan et al. 2016. Grows as 1 / h.z^2 towards the horizon; h.z counts as MF_LEAST_HALF_COSINE at least.
fn mf_slope_derivative(h: vec3f, dh: vec3f) -> vec2f {
    let inverse: f32 = 1.0 / max(h.z, MF_LEAST_HALF_COSINE);
    let share: f32 = dh.z * inverse;
    return vec2f(h.x * share - dh.x, h.y * share - dh.y) * inverse;
}

// The kernel's tensor K = 2 sigma2 (a a^T + b b^T) for derivatives a along screen x and b along y (per pixel) and a
// Gaussian pixel of variance sigma2 (pixels^2): twice its covariance (Tokuyoshi & Kaplanyan 2021).
fn mf_kernel(a: vec2f, b: vec2f, sigma2: f32) -> vec3f {
    return 2.0 * sigma2 * vec3f(a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
}

// The same of the rectangle along the tangent frame's axes that bounds the pixel, (|a| + |b|)^2 per axis: never less than
// mf_kernel along these axes, and at most twice it (Kaplanyan et al. 2016; Tokuyoshi 2017).
fn mf_kernel_rectangle(a: vec2f, b: vec2f, sigma2: f32) -> vec3f {
    let x: f32 = abs(a.x) + abs(b.x);
    let y: f32 = abs(a.y) + abs(b.y);
    return 2.0 * sigma2 * vec3f(x * x, 0.0, y * y);
}

// Half the trace of K for derivatives of unit normals, per pixel, in any space: what to add to the alpha^2 of a round lobe
// (Tokuyoshi & Kaplanyan 2021).
fn mf_kernel_mean(dndx: vec3f, dndy: vec3f, sigma2: f32) -> f32 {
    return sigma2 * (dot(dndx, dndx) + dot(dndy, dndy));
}

// The trace of K: no axis of the kernel is wider (Tokuyoshi & Kaplanyan 2019, the isotropic kernel). Twice mf_kernel_mean.
fn mf_kernel_bound(dndx: vec3f, dndy: vec3f, sigma2: f32) -> f32 {
    return 2.0 * sigma2 * (dot(dndx, dndx) + dot(dndy, dndy));
}

// A kernel with no eigenvalue above `most`, axes kept; one that has none comes back as it is.
fn mf_kernel_clamp(k: vec3f, most: f32) -> vec3f {
    let mean: f32 = 0.5 * (k.x + k.z);
    let side: f32 = 0.5 * (k.x - k.z);
    let spread: f32 = sqrt(side * side + k.y * k.y);
    if (mean + spread <= most) {
        return k;
    }
    let low: f32 = min(mean - spread, most);
    let middle: f32 = 0.5 * (most + low);
    let scale: f32 = 0.5 * (most - low) / max(spread, 1.0e-20);
    return vec3f(middle + side * scale, k.y * scale, middle - side * scale);
}

// A lobe's tensor r after the kernel k, added in slopes: R + K (Kaplanyan et al. 2016, the Beckmann proxy of GGX), with
// no width above 1.
fn mf_add_kernel(r: vec3f, k: vec3f) -> vec3f {
    if (k.x + k.z <= 0.0) {
        return r;
    }
    return mf_kernel_clamp(r + k, 1.0);
}

// The same for a round lobe, alpha^2 and half the trace of K.
fn mf_add_kernel_mean(alpha2: f32, k: f32) -> f32 {
    return min(alpha2 + k, 1.0);
}

// A lobe's tensor r (eigenvalues up to 1) after the kernel k, added in projected space: B' = B + K for B = R (I - R)^-1
// (Tokuyoshi & Kaplanyan 2021). With P = I - R that is R' = R + P M P, M = (P + K^-1)^-1 (Woodbury): nothing
// cancels or divides by 1 - alpha, no width reaches 1 that was below, and the determinant needs no clamp.
fn mf_add_kernel_projected(r: vec3f, k: vec3f) -> vec3f {
    let p: vec3f = vec3f(1.0 - r.x, -r.y, 1.0 - r.z);
    let det_k: f32 = max(k.x * k.z - k.y * k.y, 0.0);
    let det_p: f32 = max(p.x * p.z - p.y * p.y, 0.0);
    let inverse: f32 = 1.0 / (1.0 + det_k * det_p + max(k.x * p.x + 2.0 * k.y * p.y + k.z * p.z, 0.0));
    let m: vec3f = inverse * vec3f(k.x + det_k * p.z, k.y - det_k * p.y, k.z + det_k * p.x);
    let xx: f32 = p.x * (p.x * m.x + p.y * m.y) + p.y * (p.x * m.y + p.y * m.z);
    let xy: f32 = p.y * (p.x * m.x + p.y * m.y) + p.z * (p.x * m.y + p.y * m.z);
    let yy: f32 = p.y * (p.y * m.x + p.z * m.y) + p.z * (p.y * m.y + p.z * m.z);
    return vec3f(r.x + xx, r.y + xy, r.z + yy);
}

// The same for a round lobe, alpha^2 up to 1 and half the trace of K: alpha^2 + (1 - alpha^2)^2 k / (1 + (1 - alpha^2) k).
fn mf_add_kernel_projected_mean(alpha2: f32, k: f32) -> f32 {
    let p: f32 = 1.0 - alpha2;
    return alpha2 + p * p * k / (1.0 + p * k);
}

// Kaplanyan, Hill, Patney, Lefohn 2016 as published: the half extents (|a| + |b|) / 2 of the pixel in slopes, at most
// extent (MF_EXTENT_2016), as a standard deviation. a and b are derivatives of the half vector's slopes.
fn mf_aa_2016(r: vec3f, a: vec2f, b: vec2f, extent: f32) -> vec3f {
    let x: f32 = min(0.5 * (abs(a.x) + abs(b.x)), extent);
    let y: f32 = min(0.5 * (abs(a.y) + abs(b.y)), extent);
    return mf_add_kernel(r, 2.0 * vec3f(x * x, 0.0, y * y));
}

// The same with the pixel's own parallelogram as a Gaussian, without a clamp.
fn mf_aa_2016_full(r: vec3f, a: vec2f, b: vec2f, sigma2: f32) -> vec3f {
    return mf_add_kernel(r, mf_kernel(a, b, sigma2));
}

// Tokuyoshi 2017 and Tokuyoshi & Kaplanyan 2019, axis-aligned: derivatives a and b of h.xy itself, in the tangent frame, in
// place of slopes; no more than `most` per axis. Published with MF_SIGMA2_HALF, in 2021 with MF_SIGMA2_PEAK; MF_MOST_ADDED.
fn mf_aa_2019_axes(r: vec3f, a: vec2f, b: vec2f, sigma2: f32, most: f32) -> vec3f {
    let k: vec3f = mf_kernel_rectangle(a, b, sigma2);
    return mf_add_kernel(r, vec3f(min(k.x, most), 0.0, min(k.z, most)));
}

// Tokuyoshi & Kaplanyan 2019, non-axis-aligned; the practical form of 2021. a and b are derivatives of h.xy.
fn mf_aa_2019(r: vec3f, a: vec2f, b: vec2f, sigma2: f32) -> vec3f {
    return mf_add_kernel(r, mf_kernel(a, b, sigma2));
}

// Tokuyoshi & Kaplanyan 2019 for deferred shading: alpha^2 of a round lobe, and derivatives of interpolated normals, per
// pixel. Adds the trace of K, up to `most` (MF_SIGMA2_HALF, MF_MOST_ADDED).
fn mf_aa_2019_normals(alpha2: f32, dndx: vec3f, dndy: vec3f, sigma2: f32, most: f32) -> f32 {
    return mf_add_kernel_mean(alpha2, min(mf_kernel_bound(dndx, dndy, sigma2), most));
}

// Tokuyoshi & Kaplanyan 2021, added in projected space (listing 1). a and b are derivatives of h.xy in the tangent frame.
// Needs no clamp: no width reaches 1.
fn mf_aa_2021(r: vec3f, a: vec2f, b: vec2f, sigma2: f32) -> vec3f {
    return mf_add_kernel_projected(r, mf_kernel(a, b, sigma2));
}

// Tokuyoshi & Kaplanyan 2021 for deferred shading (listing 5): as mf_aa_2019_normals with half the trace, the mean of both
// axes (MF_SIGMA2_PEAK, MF_MOST_ADDED).
fn mf_aa_2021_normals(alpha2: f32, dndx: vec3f, dndy: vec3f, sigma2: f32, most: f32) -> f32 {
    return mf_add_kernel_mean(alpha2, min(mf_kernel_mean(dndx, dndy, sigma2), most));
}
