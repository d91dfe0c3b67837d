//! LDR-FLIP: how large the difference is that one sees when two pictures replace each other on a screen. Andersson,
//! Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images".

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DMat3, DVec3};
use ndarray::{Array2, Array3};

/// Exponent that compresses large colour differences (section 4.1.3).
const QC: f64 = 0.7;
/// Differences up to this share of the largest one ... (`p_c`)
const PC: f64 = 0.4;
/// ... are spread over this share of the range of errors (`p_t`).
const PT: f64 = 0.95;
/// Exponent of the feature difference (section 4.2).
const QF: f64 = 0.5;
/// Width of the feature detectors, degrees.
const DETECTOR: f64 = 0.082;

/// Contrast sensitivity in space, for Y, Cx and Cz: weights a and variances b of two Gaussians
/// `a sqrt(pi / b) exp(-pi^2 x^2 / b)`, x in degrees (table 1).
const SENSITIVITY: [[(f64, f64); 2]; 3] =
    [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];

/// FLIP error of each pixel, 0 to 1: 0 is the same, and 1 the largest difference that the method knows.
///
/// Both pictures are display-encoded sRGB, 0 to 1, axes (row, column, channel); values outside are clamped.
/// `pixels_per_degree` is the number of pixels in one degree of the field of view: 67 for a 4K screen 0.7 m wide seen
/// from 0.7 m, and smaller from nearer. The error is symmetric in its pictures.
///
/// # Panics
/// If the pictures differ in size, do not have three channels, or `pixels_per_degree` is not above 0.
pub fn flip(reference: &Array3<f32>, test: &Array3<f32>, pixels_per_degree: f32) -> Array2<f32> {
    assert_eq!(reference.dim(), test.dim(), "pictures of one size are compared");
    assert_eq!(reference.dim().2, 3, "pictures have three channels");
    assert!(pixels_per_degree > 0.0, "{pixels_per_degree} pixels per degree");
    let (rows, columns, _) = reference.dim();
    if rows * columns == 0 {
        return Array2::zeros((rows, columns));
    }
    let filters = Filters::new(pixels_per_degree.into());
    let colours = Colours::new();
    let [reference, test] = [reference, test].map(|image| Seen::new(image, &filters, &colours));
    let largest = colours.largest();
    let error = |i: usize| {
        let colour = redistributed(hyab(reference.lab[i], test.lab[i]), largest);
        let feature = |a: &[f32], b: &[f32]| f64::from((a[i] - b[i]).abs());
        let feature = feature(&reference.edges, &test.edges).max(feature(&reference.points, &test.points));
        let feature = (FRAC_1_SQRT_2 * feature).powf(QF).min(1.0);
        colour.powf(1.0 - feature).clamp(0.0, 1.0) as f32
    };
    Array2::from_shape_vec((rows, columns), (0..rows * columns).map(error).collect()).expect("one error a pixel")
}

/// Distance of two Hunt-adjusted colours: city-block in lightness, Euclidean in chroma (eq. 4).
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// A colour difference as an error of 0 to 1: compressed, and most of the range given to what is not extreme (eq. 5).
fn redistributed(difference: f64, largest: f64) -> f64 {
    let (error, most) = (difference.powf(QC), largest.powf(QC));
    let knee = PC * most;
    if error < knee { PT / knee * error } else { PT + (error - knee) / (most - knee) * (1.0 - PT) }
}

/// The colour spaces.
struct Colours {
    /// Linear sRGB to XYZ over the white's XYZ.
    to_xyz: DMat3,
    from_xyz: DMat3,
}

