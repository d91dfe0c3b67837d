// Generated from kernels/wgsl/moments.wgsl: change that file, not this one.
#ifndef MF_MOMENTS_HLSL
#define MF_MOMENTS_HLSL

// Reads every texture that `mipfold build` writes, and works with slope moments at run time (LEAN, LEADR).
// Needs: roughness
//
// Textures are linear data, looked up with your ordinary sampler. Tangent frame: x along +u, y up (v up in the picture), z
// out of the surface. A lobe's tensor R = (xx, xy, yy), eigenvalues alpha^2, refers to the lobe's own bent frame: the tangent
// is the +u axis made orthogonal to the normal, the bitangent is normal x tangent. Where your bitangent runs down, negate the
// y of normals and the xy of tensors.
//
//   map                        | call
//   normal, three channels     | mf_decode_normal, OpenEXR: mf_decode_normal_signed
//   normal, two channels       | mf_decode_normal_xy
//   roughness, gloss           | mf_decode_roughness, mf_decode_gloss
//   anisotropy and roughness   | mf_decode_anisotropy
//   tensor                     | mf_decode_tensor_root, OpenEXR: mf_decode_tensor_root_signed
//   axes, lobes.exr            | mf_decode_axes, OpenEXR: mf_decode_axes_signed
//   burley                     | mf_decode_burley
//   energy                     | mf_decode_energy; OpenEXR holds the scale itself
//   diffuse                    | the scale itself; see mf_diffuse_cosine of footprint
//   lobe2 to lobe4             | mf_decode_lobe, OpenEXR: mf_decode_lobe_signed; then mf_first_weight
//   lobe2_anisotropy to lobe4  | mf_decode_anisotropy with the alpha channel of the lobe's map
//   haze                       | mf_decode_haze
//   moments                    | mf_decode_moments, then mf_lobe_from_moments
//   (other tools' normals)     | mf_lobe_toksvig or mf_lobe_vmf, where mean normals kept their length

// A lobe to shade with.
struct MfLobe {
    float3 normal; // unit, in the surface's tangent frame
    float3 tensor; // xx, xy, yy in the bent frame of the normal
};

// A lobe of a mixture.
struct MfWeightedLobe {
    float3 normal; // unit, in the surface's tangent frame
    float3 tensor; // xx, xy, yy in the bent frame of the normal
    float weight; // share of the texel's area, 0 to 1
};

// Mean and covariance of the slopes -n.xy / n.z of a footprint's normals, along +u and +v.
struct MfMoments {
    float2 mean;
    float3 covariance; // xx, xy, yy
};

// Normals flatter than this against the surface count as this steep, 78.5 degrees: one texel cannot own a footprint.
static const float MF_STEEPEST_Z = 0.2;

// Least cosine to the mean plane that slopes are looked at from.
static const float MF_LEAST_SLOPE_COSINE = 1.0e-4;

// What `energy` textures are over.
static const float MF_LARGEST_ENERGY = 2.5;

// Unit normal from components -1 to 1 as OpenEXR files hold them. y_sign: 1 for OpenGL maps (green up), -1 for DirectX maps;
// scale: the material's normal scale (glTF normalTexture.scale), 1 for none. Straight up where n is no longer
// than 0.1, as mid-gray of 8 bits is: that has no direction, and `mipfold build` reads it so too.
float3 mf_decode_normal_signed(float3 n, float y_sign, float scale) {
    float3 scaled = float3(scale * n.x, scale * y_sign * n.y, n.z);
    float length2 = dot(scaled, scaled);
    if (dot(n, n) <= 0.01 || length2 < 1.0e-12) {
        return float3(0.0, 0.0, 1.0);
    }
    return scaled * rsqrt(length2);
}

// Unit normal from red, green, blue (0 to 1) of a PNG, which holds 0.5 + 0.5 n; y_sign and scale as above.
float3 mf_decode_normal(float3 texel, float y_sign, float scale) {
    return mf_decode_normal_signed(2.0 * texel - float3(1.0, 1.0, 1.0), y_sign, scale);
}

// Unit normal from two channels, -1 to 1: z = sqrt(max(0, 1 - x^2 - y^2)), before the scale.
float3 mf_decode_normal_xy_signed(float2 n, float y_sign, float scale) {
    float z = sqrt(max(1.0 - dot(n, n), 0.0));
    return mf_decode_normal_signed(float3(n.x, n.y, z), y_sign, scale);
}

// The same from red and green (0 to 1) of a PNG.
float3 mf_decode_normal_xy(float2 texel, float y_sign, float scale) {
    return mf_decode_normal_xy_signed(2.0 * texel - float2(1.0, 1.0), y_sign, scale);
}

