// Glints: what a pixel sees of a surface that is made of countless small mirrors, its flakes. Chart and areas, for the
// evaluators in glint_field and glint_binomial.
// Needs: roughness, glint_chance
//
// An evaluator returns the ratio g by which the flakes in a pixel answer a light, with mean 1 whatever the lobe, the pixel and
// the light: shade with D(h) g in place of D(h). Where many flakes are seen g tends to 1. How a shader joins it all:
//
// 1. The lobe to shade with, from mip chain and curvature: mf_footprint_normals (footprint), for all lights.
// 2. Once a pixel: MfGlintPixel p = mf_glint_pixel(uv, change of uv per pixel along screen x and y, flakes). Nothing here takes
//    derivatives, so that compute shaders and ray tracers can ask too; they bring their own.
// 3. For each light, with the unit half vector h in the mesh's tangent frame:
//    - the half vector in the lobe's own frame: b = mf_bent_components(lobe.normal, h), (b.x, b.y, dot(lobe.normal, h));
//    - the lobe over slopes in that frame: mean 0, lobe.tensor, GGX (an MfGlintLobe);
//    - omega = mf_glint_half_vectors(of the flake, of the light, l.h, change of h per pixel);
//    - MfGlintLight a = mf_glint_light(lobe over slopes, h, omega);
//    - g = mf_glint_field(p, a, flakes), or mf_glint_binomial;
//    - mf_footprint_shade(lobe, v, l, f0, g, scale), or a BRDF of your own with D times g.
//    Half vectors that change over the pixel may be told either to footprint (the lobe becomes smooth) or to
//    mf_glint_half_vectors (flakes answer for longer): the latter for glints, with the lobe of mf_footprint_normals.
//
// Flakes carry equal projected area, so a flake's normal m has density D(m) cos m, and a flake answers with chance D(h) cos(h)
// omega. Effective areas, 1 / integral of a kernel's square, of the pixel (in flakes) and of directions multiply to the
// expected number N_eff of answering flakes; the variance of g is 1 / N_eff, or that times 1 + variation^2.
//
// All chance is integer hashing, the same bits on every device. Places are a whole cell (i32, repeats after 2^32) and a
// fraction, so that they stay exact far from the origin. Floats are rounded down only where what could be missed weighs 0.

// Effective area 1 / integral W^2 of a round biweight of radius 1: 5 pi / 9.
const MF_BIWEIGHT_AREA: f32 = 1.74532925;

// Squared radius of a pixel's biweight, pixels squared. Its variance per axis, an eighth of this, is that of a Gaussian of
// deviation 1/2 pixel.
const MF_GLINT_SUPPORT2: f32 = 2.0;

// Longest kernel of a pixel, in widths. Longer footprints are widened, as texture samplers do it.
const MF_GLINT_ANISOTROPY: f32 = 64.0;

// Smallest share of flakes that answer: rarer ones are told apart no finer.
const MF_GLINT_LEAST: f32 = 1.0e-9;

// Effective flakes from which g is 1, and from half of which it tends there.
const MF_GLINT_SMOOTH: f32 = 1.0e4;

// Smallest share of the flakes that are there, and the variation that they then have (of areas that vary by 3).
const MF_FLAKE_LEAST_SHARE: f32 = 1.0e-3;
const MF_FLAKE_MOST_VARIATION: f32 = 99.995;

// A material's flakes.
struct MfFlakes {
    cells: f32, // root of the density: flakes per unit of length of uv, more than 0, to 2^21
    seed: u32, // another seed, another surface
    variation: f32, // standard deviation of the flakes' areas over their mean, 0 to 3; more where few of them are there
    coverage: f32, // share of the surface that flakes cover, more than 0, at most 1: their size in close-ups
    stretch: f32, // for scratches, length over width of the flakes' cells; 1 for none
    along: vec2f, // unit, uv, the long side of scratches; (1, 0) for none
}

// A number as a whole one and a rest, 0 to 1.
struct MfWhole {
    whole: i32,
    rest: f32,
}

// A pixel's kernel over the surface: a biweight over an ellipse, 3 (1 - t)^2 / (pi root) for t = d^T C^-1 d below 1.
struct MfGlintKernel {
    tensor: vec3f, // C (xx, xy, yy), cells squared
    root: f32, // sqrt(det C): long times short radius, known better than by the tensor; 0 where nothing can be asked
}