impl Colours {
    /// From the primaries and the white of BT.709.
    fn new() -> Self {
        let xyz = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let primaries = DMat3::from_cols(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06));
        let white = xyz(0.3127, 0.3290);
        let scaled = primaries * DMat3::from_diagonal(primaries.inverse() * white);
        let to_xyz = DMat3::from_diagonal(white.recip()) * scaled;
        Self { to_xyz, from_xyz: to_xyz.inverse() }
    }

    /// Y, Cx, Cz, linear in XYZ: opponent colours of about the size of L*a*b* (eq. 1).
    fn opponent(&self, rgb: DVec3) -> DVec3 {
        let v = self.to_xyz * rgb;
        DVec3::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
    }

    /// Hunt-adjusted L*a*b* of a filtered opponent colour, which is clamped to what the screen shows: chroma counts less
    /// in the dark (eq. 3).
    fn adjusted(&self, opponent: DVec3) -> DVec3 {
        let y = (opponent.x + 16.0) / 116.0;
        let xyz = DVec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
        self.hunt((self.from_xyz * xyz).clamp(DVec3::ZERO, DVec3::ONE))
    }

    fn hunt(&self, rgb: DVec3) -> DVec3 {
        // CIELAB's cube root, straight below (6/29)^3.
        const D: f64 = 6.0 / 29.0;
        let root = |t: f64| if t > D * D * D { t.cbrt() } else { t / (3.0 * D * D) + 4.0 / 29.0 };
        let [x, y, z] = (self.to_xyz * rgb).to_array().map(root);
        let lightness = 116.0 * y - 16.0;
        DVec3::new(lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z))
    }

    /// The largest colour difference of the screen: green to blue.
    fn largest(&self) -> f64 {
        hyab(self.hunt(DVec3::Y), self.hunt(DVec3::Z))
    }
}

/// A one-dimensional kernel of odd length about its middle.
type Kernel = Vec<f32>;

fn kernel(radius: usize, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|i| weight(i as f64 - radius as f64)).collect()
}

/// Scaled to a sum of 1.
fn normalised(kernel: &[f64]) -> Kernel {
    let sum: f64 = kernel.iter().sum();
    kernel.iter().map(|w| (w / sum) as f32).collect()
}

/// Scaled so that positive weights sum to 1 and negative ones to -1.
fn balanced(kernel: &[f64]) -> Kernel {
    let sum = |sign: f64| kernel.iter().filter(|w| *w * sign > 0.0).map(|w| w.abs()).sum::<f64>();
    // A detector much narrower than a pixel has no weights off its middle, and sees nothing.
    let (up, down) = (sum(1.0), sum(-1.0));
    let scaled = |w: f64| {
        if w > 0.0 && down > 0.0 {
            w / up
        } else if w < 0.0 && up > 0.0 {
            w / down
        } else {
            0.0
        }
    };
    kernel.iter().map(|w| scaled(*w) as f32).collect()
}

/// All filters for one viewing distance. All are separable; a sum of two Gaussians is two passes.
struct Filters {
    /// For each channel: weight and kernel of each Gaussian; the weights sum to 1.
    sensitivity: [Vec<(f32, Kernel)>; 3],
    smooth: Kernel,
    edge: Kernel,
    point: Kernel,
}

impl Filters {
    fn new(pixels_per_degree: f64) -> Self {
        // All channels share one radius: three standard deviations sqrt(b / (2 pi^2)) of the widest Gaussian.
        let widest = SENSITIVITY.iter().flatten().filter(|(a, _)| *a > 0.0).map(|(_, b)| *b).fold(0.0, f64::max);
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
        let sensitivity = SENSITIVITY.map(|gaussians| {
            let gaussians: Vec<_> = gaussians.into_iter().filter(|(a, _)| *a > 0.0).collect();
            // In two dimensions a Gaussian's weights sum to the square of its kernel's sum.
            let parts: Vec<_> = gaussians
                .iter()
                .map(|(a, b)| {
                    let kernel = kernel(radius, |x| (-(PI * x / pixels_per_degree).powi(2) / b).exp());
                    (a * (PI / b).sqrt() * kernel.iter().sum::<f64>().powi(2), normalised(&kernel))
                })
                .collect();
            let total: f64 = parts.iter().map(|(sum, _)| sum).sum();
            parts.into_iter().map(|(sum, kernel)| ((sum / total) as f32, kernel)).collect()
        });
        // Section 4.2: a Gaussian and its first and second derivatives.
        let sigma = 0.5 * DETECTOR * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as usize;
        let gauss = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
        Self {
            sensitivity,
            smooth: normalised(&kernel(radius, gauss)),
            edge: balanced(&kernel(radius, |x| -x * gauss(x))),
            point: balanced(&kernel(radius, |x| (x * x / (sigma * sigma) - 1.0) * gauss(x))),
        }
    }
}

