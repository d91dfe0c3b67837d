//! What is drawn: shapes with exact normals, and real meshes.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use mipfold::curvature::{BakeOptions, Curvature, LoadOptions, Mesh, bake, load, vertex_curvature};
use mipfold::image::Size;
use mipfold::ndf::{Form, Lobe, Lobes};
use mipfold::render::{Light, LobeMap, MeshScene, MeshView};

/// Something to draw.
pub struct Object {
    pub name: &'static str,
    pub mesh: Mesh,
    pub view: MeshView,
    /// Sides of the picture.
    pub pixels: usize,
    pub lights: Vec<Light>,
    /// One a vertex.
    pub curvature: Vec<Curvature>,
    /// Baked tensors as mip chains, one for each material: textures of two lie on each other.
    baked: Arc<Vec<Option<LobeMap>>>,
}

/// Silver.
pub const F0: Vec3 = Vec3::new(0.91, 0.92, 0.92);

/// Directions towards the lights in the camera's axes (right, up, back), and irradiance: a key light, one opposite, two from
/// the side and from below, and one from behind, which is seen at grazing angles alone.
const LIGHTS: [([f32; 3], f32); 5] = [
    ([-0.5, 0.6, 0.62], 1.0),
    ([0.7, 0.35, 0.6], 0.7),
    ([0.1, -0.6, 0.8], 0.5),
    ([-0.85, -0.1, 0.5], 0.4),
    ([0.35, 0.9, -0.3], 0.3),
];

impl Object {
    /// Seen from a direction (in the mesh's space, as `up` is), so that it fills the picture; baked into a map of a size.
    fn new(name: &'static str, mesh: Mesh, map: Size, from: Vec3, up: Vec3, pixels: usize) -> Self {
        let low = mesh.positions.iter().fold(Vec3::MAX, |a, b| a.min(*b));
        let high = mesh.positions.iter().fold(Vec3::MIN, |a, b| a.max(*b));
        let target = 0.5 * (low + high);
        let radius = mesh.positions.iter().map(|p| p.distance(target)).fold(0.0, f32::max);
        let (distance, back) = (6.0 * radius, from.normalize());
        // The bounding sphere's rim is at tan(asin(1 / 6)).
        let view = MeshView { eye: target + distance * back, target, up, half_view: 1.02 / 35f32.sqrt() };
        let right = up.cross(back).normalize();
        let towards = |[x, y, z]: [f32; 3]| (x * right + y * back.cross(right) + z * back).normalize();
        let light = |(direction, irradiance)| Light::Directional {
            direction: towards(direction),
            irradiance: Vec3::splat(irradiance),
        };
        let curvature = vertex_curvature(&mesh);
        let maps =
            (0..mesh.parts.len()).map(|part| mesh.parts[part].has_uvs.then(|| baked(&mesh.select(&[part]), map)));
        let baked = Arc::new(maps.collect());
        Self { name, mesh, view, pixels, lights: LIGHTS.map(light).to_vec(), curvature, baked }
    }

    /// The same under other lights.
    pub fn under(&self, lights: Vec<Light>) -> Self {
        Self { lights, mesh: self.mesh.clone(), curvature: self.curvature.clone(), baked: self.baked.clone(), ..*self }
    }

    /// Whether every part has a baked map.
    pub fn is_baked(&self) -> bool {
        self.baked.iter().all(Option::is_some)
    }

    /// The baked map of a triangle.
    pub fn baked(&self, triangle: usize) -> &LobeMap {
        let part = self.mesh.parts.iter().position(|part| part.triangles.contains(&triangle)).unwrap();
        self.baked[part].as_ref().expect("baked")
    }

    pub fn scene(&self) -> MeshScene<'_> {
        MeshScene { mesh: &self.mesh, view: self.view, lights: &self.lights, f0: F0 }
    }
}

/// The chain of what curvature adds.
fn baked(mesh: &Mesh, size: Size) -> LobeMap {
    let baked = bake(mesh, size, &BakeOptions::default(), &|_| ()).unwrap();
    let levels: Vec<Lobes> = baked
        .levels
        .iter()
        .map(|level| {
            Lobes::from_fn(Form::Anisotropic, level.size(), |x, y| Lobe {
                normal: Vec3::Z,
                roughness: level.added[(y, x)],
            })
        })
        .collect();
    LobeMap::new(&levels)
}