// Tensor of a round lobe from perceptual roughness, 0 to 1: alpha = roughness^2.
float3 mf_decode_roughness(float roughness) {
    float alpha = mf_alpha_from_perceptual(roughness);
    return float3(alpha * alpha, 0.0, alpha * alpha);
}

// The same from gloss or smoothness, 1 - roughness.
float3 mf_decode_gloss(float gloss) {
    return mf_decode_roughness(1.0 - gloss);
}

// Tensor from glTF's anisotropy texture (0.5 + 0.5 direction in red and green, strength in blue) and perceptual roughness:
// alpha across, mix(alpha, 1, strength^2) along (KHR_materials_anisotropy). A direction no longer than 0.1 is the tangent.
float3 mf_decode_anisotropy(float3 texel, float roughness) {
    MfGltf g;
    g.alpha = mf_alpha_from_perceptual(roughness);
    g.strength = texel.z;
    g.direction = 2.0 * float2(texel.x, texel.y) - float2(1.0, 1.0);
    return mf_tensor_from_gltf(g);
}

// Tensor R = S^2 from its root S = (xx, yy, xy), as `tensor` in OpenEXR holds it in this order (Gauthier et al. 2022).
float3 mf_decode_tensor_root_signed(float3 root) {
    float c2 = root.z * root.z;
    return float3(root.x * root.x + c2, (root.x + root.y) * root.z, root.y * root.y + c2);
}

// The same from red, green, blue (0 to 1) of a PNG: xx, yy, and (128 + 254 xy) / 255.
float3 mf_decode_tensor_root(float3 texel) {
    return mf_decode_tensor_root_signed(float3(texel.x, texel.y, (255.0 * texel.z - 128.0) / 254.0));
}

// Tensor from two widths (alpha) and the angle of the first in radians, counter-clockwise from the tangent: `axes` and
// `lobes` in OpenEXR.
float3 mf_decode_axes_signed(float alpha_x, float alpha_y, float angle) {
    MfAxes axes;
    axes.alpha_x = alpha_x;
    axes.alpha_y = alpha_y;
    axes.angle = angle;
    return mf_tensor_from_axes(axes);
}

// The same from red, green, blue (0 to 1) of a PNG: two perceptual roughnesses, and the angle in turns.
float3 mf_decode_axes(float3 texel) {
    return mf_decode_axes_signed(texel.x * texel.x, texel.y * texel.y, 2.0 * MF_PI * texel.z);
}

// Tensor from Disney's parameters, all 0 to 1: perceptual roughness, anisotropy, rotation in turns (Burley 2012, sec. 5.4).
float3 mf_decode_burley(float3 texel) {
    MfBurley b;
    b.alpha = mf_alpha_from_perceptual(texel.x);
    b.anisotropy = texel.y;
    b.rotation = texel.z;
    return mf_tensor_from_axes(mf_axes_from_burley(b));
}

// Scale on the specular term from a PNG. Only for renderers without multiple-scattering compensation.
float mf_decode_energy(float texel) {
    return MF_LARGEST_ENERGY * texel;
}

// A further lobe of a mixture from its OpenEXR map: n.x, n.y (-1 to 1), weight, perceptual roughness. y_sign and scale as of
// the normal map. With two widths, take the tensor of mf_decode_anisotropy instead.
MfWeightedLobe mf_decode_lobe_signed(float4 texel, float y_sign, float scale) {
    MfWeightedLobe o;
    o.normal = mf_decode_normal_xy_signed(float2(texel.x, texel.y), y_sign, scale);
    o.tensor = mf_decode_roughness(texel.w);
    o.weight = texel.z;
    return o;
}

// The same from red, green, blue, alpha (0 to 1) of a PNG.
MfWeightedLobe mf_decode_lobe(float4 texel, float y_sign, float scale) {
    return mf_decode_lobe_signed(float4(2.0 * texel.x - 1.0, 2.0 * texel.y - 1.0, texel.z, texel.w), y_sign, scale);
}

// The second lobe of a `haze` mixture from red and green (perceptual roughness, weight): the normal is the first lobe's.
MfWeightedLobe mf_decode_haze(float2 texel, float3 normal) {
    MfWeightedLobe o;
    o.normal = normal;
    o.tensor = mf_decode_roughness(texel.x);
    o.weight = texel.y;
    return o;
}

// Weight of a mixture's first lobe, that of the ordinary maps: what the further lobes leave (0 for those that are not there).
float mf_first_weight(float3 further) {
    return max(1.0 - (further.x + further.y + further.z), 0.0);
}

// The lobe of an un-normalised mean of unit normals n (0 to 1 long), looked up from a map in floats or 16 bits that keeps the
// length, over a round base of width alpha: Toksvig 2004. Maps of `mipfold build` are of unit length and need it not.
MfLobe mf_lobe_toksvig(float3 n, float alpha) {
    float width = mf_toksvig(alpha, length(n));
    MfLobe o;
    o.normal = mf_decode_normal_signed(n / max(length(n), 1.0e-6), 1.0, 1.0);
    o.tensor = float3(width * width, 0.0, width * width);
    return o;
}

