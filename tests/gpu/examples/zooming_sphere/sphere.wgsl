// A textured sphere of metal, after the text of the shader helpers (kernels/wgsl, `footprint` and what it needs).
//
// `pane` is what a renderer draws: one look-up of the mip chain a pixel. `truth` is one of many rays a pixel, at level 0.

struct Light {
    direction: vec4f, // unit, towards the light, in the world
    irradiance: vec4f, // on a surface that faces it, linear RGB
}

struct Scene {
    place: vec4f, // scale of the part of the picture that is drawn, and its middle, in clip space
    camera: vec4f, // distance of the camera, 1 / tan of half the angle of view, turn of the sphere in radians, repeats of the texture
    decode: vec4f, // 1 if green is up (-1: down), normal scale, 1 if z is rebuilt, 1 if the map is gloss
    more: vec4f, // curvature filtering: 0, NORMALS or HALF_VECTORS; 1 with an anisotropy map
    f0: vec4f, // reflectance at normal incidence
    lights: array<Light, LIGHTS>,
}

// How the mesh's curvature is seen: by its normals, or by half vectors, one for each light.
const NORMALS: f32 = 1.0;
const HALF_VECTORS: f32 = 2.0;

@group(0) @binding(0) var<uniform> scene: Scene;
@group(1) @binding(0) var filtered: sampler;
@group(1) @binding(1) var normal_map: texture_2d<f32>;
@group(1) @binding(2) var roughness_map: texture_2d<f32>;
@group(1) @binding(3) var anisotropy_map: texture_2d<f32>;

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec3f,
    @location(3) uv: vec2f,
}

// The unit sphere from longitude and latitude, the axis upright. Mercator's map: u and v have the same scale on it, so that
// bumps are not sheared, and u closes after a whole number of repeats, so that there is no seam.
@vertex
fn place_vertex(@location(0) angles: vec2f) -> Surface {
    let turned = angles.x + scene.camera.z;
    let flat = cos(angles.y);
    var o: Surface;
    o.normal = vec3f(flat * sin(turned), sin(angles.y), flat * cos(turned));
    o.tangent = vec3f(cos(turned), 0.0, -sin(turned));
    o.position = o.normal;
    // Rows of a texture run down.
    o.uv = scene.camera.w / (2.0 * MF_PI) * vec2f(angles.x, -log(tan(0.25 * MF_PI + 0.5 * angles.y)));
    let w = scene.camera.x - o.position.z;
    let screen = scene.camera.y * o.position.xy - w * scene.place.zw;
    o.clip = vec4f(screen * scene.place.xy, 0.5 * w, w);
    return o;
}

// What the maps say of a place.
struct Texels {
    normal: vec4f,
    roughness: vec4f,
    anisotropy: vec4f,
}

fn lobe_normal(texel: vec4f) -> vec3f {
    if (scene.decode.z > 0.5) {
        return mf_decode_normal_xy(texel.xy, scene.decode.x, scene.decode.y);
    }
    return mf_decode_normal(texel.xyz, scene.decode.x, scene.decode.y);
}

fn lobe_tensor(texels: Texels) -> vec3f {
    let roughness = select(texels.roughness.r, 1.0 - texels.roughness.r, scene.decode.w > 0.5);
    if (scene.more.y > 0.5) {
        return mf_decode_anisotropy(texels.anisotropy.xyz, roughness);
    }
    return mf_decode_roughness(roughness);
}

fn decoded(texels: Texels) -> MfLobe {
    var lobe: MfLobe;
    lobe.normal = lobe_normal(texels.normal);
    lobe.tensor = lobe_tensor(texels);
    return lobe;
}

// The least cosine of the mesh's normal to the camera.
const LEAST_FACING: f32 = 0.01;

// Unit, towards the camera.
fn view_of(s: Surface) -> vec3f {
    return normalize(vec3f(0.0, 0.0, scene.camera.x) - s.position);
}

// The mesh's unit frame: tangent along +u, bitangent along +v, normal. At the rim, the middle of a pixel may lie beside its
// triangle, and the normal there would face away.
fn mesh_frame(s: Surface) -> mat3x3f {
    let view = view_of(s);
    let interpolated = normalize(s.normal);
    let n = normalize(interpolated + max(LEAST_FACING - dot(interpolated, view), 0.0) * view);
    let t = normalize(s.tangent - dot(s.tangent, n) * n);
    return mat3x3f(t, cross(n, t), n);
}

// Radiance that a lobe sends to the camera from one light. One below the mesh's horizon does not reach it.
fn lit(lobe: MfLobe, view: vec3f, light: vec3f, i: i32) -> vec3f {
    if (light.z <= 0.0) {
        return vec3f(0.0);
    }
    return scene.lights[i].irradiance.xyz * mf_footprint_shade(lobe, view, light, scene.f0.xyz, 1.0, 1.0).specular;
}

@fragment
fn pane(s: Surface) -> @location(0) vec4f {
    let frame = mesh_frame(s);
    // Into the tangent frame: dot products with tangent, bitangent and normal.
    let dndx = dpdx(frame[2]) * frame;
    let dndy = dpdy(frame[2]) * frame;
    let view = view_of(s) * frame;
    var texels: Texels;
    texels.normal = textureSample(normal_map, filtered, s.uv);
    texels.roughness = textureSample(roughness_map, filtered, s.uv);
    texels.anisotropy = textureSample(anisotropy_map, filtered, s.uv);
    let chain = decoded(texels);

    var f: MfFootprint;
    f.normal = chain.normal;
    f.tensor = chain.tensor;
    f.base = vec3f(0.0);
    f.dndx = dndx;
    f.dndy = dndy;
    f.dmdx = vec3f(0.0);
    f.dmdy = vec3f(0.0);
    f.sigma2 = MF_SIGMA2_PEAK;
    f.most = MF_MOST_ADDED;
    f.texel = 1.0;
    let by_normals = mf_footprint_normals(f);
    var sum = vec3f(0.0);
    for (var i = 0; i < LIGHTS; i++) {
        let light = scene.lights[i].direction.xyz * frame;
        // Outside of branches, for derivatives compare neighbouring pixels.
        let half_vector = mf_half_vector(light, view);
        let dhdx = dpdx(half_vector);
        let dhdy = dpdy(half_vector);
        var lobe = chain;
        if (scene.more.x == NORMALS) {
            lobe = by_normals;
        } else if (scene.more.x == HALF_VECTORS) {
            f.dndx = dhdx;
            f.dndy = dhdy;
            lobe = mf_footprint_half_vectors(f);
        }
        sum += lit(lobe, view, light, i);
    }
    // Half floats end at 65504.
    return vec4f(min(sum, vec3f(60000.0)), 1.0);
}

@fragment
fn truth(s: Surface) -> @location(0) vec4f {
    var texels: Texels;
    texels.normal = textureSampleLevel(normal_map, filtered, s.uv, 0.0);
    texels.roughness = textureSampleLevel(roughness_map, filtered, s.uv, 0.0);
    texels.anisotropy = textureSampleLevel(anisotropy_map, filtered, s.uv, 0.0);
    let lobe = decoded(texels);
    let frame = mesh_frame(s);
    let view = view_of(s) * frame;
    var sum = vec3f(0.0);
    for (var i = 0; i < LIGHTS; i++) {
        sum += lit(lobe, view, scene.lights[i].direction.xyz * frame, i);
    }
    return vec4f(sum, 1.0);
}