/// One plane of a picture, row by row.
struct Plane {
    columns: usize,
    values: Vec<f32>,
}

impl Plane {
    /// Convolved along rows; the border's pixels go on outside.
    fn across(&self, kernel: &Kernel) -> Self {
        let (columns, radius) = (self.columns, kernel.len() / 2);
        let mut values = vec![0.0; self.values.len()];
        let mut wide = vec![0.0; columns + 2 * radius];
        for (row, out) in self.values.chunks_exact(columns).zip(values.chunks_exact_mut(columns)) {
            wide[..radius].fill(row[0]);
            wide[radius..radius + columns].copy_from_slice(row);
            wide[radius + columns..].fill(row[columns - 1]);
            for (k, w) in kernel.iter().enumerate() {
                out.iter_mut().zip(&wide[k..]).for_each(|(out, v)| *out += w * v);
            }
        }
        Self { columns, values }
    }

    /// Convolved along columns.
    fn down(&self, kernel: &Kernel) -> Self {
        let (columns, radius) = (self.columns, kernel.len() / 2);
        let rows = self.values.len() / columns;
        let mut values = vec![0.0; self.values.len()];
        for (y, out) in values.chunks_exact_mut(columns).enumerate() {
            for (k, w) in kernel.iter().enumerate() {
                let from = (y + k).saturating_sub(radius).min(rows - 1) * columns;
                out.iter_mut().zip(&self.values[from..]).for_each(|(out, v)| *out += w * v);
            }
        }
        Self { columns, values }
    }
}

/// A picture as the eye has it: filtered colours, and how strong edges and points are.
struct Seen {
    lab: Vec<DVec3>,
    edges: Vec<f32>,
    points: Vec<f32>,
}

