//! Draws the sphere with wgpu: once a pixel, as a renderer does, or many times, for the truth.

use std::error::Error;

use mipfold_gpu_tests::gpu::Gpu;
use mipfold_gpu_tests::source::bundle;
use mipfold_gpu_tests::translate::Language;
use wgpu::util::DeviceExt;

use crate::maps::{Map, Material};
use crate::scene::{Pose, Scene};

/// Rays are drawn so many across at a time.
const PART: u32 = 1024;
/// Edges are smoothed by so many samples; shading runs once a pixel.
const EDGE_SAMPLES: u32 = 4;
const PANE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const TRUTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// How the curvature of the mesh is added to the roughness: `footprint` of the shader helpers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// Not at all.
    None,
    /// Once, by how the normals turn across the pixel: `mf_footprint_normals`.
    Normals,
    /// For each light, by how the half vectors turn: `mf_footprint_half_vectors`.
    HalfVectors,
}

/// How textures are looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lookup {
    /// Most probes along a slanted pixel, 1 to 16; 1 is trilinear.
    pub anisotropic: u16,
    /// The truth sees single texels, and not what is interpolated between them.
    pub nearest: bool,
}

/// How a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// With the mip chain, as the GPU filters it.
    Mips(Curvature),
    /// At level 0, so many rays along a side of a pixel.
    Rays(u32),
}

/// A square picture: radiance in linear RGB, and the share of the pixel that the sphere covers; rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels along a side.
    pub side: usize,
    /// Radiance times share, and share.
    pub pixels: Vec<[f32; 4]>,
}

/// Everything that all pictures share.
pub struct Renderer<'a> {
    gpu: &'a Gpu,
    scene: Scene,
    vertices: wgpu::Buffer,
    triangles: wgpu::Buffer,
    triangle_corners: u32,
    pane: wgpu::RenderPipeline,
    truth: wgpu::RenderPipeline,
    mean: wgpu::ComputePipeline,
}

/// A material on the GPU.
pub struct Textures {
    group: wgpu::BindGroup,
    decode: [f32; 4],
    has_anisotropy: bool,
}

