//! Mean and covariance of the unit normals of a piece of surface, in object space, and their merge.

use glam::DVec3;

use crate::ndf::RoughnessTensor;

/// What is kept of the surface under a texel. Merging two (`+=`) is exact: the parallel-variance formula (Chan, Golub &
/// LeVeque 1979) on the normals as vectors of object space, so that no tangent frame has to be carried along.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NormalMoments {
    /// Surface area, object units squared; the weight of everything below.
    pub weight: f64,
    /// Area in texture space, in textures.
    pub cover: f64,
    /// Mean unit normal; shorter than 1 where normals differ.
    pub mean: DVec3,
    /// Covariance of the unit normals, xx xy xz yy yz zz.
    pub cov: [f64; 6],
    /// Mean of the unit directions in which u grows on the surface.
    pub tangent: DVec3,
    /// Mean of +1 where the texture shows unmirrored and -1 where it is mirrored.
    pub side: f64,
}

impl std::ops::AddAssign<&NormalMoments> for NormalMoments {
    #[inline]
    fn add_assign(&mut self, other: &NormalMoments) {
        if self.weight == 0.0 {
            *self = *other;
            return;
        }
        let weight = self.weight + other.weight;
        let share = other.weight / weight;
        let d = other.mean - self.mean;
        let between = share * (1.0 - share);
        for (cov, (other, product)) in self.cov.iter_mut().zip(other.cov.iter().zip(products(d))) {
            *cov += share * (other - *cov) + between * product;
        }
        self.mean += share * d;
        self.tangent += share * (other.tangent - self.tangent);
        self.side += share * (other.side - self.side);
        self.weight = weight;
        self.cover += other.cover;
    }
}

/// The products of a vector's components, xx xy xz yy yz zz.
#[inline]
pub(super) fn products(d: DVec3) -> [f64; 6] {
    [d.x * d.x, d.x * d.y, d.x * d.z, d.y * d.y, d.y * d.z, d.z * d.z]
}

/// `a^T M b` for a symmetric M, xx xy xz yy yz zz.
#[inline]
pub(super) fn form(m: &[f64; 6], a: DVec3, b: DVec3) -> f64 {
    let on = |b: DVec3| {
        DVec3::new(
            m[0] * b.x + m[1] * b.y + m[2] * b.z,
            m[1] * b.x + m[3] * b.y + m[4] * b.z,
            m[2] * b.x + m[4] * b.y + m[5] * b.z,
        )
    };
    a.dot(on(b))
}

impl NormalMoments {
    /// Twice the covariance of the normals' components in the tangent plane of their mean, as xx xy yy in the frame that
    /// a renderer builds there: x along +u made orthogonal to the mean normal, y across it on the side where v grows.
    ///
    /// A Beckmann lobe has the slope variance alpha^2 / 2 along each axis (Heitz 2014), and the components of a unit
    /// normal in the tangent plane are its slopes to first order: twice the covariance is what the spread adds to
    /// alpha^2 (Kaplanyan et al. 2016; Tokuyoshi & Kaplanyan 2021 for components in place of slopes,
    /// which stay bounded). Where no frame exists, since the normals cancel or u runs along the normal, the tensor is
    /// isotropic.
    pub fn tensor(&self) -> [f64; 3] {
        let trace = self.cov[0] + self.cov[3] + self.cov[5];
        let Some(n) = (self.mean.length_squared() > 1e-6).then(|| self.mean.normalize()) else {
            return [2.0 / 3.0 * trace, 0.0, 2.0 / 3.0 * trace];
        };
        let flat = self.tangent - n * n.dot(self.tangent);
        if flat.length_squared() < 1e-12 {
            let tangential = trace - form(&self.cov, n, n);
            return [tangential, 0.0, tangential];
        }
        let t = flat.normalize();
        let b = if self.side < 0.0 { t.cross(n) } else { n.cross(t) };
        [(t, t), (t, b), (b, b)].map(|(a, b)| 2.0 * form(&self.cov, a, b))
    }
}