// A pixel in units of flakes: cells of one flake each.
struct MfGlintPixel {
    cell: vec2i, // of the pixel's centre
    within: vec2f, // place in it, 0 to 1
    kernel: MfGlintKernel,
}

// The smooth lobe that flakes make up, over slopes -(h.x, h.y) / h.z.
struct MfGlintLobe {
    mean: vec2f, // mean slope; 0 in the lobe's own frame
    tensor: vec3f, // roughness tensor; widths below MF_SMOOTHEST are raised to it
    beckmann: bool, // Beckmann; else GGX
}

// A direction in the chart of a lobe.
struct MfGlintPoint {
    y: vec2f, // the square in which the flakes' normals are uniform, 0 to 1
    density: f32, // D(h) cos(h), 1/sr
}

// A light as a pixel's flakes see it.
struct MfGlintLight {
    y: vec2f, // of the half vector in the chart, 0 to 1
    area: f32, // effective share of flakes that answer, MF_GLINT_LEAST to MF_BIWEIGHT_AREA / 4; 0 where nothing can be asked
    widths: vec2f, // the half vector on an equal-area map of the hemisphere, in widths of what answers
}

// A flake.
struct MfFlake {
    place: vec2f, // in its cell, 0 to 1
    y: vec2f, // direction in the chart, 0 to 1
    mark: f32, // uniform in 0..1, for its size
}

// From the unit disk to the unit square, equal areas to equal areas (Shirley & Chiu 1997). The arc tangent is a polynomial of
// our own, within 2e-7: graphics interfaces promise 4096 units in the last place for theirs.
fn mf_disk_to_square(d: vec2f) -> vec2f {
    let r: f32 = length(d);
    let wide: bool = abs(d.x) > abs(d.y);
    var major: f32 = d.y;
    var minor: f32 = d.x;
    if (wide) {
        major = d.x;
        minor = d.y;
    }
    if (major == 0.0) {
        return vec2f(0.5, 0.5);
    }
    let x: f32 = minor / major;
    let q: f32 = x * x;
    var t: f32 = 0.030278297 - 0.0058057075 * q;
    t = -0.07490437 + t * q;
    t = 0.1256543 + t * q;
    t = -0.17829543 + t * q;
    t = 0.25422725 + t * q;
    t = -0.42439383 + t * q;
    t = 1.2732394 + t * q;
    let a: f32 = 0.5 * r * sign(major);
    let b: f32 = clamp(t * x, -1.0, 1.0) * a;
    if (wide) {
        return vec2f(clamp(0.5 + a, 0.0, 1.0), clamp(0.5 + b, 0.0, 1.0));
    }
    return vec2f(clamp(0.5 + b, 0.0, 1.0), clamp(0.5 + a, 0.0, 1.0));
}

// The way back. Sine and cosine are polynomials of our own, within 1e-7.
fn mf_square_to_disk(y: vec2f) -> vec2f {
    let a: f32 = 2.0 * y.x - 1.0;
    let b: f32 = 2.0 * y.y - 1.0;
    let wide: bool = abs(a) > abs(b);
    var major: f32 = b;
    var minor: f32 = a;
    if (wide) {
        major = a;
        minor = b;
    }
    if (major == 0.0) {
        return vec2f(0.0, 0.0);
    }
    let x: f32 = minor / major;
    let q: f32 = x * x;
    let s: f32 = major * x * (0.7853982 + q * (-0.080745436 + q * (0.0024900069 - 3.595429e-5 * q)));
    let c: f32 = major * (1.0 + q * (-0.30842513 + q * (0.015854325 + q * (-3.259387e-4 + 3.529797e-6 * q))));
    if (wide) {
        return vec2f(c, s);
    }
    return vec2f(s, c);
}

// Cholesky factor (xx, xy, yy) of a lobe's tensor, L L^T = R: continuous in the tensor, as axes are not.
fn mf_glint_factor(tensor: vec3f) -> vec3f {
    let least: f32 = MF_SMOOTHEST * MF_SMOOTHEST;
    let xx: f32 = sqrt(max(tensor.x, least));
    let xy: f32 = tensor.y / xx;
    return vec3f(xx, xy, sqrt(max(max(tensor.z, least) - xy * xy, least)));
}

