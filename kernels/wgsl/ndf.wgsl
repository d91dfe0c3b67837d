// Distributions of microfacet normals (GGX, Beckmann, Student-t), Smith's masking, and samples of them.
// Needs: roughness
//
// m is a microfacet's normal: the half vector h = normalize(l + v) when shading. m, l and v are unit, in the tangent frame of
// the lobe, z its normal. D is per steradian, with a mean of m.z of 1 over all m. P22 is the density of slopes
// s = -m.xy / m.z, and D = P22 / m.z^4. A tensor R = (xx, xy, yy) holds squared widths (eigenvalues alpha^2). Widths count from
// MF_SMOOTHEST. The determinant cancels to 1e-7 xx yy: turned between the axes, the D of a given f32 tensor is evaluated to
// within 5e-6 where the lobe is ten times as wide as thin, and to within 5e-4 at a hundred times. Rounding the entries
// themselves to f32 adds about as much again.

// A GGX lobe in the plane of the slopes seen from the surface, whatever its tilt: a Student-t density about a centre.
struct MfSlopeLobe {
    centre: vec2f, // most frequent slope, along the surface's x and y
    scatter: vec3f, // xx, xy, yy: squared widths about it
}

// A lobe of one width.
struct MfRoundLobe {
    normal: vec3f, // unit, in the surface's tangent frame
    alpha: f32, // its width
}

// Cosines count from this where something is divided by them.
const MF_GRAZING: f32 = 1.0e-6;

// Determinants count from this share of xx yy: below, they are rounding.
const MF_LEAST_DETERMINANT: f32 = 2.0e-7;

// D of GGX from n.h, 0 to 1, and alpha: alpha^2 / (pi (1 + (alpha^2 - 1) (n.h)^2)^2) (Walter et al. 2007, eq. 33; Burley 2012),
// with 1 - (n.h)^2 as a product. n.h in f32 is 1 for all angles up to 2e-4: for alpha below 0.01 take one of the next two.
fn mf_d_ggx(n_h: f32, alpha: f32) -> f32 {
    if (n_h <= 0.0) {
        return 0.0;
    }
    let a: f32 = max(alpha, MF_SMOOTHEST);
    let q: f32 = a / (max((1.0 - n_h) * (1.0 + n_h), 0.0) + a * a * n_h * n_h);
    return q * q / MF_PI;
}

// The same from m in the tangent frame, where m.xy tells the smallest angles.
fn mf_d_ggx_tangent(m: vec3f, alpha: f32) -> f32 {
    if (m.z <= 0.0) {
        return 0.0;
    }
    let a: f32 = max(alpha, MF_SMOOTHEST);
    let q: f32 = a / (m.x * m.x + m.y * m.y + a * a * m.z * m.z);
    return q * q / MF_PI;
}

// The same from n and h in any one frame, sin^2 as |n x h|^2 (Filament does so for half floats). n x (h - n) is n x h without
// the difference of large products.
fn mf_d_ggx_cross(n: vec3f, h: vec3f, alpha: f32) -> f32 {
    let n_h: f32 = dot(n, h);
    if (n_h <= 0.0) {
        return 0.0;
    }
    let a: f32 = max(alpha, MF_SMOOTHEST);
    let c: vec3f = cross(n, h - n);
    let q: f32 = a / (dot(c, c) + a * a * n_h * n_h);
    return q * q / MF_PI;
}

// D of GGX from two widths, along x and y: 1 / (pi ax ay ((m.x / ax)^2 + (m.y / ay)^2 + m.z^2)^2) (Burley 2012, eq. 13).
fn mf_d_ggx_aniso(m: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    if (m.z <= 0.0) {
        return 0.0;
    }
    let ax: f32 = max(alpha_x, MF_SMOOTHEST);
    let ay: f32 = max(alpha_y, MF_SMOOTHEST);
    let x: f32 = m.x / ax;
    let y: f32 = m.y / ay;
    let q: f32 = 1.0 / (x * x + y * y + m.z * m.z);
    return q * q / (MF_PI * ax * ay);
}