impl Seen {
    fn new(image: &Array3<f32>, filters: &Filters, colours: &Colours) -> Self {
        let columns = image.dim().1;
        let linear = |v: &f32| {
            let v = f64::from(v.clamp(0.0, 1.0));
            // IEC 61966-2-1.
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        let values: Vec<f64> = image.iter().map(linear).collect();
        let opponent: Vec<DVec3> =
            values.as_chunks::<3>().0.iter().map(|rgb| colours.opponent(DVec3::from_array(*rgb))).collect();
        let plane = |c: usize| Plane { columns, values: opponent.iter().map(|v| v[c] as f32).collect() };
        let filtered: [Vec<f32>; 3] = std::array::from_fn(|c| {
            let plane = plane(c);
            let mut sum = vec![0.0; opponent.len()];
            for (weight, kernel) in &filters.sensitivity[c] {
                let part = plane.across(kernel).down(kernel);
                sum.iter_mut().zip(part.values).for_each(|(sum, v)| *sum += weight * v);
            }
            sum
        });
        let at = |i: usize| DVec3::from_array([0, 1, 2].map(|c: usize| f64::from(filtered[c][i])));
        let lab = (0..opponent.len()).map(|i| colours.adjusted(at(i))).collect();

        // Features are sought in the unfiltered lightness, 0 to 1.
        let lightness = Plane { columns, values: opponent.iter().map(|v| ((v.x + 16.0) / 116.0) as f32).collect() };
        let (smooth_across, smooth_down) = (lightness.across(&filters.smooth), lightness.down(&filters.smooth));
        let strength = |kernel: &Kernel| {
            let (x, y) = (smooth_down.across(kernel), smooth_across.down(kernel));
            x.values.iter().zip(y.values).map(|(x, y)| x.hypot(y)).collect()
        };
        Self { lab, edges: strength(&filters.edge), points: strength(&filters.point) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PPD: f32 = 67.0;

    fn plain(rgb: [f32; 3]) -> Array3<f32> {
        Array3::from_shape_fn((7, 9, 3), |(_, _, c)| rgb[c])
    }

    fn noise(seed: u32) -> Array3<f32> {
        Array3::from_shape_fn((24, 17, 3), |(y, x, c)| {
            let hash = (seed + 97 * y as u32 + 1009 * x as u32 + 31 * c as u32).wrapping_mul(2_654_435_761);
            (hash >> 8) as f32 / (1u32 << 24) as f32
        })
    }

    #[test]
    fn a_picture_is_itself() {
        for image in [noise(3), plain([0.2, 0.9, 0.0])] {
            for ppd in [1.0, 20.0, PPD] {
                assert!(flip(&image, &image, ppd).iter().all(|error| *error == 0.0));
            }
        }
        assert_eq!(flip(&Array3::zeros((0, 4, 3)), &Array3::zeros((0, 4, 3)), PPD).dim(), (0, 4));
    }

    /// Plain pictures have no features and filters change nothing: black and white differ by 100 in L* alone, and the
    /// largest difference, green to blue, by that of CIELAB's usual coordinates for them.
    #[test]
    fn black_and_white_worked_by_hand() {
        let adjusted = |l: f64, a: f64, b: f64| DVec3::new(l, 0.01 * l * a, 0.01 * l * b);
        // L*a*b* of the sRGB primaries under D65, as colour tables list them.
        let largest = hyab(adjusted(87.737, -86.185, 83.181), adjusted(32.303, 79.188, -107.860));
        let most = largest.powf(0.7);
        let expected = 0.95 + 0.05 * (100f64.powf(0.7) - 0.4 * most) / (0.6 * most);
        for error in flip(&plain([0.0; 3]), &plain([1.0; 3]), PPD) {
            assert!((f64::from(error) - expected).abs() < 1e-4, "{error} {expected}");
        }
        for error in flip(&plain([0.0, 1.0, 0.0]), &plain([0.0, 0.0, 1.0]), PPD) {
            assert!((error - 1.0).abs() < 1e-5, "{error}");
        }
        // A step of 1 in L* from L* = 50 (sRGB 0.4663 and 0.4761 or so) stays below the knee.
        let gray = |l: f64| {
            let y = ((l + 16.0) / 116.0).powi(3);
            plain([(1.055 * y.powf(1.0 / 2.4) - 0.055) as f32; 3])
        };
        let expected = 0.95 / (0.4 * most);
        for error in flip(&gray(50.0), &gray(51.0), PPD) {
            assert!((f64::from(error) - expected).abs() < 1e-4, "{error} {expected}");
        }
    }

    /// A vertical step has an edge strength of the step's height where it is sharpest, and no points in its middle.
    #[test]
    fn an_edge_is_seen_as_an_edge() {
        let step = Array3::from_shape_fn((40, 41, 3), |(_, x, _)| if x < 20 { 0.0 } else { 1.0 });
        let seen = Seen::new(&step, &Filters::new(PPD.into()), &Colours::new());
        let strongest = seen.edges.iter().copied().fold(0.0, f32::max);
        assert!((strongest - 1.0).abs() < 0.05, "{strongest}");
        assert!(seen.edges[20 * 41 + 2] < 1e-6 && seen.points[20 * 41 + 2] < 1e-6);
        // Features raise the error of a faint edge over that of the same difference without one.
        let faint = |x: usize| if x < 20 { 0.50 } else { 0.52 };
        let (edge, flat) =
            (Array3::from_shape_fn((40, 41, 3), |(_, x, _)| faint(x)), Array3::from_elem((40, 41, 3), 0.5));
        let with_edge = flip(&flat, &edge, PPD);
        assert!(with_edge[(20, 20)] > with_edge[(20, 38)]);
    }

    proptest! {
        #[test]
        fn errors_are_symmetric_and_bounded(a in 0u32..1000, b in 0u32..1000, ppd in 0.3f32..100.0) {
            let (a, b) = (noise(a), noise(b));
            let (forth, back) = (flip(&a, &b, ppd), flip(&b, &a, ppd));
            prop_assert_eq!(&forth, &back);
            prop_assert!(forth.iter().all(|error| (0.0..=1.0).contains(error)));
        }

        /// A larger difference is a larger error.
        #[test]
        fn errors_grow(level in 0.0f32..0.5, small in 0.01f32..0.2, more in 0.01f32..0.3) {
            let error = |v: f32| flip(&plain([level; 3]), &plain([v; 3]), PPD)[(3, 3)];
            prop_assert!(error(level + small) < error(level + small + more));
        }
    }
}