/// The tensor in the library's own type.
pub(super) fn rounded([xx, xy, yy]: [f64; 3]) -> RoughnessTensor {
    // Rounding can leave -1e-20 where a surface is flat along an axis.
    RoughnessTensor { xx: xx.max(0.0) as f32, xy: xy as f32, yy: yy.max(0.0) as f32 }
}

/// Sums over quadrature points of one piece of surface, about a normal of the piece, so that no precision is lost to
/// the mean.
#[derive(Default)]
pub(super) struct Gather {
    about: Option<DVec3>,
    weight: f64,
    first: DVec3,
    second: [f64; 6],
}

impl Gather {
    /// A point with this unit normal.
    #[inline]
    pub fn add(&mut self, weight: f64, n: DVec3) {
        let d = n - *self.about.get_or_insert(n);
        self.weight += weight;
        self.first += weight * d;
        for (sum, product) in self.second.iter_mut().zip(products(d)) {
            *sum += weight * product;
        }
    }

    /// Mean and covariance.
    #[inline]
    pub fn mean_and_cov(&self) -> (DVec3, [f64; 6]) {
        let mean = self.first / self.weight;
        let about = products(mean);
        let mut cov = self.second;
        for (cov, about) in cov.iter_mut().zip(about) {
            *cov = *cov / self.weight - about;
        }
        (self.about.unwrap_or_default() + mean, cov)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(normals: &[(f64, DVec3)]) -> NormalMoments {
        let mut sum = NormalMoments::default();
        for &(weight, n) in normals {
            sum += &NormalMoments { weight, mean: n, tangent: DVec3::X, side: 1.0, ..Default::default() };
        }
        sum
    }

    #[test]
    fn two_normals_worked_by_hand() {
        // Slopes of +-0.1 along x, equally often: mean z, variance of n.x is 0.01 / 1.01.
        let n = |x: f64| DVec3::new(x, 0.0, 1.0).normalize();
        let [xx, xy, yy] = of(&[(2.0, n(0.1)), (2.0, n(-0.1))]).tensor();
        assert!((xx - 0.02 / 1.01).abs() < 1e-15 && xy.abs() < 1e-15 && yy.abs() < 1e-15);
    }

    #[test]
    fn merging_in_any_order_and_gathering_agree() {
        let n = |i: f64| DVec3::new((3.0 * i).sin(), 0.3 * i.cos(), 1.5).normalize();
        let all: Vec<_> = (1..9).map(|i| (f64::from(i), n(f64::from(i)))).collect();
        let (mut a, b) = (of(&all[..3]), of(&all[3..]));
        let whole = of(&all);
        a += &b;
        let mut gather = Gather::default();
        all.iter().for_each(|&(weight, n)| gather.add(weight, n));
        let (mean, cov) = gather.mean_and_cov();
        for i in 0..6 {
            assert!((a.cov[i] - whole.cov[i]).abs() < 1e-15 && (cov[i] - whole.cov[i]).abs() < 1e-15);
        }
        assert!(mean.distance(whole.mean) < 1e-15 && a.mean.distance(whole.mean) < 1e-15);
    }

    #[test]
    fn a_mirrored_texture_turns_the_mixed_term() {
        let n = |x: f64| DVec3::new(x, x, 1.0).normalize();
        let mut moments = of(&[(1.0, n(0.1)), (1.0, n(-0.1))]);
        let [xx, xy, yy] = moments.tensor();
        moments.side = -1.0;
        assert_eq!(moments.tensor(), [xx, -xy, yy]);
        assert!(xy > 0.0 && (xy - xx).abs() < 1e-15);
    }

    #[test]
    fn normals_that_cancel_give_a_round_tensor() {
        let [xx, xy, yy] = of(&[(1.0, DVec3::Z), (1.0, -DVec3::Z)]).tensor();
        assert!((xx - 2.0 / 3.0).abs() < 1e-15 && xy == 0.0 && xx == yy);
    }
}
