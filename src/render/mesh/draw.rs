//! Drawing a mesh.

use glam::{DVec2, Vec2, Vec3};
use ndarray::Array2;
use rayon::prelude::*;

use super::attributes::{Attributes, Fragment, SurfacePoint};
use super::projected::{Camera, MeshView, Projected, Screen};
use super::visible::Band;
use crate::curvature::Mesh;
use crate::ndf::{Lobe, Lobes};
use crate::render::shade::Lighting;
use crate::render::texture::Texture;
use crate::render::{Image, Light};

/// A mesh of bare metal under lights, before a camera. Nothing casts shadows. Beside it the picture is black.
#[derive(Clone, Copy, Debug)]
pub struct MeshScene<'a> {
    /// What is drawn.
    pub mesh: &'a Mesh,
    /// From where.
    pub view: MeshView,
    /// The lights, in the mesh's space.
    pub lights: &'a [Light],
    /// Reflectance at normal incidence, linear RGB, 0 to 1.
    pub f0: Vec3,
}

/// What a picture of endlessly many samples would be near to.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Mean radiance of the samples of each pixel: one picture for each rule that was asked for.
    pub images: Vec<Image>,
    /// Share of each pixel's samples that see the mesh; axes (row, column).
    pub coverage: Array2<f32>,
    /// Whether a pixel sees one surface: all samples the mesh, and no step in depth between neighbours that is wider than
    /// the pixel.
    pub whole: Array2<bool>,
}

/// A rule that gives a point its lobe, in the point's frame.
pub type PointLobe<'a> = &'a (dyn Fn(&SurfacePoint) -> Lobe + Sync);

impl MeshScene<'_> {
    fn lighting(&self, lights: &[Light]) -> Lighting {
        Lighting::new(lights, None, self.f0)
    }

    fn projected(&self, camera: &Camera, screen: &Screen) -> Vec<Projected> {
        let triangles = (0..self.mesh.triangles.len()).into_par_iter();
        triangles.filter_map(|i| Projected::new(self.mesh, i, camera, screen)).collect()
    }

    /// What the middle of every pixel sees; axes (row, column). The picture is moved by `offset`, pixels to the right and up.
    pub fn fragments(&self, pixels: usize, offset: Vec2) -> Array2<Option<Fragment>> {
        let camera = Camera::new(&self.view);
        let screen = Screen::new(&camera, pixels, offset.as_dvec2());
        let triangles = self.projected(&camera, &screen);
        let band = Band::new(&triangles, screen, 0..pixels);
        let attributes = Attributes { mesh: self.mesh, camera };
        Array2::from_shape_fn((pixels, pixels), |(row, column)| {
            let (_, place) = band.at(column, row)?;
            attributes.fragment(&triangles[place], &screen, column, row)
        })
    }

    /// A picture of fragments: the sum over lights of what `lobe` reflects, which is asked for each fragment and light.
    pub fn shade(
        &self,
        fragments: &Array2<Option<Fragment>>,
        lobe: &(dyn Fn(&Fragment, &Light) -> Lobe + Sync),
    ) -> Image {
        let lights: Vec<_> =
            self.lights.iter().map(|light| (light, self.lighting(std::slice::from_ref(light)))).collect();
        let pixel = |fragment: &Option<Fragment>| -> Vec3 {
            let Some(f) = fragment else { return Vec3::ZERO };
            let p = &f.point;
            let part = |(light, lighting): &(&Light, Lighting)| {
                lighting.radiance(&lobe(f, light), p.position, p.normal, p.frame, p.view)
            };
            lights.iter().map(part).sum()
        };
        let (rows, columns) = fragments.dim();
        let fragments: Vec<_> = fragments.iter().collect();
        let values: Vec<f32> = fragments.into_par_iter().flat_map_iter(|f| pixel(f).to_array()).collect();
        Image::from_shape_vec((rows, columns, 3), values).expect("three values a pixel")
    }

    /// `per_side` x `per_side` samples a pixel, each shaded by itself with the normal and the lobe that it sees; one picture for
    /// each of `lobes`, from the same samples.
    pub fn truth(&self, pixels: usize, offset: Vec2, per_side: usize, lobes: &[PointLobe]) -> Truth {
        let camera = Camera::new(&self.view);
        let offset: DVec2 = offset.as_dvec2() * per_side as f64;
        let screen = Screen::new(&camera, pixels * per_side, offset);
        let triangles = self.projected(&camera, &screen);
        let attributes = Attributes { mesh: self.mesh, camera };
        let lighting = self.lighting(self.lights);
        let rows = (0..pixels).into_par_iter().map(|row| {
            let band = Band::new(&triangles, screen, row * per_side..(row + 1) * per_side);
            let cell = |column| Cell { band: &band, column: column * per_side, row: row * per_side, per_side };
            (0..pixels)
                .map(|column| {
                    let cell = cell(column);
                    let mut sums = vec![Vec3::ZERO; lobes.len()];
                    let mut hits = 0;
                    for (x, y, place) in cell.hits() {
                        let ray = screen.ray(x as f64, y as f64);
                        let Some(p) = attributes.at(&triangles[place], ray) else { continue };
                        hits += 1;
                        for (sum, lobe) in sums.iter_mut().zip(lobes) {
                            *sum += lighting.radiance(&lobe(&p), p.position, p.normal, p.frame, p.view);
                        }
                    }
                    let count = (per_side * per_side) as f32;
                    let whole = hits == per_side * per_side && cell.is_smooth(|depth| camera.pixel(pixels, depth));
                    (sums.iter().map(|sum| *sum / count).collect::<Vec<_>>(), hits as f32 / count, whole)
                })
                .collect::<Vec<_>>()
        });
        let rows: Vec<_> = rows.collect();
        let image = |k: usize| Image::from_shape_fn((pixels, pixels, 3), |(y, x, c)| rows[y][x].0[k][c]);
        Truth {
            images: (0..lobes.len()).map(image).collect(),
            coverage: Array2::from_shape_fn((pixels, pixels), |(y, x)| rows[y][x].1),
            whole: Array2::from_shape_fn((pixels, pixels), |(y, x)| rows[y][x].2),
        }
    }
}

