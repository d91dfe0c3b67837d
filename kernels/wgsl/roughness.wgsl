// Units of width, the conversions between them, and widths of two axes in the forms that engines use.
// Needs: nothing
//
// alpha is the width of a GGX or Beckmann lobe in slope units, 0 (mirror) to 1. What textures and materials call roughness
// is mostly perceptual: alpha = roughness^2. Variances and their like add up in alpha^2.
//
// A lobe of two widths is a symmetric tensor R = (xx, xy, yy) as a vec3f, with eigenvalues alpha_x^2 and alpha_y^2, in a
// tangent frame. Angles turn counter-clockwise from the tangent in a frame with v up; where your bitangent runs down, the
// angle, direction.y and xy change sign.

// Ratio of a circle's circumference to its diameter.
const MF_PI: f32 = 3.14159265;

// The smoothest width that lobes are evaluated at: the peak 1 / (pi alpha^2) stays below 3.2e7.
const MF_SMOOTHEST: f32 = 1.0e-4;

// The shortest mean normal: opposed normals have none. This length stands for alpha 1 to 4 digits.
const MF_SHORTEST_MEAN: f32 = 1.0e-4;

// Two widths and the direction of the larger.
struct MfAxes {
    alpha_x: f32, // the larger
    alpha_y: f32, // the smaller, across it
    angle: f32, // radians from the tangent to the axis of alpha_x, in (-pi/2, pi/2]; 0 if the lobe is round
}

// glTF's KHR_materials_anisotropy: alpha across, mix(alpha, 1, strength^2) along.
struct MfGltf {
    alpha: f32, // the smaller width; the material's roughness is its root
    strength: f32, // 0 to 1
    direction: vec2f, // unit, along the larger width
}

// Disney's parameters: alpha / aspect along and alpha aspect across, aspect = sqrt(1 - 0.9 anisotropy).
struct MfBurley {
    alpha: f32, // geometric mean of the widths; the material's roughness is its root
    anisotropy: f32, // 0 to 1
    rotation: f32, // of the larger width, in turns, 0 to 0.5: the other half turn is the same lobe
}

// alpha from perceptual roughness, 0 to 1: alpha = perceptual^2 (Burley 2012, sec. 5.4).
fn mf_alpha_from_perceptual(perceptual: f32) -> f32 {
    return perceptual * perceptual;
}

// Perceptual roughness from alpha. Below 0 counts as 0.
fn mf_perceptual_from_alpha(alpha: f32) -> f32 {
    return sqrt(max(alpha, 0.0));
}

// alpha from smoothness or gloss, 0 to 1: that is 1 - perceptual (Unity and others).
fn mf_alpha_from_smoothness(smoothness: f32) -> f32 {
    return (1.0 - smoothness) * (1.0 - smoothness);
}

// Smoothness or gloss from alpha. 1 - sqrt(alpha), without the difference.
fn mf_smoothness_from_alpha(alpha: f32) -> f32 {
    return (1.0 - alpha) / (1.0 + sqrt(max(alpha, 0.0)));
}

// Variance of a Beckmann lobe's slopes along an axis: alpha^2 / 2 (Heitz 2014, sec. 5.2). GGX has none: it diverges.
fn mf_variance_from_alpha(alpha: f32) -> f32 {
    return 0.5 * alpha * alpha;
}

// Width of the Beckmann lobe with this variance of slopes along an axis: sqrt(2 variance). Below 0 (rounding) counts as 0.
fn mf_alpha_from_variance(variance: f32) -> f32 {
    return sqrt(2.0 * max(variance, 0.0));
}

// Concentration of the von Mises-Fisher lobe of normals with the same peak: kappa = 2 / alpha^2, right to first order in
// alpha. Of reflected directions the sharpness is a quarter of it, at normal incidence. Widths count from MF_SMOOTHEST.
fn mf_kappa_from_alpha(alpha: f32) -> f32 {
    let a: f32 = max(alpha, MF_SMOOTHEST);
    return 2.0 / (a * a);
}

// alpha from a concentration of normals: sqrt(2 / kappa), at most 1 (kappa below 2).
fn mf_alpha_from_kappa(kappa: f32) -> f32 {
    return sqrt(2.0 / max(kappa, 2.0));
}

