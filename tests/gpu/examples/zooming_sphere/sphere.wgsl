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
    more: vec4f, // 1 with curvature filtering, 1 with an anisotropy map
    f0: vec4f, // reflectance at normal incidence
    lights: array<Light, LIGHTS>,
}

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

// The mesh's unit frame: tangent along +u, bitangent along +v, normal.
fn mesh_frame(s: Surface) -> mat3x3f {
    let n = normalize(s.normal);
    let t = normalize(s.tangent - dot(s.tangent, n) * n);
    return mat3x3f(t, cross(n, t), n);
}

// Radiance of a lobe towards the camera, all lights together. Lights below the mesh's horizon do not reach it.
fn radiance(lobe: MfLobe, frame: mat3x3f, position: vec3f) -> vec3f {
    let view = normalize(vec3f(0.0, 0.0, scene.camera.x) - position) * frame;
    var sum = vec3f(0.0);
    for (var i = 0; i < LIGHTS; i++) {
        let light = scene.lights[i].direction.xyz * frame;
        if (light.z > 0.0) {
            let seen = mf_footprint_shade(lobe, view, light, scene.f0.xyz, 1.0, 1.0);
            sum += scene.lights[i].irradiance.xyz * seen.specular;
        }
    }
    return sum;
}

@fragment
fn pane(s: Surface) -> @location(0) vec4f {
    let frame = mesh_frame(s);
    let dndx = scene.more.x * dpdx(frame[2]);
    let dndy = scene.more.x * dpdy(frame[2]);
    var texels: Texels;
    texels.normal = textureSample(normal_map, filtered, s.uv);
    texels.roughness = textureSample(roughness_map, filtered, s.uv);
    texels.anisotropy = textureSample(anisotropy_map, filtered, s.uv);

    var f: MfFootprint;
    f.normal = lobe_normal(texels.normal);
    f.tensor = lobe_tensor(texels);
    f.base = vec3f(0.0);
    f.dndx = dndx * frame;
    f.dndy = dndy * frame;
    f.dmdx = vec3f(0.0);
    f.dmdy = vec3f(0.0);
    f.sigma2 = MF_SIGMA2_PEAK;
    f.kappa = MF_KAPPA;
    f.texel = 1.0;
    // Derivatives that are 0 give the chain's lobe back. Half floats end at 65504.
    let seen = radiance(mf_footprint_normals(f), frame, s.position);
    return vec4f(min(seen, vec3f(60000.0)), 1.0);
}

@fragment
fn truth(s: Surface) -> @location(0) vec4f {
    var texels: Texels;
    texels.normal = textureSampleLevel(normal_map, filtered, s.uv, 0.0);
    texels.roughness = textureSampleLevel(roughness_map, filtered, s.uv, 0.0);
    texels.anisotropy = textureSampleLevel(anisotropy_map, filtered, s.uv, 0.0);
    var lobe: MfLobe;
    lobe.normal = lobe_normal(texels.normal);
    lobe.tensor = lobe_tensor(texels);
    return vec4f(radiance(lobe, mesh_frame(s), s.position), 1.0);
}