// Determinant of a tensor, (alpha_x alpha_y)^2: at least MF_SMOOTHEST^4, and MF_LEAST_DETERMINANT of xx yy.
fn mf_tensor_determinant(r: vec3f) -> f32 {
    let least: f32 = MF_SMOOTHEST * MF_SMOOTHEST;
    let product: f32 = max(r.x, least) * max(r.z, least);
    return max(product - r.y * r.y, MF_LEAST_DETERMINANT * product);
}

// p^T R p.
fn mf_tensor_quadratic(r: vec3f, p: vec2f) -> f32 {
    return max(r.x * p.x * p.x + 2.0 * r.y * p.x * p.y + r.z * p.y * p.y, 0.0);
}

// p^T R^-1 p. As p.x^2 / xx and a square over the determinant, which loses less than the sum of three terms.
fn mf_tensor_inverse_quadratic(r: vec3f, p: vec2f) -> f32 {
    let least: f32 = MF_SMOOTHEST * MF_SMOOTHEST;
    let xx: f32 = max(r.x, least);
    let yy: f32 = max(r.z, least);
    let det: f32 = mf_tensor_determinant(r);
    if (xx >= yy) {
        let w: f32 = p.y - r.y / xx * p.x;
        return p.x * p.x / xx + w * w * (xx / det);
    }
    let w: f32 = p.x - r.y / yy * p.y;
    return p.y * p.y / yy + w * w * (yy / det);
}

// D of GGX from a tensor: 1 / (pi sqrt(det R) (m.xy^T R^-1 m.xy + m.z^2)^2).
fn mf_d_ggx_tensor(m: vec3f, r: vec3f) -> f32 {
    if (m.z <= 0.0) {
        return 0.0;
    }
    let q: f32 = 1.0 / (mf_tensor_inverse_quadratic(r, vec2f(m.x, m.y)) + m.z * m.z);
    return q * q / (MF_PI * sqrt(mf_tensor_determinant(r)));
}

// P22 of GGX at the slope s: 1 / (pi sqrt(det R) (1 + s^T R^-1 s)^2) (Heitz 2014, sec. 5.3).
fn mf_p22_ggx(s: vec2f, r: vec3f) -> f32 {
    let q: f32 = 1.0 / (1.0 + mf_tensor_inverse_quadratic(r, s));
    return q * q / (MF_PI * sqrt(mf_tensor_determinant(r)));
}

// P22 of Beckmann: exp(-s^T R^-1 s) / (pi sqrt(det R)) (Heitz 2014, sec. 5.2): Gaussian slopes of covariance R / 2.
fn mf_p22_beckmann(s: vec2f, r: vec3f) -> f32 {
    return exp(-mf_tensor_inverse_quadratic(r, s)) / (MF_PI * sqrt(mf_tensor_determinant(r)));
}

// log(1 + x), x from 0. Small x by 2 artanh(x / (2 + x)), whose series is cut at 1e-8 of itself.
fn mf_log_one_plus(x: f32) -> f32 {
    if (x > 0.5) {
        return log(1.0 + x);
    }
    let y: f32 = x / (2.0 + x);
    let y2: f32 = y * y;
    return 2.0 * y * (1.0 + y2 * (0.33333333 + y2 * (0.2 + y2 * (0.14285714 + y2 * 0.11111111))));
}

// P22 of the Student-t lobe with the tail exponent gamma, above 1: (1 + s^T R^-1 s / (gamma - 1))^-gamma / (pi sqrt(det R))
// (STD, Ribardiere et al. 2017). Steep slopes get rare as |s|^(-2 gamma): 2 is GGX, large values are Beckmann.
fn mf_p22_student(s: vec2f, r: vec3f, gamma: f32) -> f32 {
    let fall: f32 = gamma * mf_log_one_plus(mf_tensor_inverse_quadratic(r, s) / (gamma - 1.0));
    return exp(-fall) / (MF_PI * sqrt(mf_tensor_determinant(r)));
}