// The chart of a lobe at a unit h with h.z above 0. Slopes are whitened by the lobe, the share of flakes less steep with the
// slope's direction is a point of the disk, and the disk goes to the square: dy = D(m) cos(m) dm all the way, so one set of
// flakes serves every lobe.
fn mf_glint_point(lobe: MfGlintLobe, h: vec3f) -> MfGlintPoint {
    let l: vec3f = mf_glint_factor(lobe.tensor);
    // Whitened slopes times h.z: nothing overflows at the horizon.
    let x: f32 = (-h.x - lobe.mean.x * h.z) / l.x;
    let y: f32 = (-h.y - lobe.mean.y * h.z - l.y * x) / l.z;
    let w2: f32 = x * x + y * y;
    let area: f32 = MF_PI * l.x * l.z;
    var o: MfGlintPoint;
    if (lobe.beckmann) {
        let q: f32 = w2 / max(h.z * h.z, 1.0e-30);
        let scale: f32 = sqrt(mf_one_minus_exp(q) / max(w2, 1.0e-30));
        o.y = mf_disk_to_square(vec2f(x * scale, y * scale));
        o.density = exp(-min(q, 100.0)) / (area * max(h.z * h.z * h.z, 1.0e-30));
    } else {
        let s2: f32 = h.z * h.z + w2;
        let scale: f32 = inverseSqrt(s2);
        o.y = mf_disk_to_square(vec2f(x * scale, y * scale));
        o.density = h.z / (area * s2 * s2);
    }
    return o;
}

// The unit normal of a flake at a point y of the chart, 0 to 1: to sample, or to shade flakes one by one.
fn mf_glint_normal(lobe: MfGlintLobe, y: vec2f) -> vec3f {
    let l: vec3f = mf_glint_factor(lobe.tensor);
    let d: vec2f = mf_square_to_disk(y);
    let u: f32 = min(dot(d, d), 0.9999999);
    var scale: f32 = inverseSqrt(1.0 - u);
    if (lobe.beckmann) {
        scale = 1.0 + 0.25 * u;
        if (u > 1.0e-4) {
            scale = sqrt(-mf_ln_one_minus(u) / u);
        }
    }
    let s: vec2f = d * scale;
    return normalize(vec3f(-lobe.mean.x - l.x * s.x, -lobe.mean.y - l.y * s.x - l.z * s.y, 1.0));
}

// Solid angle (sr) of half vectors that a flake with a GGX or Beckmann lobe of its own answers, alpha 0 to 1: the effective area
// 1 / integral K^2 of the lobe's density over slopes. The smooth lobe is then the flakes' normals spread by this lobe.
fn mf_flake_solid_angle(alpha: f32, beckmann: bool) -> f32 {
    if (beckmann) {
        return 2.0 * MF_PI * alpha * alpha;
    }
    return 3.0 * MF_PI * alpha * alpha;
}

// Solid angle (sr) of a round light seen under this half angle, radians to pi: 0.00465 for the sun.
fn mf_cone_solid_angle(half_angle: f32) -> f32 {
    let s: f32 = sin(0.5 * half_angle);
    return 4.0 * MF_PI * s * s;
}

// Solid angle (sr) of half vectors that make a flake shine in the pixel: of the flake (mf_flake_solid_angle), of the light from
// the surface, 0 for a point, over 4 l.h (Walter et al. 2007, eq. 14), and of the change of the unit half vector per pixel
// along screen x and y, 0 if not known. The latter is added as a tensor, so that a change along one direction counts.
fn mf_glint_half_vectors(flake: f32, light: f32, l_dot_h: f32, dhdx: vec3f, dhdy: vec3f) -> f32 {
    let still: f32 = max(flake, 0.0) + max(light, 0.0) / (4.0 * max(abs(l_dot_h), 1.0e-3));
    let r2: f32 = still / MF_BIWEIGHT_AREA;
    // (r2 + xx) (r2 + yy) - xy^2, without the difference: xx yy - xy^2 is the square of a cross product.
    let trace: f32 = MF_GLINT_SUPPORT2 * (dot(dhdx, dhdx) + dot(dhdy, dhdy));
    let c: vec3f = MF_GLINT_SUPPORT2 * cross(dhdx, dhdy);
    return MF_BIWEIGHT_AREA * sqrt(r2 * r2 + r2 * trace + dot(c, c));
}