// Exponent of the Blinn-Phong lobe (n.h)^s with the same peak: 2 / alpha^2 - 2 (Walter et al. 2007, sec. 5.2, has the way
// back). alpha up to 1; widths count from MF_SMOOTHEST.
fn mf_exponent_from_alpha(alpha: f32) -> f32 {
    let a: f32 = max(alpha, MF_SMOOTHEST);
    return 2.0 * (1.0 - a) * (1.0 + a) / (a * a);
}

// alpha from a Blinn-Phong exponent, 0 and up: sqrt(2 / (s + 2)). Below 0 counts as 0.
fn mf_alpha_from_exponent(exponent: f32) -> f32 {
    return sqrt(2.0 / (max(exponent, 0.0) + 2.0));
}

// alpha of a lobe over slopes of this variance per axis: alpha'^2 = alpha^2 + 2 variance, at most 1 (Olano & Baker 2010;
// exact for Beckmann). Variance from 0.
fn mf_alpha_widened(alpha: f32, variance: f32) -> f32 {
    return sqrt(min(alpha * alpha + 2.0 * variance, 1.0));
}

// The same in projected space, for the variance of a projected normal's x or y: with X = alpha^2 / (1 - alpha^2),
// X' = X + 2 variance (Tokuyoshi & Kaplanyan 2021), without the division that fails at alpha 1. Never above 1.
fn mf_alpha_widened_projected(alpha: f32, variance: f32) -> f32 {
    let a2: f32 = alpha * alpha;
    let added: f32 = 2.0 * variance * (1.0 - alpha) * (1.0 + alpha);
    return sqrt((a2 + added) / (1.0 + added));
}

// alpha of a lobe over normals whose mean has this length, 0 to 1: the gloss factor of Toksvig 2004, 1/s' = 1/s + V with
// V = (1 - r) / r and the exponent s = 2 / alpha^2 - 2, told in alpha. Lengths above 1 count as 1. r must be the mean of
// unit normals: two-channel textures and 8 bits do not hold it.
fn mf_toksvig(alpha: f32, mean_length: f32) -> f32 {
    let r: f32 = clamp(mean_length, MF_SHORTEST_MEAN, 1.0);
    return mf_alpha_widened_projected(alpha, (1.0 - r) / r);
}

// Concentration kappa of the von Mises-Fisher distribution whose mean has this length r, 0 to 1: the inverse of
// A(kappa) = coth kappa - 1/kappa. From 0.9, A is 1 - 1/kappa to 1e-8; to 0.2, a series, for there A cancels; between,
// Banerjee et al. 2005, eq. 4.4 (within 5 percent), and two Newton steps (one leaves 0.24 percent, two 6e-6). At most
// 2 / MF_SMOOTHEST^2, for r = 1.
fn mf_kappa_from_mean_length(mean_length: f32) -> f32 {
    let r: f32 = clamp(mean_length, 0.0, 1.0);
    let r2: f32 = r * r;
    if (r >= 0.9) {
        return 1.0 / max(1.0 - r, 5.0e-9);
    }
    if (r <= 0.2) {
        return r * (3.0 + r2 * (1.8 + r2 * (1.6971429 + r2 * 1.7588571)));
    }
    var kappa: f32 = r * (3.0 - r2) / (1.0 - r2);
    for (var i: u32 = 0u; i < 2u; i = i + 1u) { // turns: 2
        let e: f32 = exp(-2.0 * kappa);
        let a: f32 = (1.0 + e) / (1.0 - e) - 1.0 / kappa;
        kappa = kappa - (a - r) / (1.0 - a * a - 2.0 * a / kappa);
    }
    return kappa;
}

// alpha of a lobe over normals whose mean has this length, 0 to 1, taken as a von Mises-Fisher lobe: alpha^2 + 2 / kappa,
// at most 1 (Han et al. 2007).
fn mf_alpha_widened_vmf(alpha: f32, mean_length: f32) -> f32 {
    if (mean_length >= 1.0) {
        return alpha;
    }
    return sqrt(min(alpha * alpha + 2.0 / max(mf_kappa_from_mean_length(mean_length), 2.0), 1.0));
}