// The same by the von Mises-Fisher lobe of that mean (Han et al. 2007).
MfLobe mf_lobe_vmf(float3 n, float alpha) {
    float width = mf_alpha_widened_vmf(alpha, length(n));
    MfLobe o;
    o.normal = mf_decode_normal_signed(n / max(length(n), 1.0e-6), 1.0, 1.0);
    o.tensor = float3(width * width, 0.0, width * width);
    return o;
}

// A symmetric tensor without its negative eigenvalues; one that has none comes back as it is.
float3 mf_tensor_positive(float3 x) {
    float mean = 0.5 * (x.x + x.z);
    float side = 0.5 * (x.x - x.z);
    float spread = sqrt(side * side + x.y * x.y);
    if (spread <= mean) {
        return x;
    }
    float high = max(mean + spread, 0.0);
    float scale = 0.5 * high / max(spread, 1.0e-30);
    return float3(scale * (spread + side), scale * x.y, scale * (spread - side));
}

// Moments from the channels of `moments`: mean = (b1_dhds, b2_dhdt), raw = (b3_dhds2, b4_dhdt2, b5_dh2dsdt), looked up with any
// filter that has no negative weights. y_sign as of the normal map. The covariance is a difference of raw moments: keep them
// in 32 bits. (Olano & Baker 2010, eq. 5; maketx --bumpslopes.)
MfMoments mf_decode_moments(float2 mean, float3 raw, float y_sign) {
    MfMoments o;
    o.mean = float2(mean.x, y_sign * mean.y);
    float xx = raw.x - mean.x * mean.x;
    float yy = raw.y - mean.y * mean.y;
    float xy = raw.z - mean.x * mean.y;
    o.covariance = mf_tensor_positive(float3(xx, y_sign * xy, yy));
    return o;
}

// Moments of a single unit normal: its slope, no steeper than MF_STEEPEST_Z, and no covariance.
MfMoments mf_moments_of_normal(float3 n) {
    float k = -1.0 / max(n.z, MF_STEEPEST_Z);
    MfMoments o;
    o.mean = float2(k * n.x, k * n.y);
    o.covariance = float3(0.0, 0.0, 0.0);
    return o;
}

// Moments of slopes that a linear map takes to (dot(row_x, s), dot(row_y, s)): T m and T C T^T. Where texture coordinates are
// stretched on the mesh by a matrix A (tangent plane = A uv, 1 for the scale that was baked), T is the inverse transpose of
// A. A factor on normals or displacements is T = factor; the base roughness is not in the moments and stays.
MfMoments mf_moments_transform(MfMoments m, float2 row_x, float2 row_y) {
    float3 c = m.covariance;
    float ax = row_x.x * c.x + row_x.y * c.y;
    float ay = row_x.x * c.y + row_x.y * c.z;
    float bx = row_y.x * c.x + row_y.y * c.y;
    float by = row_y.x * c.y + row_y.y * c.z;
    MfMoments o;
    o.mean = float2(dot(row_x, m.mean), dot(row_y, m.mean));
    o.covariance = float3(ax * row_x.x + ay * row_x.y, ax * row_y.x + ay * row_y.y, bx * row_y.x + by * row_y.y);
    return o;
}

// Moments of two layers whose slopes add up and know nothing of each other: detail on a base.
MfMoments mf_moments_add(MfMoments a, MfMoments b) {
    MfMoments o;
    o.mean = a.mean + b.mean;
    o.covariance = a.covariance + b.covariance;
    return o;
}

// Moments of a share 1 - t of a's surface and a share t of b's (a mask; t from 0 to 1): the raw moments are mixed, which adds
// t (1 - t) times the product of the means' difference.
MfMoments mf_moments_blend(MfMoments a, MfMoments b, float t) {
    float2 d = b.mean - a.mean;
    float between = t * (1.0 - t);
    MfMoments o;
    o.mean = a.mean + t * d;
    o.covariance = (1.0 - t) * a.covariance + t * b.covariance + between * float3(d.x * d.x, d.x * d.y, d.y * d.y);
    return o;
}

// The lobe of slope moments: the mean slope's normal n, and R = base + 2 J C J^T, where J = n.z (t.xy, b.xy)^T takes slopes into
// the bent frame of n (cos^2 along the tilt and cos across it; Olano & Baker 2010, Dupuy et al. 2013). base: the material's own
// tensor in that frame, mf_decode_roughness as a rule.
// Slopes up to 1e4. Widths may lie above 1; clamp them as you clamp others.
MfLobe mf_lobe_from_moments(MfMoments m, float3 base) {
    float3 n = normalize(float3(-m.mean.x, -m.mean.y, 1.0));
    float root = sqrt(n.y * n.y + n.z * n.z);
    float2 row_x = float2(n.z * root, -n.z * n.x * n.y / root);
    float2 row_y = float2(0.0, n.z * n.z / root);
    MfMoments local = mf_moments_transform(m, row_x, row_y);
    MfLobe o;
    o.normal = n;
    o.tensor = base + 2.0 * local.covariance;
    return o;
}

