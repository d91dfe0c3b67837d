//! GGX lobes integrated over a piece of the map, for one half vector.
//!
//! In a frame whose third axis is h, let `N = (-s, 1)` be a normal of length `1 / n_z`, p its coordinates and
//! `V = (p.x / alpha, p.y / alpha, p.z)`. Then `D_n(h) = |N|^4 / (pi alpha^2 |V|^4)`. An area of the map with this normal
//! has `1 / n_z` of surface, or rather, for microfacets that reach past the horizon, `1 / sqrt(n_z^2 + alpha^2 (1 - n_z^2))`:
//! the projected area of their ellipsoid (Heitz et al. 2015), with which `integral D h_z dh` is 1 exactly. Over a triangle of area A on
//! which N is linear in the position, so is V, and its solid angle is `det / |V|^3` times that of the barycentric
//! coordinates, with det that of the three V. A weight that is linear too, `g = w . V`, leaves
//!
//! ```text
//! integral g / (pi alpha^2 |V|^4) = 2 A / (pi alpha^2 |det|) integral w . v dv,    v = V / |V|
//! ```
//!
//! and the last integral is w times the vector irradiance of the spherical triangle, half the sum over its edges of the
//! arc times the edge's unit normal (Lambert; Arvo 1994). The weight, kernel times `|N|^4` and area, is taken at the corners.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

use glam::DVec3;

/// Squared extent of a triangle, over the squared distance, below which three points do.
const SMALL: f64 = 0.04;
/// Least height of a triangle as an angle: flatter ones are opened to it, which moves the result by its share of a lobe's
/// width and keeps the digits of the division by the squared determinant.
const FLATTEST: f64 = 3e-5;

/// The lobe at h, over the map's area, of a normal with coordinates p; `inverse` is 1 / alpha.
#[inline]
pub(super) fn lobe(p: DVec3, inverse: f64) -> f64 {
    let inverse2 = inverse * inverse;
    let v2 = (p.x * p.x + p.y * p.y) * inverse2 + p.z * p.z;
    FRAC_1_PI * inverse2 * share(p, inverse) / (v2 * v2)
}

/// The lobe at h of normals about one with coordinates p that are spread along two axes, as a GGX lobe that is wider
/// by the squares of these (as LEAN adds twice the covariance of slopes).
#[inline]
pub(super) fn stretched_lobe(p: DVec3, alpha: f64, axes: [DVec3; 2]) -> f64 {
    if p.z <= 0.0 {
        return lobe(p, 1.0 / alpha);
    }
    let over = 1.0 / p.z;
    let at = p.truncate() * over;
    let [a, b] = axes.map(|v| (v.truncate() - at * v.z) * over);
    let alpha2 = alpha * alpha;
    let (xx, yy) = (alpha2 + a.x * a.x + b.x * b.x, alpha2 + a.y * a.y + b.y * b.y);
    let xy = a.x * a.y + b.x * b.y;
    let det = xx * yy - xy * xy;
    let d2 = (yy * at.x * at.x - 2.0 * xy * at.x * at.y + xx * at.y * at.y) / det;
    let v2 = p.z * p.z * (1.0 + d2);
    FRAC_1_PI * share(p, 1.0 / alpha) / (det.sqrt() * v2 * v2)
}

/// `|N|^4` and surface over the map's area.
#[inline]
pub(super) fn share(p: DVec3, inverse: f64) -> f64 {
    let n2 = p.length_squared();
    n2 * n2 * (n2 / (1.0 + (n2 - 1.0) / (inverse * inverse))).sqrt()
}

/// `atan(sqrt(z)) / sqrt(z)` for z up to `tan(pi / 8)^2`, relative error 1e-15: interpolated at Chebyshev's nodes.
#[inline]
fn short_atan(z: f64) -> f64 {
    const BY_DEGREE: [f64; 10] = [
        0.999_999_999_999_999,
        -0.333_333_333_332_214_3,
        0.199_999_999_783_926_63,
        -0.142_857_126_616_847_93,
        0.111_110_488_537_512_96,
        -0.090_895_299_565_623_07,
        0.076_735_354_281_832_85,
        -0.065_059_829_671_708_4,
        0.050_247_621_189_401_28,
        -0.025_316_479_573_776_474,
    ];
    BY_DEGREE.iter().rev().fold(0.0, |sum, c| sum * z + c)
}

/// The arc between two directions over the sine, both given up to one factor: `atan2(sine, cosine) / sine`, the sine 0
/// or more. Without branches, for several at once.
#[inline]
fn arc_over_sine(sine: f64, cosine: f64) -> f64 {
    let (sine, size) = (sine.max(1e-150), cosine.abs());
    let (less, more) = (sine.min(size), sine.max(size));
    // From an eighth of a turn to a sixteenth on either side.
    let wide = less > 0.414_213_562_373_095 * more;
    let (over, under) = if wide { (less - more, less + more) } else { (less, more) };
    let t = over / under;
    let arc = if wide { FRAC_PI_4 } else { 0.0 } + t * short_atan(t * t);
    let arc = if sine > size { FRAC_PI_2 - arc } else { arc };
    (if cosine < 0.0 { PI - arc } else { arc }) / sine
}

