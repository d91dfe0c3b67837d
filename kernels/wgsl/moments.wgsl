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
    normal: vec3f, // unit, in the surface's tangent frame
    tensor: vec3f, // xx, xy, yy in the bent frame of the normal
}

// A lobe of a mixture.
struct MfWeightedLobe {
    normal: vec3f, // unit, in the surface's tangent frame
    tensor: vec3f, // xx, xy, yy in the bent frame of the normal
    weight: f32, // share of the texel's area, 0 to 1
}

// Mean and covariance of the slopes -n.xy / n.z of a footprint's normals, along +u and +v.
struct MfMoments {
    mean: vec2f,
    covariance: vec3f, // xx, xy, yy
}

// Normals flatter than this against the surface count as this steep, 78.5 degrees: one texel cannot own a footprint.
const MF_STEEPEST_Z: f32 = 0.2;

// Least cosine to the mean plane that slopes are looked at from.
const MF_LEAST_SLOPE_COSINE: f32 = 1.0e-4;

// What `energy` textures are over.
const MF_LARGEST_ENERGY: f32 = 2.5;

// Unit normal from components -1 to 1 as OpenEXR files hold them. y_sign: 1 for OpenGL maps (green up), -1 for DirectX maps;
// scale: the material's normal scale (glTF normalTexture.scale), 1 for none. Straight up where n is no longer
// than 0.1, as mid-gray of 8 bits is: that has no direction, and `mipfold build` reads it so too.
fn mf_decode_normal_signed(n: vec3f, y_sign: f32, scale: f32) -> vec3f {
    let scaled: vec3f = vec3f(scale * n.x, scale * y_sign * n.y, n.z);
    let length2: f32 = dot(scaled, scaled);
    if (dot(n, n) <= 0.01 || length2 < 1.0e-12) {
        return vec3f(0.0, 0.0, 1.0);
    }
    return scaled * inverseSqrt(length2);
}

// Unit normal from red, green, blue (0 to 1) of a PNG, which holds 0.5 + 0.5 n; y_sign and scale as above.
fn mf_decode_normal(texel: vec3f, y_sign: f32, scale: f32) -> vec3f {
    return mf_decode_normal_signed(2.0 * texel - vec3f(1.0, 1.0, 1.0), y_sign, scale);
}

// Unit normal from two channels, -1 to 1: z = sqrt(max(0, 1 - x^2 - y^2)), before the scale.
fn mf_decode_normal_xy_signed(n: vec2f, y_sign: f32, scale: f32) -> vec3f {
    let z: f32 = sqrt(max(1.0 - dot(n, n), 0.0));
    return mf_decode_normal_signed(vec3f(n.x, n.y, z), y_sign, scale);
}

// The same from red and green (0 to 1) of a PNG.
fn mf_decode_normal_xy(texel: vec2f, y_sign: f32, scale: f32) -> vec3f {
    return mf_decode_normal_xy_signed(2.0 * texel - vec2f(1.0, 1.0), y_sign, scale);
}

// Tensor of a round lobe from perceptual roughness, 0 to 1: alpha = roughness^2.
fn mf_decode_roughness(roughness: f32) -> vec3f {
    let alpha: f32 = mf_alpha_from_perceptual(roughness);
    return vec3f(alpha * alpha, 0.0, alpha * alpha);
}

// The same from gloss or smoothness, 1 - roughness.
fn mf_decode_gloss(gloss: f32) -> vec3f {
    return mf_decode_roughness(1.0 - gloss);
}

// Tensor from glTF's anisotropy texture (0.5 + 0.5 direction in red and green, strength in blue) and perceptual roughness:
// alpha across, mix(alpha, 1, strength^2) along (KHR_materials_anisotropy). A direction no longer than 0.1 is the tangent.
fn mf_decode_anisotropy(texel: vec3f, roughness: f32) -> vec3f {
    var g: MfGltf;
    g.alpha = mf_alpha_from_perceptual(roughness);
    g.strength = texel.z;
    g.direction = 2.0 * vec2f(texel.x, texel.y) - vec2f(1.0, 1.0);
    return mf_tensor_from_gltf(g);
}

// Tensor R = S^2 from its root S = (xx, yy, xy), as `tensor` in OpenEXR holds it in this order (Gauthier et al. 2022).
fn mf_decode_tensor_root_signed(root: vec3f) -> vec3f {
    let c2: f32 = root.z * root.z;
    return vec3f(root.x * root.x + c2, (root.x + root.y) * root.z, root.y * root.y + c2);
}

// The same from red, green, blue (0 to 1) of a PNG: xx, yy, and (128 + 254 xy) / 255.
fn mf_decode_tensor_root(texel: vec3f) -> vec3f {
    return mf_decode_tensor_root_signed(vec3f(texel.x, texel.y, (255.0 * texel.z - 128.0) / 254.0));
}