// Tensor from two widths and the angle of the first (radians): alpha_y^2 I + (alpha_x^2 - alpha_y^2) d d^T.
fn mf_tensor_from_axes(axes: MfAxes) -> vec3f {
    let c: f32 = cos(axes.angle);
    let s: f32 = sin(axes.angle);
    let low: f32 = axes.alpha_y * axes.alpha_y;
    let more: f32 = (axes.alpha_x - axes.alpha_y) * (axes.alpha_x + axes.alpha_y);
    return vec3f(low + more * c * c, more * c * s, low + more * s * s);
}

// The two widths of a tensor, the larger first: roots of its eigenvalues. The smaller by the determinant, which loses less
// than a difference; of tensors in f32 it is known to 2e-4 of the larger at least. Eigenvalues below 0 count as 0.
fn mf_widths_from_tensor(r: vec3f) -> vec2f {
    let side: f32 = 0.5 * (r.x - r.z);
    let high: f32 = 0.5 * (r.x + r.z) + sqrt(side * side + r.y * r.y);
    if (high <= 0.0) {
        return vec2f(0.0, 0.0);
    }
    return vec2f(sqrt(high), sqrt(max(r.x * r.z - r.y * r.y, 0.0) / high));
}

// Unit direction of a tensor's larger width, x not below 0; the tangent if the lobe is round. Half the angle of
// (xx - yy, 2 xy), without trigonometry.
fn mf_direction_from_tensor(r: vec3f) -> vec2f {
    let side: f32 = 0.5 * (r.x - r.z);
    let spread: f32 = sqrt(side * side + r.y * r.y);
    if (spread <= 0.0) {
        return vec2f(1.0, 0.0);
    }
    if (side >= 0.0) {
        return normalize(vec2f(spread + side, r.y) / spread);
    }
    let d: vec2f = normalize(vec2f(abs(r.y), spread - side) / spread);
    if (r.y < 0.0) {
        return vec2f(d.x, -d.y);
    }
    return d;
}

// Widths and angle of a tensor.
fn mf_axes_from_tensor(r: vec3f) -> MfAxes {
    let widths: vec2f = mf_widths_from_tensor(r);
    let d: vec2f = mf_direction_from_tensor(r);
    var o: MfAxes;
    o.alpha_x = widths.x;
    o.alpha_y = widths.y;
    o.angle = atan2(d.y, d.x);
    return o;
}

// A tensor with its eigenvalues (squared widths) clamped to low..high, axes kept.
fn mf_tensor_clamped(r: vec3f, low: f32, high: f32) -> vec3f {
    let mean: f32 = 0.5 * (r.x + r.z);
    let side: f32 = 0.5 * (r.x - r.z);
    let spread: f32 = sqrt(side * side + r.y * r.y);
    let a: f32 = clamp(mean + spread, low, high);
    let b: f32 = clamp(mean - spread, low, high);
    let middle: f32 = 0.5 * (a + b);
    if (spread <= 0.0) {
        return vec3f(middle, 0.0, middle);
    }
    let scale: f32 = 0.5 * (a - b) / spread;
    return vec3f(middle + side * scale, r.y * scale, middle - side * scale);
}

// glTF's strength from two widths, the larger first, up to 1: sqrt((along - across) / (1 - across)).
fn mf_gltf_strength(along: f32, across: f32) -> f32 {
    if (across >= 1.0) {
        return 0.0;
    }
    return sqrt(clamp((along - across) / (1.0 - across), 0.0, 1.0));
}

// glTF's parameters from widths and angle. Every lobe with widths up to 1 has them.
fn mf_gltf_from_axes(axes: MfAxes) -> MfGltf {
    var o: MfGltf;
    o.alpha = axes.alpha_y;
    o.strength = mf_gltf_strength(axes.alpha_x, axes.alpha_y);
    o.direction = vec2f(cos(axes.angle), sin(axes.angle));
    return o;
}

// glTF's parameters from a tensor.
fn mf_gltf_from_tensor(r: vec3f) -> MfGltf {
    let widths: vec2f = mf_widths_from_tensor(r);
    var o: MfGltf;
    o.alpha = widths.y;
    o.strength = mf_gltf_strength(widths.x, widths.y);
    o.direction = mf_direction_from_tensor(r);
    return o;
}