// The half vector of a light in a lobe's frame (of any length, h.z above 0: else nothing can be asked), with the solid angle of half
// vectors that answer.
fn mf_glint_light(lobe: MfGlintLobe, half_vector: vec3f, omega: f32) -> MfGlintLight {
    let h: vec3f = normalize(half_vector);
    var o: MfGlintLight;
    o.y = vec2f(0.5, 0.5);
    o.area = 0.0;
    o.widths = vec2f(0.0, 0.0);
    let known: f32 = abs(omega) + abs(h.x) + abs(h.y) + abs(lobe.mean.x) + abs(lobe.mean.y);
    let size: f32 = abs(lobe.tensor.x) + abs(lobe.tensor.y) + abs(lobe.tensor.z);
    // Comparisons with what is not a number are false.
    if (h.z > 0.0 && h.z < 2.0 && known < 1.0e9 && size < 1.0e9) {
        let at: MfGlintPoint = mf_glint_point(lobe, h);
        o.y = at.y;
        o.area = clamp(at.density * max(omega, 0.0), MF_GLINT_LEAST, 0.25 * MF_BIWEIGHT_AREA);
        // Lambert's map, (h.x, h.y) sqrt(2 / (1 + h.z)).
        o.widths = vec2f(h.x, h.y) * sqrt(2.0 / ((1.0 + h.z) * max(omega, MF_GLINT_LEAST)));
    }
    return o;
}

// m x as a whole number and a rest, |m| and |x| below 2^21: right to (|m| + |x|) 2^-33 and the rest's rounding, where f32 alone
// leaves |m x| 2^-24, some cells far from the origin. Both are cut at the point and ten bits below it; products of whole parts
// are exact.
fn mf_whole_product(m: f32, x: f32) -> MfWhole {
    let ma: f32 = abs(m);
    let xa: f32 = abs(x);
    let mi: f32 = floor(ma);
    let xi: f32 = floor(xa);
    let mf: f32 = (ma - mi) * 1024.0;
    let xf: f32 = (xa - xi) * 1024.0;
    let a: i32 = i32(xi) * i32(mf);
    let b: i32 = i32(mi) * i32(xf);
    let fine: f32 = f32(a & 1023) + f32(b & 1023) + xi * fract(mf) + mi * fract(xf) + mf * xf * 0.0009765625;
    let whole: i32 = i32(mi) * i32(xi) + (a >> 10u) + (b >> 10u);
    let side: f32 = sign(m) * sign(x);
    let rest: f32 = side * fine * 0.0009765625;
    let up: f32 = floor(rest);
    var o: MfWhole;
    o.whole = i32(side) * whole + i32(up);
    o.rest = rest - up;
    return o;
}

// dot(m, x) as a whole number and a rest: see mf_whole_product.
fn mf_whole_dot(m: vec2f, x: vec2f) -> MfWhole {
    let a: MfWhole = mf_whole_product(m.x, x.x);
    let b: MfWhole = mf_whole_product(m.y, x.y);
    let up: f32 = floor(a.rest + b.rest);
    var o: MfWhole;
    o.whole = a.whole + b.whole + i32(up);
    o.rest = a.rest + b.rest - up;
    return o;
}

// The kernel of a pixel: dx and dy are the change of its place per pixel along screen x and y, in cells; flake is the support
// radius of a flake, more than 0: close-ups show disks, not points. The determinant is a sum, without the difference that loses
// the short side of a long ellipse.
fn mf_glint_kernel(dx: vec2f, dy: vec2f, flake: f32) -> MfGlintKernel {
    let r2: f32 = flake * flake;
    let xx: f32 = MF_GLINT_SUPPORT2 * (dx.x * dx.x + dy.x * dy.x);
    let xy: f32 = MF_GLINT_SUPPORT2 * (dx.x * dx.y + dy.x * dy.y);
    let yy: f32 = MF_GLINT_SUPPORT2 * (dx.y * dx.y + dy.y * dy.y);
    let area: f32 = MF_GLINT_SUPPORT2 * (dx.x * dy.y - dx.y * dy.x);
    var o: MfGlintKernel;
    // So large that any light finds enough flakes.
    o.tensor = vec3f(1.0e16, 0.0, 1.0e16);
    o.root = 1.0e16;
    if (xx + yy + r2 < 1.0e16) {
        let det: f32 = area * area + r2 * (xx + yy + r2);
        let mean: f32 = 0.5 * (xx + yy) + r2;
        let side: f32 = 0.5 * (xx - yy);
        let spread: f32 = sqrt(side * side + xy * xy);
        let long2: f32 = mean + spread;
        let least: f32 = long2 / (MF_GLINT_ANISOTROPY * MF_GLINT_ANISOTROPY);
        o.tensor = vec3f(xx + r2, xy, yy + r2);
        o.root = sqrt(det);
        if (det < least * long2) {
            // The part across the long side goes to `least`; spread is not 0 here.
            let scale: f32 = 0.5 * (long2 - least) / spread;
            let middle: f32 = 0.5 * (long2 + least);
            o.tensor = vec3f(middle + scale * side, scale * xy, middle - scale * side);
            o.root = long2 / MF_GLINT_ANISOTROPY;
        }
    }
    return o;
}