/// The samples of one pixel.
struct Cell<'a> {
    band: &'a Band,
    column: usize,
    row: usize,
    per_side: usize,
}

impl Cell<'_> {
    fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (column, row, side) = (self.column, self.row, self.per_side);
        (row..row + side).flat_map(move |y| (column..column + side).map(move |x| (x, y)))
    }

    /// Column, row, and the place of the triangle.
    fn hits(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        self.places().filter_map(|(x, y)| self.band.at(x, y).map(|(_, place)| (x, y, place)))
    }

    /// Whether no neighbours differ in depth by more than the width of a pixel there.
    fn is_smooth(&self, width: impl Fn(f64) -> f64) -> bool {
        let depth = |x: usize, y: usize| self.band.at(x, y).map_or(f64::INFINITY, |(depth, _)| depth);
        self.places().all(|(x, y)| {
            let here = depth(x, y);
            let near = |there: f64| (here - there).abs() <= width(here);
            (x + 1 == self.column + self.per_side || near(depth(x + 1, y)))
                && (y + 1 == self.row + self.per_side || near(depth(x, y + 1)))
        })
    }
}

/// A mip chain of lobes on a mesh, one lobe a texel.
pub struct LobeMap(Texture);

impl LobeMap {
    /// Level 0 first, each level half as large as the one before; at least one level. Of several lobes in a texel the first.
    pub fn new(levels: &[Lobes]) -> Self {
        Self(Texture::new(levels))
    }

    /// Level 0, bilinear.
    pub fn base(&self, uv: Vec2) -> Lobe {
        Self::first(self.0.base(uv))
    }

    /// One trilinear probe, at the level whose texels have the area of a pixel over which texture coordinates change by `steps`.
    pub fn trilinear(&self, uv: Vec2, steps: [Vec2; 2]) -> Lobe {
        Self::first(self.0.mipped(uv, steps[0].perp_dot(steps[1]).abs().sqrt()))
    }

    /// Up to `taps` trilinear probes along the longer axis of a pixel over which texture coordinates change by `steps`.
    pub fn anisotropic(&self, uv: Vec2, steps: [Vec2; 2], taps: usize) -> Lobe {
        Self::first(self.0.anisotropic(uv, steps, taps))
    }

    fn first(mut lobes: impl Iterator<Item = (Lobe, f32)>) -> Lobe {
        lobes.next().expect("a texel has a lobe").0
    }
}
