// Generated from kernels/wgsl/roughness.wgsl: change that file, not this one.
// In GLSL ES, include it after `precision highp float;` and `precision highp int;`.
#ifndef MF_ROUGHNESS_GLSL
#define MF_ROUGHNESS_GLSL

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
const float MF_PI = 3.14159265;

// The smoothest width that lobes are evaluated at: the peak 1 / (pi alpha^2) stays below 3.2e7.
const float MF_SMOOTHEST = 1.0e-4;

// The shortest mean normal: opposed normals have none. This length stands for alpha 1 to 4 digits.
const float MF_SHORTEST_MEAN = 1.0e-4;

// Two widths and the direction of the larger.
struct MfAxes {
    float alpha_x; // the larger
    float alpha_y; // the smaller, across it
    float angle; // radians from the tangent to the axis of alpha_x, in (-pi/2, pi/2]; 0 if the lobe is round
};

// glTF's KHR_materials_anisotropy: alpha across, mix(alpha, 1, strength^2) along.
struct MfGltf {
    float alpha; // the smaller width; the material's roughness is its root
    float strength; // 0 to 1
    vec2 direction; // unit, along the larger width
};

// Disney's parameters: alpha / aspect along and alpha aspect across, aspect = sqrt(1 - 0.9 anisotropy).
struct MfBurley {
    float alpha; // geometric mean of the widths; the material's roughness is its root
    float anisotropy; // 0 to 1
    float rotation; // of the larger width, in turns, 0 to 0.5: the other half turn is the same lobe
};

// alpha from perceptual roughness, 0 to 1: alpha = perceptual^2 (Burley 2012, sec. 5.4).
float mf_alpha_from_perceptual(float perceptual) {
    return perceptual * perceptual;
}

// Perceptual roughness from alpha. Below 0 counts as 0.
float mf_perceptual_from_alpha(float alpha) {
    return sqrt(max(alpha, 0.0));
}

// alpha from smoothness or gloss, 0 to 1: that is 1 - perceptual (Unity and others).
float mf_alpha_from_smoothness(float smoothness) {
    return (1.0 - smoothness) * (1.0 - smoothness);
}

// Smoothness or gloss from alpha. 1 - sqrt(alpha), without the difference.
float mf_smoothness_from_alpha(float alpha) {
    return (1.0 - alpha) / (1.0 + sqrt(max(alpha, 0.0)));
}

// Variance of a Beckmann lobe's slopes along an axis: alpha^2 / 2 (Heitz 2014, sec. 5.2). GGX has none: it diverges.
float mf_variance_from_alpha(float alpha) {
    return 0.5 * alpha * alpha;
}

// Width of the Beckmann lobe with this variance of slopes along an axis: sqrt(2 variance). Below 0 (rounding) counts as 0.
float mf_alpha_from_variance(float variance) {
    return sqrt(2.0 * max(variance, 0.0));
}

// Concentration of the von Mises-Fisher lobe of normals with the same peak: kappa = 2 / alpha^2, right to first order in
// alpha. Of reflected directions the sharpness is a quarter of it, at normal incidence. Widths count from MF_SMOOTHEST.
float mf_kappa_from_alpha(float alpha) {
    float a = max(alpha, MF_SMOOTHEST);
    return 2.0 / (a * a);
}

// alpha from a concentration of normals: sqrt(2 / kappa), at most 1 (kappa below 2).
float mf_alpha_from_kappa(float kappa) {
    return sqrt(2.0 / max(kappa, 2.0));
}

// Exponent of the Blinn-Phong lobe (n.h)^s with the same peak: 2 / alpha^2 - 2 (Walter et al. 2007, sec. 5.2, has the way
// back). alpha up to 1; widths count from MF_SMOOTHEST.
float mf_exponent_from_alpha(float alpha) {
    float a = max(alpha, MF_SMOOTHEST);
    return 2.0 * (1.0 - a) * (1.0 + a) / (a * a);
}

// alpha from a Blinn-Phong exponent, 0 and up: sqrt(2 / (s + 2)). Below 0 counts as 0.
float mf_alpha_from_exponent(float exponent) {
    return sqrt(2.0 / (max(exponent, 0.0) + 2.0));
}

// alpha of a lobe over slopes of this variance per axis: alpha'^2 = alpha^2 + 2 variance, at most 1 (Olano & Baker 2010;
// exact for Beckmann). Variance from 0.
float mf_alpha_widened(float alpha, float variance) {
    return sqrt(min(alpha * alpha + 2.0 * variance, 1.0));
}

// The same in projected space, for the variance of a projected normal's x or y: with X = alpha^2 / (1 - alpha^2),
// X' = X + 2 variance (Tokuyoshi & Kaplanyan 2021), without the division that fails at alpha 1. Never above 1.
float mf_alpha_widened_projected(float alpha, float variance) {
    float a2 = alpha * alpha;
    float added = 2.0 * variance * (1.0 - alpha) * (1.0 + alpha);
    return sqrt((a2 + added) / (1.0 + added));
}