// C^(-1/2) of a kernel: |S d|^2 is the squared distance from the centre, 1 at the rim, and keeps its digits across long ellipses.
fn mf_glint_inverse_root(kernel: MfGlintKernel) -> vec3f {
    let c: vec3f = kernel.tensor;
    let scale: f32 = 1.0 / (kernel.root * sqrt(c.x + c.z + 2.0 * kernel.root));
    return vec3f((c.z + kernel.root) * scale, -c.y * scale, (c.x + kernel.root) * scale);
}

// Length over width of a kernel, 1 or more.
fn mf_glint_anisotropy(kernel: MfGlintKernel) -> f32 {
    let side: f32 = 0.5 * (kernel.tensor.x - kernel.tensor.z);
    let long2: f32 = 0.5 * (kernel.tensor.x + kernel.tensor.z) + sqrt(side * side + kernel.tensor.y * kernel.tensor.y);
    return max(long2 / kernel.root, 1.0);
}

// A pixel in units of flakes: uv at its centre, and the change of uv per pixel along screen x and y. |uv| to 2^21. Without
// scratches the place is that of the given numbers (mf_whole_product); with them it is rounded as f32 is.
fn mf_glint_pixel(uv: vec2f, dx: vec2f, dy: vec2f, flakes: MfFlakes) -> MfGlintPixel {
    var m: vec2f = flakes.cells * flakes.along;
    var n: vec2f = flakes.cells * vec2f(-flakes.along.y, flakes.along.x);
    let stretch: f32 = sqrt(max(flakes.stretch, 1.0));
    if (stretch > 1.0) {
        m = m / stretch;
        n = n * stretch;
    }
    let size: f32 = sqrt(clamp(flakes.coverage, 1.0e-6, 1.0) / MF_BIWEIGHT_AREA);
    let change: f32 = abs(dx.x) + abs(dx.y) + abs(dy.x) + abs(dy.y);
    var none: MfGlintKernel;
    none.tensor = vec3f(1.0, 0.0, 1.0);
    none.root = 0.0;
    var o: MfGlintPixel;
    o.cell = vec2i(0, 0);
    o.within = vec2f(0.0, 0.0);
    o.kernel = none;
    // Comparisons with what is not a number are false.
    if (flakes.cells > 0.0 && flakes.cells * stretch < 4.0e6 && abs(uv.x) + abs(uv.y) < 1.0e9 && change < 1.0e15) {
        let x: MfWhole = mf_whole_dot(m, uv);
        let y: MfWhole = mf_whole_dot(n, uv);
        o.cell = vec2i(x.whole, y.whole);
        o.within = vec2f(x.rest, y.rest);
        o.kernel = mf_glint_kernel(vec2f(dot(m, dx), dot(n, dx)), vec2f(dot(m, dy), dot(n, dy)), size);
    }
    return o;
}

// Variation of flakes of which only a share is there, 0 to 1, each answering the more strongly: what the red channel of a
// map of flakes says. For MfFlakes.variation; the ratio's mean stays 1. Of a pixel of which a share m (green) is flakes at
// all, shade with D(h) (1 + m (g - 1)).
fn mf_flake_variation(variation: f32, share: f32) -> f32 {
    let own: f32 = clamp(variation, 0.0, 3.0);
    return sqrt((1.0 + own * own) / clamp(share, MF_FLAKE_LEAST_SHARE, 1.0) - 1.0);
}

// Effective number of answering flakes: 0 where nothing can be asked, then g is 1.
fn mf_glint_effective(seen: MfGlintPixel, light: MfGlintLight) -> f32 {
    return MF_BIWEIGHT_AREA * seen.kernel.root * light.area;
}