// D of Beckmann from a tensor: exp(-tan^2 / alpha^2) / (pi alpha^2 cos^4) in two widths (Walter et al. 2007, eq. 25).
fn mf_d_beckmann(m: vec3f, r: vec3f) -> f32 {
    if (m.z <= 0.0) {
        return 0.0;
    }
    let z: f32 = max(m.z, MF_GRAZING);
    return mf_p22_beckmann(vec2f(m.x / z, m.y / z), r) / (z * z * z * z);
}

// D of the Student-t lobe. Below gamma 2 it grows without end towards the horizon: m.z counts from MF_GRAZING.
fn mf_d_student(m: vec3f, r: vec3f, gamma: f32) -> f32 {
    if (m.z <= 0.0) {
        return 0.0;
    }
    let z: f32 = max(m.z, MF_GRAZING);
    let q: f32 = mf_tensor_inverse_quadratic(r, vec2f(m.x / z, m.y / z));
    let fall: f32 = gamma * mf_log_one_plus(q / (gamma - 1.0)) + 4.0 * log(z);
    return exp(-fall) / (MF_PI * sqrt(mf_tensor_determinant(r)));
}

// The slope lobe of a GGX lobe with the normal n (unit, n.z above 0) and the tensor R in its bent frame: tangent t = +x made
// orthogonal to n, bitangent b = n x t. From the lobe's ellipsoid S = n n^T + (t b) R (t b)^T (Heitz et al. 2015): S / S_zz =
// [[P + u u^T, -u], [-u^T, 1]] for the centre u and the scatter P. P is made of cofactors of S, in which nothing cancels.
fn mf_slope_lobe(n: vec3f, r: vec3f) -> MfSlopeLobe {
    let root: f32 = sqrt(n.y * n.y + n.z * n.z);
    var t: vec3f = vec3f(0.0, 0.0, -1.0);
    var b: vec3f = vec3f(0.0, sign(n.x), 0.0);
    if (root > MF_GRAZING) {
        t = vec3f(root, -n.x * n.y / root, -n.x * n.z / root);
        b = vec3f(0.0, n.z / root, -n.y / root);
    }
    let rz: vec2f = vec2f(r.x * t.z + r.y * b.z, r.y * t.z + r.z * b.z);
    let zz: f32 = max(n.z * n.z + t.z * rz.x + b.z * rz.y, MF_SMOOTHEST * MF_SMOOTHEST);
    let det: f32 = mf_tensor_determinant(r);
    let k: f32 = 1.0 / zz;
    var o: MfSlopeLobe;
    o.centre = vec2f(-k * (n.x * n.z + t.x * rz.x + b.x * rz.y), -k * (n.y * n.z + t.y * rz.x + b.y * rz.y));
    let xx: f32 = det * n.y * n.y + r.z * t.y * t.y - 2.0 * r.y * t.y * b.y + r.x * b.y * b.y;
    let xy: f32 = det * n.x * n.y + r.z * t.x * t.y - r.y * (t.x * b.y + b.x * t.y) + r.x * b.x * b.y;
    let yy: f32 = det * n.x * n.x + r.z * t.x * t.x - 2.0 * r.y * t.x * b.x + r.x * b.x * b.x;
    o.scatter = k * k * vec3f(xx, -xy, yy);
    return o;
}

// The same for a lobe of one width, alpha up to 1.
fn mf_slope_lobe_round(n: vec3f, alpha: f32) -> MfSlopeLobe {
    let a: f32 = max(alpha, MF_SMOOTHEST);
    let rest: f32 = (1.0 - a) * (1.0 + a);
    let zz: f32 = a * a + rest * n.z * n.z;
    let k: f32 = rest * n.z / zz;
    let scale: f32 = a * a / (zz * zz);
    var o: MfSlopeLobe;
    o.centre = vec2f(-k * n.x, -k * n.y);
    o.scatter = scale * vec3f(zz + rest * n.x * n.x, rest * n.x * n.y, zz + rest * n.y * n.y);
    return o;
}