// alpha of a lobe over normals whose mean has this length, 0 to 1: the gloss factor of Toksvig 2004, 1/s' = 1/s + V with
// V = (1 - r) / r and the exponent s = 2 / alpha^2 - 2, told in alpha. Lengths above 1 count as 1. r must be the mean of
// unit normals: two-channel textures and 8 bits do not hold it.
float mf_toksvig(float alpha, float mean_length) {
    float r = clamp(mean_length, MF_SHORTEST_MEAN, 1.0);
    return mf_alpha_widened_projected(alpha, (1.0 - r) / r);
}

// Concentration kappa of the von Mises-Fisher distribution whose mean has this length r, 0 to 1: the inverse of
// A(kappa) = coth kappa - 1/kappa. From 0.9, A is 1 - 1/kappa to 1e-8; to 0.2, a series, for there A cancels; between,
// Banerjee et al. 2005, eq. 4.4 (within 5 percent), and two Newton steps (one leaves 0.24 percent, two 6e-6). At most
// 2 / MF_SMOOTHEST^2, for r = 1.
float mf_kappa_from_mean_length(float mean_length) {
    float r = clamp(mean_length, 0.0, 1.0);
    float r2 = r * r;
    if (r >= 0.9) {
        return 1.0 / max(1.0 - r, 5.0e-9);
    }
    if (r <= 0.2) {
        return r * (3.0 + r2 * (1.8 + r2 * (1.6971429 + r2 * 1.7588571)));
    }
    float kappa = r * (3.0 - r2) / (1.0 - r2);
    for (uint i = 0u; i < 2u; i = i + 1u) { // turns: 2
        float e = exp(-2.0 * kappa);
        float a = (1.0 + e) / (1.0 - e) - 1.0 / kappa;
        kappa = kappa - (a - r) / (1.0 - a * a - 2.0 * a / kappa);
    }
    return kappa;
}

// alpha of a lobe over normals whose mean has this length, 0 to 1, taken as a von Mises-Fisher lobe: alpha^2 + 2 / kappa,
// at most 1 (Han et al. 2007).
float mf_alpha_widened_vmf(float alpha, float mean_length) {
    if (mean_length >= 1.0) {
        return alpha;
    }
    return sqrt(min(alpha * alpha + 2.0 / max(mf_kappa_from_mean_length(mean_length), 2.0), 1.0));
}

// Tensor from two widths and the angle of the first (radians): alpha_y^2 I + (alpha_x^2 - alpha_y^2) d d^T.
vec3 mf_tensor_from_axes(MfAxes axes) {
    float c = cos(axes.angle);
    float s = sin(axes.angle);
    float low = axes.alpha_y * axes.alpha_y;
    float more = (axes.alpha_x - axes.alpha_y) * (axes.alpha_x + axes.alpha_y);
    return vec3(low + more * c * c, more * c * s, low + more * s * s);
}

// The two widths of a tensor, the larger first: roots of its eigenvalues. The smaller by the determinant, which loses less
// than a difference; of tensors in f32 it is known to 2e-4 of the larger at least. Eigenvalues below 0 count as 0.
vec2 mf_widths_from_tensor(vec3 r) {
    float side = 0.5 * (r.x - r.z);
    float high = 0.5 * (r.x + r.z) + sqrt(side * side + r.y * r.y);
    if (high <= 0.0) {
        return vec2(0.0, 0.0);
    }
    return vec2(sqrt(high), sqrt(max(r.x * r.z - r.y * r.y, 0.0) / high));
}

// Unit direction of a tensor's larger width, x not below 0; the tangent if the lobe is round. Half the angle of
// (xx - yy, 2 xy), without trigonometry.
vec2 mf_direction_from_tensor(vec3 r) {
    float side = 0.5 * (r.x - r.z);
    float spread = sqrt(side * side + r.y * r.y);
    if (spread <= 0.0) {
        return vec2(1.0, 0.0);
    }
    if (side >= 0.0) {
        return normalize(vec2(spread + side, r.y) / spread);
    }
    vec2 d = normalize(vec2(abs(r.y), spread - side) / spread);
    if (r.y < 0.0) {
        return vec2(d.x, -d.y);
    }
    return d;
}

// Widths and angle of a tensor.
MfAxes mf_axes_from_tensor(vec3 r) {
    vec2 widths = mf_widths_from_tensor(r);
    vec2 d = mf_direction_from_tensor(r);
    MfAxes o;
    o.alpha_x = widths.x;
    o.alpha_y = widths.y;
    o.angle = atan(d.y, d.x);
    return o;
}

