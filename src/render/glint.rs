//! Flakes over what is drawn: each light's share of a lobe, times the ratio of the flakes in the pixel.

use glam::{DMat2, DVec3, Vec2, Vec3};

use super::Scene;
use super::geometry::{Hit, hit};
use super::texture::Pairs;
use crate::glint::{Evaluator, Flakes, Light, Macro, Query, SolidAngle, Tail, glint_ratio};
use crate::ndf::{Frame, RoughnessTensor};

/// Flakes that cover an object. The environment lights them too, but from all sides, and so is left smooth.
pub struct Glints {
    /// In the texture's coordinates.
    pub flakes: Flakes,
    /// How they are counted.
    pub evaluator: &'static Evaluator,
    /// Of every light, seen from the object.
    pub light: SolidAngle,
    /// Where flakes are: their share of the density, and the share of the surface that they make up; everywhere without.
    pub places: Option<Pairs>,
}

/// A point of a surface, for its half vectors.
struct Point {
    position: Vec3,
    view: Vec3,
    axes: [Vec3; 3],
}

impl Point {
    fn new(hit: &Hit) -> Self {
        let Frame { tangent, bitangent } = hit.frame;
        Self { position: hit.position, view: hit.view, axes: [tangent, bitangent, hit.normal] }
    }

    /// Half vector of a light, in the surface's frame.
    fn half_vector(&self, toward: &dyn Fn(Vec3) -> Vec3) -> DVec3 {
        let h = (self.view + toward(self.position)).normalize_or(self.axes[2]);
        DVec3::from_array(self.axes.map(|axis| f64::from(axis.dot(h))))
    }
}

/// The flakes under one ray.
pub(super) struct Spot<'a> {
    glints: &'a Glints,
    flakes: Flakes,
    uv: Vec2,
    jacobian: DMat2,
    here: Point,
    /// One ray to the right, and one up; none beyond the rim.
    beside: [Option<Point>; 2],
    /// Share of the surface that flakes make up.
    mask: f32,
}

impl Glints {
    /// Under the ray through `place`, one of `per_side` x `per_side` of its pixel, which met the object at `hit_here`; the
    /// texture is moved on by `shift`.
    pub(super) fn at(
        &self,
        scene: &Scene,
        place: Vec2,
        pixels: usize,
        per_side: usize,
        hit_here: &Hit,
        shift: Vec2,
    ) -> Spot<'_> {
        let rays = pixels * per_side;
        let step = 2.0 / rays as f32;
        let beside = [Vec2::X, Vec2::Y].map(|way| hit(scene, place + step * way, rays).map(|hit| Point::new(&hit)));
        let uv = hit_here.uv - shift;
        let [share, mask] = self.places.as_ref().map_or([1.0; 2], |places| places.mipped(uv, hit_here.footprint));
        let flakes = Flakes { share: f64::from(share), ..self.flakes };
        let [x, y] = hit_here.steps.map(|step| step.as_dvec2() / per_side as f64);
        Spot { glints: self, flakes, uv, jacobian: DMat2::from_cols(x, y), here: Point::new(hit_here), beside, mask }
    }
}