// Tensor from two widths (alpha) and the angle of the first in radians, counter-clockwise from the tangent: `axes` and
// `lobes` in OpenEXR.
fn mf_decode_axes_signed(alpha_x: f32, alpha_y: f32, angle: f32) -> vec3f {
    var axes: MfAxes;
    axes.alpha_x = alpha_x;
    axes.alpha_y = alpha_y;
    axes.angle = angle;
    return mf_tensor_from_axes(axes);
}

// The same from red, green, blue (0 to 1) of a PNG: two perceptual roughnesses, and the angle in turns.
fn mf_decode_axes(texel: vec3f) -> vec3f {
    return mf_decode_axes_signed(texel.x * texel.x, texel.y * texel.y, 2.0 * MF_PI * texel.z);
}

// Tensor from Disney's parameters, all 0 to 1: perceptual roughness, anisotropy, rotation in turns (Burley 2012, sec. 5.4).
fn mf_decode_burley(texel: vec3f) -> vec3f {
    var b: MfBurley;
    b.alpha = mf_alpha_from_perceptual(texel.x);
    b.anisotropy = texel.y;
    b.rotation = texel.z;
    return mf_tensor_from_axes(mf_axes_from_burley(b));
}

// Scale on the specular term from a PNG. Only for renderers without multiple-scattering compensation.
fn mf_decode_energy(texel: f32) -> f32 {
    return MF_LARGEST_ENERGY * texel;
}

// A further lobe of a mixture from its OpenEXR map: n.x, n.y (-1 to 1), weight, perceptual roughness. y_sign and scale as of
// the normal map. With two widths, take the tensor of mf_decode_anisotropy instead.
fn mf_decode_lobe_signed(texel: vec4f, y_sign: f32, scale: f32) -> MfWeightedLobe {
    var o: MfWeightedLobe;
    o.normal = mf_decode_normal_xy_signed(vec2f(texel.x, texel.y), y_sign, scale);
    o.tensor = mf_decode_roughness(texel.w);
    o.weight = texel.z;
    return o;
}

// The same from red, green, blue, alpha (0 to 1) of a PNG.
fn mf_decode_lobe(texel: vec4f, y_sign: f32, scale: f32) -> MfWeightedLobe {
    return mf_decode_lobe_signed(vec4f(2.0 * texel.x - 1.0, 2.0 * texel.y - 1.0, texel.z, texel.w), y_sign, scale);
}

// The second lobe of a `haze` mixture from red and green (perceptual roughness, weight): the normal is the first lobe's.
fn mf_decode_haze(texel: vec2f, normal: vec3f) -> MfWeightedLobe {
    var o: MfWeightedLobe;
    o.normal = normal;
    o.tensor = mf_decode_roughness(texel.x);
    o.weight = texel.y;
    return o;
}

// Weight of a mixture's first lobe, that of the ordinary maps: what the further lobes leave (0 for those that are not there).
fn mf_first_weight(further: vec3f) -> f32 {
    return max(1.0 - (further.x + further.y + further.z), 0.0);
}

// The lobe of an un-normalised mean of unit normals n (0 to 1 long), looked up from a map in floats or 16 bits that keeps the
// length, over a round base of width alpha: Toksvig 2004. Maps of `mipfold build` are of unit length and need it not.
fn mf_lobe_toksvig(n: vec3f, alpha: f32) -> MfLobe {
    let width: f32 = mf_toksvig(alpha, length(n));
    var o: MfLobe;
    o.normal = mf_decode_normal_signed(n / max(length(n), 1.0e-6), 1.0, 1.0);
    o.tensor = vec3f(width * width, 0.0, width * width);
    return o;
}

// The same by the von Mises-Fisher lobe of that mean (Han et al. 2007).
fn mf_lobe_vmf(n: vec3f, alpha: f32) -> MfLobe {
    let width: f32 = mf_alpha_widened_vmf(alpha, length(n));
    var o: MfLobe;
    o.normal = mf_decode_normal_signed(n / max(length(n), 1.0e-6), 1.0, 1.0);
    o.tensor = vec3f(width * width, 0.0, width * width);
    return o;
}

// A symmetric tensor without its negative eigenvalues; one that has none comes back as it is.
fn mf_tensor_positive(x: vec3f) -> vec3f {
    let mean: f32 = 0.5 * (x.x + x.z);
    let side: f32 = 0.5 * (x.x - x.z);
    let spread: f32 = sqrt(side * side + x.y * x.y);
    if (spread <= mean) {
        return x;
    }
    let high: f32 = max(mean + spread, 0.0);
    let scale: f32 = 0.5 * high / max(spread, 1.0e-30);
    return vec3f(scale * (spread + side), scale * x.y, scale * (spread - side));
}

