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

use std::f64::consts::FRAC_1_PI;

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

/// Arc between two directions times the unit normal of their plane.
#[inline]
fn arc(a: DVec3, b: DVec3) -> DVec3 {
    let (cross, dot) = (a.cross(b), a.dot(b));
    let sine = cross.length();
    if sine > 1e-9 * dot.abs() { cross * (sine.atan2(dot) / sine) } else { cross / dot }
}

/// Mean over a square piece with these corners (x first) of kernel times lobe, as four triangles about its middle.
/// `kernel` is taken at the corners and in the middle, and the weight scaled to the mean that it has at other nodes.
pub(super) fn fan(corners: &[DVec3; 4], kernel: &[f64; 5], mean: f64, inverse: f64) -> f64 {
    let middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    let stretch = |p: DVec3| DVec3::new(p.x * inverse, p.y * inverse, p.z);
    // Around: 0 1 3 2.
    let ring = [0, 1, 3, 2].map(|k| (stretch(corners[k]), kernel[k] * share(corners[k], inverse)));
    let centre = (stretch(middle), kernel[4] * share(middle, inverse));
    let spokes = ring.map(|(v, _)| arc(centre.0, v));
    let linear = (ring[0].1 + ring[1].1 + ring[2].1 + ring[3].1) / 6.0 + centre.1 / 3.0;
    let mut sum = 0.0;
    for k in 0..4 {
        let next = (k + 1) % 4;
        let around = || spokes[k] + arc(ring[k].0, ring[next].0) - spokes[next];
        sum += triangle([centre, ring[k], ring[next]], around);
    }
    0.25 * FRAC_1_PI * inverse * inverse * sum * (mean / linear)
}

/// Mean over a triangle of `g / |V|^4`, from V and g at its corners. `around` is the sum over its edges.
#[inline]
fn triangle([(a, ga), (b, gb), (c, gc)]: [(DVec3, f64); 3], around: impl Fn() -> DVec3) -> f64 {
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
        return open(v, [ga, gb, gc], arc(v[0], v[1]) + arc(v[1], v[2]) + arc(v[2], v[0]));
    }
    let w = ga * normals[0] + gb * normals[1] + gc * normals[2];
    w.dot(around()) / (det * det)
}

/// The closed form for corners in no plane with the origin.
fn open([a, b, c]: [DVec3; 3], [ga, gb, gc]: [f64; 3], around: DVec3) -> f64 {
    let w = ga * b.cross(c) + gb * c.cross(a) + gc * a.cross(b);
    let det = a.dot(b.cross(c));
    w.dot(around) / (det * det)
}