// glTF's direction and larger width, (x, y, alpha_t), alpha_t = mix(alpha, 1, strength^2) (KHR_materials_anisotropy). The
// direction is made unit; one that filtering or mid-gray of 8 bits left no longer than 0.1 counts as the tangent.
fn mf_gltf_along(g: MfGltf) -> vec3f {
    let along: f32 = g.alpha + (1.0 - g.alpha) * g.strength * g.strength;
    let length2: f32 = dot(g.direction, g.direction);
    if (length2 <= 0.01) {
        return vec3f(1.0, 0.0, along);
    }
    let d: vec2f = g.direction * inverseSqrt(length2);
    return vec3f(d.x, d.y, along);
}

// Widths and angle from glTF's parameters.
fn mf_axes_from_gltf(g: MfGltf) -> MfAxes {
    let along: vec3f = mf_gltf_along(g);
    var o: MfAxes;
    o.alpha_x = along.z;
    o.alpha_y = g.alpha;
    o.angle = atan2(along.y, along.x);
    if (o.angle > 0.5 * MF_PI) {
        o.angle = o.angle - MF_PI;
    } else if (o.angle <= -0.5 * MF_PI) {
        o.angle = o.angle + MF_PI;
    }
    return o;
}

// Tensor from glTF's parameters, as glTF's sample renderer builds it.
fn mf_tensor_from_gltf(g: MfGltf) -> vec3f {
    let along: vec3f = mf_gltf_along(g);
    let low: f32 = g.alpha * g.alpha;
    let more: f32 = (along.z - g.alpha) * (along.z + g.alpha);
    return vec3f(low + more * along.x * along.x, more * along.x * along.y, low + more * along.y * along.y);
}

// Disney's parameters from widths and angle (Burley 2012, sec. 5.4). Widths further apart than 1 to 10 are out of reach:
// they become the nearest, with the same product.
fn mf_burley_from_axes(axes: MfAxes) -> MfBurley {
    var o: MfBurley;
    o.alpha = sqrt(axes.alpha_x * axes.alpha_y);
    o.anisotropy = 0.0;
    if (axes.alpha_x > 0.0) {
        o.anisotropy = clamp((axes.alpha_x - axes.alpha_y) / (0.9 * axes.alpha_x), 0.0, 1.0);
    }
    o.rotation = 0.5 * fract(axes.angle / MF_PI);
    return o;
}

// Widths and angle from Disney's parameters; rotation in turns, 0 to 1.
fn mf_axes_from_burley(b: MfBurley) -> MfAxes {
    let aspect: f32 = sqrt(1.0 - 0.9 * b.anisotropy);
    let half_turns: f32 = fract(2.0 * b.rotation);
    var o: MfAxes;
    o.alpha_x = b.alpha / aspect;
    o.alpha_y = b.alpha * aspect;
    o.angle = MF_PI * half_turns;
    if (half_turns > 0.5) {
        o.angle = MF_PI * (half_turns - 1.0);
    }
    return o;
}

// Arithmetic mean and anisotropy, (alpha, 0 to 1), of two widths: alpha (1 + A) along and alpha (1 - A) across (Kulla &
// Conty 2017; Filament, Unity HDRP). The angle is that of the axes.
fn mf_kulla_conty_from_axes(axes: MfAxes) -> vec2f {
    let sum: f32 = axes.alpha_x + axes.alpha_y;
    if (sum <= 0.0) {
        return vec2f(0.0, 0.0);
    }
    return vec2f(0.5 * sum, (axes.alpha_x - axes.alpha_y) / sum);
}

// Widths and angle from the arithmetic mean, the anisotropy A, -1 to 1, and the angle of the tangent in radians, -pi/2 to
// pi/2. Below 0, the larger width is across the tangent.
fn mf_axes_from_kulla_conty(alpha: f32, anisotropy: f32, angle: f32) -> MfAxes {
    var o: MfAxes;
    o.alpha_x = alpha * (1.0 + abs(anisotropy));
    o.alpha_y = alpha * (1.0 - abs(anisotropy));
    o.angle = angle;
    if (anisotropy < 0.0) {
        if (angle > 0.0) {
            o.angle = angle - 0.5 * MF_PI;
        } else {
            o.angle = angle + 0.5 * MF_PI;
        }
    }
    return o;
}