// Back: the lobe of one width with these slopes, exact for those of one width up to 1. Of others, the normal is that of the
// scatter along the tilt, and alpha the geometric mean. Along the tilt, tan 2 theta = 2 |u| / (1 - P_aa - |u|^2).
fn mf_round_lobe(lobe: MfSlopeLobe) -> MfRoundLobe {
    let tilt: f32 = length(lobe.centre);
    var along: vec2f = vec2f(1.0, 0.0);
    if (tilt > 0.0) {
        along = lobe.centre / tilt;
    }
    let least: f32 = MF_SMOOTHEST * MF_SMOOTHEST;
    let aa: f32 = max(mf_tensor_quadratic(lobe.scatter, along), least);
    let cc: f32 = max(mf_tensor_quadratic(lobe.scatter, vec2f(-along.y, along.x)), least);
    let side: f32 = 1.0 - aa - tilt * tilt;
    let spread: f32 = sqrt(side * side + 4.0 * tilt * tilt);
    var n: vec2f = vec2f(2.0 * tilt, spread + side);
    if (side < 0.0) {
        n = vec2f(spread - side, 2.0 * tilt);
    }
    let inverse: f32 = inverseSqrt(max(dot(n, n), 1.0e-30));
    let largest: f32 = 0.5 * (1.0 + aa + tilt * tilt + spread);
    var o: MfRoundLobe;
    o.normal = vec3f(-along.x * n.x * inverse, -along.y * n.x * inverse, n.y * inverse);
    if (spread <= 0.0) {
        o.normal = vec3f(0.0, 0.0, 1.0);
    }
    o.alpha = sqrt(sqrt(aa * cc / largest) / largest);
    return o;
}

// P22 of a slope lobe: 1 / (pi sqrt(det P) (1 + (s - u)^T P^-1 (s - u))^2).
fn mf_p22_slope_lobe(s: vec2f, lobe: MfSlopeLobe) -> f32 {
    return mf_p22_ggx(s - lobe.centre, lobe.scatter);
}

// D of a slope lobe, m in the surface's frame, for a mean of m.z of 1 there: P22 / m.z^4 without the division by m.z. The
// lobe's own D, for the plane of its normal, is this times sqrt(S_zz) (S_zz as in mf_slope_lobe).
fn mf_d_slope_lobe(m: vec3f, lobe: MfSlopeLobe) -> f32 {
    if (m.z <= 0.0) {
        return 0.0;
    }
    let w: vec2f = vec2f(m.x + lobe.centre.x * m.z, m.y + lobe.centre.y * m.z);
    let q: f32 = 1.0 / (mf_tensor_inverse_quadratic(lobe.scatter, w) + m.z * m.z);
    return q * q / (MF_PI * sqrt(mf_tensor_determinant(lobe.scatter)));
}

// Smith's Lambda of GGX: (sqrt(1 + v.xy^T R v.xy / v.z^2) - 1) / 2 (Heitz 2014, eq. 72 and 86), without the difference.
fn mf_lambda_ggx(v: vec3f, r: vec3f) -> f32 {
    let z: f32 = max(v.z, MF_GRAZING);
    let t: f32 = mf_tensor_quadratic(r, vec2f(v.x, v.y)) / (z * z);
    return 0.5 * t / (1.0 + sqrt(1.0 + t));
}

// The same from two widths, along x and y.
fn mf_lambda_ggx_aniso(v: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    return mf_lambda_ggx(v, vec3f(alpha_x * alpha_x, 0.0, alpha_y * alpha_y));
}

// exp(x^2) erfc(x), x from 0, to 5e-6 of itself: a polynomial in t = 1 / (1 + 0.55 x), fitted.
fn mf_erfc_scaled(x: f32) -> f32 {
    let t: f32 = 1.0 / (1.0 + 0.55 * x);
    let high: f32 = 0.13861866 + t * (0.17717712 + t * (-0.30184911 + t * 0.098847289));
    return t * (0.31030417 + t * (0.31018776 + t * (0.26671837 + t * high)));
}