// Moments from the channels of `moments`: mean = (b1_dhds, b2_dhdt), raw = (b3_dhds2, b4_dhdt2, b5_dh2dsdt), looked up with any
// filter that has no negative weights. y_sign as of the normal map. The covariance is a difference of raw moments: keep them
// in 32 bits. (Olano & Baker 2010, eq. 5; maketx --bumpslopes.)
fn mf_decode_moments(mean: vec2f, raw: vec3f, y_sign: f32) -> MfMoments {
    var o: MfMoments;
    o.mean = vec2f(mean.x, y_sign * mean.y);
    let xx: f32 = raw.x - mean.x * mean.x;
    let yy: f32 = raw.y - mean.y * mean.y;
    let xy: f32 = raw.z - mean.x * mean.y;
    o.covariance = mf_tensor_positive(vec3f(xx, y_sign * xy, yy));
    return o;
}

// Moments of a single unit normal: its slope, no steeper than MF_STEEPEST_Z, and no covariance.
fn mf_moments_of_normal(n: vec3f) -> MfMoments {
    let k: f32 = -1.0 / max(n.z, MF_STEEPEST_Z);
    var o: MfMoments;
    o.mean = vec2f(k * n.x, k * n.y);
    o.covariance = vec3f(0.0, 0.0, 0.0);
    return o;
}

// Moments of slopes that a linear map takes to (dot(row_x, s), dot(row_y, s)): T m and T C T^T. Where texture coordinates are
// stretched on the mesh by a matrix A (tangent plane = A uv, 1 for the scale that was baked), T is the inverse transpose of
// A. A factor on normals or displacements is T = factor; the base roughness is not in the moments and stays.
fn mf_moments_transform(m: MfMoments, row_x: vec2f, row_y: vec2f) -> MfMoments {
    let c: vec3f = m.covariance;
    let ax: f32 = row_x.x * c.x + row_x.y * c.y;
    let ay: f32 = row_x.x * c.y + row_x.y * c.z;
    let bx: f32 = row_y.x * c.x + row_y.y * c.y;
    let by: f32 = row_y.x * c.y + row_y.y * c.z;
    var o: MfMoments;
    o.mean = vec2f(dot(row_x, m.mean), dot(row_y, m.mean));
    o.covariance = vec3f(ax * row_x.x + ay * row_x.y, ax * row_y.x + ay * row_y.y, bx * row_y.x + by * row_y.y);
    return o;
}

// Moments of two layers whose slopes add up and know nothing of each other: detail on a base.
fn mf_moments_add(a: MfMoments, b: MfMoments) -> MfMoments {
    var o: MfMoments;
    o.mean = a.mean + b.mean;
    o.covariance = a.covariance + b.covariance;
    return o;
}

// Moments of a share 1 - t of a's surface and a share t of b's (a mask; t from 0 to 1): the raw moments are mixed, which adds
// t (1 - t) times the product of the means' difference.
fn mf_moments_blend(a: MfMoments, b: MfMoments, t: f32) -> MfMoments {
    let d: vec2f = b.mean - a.mean;
    let between: f32 = t * (1.0 - t);
    var o: MfMoments;
    o.mean = a.mean + t * d;
    o.covariance = (1.0 - t) * a.covariance + t * b.covariance + between * vec3f(d.x * d.x, d.x * d.y, d.y * d.y);
    return o;
}

// The lobe of slope moments: the mean slope's normal n, and R = base + 2 J C J^T, where J = n.z (t.xy, b.xy)^T takes slopes into
// the bent frame of n (cos^2 along the tilt and cos across it; Olano & Baker 2010, Dupuy et al. 2013). base: the material's own
// tensor in that frame, mf_decode_roughness as a rule.
// Slopes up to 1e4. Widths may lie above 1; clamp them as you clamp others.
fn mf_lobe_from_moments(m: MfMoments, base: vec3f) -> MfLobe {
    let n: vec3f = normalize(vec3f(-m.mean.x, -m.mean.y, 1.0));
    let root: f32 = sqrt(n.y * n.y + n.z * n.z);
    let row_x: vec2f = vec2f(n.z * root, -n.z * n.x * n.y / root);
    let row_y: vec2f = vec2f(0.0, n.z * n.z / root);
    let local: MfMoments = mf_moments_transform(m, row_x, row_y);
    var o: MfLobe;
    o.normal = n;
    o.tensor = base + 2.0 * local.covariance;
    return o;
}