// A tensor with its eigenvalues (squared widths) clamped to low..high, axes kept.
vec3 mf_tensor_clamped(vec3 r, float low, float high) {
    float mean = 0.5 * (r.x + r.z);
    float side = 0.5 * (r.x - r.z);
    float spread = sqrt(side * side + r.y * r.y);
    float a = clamp(mean + spread, low, high);
    float b = clamp(mean - spread, low, high);
    float middle = 0.5 * (a + b);
    if (spread <= 0.0) {
        return vec3(middle, 0.0, middle);
    }
    float scale = 0.5 * (a - b) / spread;
    return vec3(middle + side * scale, r.y * scale, middle - side * scale);
}

// glTF's strength from two widths, the larger first, up to 1: sqrt((along - across) / (1 - across)).
float mf_gltf_strength(float along, float across) {
    if (across >= 1.0) {
        return 0.0;
    }
    return sqrt(clamp((along - across) / (1.0 - across), 0.0, 1.0));
}

// glTF's parameters from widths and angle. Every lobe with widths up to 1 has them.
MfGltf mf_gltf_from_axes(MfAxes axes) {
    MfGltf o;
    o.alpha = axes.alpha_y;
    o.strength = mf_gltf_strength(axes.alpha_x, axes.alpha_y);
    o.direction = vec2(cos(axes.angle), sin(axes.angle));
    return o;
}

// glTF's parameters from a tensor.
MfGltf mf_gltf_from_tensor(vec3 r) {
    vec2 widths = mf_widths_from_tensor(r);
    MfGltf o;
    o.alpha = widths.y;
    o.strength = mf_gltf_strength(widths.x, widths.y);
    o.direction = mf_direction_from_tensor(r);
    return o;
}

// glTF's direction and larger width, (x, y, alpha_t), alpha_t = mix(alpha, 1, strength^2) (KHR_materials_anisotropy). The
// direction is made unit; one that filtering or mid-gray of 8 bits left no longer than 0.1 counts as the tangent.
vec3 mf_gltf_along(MfGltf g) {
    float along = g.alpha + (1.0 - g.alpha) * g.strength * g.strength;
    float length2 = dot(g.direction, g.direction);
    if (length2 <= 0.01) {
        return vec3(1.0, 0.0, along);
    }
    vec2 d = g.direction * inversesqrt(length2);
    return vec3(d.x, d.y, along);
}

// Widths and angle from glTF's parameters.
MfAxes mf_axes_from_gltf(MfGltf g) {
    vec3 along = mf_gltf_along(g);
    MfAxes o;
    o.alpha_x = along.z;
    o.alpha_y = g.alpha;
    o.angle = atan(along.y, along.x);
    if (o.angle > 0.5 * MF_PI) {
        o.angle = o.angle - MF_PI;
    } else if (o.angle <= -0.5 * MF_PI) {
        o.angle = o.angle + MF_PI;
    }
    return o;
}

// Tensor from glTF's parameters, as glTF's sample renderer builds it.
vec3 mf_tensor_from_gltf(MfGltf g) {
    vec3 along = mf_gltf_along(g);
    float low = g.alpha * g.alpha;
    float more = (along.z - g.alpha) * (along.z + g.alpha);
    return vec3(low + more * along.x * along.x, more * along.x * along.y, low + more * along.y * along.y);
}

// Disney's parameters from widths and angle (Burley 2012, sec. 5.4). Widths further apart than 1 to 10 are out of reach:
// they become the nearest, with the same product.
MfBurley mf_burley_from_axes(MfAxes axes) {
    MfBurley o;
    o.alpha = sqrt(axes.alpha_x * axes.alpha_y);
    o.anisotropy = 0.0;
    if (axes.alpha_x > 0.0) {
        o.anisotropy = clamp((axes.alpha_x - axes.alpha_y) / (0.9 * axes.alpha_x), 0.0, 1.0);
    }
    o.rotation = 0.5 * fract(axes.angle / MF_PI);
    return o;
}

// Widths and angle from Disney's parameters; rotation in turns, 0 to 1.
MfAxes mf_axes_from_burley(MfBurley b) {
    float aspect = sqrt(1.0 - 0.9 * b.anisotropy);
    float half_turns = fract(2.0 * b.rotation);
    MfAxes o;
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
vec2 mf_kulla_conty_from_axes(MfAxes axes) {
    float sum = axes.alpha_x + axes.alpha_y;
    if (sum <= 0.0) {
        return vec2(0.0, 0.0);
    }
    return vec2(0.5 * sum, (axes.alpha_x - axes.alpha_y) / sum);
}

// Widths and angle from the arithmetic mean, the anisotropy A, -1 to 1, and the angle of the tangent in radians, -pi/2 to
// pi/2. Below 0, the larger width is across the tangent.
MfAxes mf_axes_from_kulla_conty(float alpha, float anisotropy, float angle) {
    MfAxes o;
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

#endif