impl<'a> Renderer<'a> {
    /// Errors are the shader compiler's.
    pub fn new(gpu: &'a Gpu, scene: Scene) -> Result<Self, Box<dyn Error>> {
        let device = gpu.device();
        let _one = gpu.alone();
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let helpers = bundle("footprint", Language::Wgsl)?.text;
        let lights = scene.lights.len();
        let text = format!("{helpers}\nconst LIGHTS: i32 = {lights};\n{}", include_str!("sphere.wgsl"));
        let module = |text: &str| {
            let source = wgpu::ShaderSource::Wgsl(text.into());
            device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source })
        };
        let (sphere, mean) = (module(&text), module(include_str!("mean.wgsl")));
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&scene_layout(device)), Some(&material_layout(device))],
            immediate_size: 0,
        });
        let pipeline = |entry, format, samples| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: None,
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &sphere,
                    entry_point: Some("place_vertex"),
                    compilation_options: Default::default(),
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: 8,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &wgpu::vertex_attr_array![0 => Float32x2],
                    })],
                },
                // A sphere hides nothing but its own back.
                primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..Default::default() },
                depth_stencil: None,
                multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
                fragment: Some(wgpu::FragmentState {
                    module: &sphere,
                    entry_point: Some(entry),
                    compilation_options: Default::default(),
                    targets: &[Some(wgpu::ColorTargetState::from(format))],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let pane = pipeline("pane", PANE_FORMAT, EDGE_SAMPLES);
        let truth = pipeline("truth", TRUTH_FORMAT, 1);
        let mean = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &mean,
            entry_point: Some("mean"),
            compilation_options: Default::default(),
            cache: None,
        });
        let corners = Scene::triangles();
        let words = Scene::vertices().iter().flatten().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let vertices = filled(device, &words, wgpu::BufferUsages::VERTEX);
        let words = corners.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let triangles = filled(device, &words, wgpu::BufferUsages::INDEX);
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(error.to_string().into());
        }
        let triangle_corners = corners.len() as u32;
        Ok(Self { gpu, scene, vertices, triangles, triangle_corners, pane, truth, mean })
    }

    /// Copies maps to the GPU.
    pub fn upload(&self, material: &Material, lookup: Lookup) -> Result<Textures, Box<dyn Error>> {
        let device = self.gpu.device();
        let address = if material.mirrored { wgpu::AddressMode::MirrorRepeat } else { wgpu::AddressMode::Repeat };
        let linear = wgpu::FilterMode::Linear;
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            address_mode_u: address,
            address_mode_v: address,
            // Level 0, as the truth asks for it, is never minified.
            mag_filter: if lookup.nearest { wgpu::FilterMode::Nearest } else { linear },
            min_filter: linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            anisotropy_clamp: lookup.anisotropic,
            ..Default::default()
        });
        let normal = self.texture(&material.normal)?;
        let roughness = self.texture(&material.roughness)?;
        // The shader does not look at it where there is none.
        let anisotropy = material.anisotropy.as_ref().map_or_else(|| Ok(normal.clone()), |map| self.texture(map))?;
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &material_layout(device),
            entries: &[
                entry(0, wgpu::BindingResource::Sampler(&sampler)),
                entry(1, wgpu::BindingResource::TextureView(&normal)),
                entry(2, wgpu::BindingResource::TextureView(&roughness)),
                entry(3, wgpu::BindingResource::TextureView(&anisotropy)),
            ],
        });
        let flag = |on: bool| f32::from(u8::from(on));
        let y_sign = if material.y_up { 1.0 } else { -1.0 };
        let decode = [y_sign, material.normal_scale, flag(material.two_channels), flag(material.gloss)];
        Ok(Textures { group, decode, has_anisotropy: material.anisotropy.is_some() })
    }

    fn texture(&self, map: &Map) -> Result<wgpu::TextureView, Box<dyn Error>> {
        use wgpu::TextureFormat::{R8Unorm, R16Unorm, Rgba8Unorm, Rgba16Unorm};
        let device = self.gpu.device();
        if map.bits != 8 && !device.features().contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM) {
            return Err("the maps have 16 bits, and this device has no such textures".into());
        }
        let format = match (map.channels, map.bits) {
            (1, 8) => R8Unorm,
            (1, _) => R16Unorm,
            (_, 8) => Rgba8Unorm,
            _ => Rgba16Unorm,
        };
        let (width, height) = (map.levels[0].width as u32, map.levels[0].height as u32);
        let most = device.limits().max_texture_dimension_2d;
        if width.max(height) > most {
            return Err(format!("the maps are {width} x {height}, this device takes up to {most} x {most}").into());
        }
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: map.levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (k, level) in map.levels.iter().enumerate() {
            let to = wgpu::TexelCopyTextureInfo { mip_level: k as u32, ..texture.as_image_copy() };
            let row = level.width as u32 * map.channels as u32 * map.bits / 8;
            let rows = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
            let size =
                wgpu::Extent3d { width: level.width as u32, height: level.height as u32, depth_or_array_layers: 1 };
            self.gpu.queue().write_texture(to, &map.bytes(k), rows, size);
        }
        Ok(texture.create_view(&Default::default()))
    }

    /// A picture of `side` pixels along a side.
    pub fn draw(&self, textures: &Textures, pose: Pose, side: u32, way: Way) -> Result<Picture, Box<dyn Error>> {
        let device = self.gpu.device();
        let _one = self.gpu.alone();
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let (rays, format, samples) = match way {
            Way::Mips(_) => (1, PANE_FORMAT, EDGE_SAMPLES),
            Way::Rays(rays) => (rays, TRUTH_FORMAT, 1),
        };
        let size = 16 * u64::from(side) * u64::from(side);
        let buffer = |usage| {
            let mapped_at_creation = false;
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation })
        };
        let picture = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let read = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
        // Whole pixels at a time.
        let part = (PART / rays).clamp(1, side);
        let target = |samples| target(device, part * rays, format, samples);
        let drawn = target(1);
        let smoothed = (samples > 1).then(|| target(samples));
        let mut encoder = device.create_command_encoder(&Default::default());
        for (x, y) in (0..side.div_ceil(part)).flat_map(|y| (0..side.div_ceil(part)).map(move |x| (x * part, y * part)))
        {
            let (scene, blocks) = self.uniforms(textures, pose, side, way, [x, y, part, rays]);
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &scene_layout(device),
                entries: &[entry(0, scene.as_entire_binding())],
            });
            let (view, resolve_target) = smoothed.as_ref().map_or((&drawn, None), |s| (s, Some(&drawn)));
            let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target,
                    ops: wgpu::Operations { load: clear, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            pass.set_pipeline(if samples > 1 { &self.pane } else { &self.truth });
            pass.set_bind_group(0, &group, &[]);
            pass.set_bind_group(1, &textures.group, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_index_buffer(self.triangles.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.triangle_corners, 0, 0..1);
            drop(pass);
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &self.mean.get_bind_group_layout(0),
                entries: &[
                    entry(0, blocks.as_entire_binding()),
                    entry(1, wgpu::BindingResource::TextureView(&drawn)),
                    entry(2, picture.as_entire_binding()),
                ],
            });
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.mean);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(part.min(side - x), part.min(side - y), 1);
        }
        encoder.copy_buffer_to_buffer(&picture, 0, &read, 0, size);
        self.gpu.queue().submit([encoder.finish()]);
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(error.to_string().into());
        }
        read.map_async(wgpu::MapMode::Read, .., |done| done.expect("mapping a buffer"));
        device.poll(wgpu::PollType::wait_indefinitely())?;
        let bytes = read.get_mapped_range(..)?;
        let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        let pixel = |b: &[u8]| [number(&b[0..4]), number(&b[4..8]), number(&b[8..12]), number(&b[12..16])];
        Ok(Picture { side: side as usize, pixels: bytes.chunks_exact(16).map(pixel).collect() })
    }

    /// Of a part of the picture: what both shaders read. The part is its left and upper side, its width and its rays a
    /// pixel's side.
    fn uniforms(
        &self,
        textures: &Textures,
        pose: Pose,
        side: u32,
        way: Way,
        [x, y, part, rays]: [u32; 4],
    ) -> (wgpu::Buffer, wgpu::Buffer) {
        let flag = |on: bool| f32::from(u8::from(on));
        let scale = side as f32 / part as f32;
        let middle = |from: u32| (2 * from + part) as f32 / side as f32 - 1.0;
        let curvature = match way {
            Way::Mips(Curvature::None) | Way::Rays(_) => 0.0,
            Way::Mips(Curvature::Normals) => 1.0,
            Way::Mips(Curvature::HalfVectors) => 2.0,
        };
        let more = [curvature, flag(textures.has_anisotropy), 0.0, 0.0];
        let words = self.scene.uniform(pose, [scale, scale, middle(x), -middle(y)], textures.decode, more);
        let bytes: Vec<u8> = words.iter().flat_map(|v| v.to_le_bytes()).collect();
        let scene = filled(self.gpu.device(), &bytes, wgpu::BufferUsages::UNIFORM);
        let bytes: Vec<u8> = [rays, side, x, y].iter().flat_map(|v| v.to_le_bytes()).collect();
        (scene, filled(self.gpu.device(), &bytes, wgpu::BufferUsages::UNIFORM))
    }
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

fn filled(device: &wgpu::Device, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

fn target(device: &wgpu::Device, side: u32, format: wgpu::TextureFormat, samples: u32) -> wgpu::TextureView {
    let read = if samples == 1 { wgpu::TextureUsages::TEXTURE_BINDING } else { wgpu::TextureUsages::empty() };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | read,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

fn layout(device: &wgpu::Device, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
    let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
    let entry = |(i, &ty): (usize, _)| wgpu::BindGroupLayoutEntry { binding: i as u32, visibility, ty, count: None };
    let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

fn scene_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let ty = wgpu::BufferBindingType::Uniform;
    layout(device, &[wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }])
}

fn material_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let map = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    layout(device, &[wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering), map, map, map])
}