// Moments that a lobe stands for, C = J^-1 R J^-T / 2: the way back, with base 0, so that folded mips can be layered, blended
// and stretched like moments. The base roughness is in them then. Exact for Beckmann lobes; of a GGX lobe, which has no
// variance, they are those of the Beckmann lobe of its widths. n.z counts as MF_STEEPEST_Z at least.
MfMoments mf_moments_from_lobe(MfLobe lobe) {
    float2 mean = mf_moments_of_normal(lobe.normal).mean;
    float3 n = normalize(float3(-mean.x, -mean.y, 1.0));
    float root = sqrt(n.y * n.y + n.z * n.z);
    float inverse = 1.0 / (n.z * root);
    MfMoments r;
    r.mean = float2(0.0, 0.0);
    r.covariance = 0.5 * lobe.tensor;
    float2 row_x = float2(inverse, inverse * n.x * n.y / n.z);
    float2 row_y = float2(0.0, inverse * root * root / n.z);
    MfMoments o = mf_moments_transform(r, row_x, row_y);
    o.mean = mean;
    return o;
}

// Density of the standard normal distribution; x up to 12 by its size.
float mf_gaussian_pdf(float x) {
    return 0.39894228 * exp(-0.5 * x * x);
}

// Share of the standard normal distribution below x (Abramowitz & Stegun 26.2.17: within 7.5e-8 before rounding).
float mf_gaussian_cdf(float x) {
    float t = 1.0 / (1.0 + 0.2316419 * abs(x));
    float sum = t * (0.31938153 + t * (-0.356563782 + t * (1.781477937 + t * (-1.821255978 + t * 1.330274429))));
    float above = sum * mf_gaussian_pdf(x);
    if (x < 0.0) {
        return above;
    }
    return 1.0 - above;
}

// Mean of max(0, v.z - s . v.xy) over Gaussian slopes s with these moments: the area that faces v over that of the mean
// plane (Dupuy et al. 2013, projected area of a non-centred Beckmann surface; c Phi(c / tau) + tau phi(c / tau)). For light,
// which may come from below, take mf_diffuse_gaussian of shading. v unit; less than MF_LEAST_SLOPE_COSINE above the mean plane
// counts as that.
float mf_slope_cosine(MfMoments m, float3 v) {
    float c = max(v.z - dot(m.mean, float2(v.x, v.y)), MF_LEAST_SLOPE_COSINE);
    float form = m.covariance.x * v.x * v.x + 2.0 * m.covariance.y * v.x * v.y + m.covariance.z * v.y * v.y;
    float tau = max(sqrt(max(form, 0.0)), 1.0e-10);
    float z = min(c / tau, 12.0);
    return c * mf_gaussian_cdf(z) + tau * mf_gaussian_pdf(z);
}

// By how much the slope s is seen from v more than the mean of them: max(0, v.z - s . v.xy) over mf_slope_cosine. Its mean
// over the slopes is 1, so that it weighs samples of slopes (Dupuy et al. 2013, visible slopes).
float mf_visible_weight(MfMoments m, float3 v, float2 s) {
    return max(v.z - dot(s, float2(v.x, v.y)), 0.0) / mf_slope_cosine(m, v);
}

// Moments of the slopes as v sees them, each weighted by mf_visible_weight. By Stein's lemma, with w = C v.xy: mean - w Phi / E
// and C + w w^T (phi E / tau - Phi^2) / E^2 for E = mf_slope_cosine. What lies towards the viewer counts for more.
MfMoments mf_visible_moments(MfMoments m, float3 v) {
    float c = max(v.z - dot(m.mean, float2(v.x, v.y)), MF_LEAST_SLOPE_COSINE);
    float2 w = float2(m.covariance.x * v.x + m.covariance.y * v.y, m.covariance.y * v.x + m.covariance.z * v.y);
    float tau = max(sqrt(max(dot(w, float2(v.x, v.y)), 0.0)), 1.0e-10);
    float z = min(c / tau, 12.0);
    float share = mf_gaussian_cdf(z);
    float density = mf_gaussian_pdf(z);
    float inverse = 1.0 / (c * share + tau * density);
    float shift = share * inverse;
    float factor = density / tau * inverse - shift * shift;
    MfMoments o;
    o.mean = m.mean - shift * w;
    o.covariance = m.covariance + factor * float3(w.x * w.x, w.x * w.y, w.y * w.y);
    return o;
}

#endif