impl Spot<'_> {
    /// By how much the flakes of a lobe, with this frame and tensor, shine more or less than the smooth lobe, in a light that
    /// stands in this direction from a place.
    pub(super) fn ratio(&self, axes: [Vec3; 3], roughness: RoughnessTensor, toward: &dyn Fn(Vec3) -> Vec3) -> f32 {
        let light = toward(self.here.position);
        let half = (self.here.view + light).normalize_or(axes[2]);
        let here = self.here.half_vector(toward);
        let per_pixel = |point: &Option<Point>| point.as_ref().map_or(DVec3::ZERO, |p| p.half_vector(toward) - here);
        let query = Query {
            uv: self.uv.as_dvec2(),
            jacobian: self.jacobian,
            h: DVec3::from_array(axes.map(|axis| f64::from(axis.dot(half)))),
            lobe: Macro { mean: glam::DVec2::ZERO, roughness, tail: Tail::Ggx },
            flakes: self.flakes,
            light: Light {
                solid_angle: self.glints.light,
                l_dot_h: f64::from(light.dot(half)),
                half_vector_per_pixel: [per_pixel(&self.beside[0]), per_pixel(&self.beside[1])],
            },
        };
        1.0 + self.mask * (glint_ratio(self.glints.evaluator, &query) as f32 - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glint::{FlakeDensity, evaluator};
    use crate::image::Size;
    use crate::ndf::{Form, Lobe, Lobes};
    use crate::render::{Image, Sampling, Shape, render, render_glints};
    use crate::roughness::Alpha;
    use ndarray::Array3;

    /// A flat panel of alpha 0.3 that faces the camera, two lamps before it.
    fn panel() -> (Scene, Vec<Lobes>) {
        let scene = Scene { shape: Shape::Plane { tilt: 0.0 }, repeats: 1.0, environment: None, ..Scene::lamps() };
        (scene, vec![Lobes::from_fn(Form::Isotropic, Size::new(4, 4), |_, _| Lobe::isotropic(Vec3::Z, Alpha(0.3)))])
    }

    fn glints(name: &str, flakes: f64) -> Glints {
        let lobe = SolidAngle::of_flake(Alpha(0.05), Tail::Ggx);
        let flakes = Flakes::new(FlakeDensity(flakes), lobe, 5);
        Glints { flakes, evaluator: evaluator(name).unwrap(), light: SolidAngle::of_cone(0.01), places: None }
    }

    /// Mean and deviation of a picture over another, in the middle, which the panel fills.
    fn over(image: &Image, smooth: &Image) -> (f64, f64) {
        let side = image.dim().0;
        let inner = |(y, x, _): (usize, usize, usize)| [x, y].iter().all(|v| (side / 4..3 * side / 4).contains(v));
        let ratios: Vec<f64> = image
            .indexed_iter()
            .zip(smooth)
            .filter(|((place, _), _)| inner(*place))
            .map(|((_, v), smooth)| f64::from(v / smooth))
            .collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        (mean, (ratios.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / ratios.len() as f64).sqrt())
    }

    /// 96 x 96 pixels of some 0.3 flakes that answer: the mean stays within 4 standard errors (each pixel shares flakes with
    /// its neighbours, which is counted as a quarter as many), while pixels differ by more than the mean.
    #[test]
    fn glints_keep_the_light_and_break_it_up() {
        let (scene, levels) = panel();
        let smooth = render(&scene, &levels, 192, Sampling::mips(1));
        for name in ["field", "binomial"] {
            let image = render_glints(&scene, &levels, 192, Sampling::mips(1), &glints(name, 1e5));
            let (mean, deviation) = over(&image, &smooth);
            assert!((mean - 1.0).abs() < 4.0 * deviation / 48.0, "{name}: {mean} with deviation {deviation}");
            assert!(deviation > 1.0, "{name}: {deviation}");
        }
    }

    /// A pixel that sees more than 1e4 answering flakes is smooth, bit by bit.
    #[test]
    fn countless_flakes_are_the_smooth_lobe() {
        let (scene, levels) = panel();
        let many = render_glints(&scene, &levels, 24, Sampling::mips(2), &glints("field", 1e12));
        assert_eq!(many, render(&scene, &levels, 24, Sampling::mips(2)));
    }

    /// Half of the surface without flakes is smooth; the other half glints.
    #[test]
    fn flakes_are_where_the_mask_is() {
        let (scene, levels) = panel();
        let half = Array3::from_shape_fn((64, 64, 2), |(_, x, _)| if x < 32 { 0.0 } else { 1.0 });
        let glints = Glints { places: Some(Pairs::new(&[half])), ..glints("field", 1e5) };
        let image = render_glints(&scene, &levels, 96, Sampling::mips(1), &glints);
        let smooth = render(&scene, &levels, 96, Sampling::mips(1));
        let change = |x: usize| (0..96).filter(|y| image[(*y, x, 0)] != smooth[(*y, x, 0)]).count();
        assert_eq!((change(20), change(40)), (0, 0));
        assert!(change(60) > 40 && change(70) > 40);
    }

    /// A 25th of the flakes, each 25 times as strong: the same mean, and five times the deviation.
    #[test]
    fn a_thin_density_is_fewer_and_brighter_flakes() {
        let (scene, levels) = panel();
        let thin = Array3::from_shape_fn((1, 1, 2), |(_, _, which)| [0.04, 1.0][which]);
        let smooth = render(&scene, &levels, 192, Sampling::mips(1));
        let deviation = |places: Option<Pairs>, name: &str, flakes| {
            let glints = Glints { places, ..glints(name, flakes) };
            over(&render_glints(&scene, &levels, 192, Sampling::mips(1), &glints), &smooth)
        };
        for name in ["field", "binomial"] {
            let (dense, thin) =
                (deviation(None, name, 1e7), deviation(Some(Pairs::new(std::slice::from_ref(&thin))), name, 1e7));
            assert!((thin.0 / dense.0 - 1.0).abs() < 0.05, "{name}: means {} {}", thin.0, dense.0);
            assert!((thin.1 / dense.1 / 5.0 - 1.0).abs() < 0.1, "{name}: deviations {} {}", thin.1, dense.1);
        }
    }
}