// Moments that a lobe stands for, C = J^-1 R J^-T / 2: the way back, with base 0, so that folded mips can be layered, blended
// and stretched like moments. The base roughness is in them then. Exact for Beckmann lobes; of a GGX lobe, which has no
// variance, they are those of the Beckmann lobe of its widths. n.z counts as MF_STEEPEST_Z at least.
fn mf_moments_from_lobe(lobe: MfLobe) -> MfMoments {
    let mean: vec2f = mf_moments_of_normal(lobe.normal).mean;
    let n: vec3f = normalize(vec3f(-mean.x, -mean.y, 1.0));
    let root: f32 = sqrt(n.y * n.y + n.z * n.z);
    let inverse: f32 = 1.0 / (n.z * root);
    var r: MfMoments;
    r.mean = vec2f(0.0, 0.0);
    r.covariance = 0.5 * lobe.tensor;
    let row_x: vec2f = vec2f(inverse, inverse * n.x * n.y / n.z);
    let row_y: vec2f = vec2f(0.0, inverse * root * root / n.z);
    var o: MfMoments = mf_moments_transform(r, row_x, row_y);
    o.mean = mean;
    return o;
}

// Density of the standard normal distribution; x up to 12 by its size.
fn mf_gaussian_pdf(x: f32) -> f32 {
    return 0.39894228 * exp(-0.5 * x * x);
}

// Share of the standard normal distribution below x (Abramowitz & Stegun 26.2.17: within 7.5e-8 before rounding).
fn mf_gaussian_cdf(x: f32) -> f32 {
    let t: f32 = 1.0 / (1.0 + 0.2316419 * abs(x));
    let sum: f32 = t * (0.31938153 + t * (-0.356563782 + t * (1.781477937 + t * (-1.821255978 + t * 1.330274429))));
    let above: f32 = sum * mf_gaussian_pdf(x);
    if (x < 0.0) {
        return above;
    }
    return 1.0 - above;
}

// Mean of max(0, v.z - s . v.xy) over Gaussian slopes s with these moments: the area that faces v over that of the mean
// plane (Dupuy et al. 2013, projected area of a non-centred Beckmann surface; c Phi(c / tau) + tau phi(c / tau)). For light,
// which may come from below, take mf_diffuse_gaussian of shading. v unit; less than MF_LEAST_SLOPE_COSINE above the mean plane
// counts as that.
fn mf_slope_cosine(m: MfMoments, v: vec3f) -> f32 {
    let c: f32 = max(v.z - dot(m.mean, vec2f(v.x, v.y)), MF_LEAST_SLOPE_COSINE);
    let form: f32 = m.covariance.x * v.x * v.x + 2.0 * m.covariance.y * v.x * v.y + m.covariance.z * v.y * v.y;
    let tau: f32 = max(sqrt(max(form, 0.0)), 1.0e-10);
    let z: f32 = min(c / tau, 12.0);
    return c * mf_gaussian_cdf(z) + tau * mf_gaussian_pdf(z);
}

// By how much the slope s is seen from v more than the mean of them: max(0, v.z - s . v.xy) over mf_slope_cosine. Its mean
// over the slopes is 1, so that it weighs samples of slopes (Dupuy et al. 2013, visible slopes).
fn mf_visible_weight(m: MfMoments, v: vec3f, s: vec2f) -> f32 {
    return max(v.z - dot(s, vec2f(v.x, v.y)), 0.0) / mf_slope_cosine(m, v);
}

// Moments of the slopes as v sees them, each weighted by mf_visible_weight. By Stein's lemma, with w = C v.xy: mean - w Phi / E
// and C + w w^T (phi E / tau - Phi^2) / E^2 for E = mf_slope_cosine. What lies towards the viewer counts for more.
fn mf_visible_moments(m: MfMoments, v: vec3f) -> MfMoments {
    let c: f32 = max(v.z - dot(m.mean, vec2f(v.x, v.y)), MF_LEAST_SLOPE_COSINE);
    let w: vec2f = vec2f(m.covariance.x * v.x + m.covariance.y * v.y, m.covariance.y * v.x + m.covariance.z * v.y);
    let tau: f32 = max(sqrt(max(dot(w, vec2f(v.x, v.y)), 0.0)), 1.0e-10);
    let z: f32 = min(c / tau, 12.0);
    let share: f32 = mf_gaussian_cdf(z);
    let density: f32 = mf_gaussian_pdf(z);
    let inverse: f32 = 1.0 / (c * share + tau * density);
    let shift: f32 = share * inverse;
    let factor: f32 = density / tau * inverse - shift * shift;
    var o: MfMoments;
    o.mean = m.mean - shift * w;
    o.covariance = m.covariance + factor * vec3f(w.x * w.x, w.x * w.y, w.y * w.y);
    return o;
}