/// Arc between two directions times the unit normal of their plane.
#[inline]
fn arc(a: DVec3, b: DVec3) -> DVec3 {
    let cross = a.cross(b);
    cross * arc_over_sine(cross.length(), a.dot(b))
}

/// Mean over a square piece with these corners (x first) of kernel times lobe, as four triangles about its middle.
/// `kernel` is taken at the corners and in the middle, and the weight scaled to the mean that it has at other nodes.
pub(super) fn fan(corners: &[DVec3; 4], kernel: &[f64; 5], mean: f64, inverse: f64) -> f64 {
    let middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    let stretch = |p: DVec3| DVec3::new(p.x * inverse, p.y * inverse, p.z);
    // Around: 0 1 3 2.
    let ring = [0, 1, 3, 2].map(|k| (stretch(corners[k]), kernel[k] * share(corners[k], inverse)));
    let (centre, weight) = (stretch(middle), kernel[4] * share(middle, inverse));
    let linear = (ring[0].1 + ring[1].1 + ring[2].1 + ring[3].1) / 6.0 + weight / 3.0;
    // Four spokes, then four edges of the ring.
    let next = [1, 2, 3, 0];
    let pair = |k: usize| if k < 4 { (centre, ring[k].0) } else { (ring[k - 4].0, ring[next[k - 4]].0) };
    let (mut normals, mut cosines, mut squares, mut arcs) = ([DVec3::ZERO; 8], [0.0; 8], [0.0; 8], [0.0; 8]);
    for k in 0..8 {
        let (a, b) = pair(k);
        (normals[k], cosines[k]) = (a.cross(b), a.dot(b));
        squares[k] = normals[k].length_squared();
    }
    for k in 0..8 {
        arcs[k] = arc_over_sine(f64::sqrt(squares[k]), cosines[k]);
    }
    let lengths = [ring[0].0, ring[1].0, ring[2].0, ring[3].0, centre].map(|v| v.length_squared());
    let mut sum = 0.0;
    for k in 0..4 {
        let (to, edge) = (next[k], k + 4);
        let (a, b, c) = (lengths[4], lengths[k], lengths[to]);
        let nearest = a.min(b).min(c);
        let side = |a: f64, b: f64, cosine: f64| a + b - 2.0 * cosine;
        let extent = side(a, b, cosines[k]).max(side(a, c, cosines[to])).max(side(b, c, cosines[edge]));
        let det = centre.dot(normals[edge]);
        // Height over the widest of the three planes.
        let flat = (squares[edge] * a).max(squares[to] * b).max(squares[k] * c);
        sum += if extent < SMALL * nearest || det * det < FLATTEST * FLATTEST * flat {
            triangle([(centre, weight), ring[k], ring[to]])
        } else {
            let w = weight * normals[edge] - ring[k].1 * normals[to] + ring[to].1 * normals[k];
            let around = normals[k] * arcs[k] + normals[edge] * arcs[edge] - normals[to] * arcs[to];
            w.dot(around) / (det * det)
        };
    }
    0.25 * FRAC_1_PI * inverse * inverse * sum * (mean / linear)
}

/// Mean over a triangle of `g / |V|^4`, from V and g at its corners.
fn triangle([(a, ga), (b, gb), (c, gc)]: [(DVec3, f64); 3]) -> f64 {
    let extent = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
    let nearest = a.length_squared().min(b.length_squared()).min(c.length_squared());
    let few = || {
        let point = |v: DVec3, g: f64| g / v.length_squared().powi(2);
        // Middles of the edges: exact to the second degree.
        (point(0.5 * (a + b), 0.5 * (ga + gb))
            + point(0.5 * (b + c), 0.5 * (gb + gc))
            + point(0.5 * (c + a), 0.5 * (gc + ga)))
            / 3.0
    };
    if extent < SMALL * nearest {
        return few();
    }
    let normals = [b.cross(c), c.cross(a), a.cross(b)];
    let sizes = normals.map(|n| n.length_squared());
    let det = a.dot(normals[0]);
    let longest = if sizes[0] >= sizes[1].max(sizes[2]) {
        0
    } else if sizes[1] >= sizes[2] {
        1
    } else {
        2
    };
    let corner = [a, b, c][longest];
    if sizes[longest] <= 1e-20 * nearest * nearest {
        return few();
    }
    if det * det < FLATTEST * FLATTEST * corner.length_squared() * sizes[longest] {
        let mut v = [a, b, c];
        v[longest] += normals[longest] * (FLATTEST * corner.length() / sizes[longest].sqrt());
        return open(v, [ga, gb, gc]);
    }
    open([a, b, c], [ga, gb, gc])
}

/// The closed form for corners in no plane with the origin.
fn open([a, b, c]: [DVec3; 3], [ga, gb, gc]: [f64; 3]) -> f64 {
    let around = arc(a, b) + arc(b, c) + arc(c, a);
    let w = ga * b.cross(c) + gb * c.cross(a) + gc * a.cross(b);
    let det = a.dot(b.cross(c));
    w.dot(around) / (det * det)
}