// Smith's Lambda of Beckmann: (erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi)) with a = v.z / sqrt(v.xy^T R v.xy) (Heitz 2014,
// sec. 5.2), to 3e-6 of 1 + Lambda.
fn mf_lambda_beckmann(v: vec3f, r: vec3f) -> f32 {
    let z: f32 = max(v.z, MF_GRAZING);
    let width: f32 = sqrt(mf_tensor_quadratic(r, vec2f(v.x, v.y)));
    if (width <= 0.1 * z) {
        return 0.0;
    }
    let a: f32 = z / width;
    return max(exp(-a * a) * (0.28209479 / a - 0.5 * mf_erfc_scaled(a)), 0.0);
}

// Smith's masking of one direction from its Lambda, 0 to 1 (Smith 1967).
fn mf_g1(lambda: f32) -> f32 {
    return 1.0 / (1.0 + lambda);
}

// Smith's masking and shadowing, height-correlated, from Lambda of view and light (Heitz 2014, eq. 99).
fn mf_g2(lambda_v: f32, lambda_l: f32) -> f32 {
    return 1.0 / (1.0 + lambda_v + lambda_l);
}

// V = G2 / (4 n.l n.v) of GGX, height-correlated, from n.l, n.v (0 to 1) and alpha (Lagarde & de Rousiers 2014, listing 2).
fn mf_v_smith_ggx(n_l: f32, n_v: f32, alpha: f32) -> f32 {
    let l: f32 = max(n_l, MF_GRAZING);
    let v: f32 = max(n_v, MF_GRAZING);
    let a: f32 = max(alpha, MF_SMOOTHEST);
    let rest: f32 = (1.0 - a) * (1.0 + a);
    return 0.5 / (l * sqrt(a * a + rest * v * v) + v * sqrt(a * a + rest * l * l));
}

// The same from two widths, along x and y (V_SmithJointGGXAniso: Heitz 2014, as in Lagarde 2017).
fn mf_v_smith_ggx_aniso(l: vec3f, v: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let ax: f32 = max(alpha_x, MF_SMOOTHEST);
    let ay: f32 = max(alpha_y, MF_SMOOTHEST);
    let lz: f32 = max(l.z, MF_GRAZING);
    let vz: f32 = max(v.z, MF_GRAZING);
    return 0.5 / (lz * length(vec3f(ax * v.x, ay * v.y, vz)) + vz * length(vec3f(ax * l.x, ay * l.y, lz)));
}

// The same from a tensor.
fn mf_v_smith_ggx_tensor(l: vec3f, v: vec3f, r: vec3f) -> f32 {
    let lz: f32 = max(l.z, MF_GRAZING);
    let vz: f32 = max(v.z, MF_GRAZING);
    let sv: f32 = sqrt(mf_tensor_quadratic(r, vec2f(v.x, v.y)) + vz * vz);
    return 0.5 / (lz * sv + vz * sqrt(mf_tensor_quadratic(r, vec2f(l.x, l.y)) + lz * lz));
}

// Area of a slope lobe's facets that v sees, over that of the surface: the mean of max(0, v.z - s.v.xy), which is
// (c + sqrt(c^2 + v.xy^T P v.xy)) / 2 with c = v.z - u.v.xy (Dupuy et al. 2013). With the light as v it is their diffuse
// irradiance without shadows.
fn mf_sigma_slope_lobe(v: vec3f, lobe: MfSlopeLobe) -> f32 {
    let c: f32 = v.z - lobe.centre.x * v.x - lobe.centre.y * v.y;
    let form: f32 = mf_tensor_quadratic(lobe.scatter, vec2f(v.x, v.y));
    let root: f32 = sqrt(c * c + form);
    if (c < 0.0) {
        return 0.5 * form / (root - c);
    }
    return 0.5 * (c + root);
}

// Smith's masking about the mean plane of a slope lobe, c / sigma; 0 from below that plane. v.z / sigma, which is also in use,
// is above 1 where the plane faces away.
fn mf_g1_slope_lobe(v: vec3f, lobe: MfSlopeLobe) -> f32 {
    let c: f32 = v.z - lobe.centre.x * v.x - lobe.centre.y * v.y;
    if (c <= 0.0) {
        return 0.0;
    }
    return c / mf_sigma_slope_lobe(v, lobe);
}