/// Position and unit normal over the unit square.
type Shape = fn(DVec2) -> (DVec3, DVec3);

fn sphere(uv: DVec2) -> (DVec3, DVec3) {
    let ((sin, cos), (y, r)) = ((TAU * uv.x).sin_cos(), (0.5 * TAU * (uv.y - 0.5)).sin_cos());
    let n = DVec3::new(r * sin, y, r * cos);
    (n, n)
}

fn cylinder(uv: DVec2) -> (DVec3, DVec3) {
    let (sin, cos) = (TAU * uv.x).sin_cos();
    (DVec3::new(0.25 * sin, 2.0 * uv.y - 1.0, 0.25 * cos), DVec3::new(sin, 0.0, cos))
}

fn torus(uv: DVec2) -> (DVec3, DVec3) {
    let ((sin, cos), (y, r)) = ((TAU * uv.x).sin_cos(), (TAU * uv.y).sin_cos());
    let n = DVec3::new(r * sin, y, r * cos);
    (DVec3::new(sin, 0.0, cos) + 0.35 * n, n)
}

/// A grid of quads over a shape, each as two triangles.
fn grid(shape: Shape, [wide, high]: [usize; 2]) -> Mesh {
    let place = |i: usize| {
        let (x, y) = (i % (wide + 1), i / (wide + 1));
        DVec2::new(x as f64 / wide as f64, y as f64 / high as f64)
    };
    let count = (wide + 1) * (high + 1);
    let points: Vec<_> = (0..count).map(|i| shape(place(i))).collect();
    let corner = |x: usize, y: usize| (y * (wide + 1) + x) as u32;
    let quad = |i: usize| {
        let (x, y) = (i % wide, i / wide);
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        [[a, b, c], [a, c, d]]
    };
    Mesh::new(
        points.iter().map(|p| p.0.as_vec3()).collect(),
        Some(points.iter().map(|p| p.1.as_vec3()).collect()),
        Some((0..count).map(|i| place(i).as_vec2()).collect()),
        (0..wide * high).flat_map(quad).collect(),
        60.0,
    )
    .unwrap()
}

/// Shapes whose facets are much smaller than a pixel, with exact normals. Texels of their maps are about square.
pub fn solids() -> Vec<Object> {
    let aslant = Vec3::new(0.35, 1.0, 0.2).normalize();
    let (sphere, cylinder, torus) = (grid(sphere, [384, 192]), grid(cylinder, [256, 64]), grid(torus, [384, 128]));
    vec![
        Object::new("sphere", sphere, Size::new(256, 128), Vec3::new(0.2, 0.3, 1.0), Vec3::Y, 24),
        Object::new("cylinder", cylinder, Size::new(256, 256), Vec3::new(-0.4, 0.05, 1.0), aslant, 48),
        Object::new("torus", torus, Size::new(512, 128), Vec3::new(0.3, 0.9, 1.0), aslant, 40),
    ]
}

/// Real meshes, if they are there; those of `names`, or all.
pub fn meshes(names: &[&str]) -> Vec<Object> {
    let Some(folder) = crate::common::meshes() else { return Vec::new() };
    let files = [
        ("shader ball", "shader_ball/shader_ball.gltf", Vec3::new(0.3, 0.3, 1.0), Vec3::Y, 64),
        ("USD shader ball", "usd_shader_ball/shaderball.glb", Vec3::new(0.3, 0.3, 1.0), Vec3::Y, 64),
        ("spot", "spot/spot.obj", Vec3::new(0.6, 0.3, -1.0), Vec3::Y, 40),
        ("cycloidal", "cycloidal/cycloidal.ply", Vec3::new(0.4, 0.3, 1.0), Vec3::Y, 64),
    ];
    files
        .into_iter()
        .filter(|file| names.is_empty() || names.contains(&file.0))
        .map(|(name, file, from, up, pixels)| {
            let mesh = load(&folder.join(file), &LoadOptions::default()).unwrap();
            Object::new(name, mesh, Size::new(512, 512), from, up, pixels)
        })
        .collect()
}