// V of a slope lobe: G2 / (4 c_l c_v) with c = v.z - u.v.xy in the place of cosines; 0 from below the mean plane. Reflected
// radiance is F D V c_l times the light's irradiance, with mf_d_slope_lobe.
fn mf_v_smith_slope_lobe(l: vec3f, v: vec3f, lobe: MfSlopeLobe) -> f32 {
    let cl: f32 = l.z - lobe.centre.x * l.x - lobe.centre.y * l.y;
    let cv: f32 = v.z - lobe.centre.x * v.x - lobe.centre.y * v.y;
    if (cl <= 0.0 || cv <= 0.0) {
        return 0.0;
    }
    return mf_v_smith_ggx_tensor(vec3f(l.x, l.y, cl), vec3f(v.x, v.y, cv), lobe.scatter);
}

// m drawn from GGX with the density mf_pdf_ggx, from two uniform numbers 0 to 1 (Walter et al. 2007, eq. 35, 36, stretched).
fn mf_sample_ggx(u: vec2f, alpha_x: f32, alpha_y: f32) -> vec3f {
    let ax: f32 = max(alpha_x, MF_SMOOTHEST);
    let ay: f32 = max(alpha_y, MF_SMOOTHEST);
    let radius: f32 = sqrt(u.x);
    let angle: f32 = 2.0 * MF_PI * u.y;
    return normalize(vec3f(ax * radius * cos(angle), ay * radius * sin(angle), sqrt(1.0 - u.x)));
}

// Its density per steradian of m: D m.z. Of l, divide by 4 v.m.
fn mf_pdf_ggx(m: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    return mf_d_ggx_aniso(m, alpha_x, alpha_y) * max(m.z, 0.0);
}

// m drawn from the GGX normals that v sees (v.z from 0), with the density mf_pdf_ggx_visible: a point of a spherical cap, u.x
// its height and u.y its angle, plus v, both where the lobe is a sphere (Dupuy & Benyoub 2023).
fn mf_sample_ggx_visible(u: vec2f, v: vec3f, alpha_x: f32, alpha_y: f32) -> vec3f {
    let ax: f32 = max(alpha_x, MF_SMOOTHEST);
    let ay: f32 = max(alpha_y, MF_SMOOTHEST);
    let stretched: vec3f = vec3f(ax * v.x, ay * v.y, max(v.z, 0.0));
    let s: vec3f = stretched * inverseSqrt(max(dot(stretched, stretched), 1.0e-16));
    // z of the cap's point is high - s.z; its radius without a difference from 1.
    let high: f32 = (1.0 - u.x) * (1.0 + s.z);
    let below: f32 = (s.x * s.x + s.y * s.y) / (1.0 + s.z);
    let radius: f32 = sqrt(u.x * (1.0 + s.z) * (high + below));
    let angle: f32 = 2.0 * MF_PI * u.y;
    let m: vec3f = vec3f(ax * (radius * cos(angle) + s.x), ay * (radius * sin(angle) + s.y), high);
    return m * inverseSqrt(max(dot(m, m), 1.0e-30));
}

// Its density per steradian of m: D max(0, v.m) / sigma with sigma = (v.z + sqrt(v.z^2 + v.xy^T R v.xy)) / 2, which is
// G1 D max(0, v.m) / v.z (Heitz 2014, sec. 2). Of l, divide by 4 v.m.
fn mf_pdf_ggx_visible(m: vec3f, v: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let ax: f32 = max(alpha_x, MF_SMOOTHEST);
    let ay: f32 = max(alpha_y, MF_SMOOTHEST);
    let vz: f32 = max(v.z, 0.0);
    let sigma: f32 = 0.5 * (vz + length(vec3f(ax * v.x, ay * v.y, vz)));
    return mf_d_ggx_aniso(m, ax, ay) * max(dot(v, m), 0.0) / max(sigma, 1.0e-8);
}
