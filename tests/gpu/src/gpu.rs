//! One Vulkan device, and shaders that turn one buffer of words into another.

use std::fs;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use wgpu::util::DeviceExt;

use crate::translate::Language;

/// Says why the tests cannot run here; with `MIPFOLD_NO_SKIP` set, that is a failure.
pub fn skipped(why: &str) {
    assert!(std::env::var_os("MIPFOLD_NO_SKIP").is_none(), "MIPFOLD_NO_SKIP is set, but: {why}");
    say(&format!("SKIPPED: {why}\n"));
}

/// Prints, even where the test runner keeps output back.
pub fn say(text: &str) {
    use std::io::Write;
    std::io::stderr().write_all(text.as_bytes()).expect("standard error");
}

/// Device and queue, with the name of the adapter.
pub struct Gpu {
    /// As the driver calls it.
    pub name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// One run at a time: scopes of errors nest.
    running: Mutex<()>,
}

/// What a shader is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// One thread a call.
    Compute,
    /// Four pixels a call.
    Fragment,
}

/// Calls of a group of threads, and in a row of the picture that fragment shaders draw.
pub const CALLS_AT_ONCE: usize = 64;

/// The device that all tests share; none where there is no Vulkan adapter.
pub fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    GPU.get_or_init(Gpu::new).as_ref()
}

impl Gpu {
    fn new() -> Option<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::VULKAN,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        }))
        .ok()?;
        let info = adapter.get_info();
        let wanted = wgpu::DeviceDescriptor {
            // For 16-bit maps, where there is such a thing.
            required_features: adapter.features() & wgpu::Features::TEXTURE_FORMAT_16BIT_NORM,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&wanted)).expect("a device of the adapter");
        Some(Self { name: format!("{} ({})", info.name, info.driver_info), device, queue, running: Mutex::new(()) })
    }

    /// For shaders of other kinds.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// Hold it while a scope of errors is open: one run at a time.
    pub fn alone(&self) -> MutexGuard<'_, ()> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Of [`device`](Self::device).
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Runs one function of a program once for each of `calls`, whole groups of them. It reads the words at binding 0 and
    /// writes `words_out` words at binding 1. Errors are the compiler's.
    pub fn run(
        &self,
        program: &Program,
        which: u32,
        calls: usize,
        words: &[u32],
        words_out: usize,
    ) -> Result<Vec<u32>, String> {
        use wgpu::{BufferUsages, ShaderStages};
        let _one = self.alone();
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let source = match &program.code {
            Code::Wgsl(text) => wgpu::ShaderSource::Wgsl(text.replace("WHICH", &which.to_string()).into()),
            Code::SpirV(words) => wgpu::ShaderSource::SpirV(specialised(words, which).into()),
        };
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let buffer = |contents: &[u32]| {
            let bytes: Vec<u8> = contents.iter().flat_map(|w| w.to_le_bytes()).collect();
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
            self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents: &bytes, usage })
        };
        let size = 4 * words_out as u64;
        let (given, results) = (buffer(words), buffer(&vec![NOT_WRITTEN; words_out]));
        let read = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let visibility = if program.stage == Stage::Compute { ShaderStages::COMPUTE } else { ShaderStages::FRAGMENT };
        let ty = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: false },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let entry = |binding| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let layout = self
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &[entry(0), entry(1)] });
        let entries = [(0, &given), (1, &results)]
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() });
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &entries,
        });
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        match program.stage {
            Stage::Compute => self.compute(&mut encoder, &module, &layout, &group, calls),
            Stage::Fragment => self.draw(&mut encoder, &module, &layout, &group, calls),
        }
        encoder.copy_buffer_to_buffer(&results, 0, &read, 0, size);
        self.queue.submit([encoder.finish()]);
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(error.to_string());
        }
        read.map_async(wgpu::MapMode::Read, .., |done| done.expect("mapping a buffer"));
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| e.to_string())?;
        let bytes = read.get_mapped_range(..).map_err(|e| e.to_string())?;
        Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }

    fn compute(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        module: &wgpu::ShaderModule,
        layout: &wgpu::PipelineLayout,
        group: &wgpu::BindGroup,
        calls: usize,
    ) {
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(layout),
            module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(calls.div_ceil(CALLS_AT_ONCE) as u32, 1, 1);
    }

    /// One triangle over the quarter of a picture that has a 2x2 quad of pixels for each call. It lies within the picture,
    /// for clipped ones are drawn in parts, and in quads along their seam Mesa reads zeros for the pixels of the other part.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        module: &wgpu::ShaderModule,
        layout: &wgpu::PipelineLayout,
        group: &wgpu::BindGroup,
        calls: usize,
    ) {
        let vertex = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(TRIANGLE.into()),
        });
        let (width, height) = (2 * CALLS_AT_ONCE as u32, 2 * calls.div_ceil(CALLS_AT_ONCE) as u32);
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let picture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 2 * width, height: 2 * height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let pipeline = self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module: &vertex,
                entry_point: Some("main"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("main"),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let view = picture.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.set_scissor_rect(0, 0, width, height);
        pass.draw(0..3, 0..1);
    }
}

/// A NaN, so that a result that no shader wrote is seen.
const NOT_WRITTEN: u32 = 0xFFFF_FFFF;

const TRIANGLE: &str = "
@vertex
fn main(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 2.0 - 1.0, 1.0 - f32(i >> 1u) * 2.0, 0.5, 1.0);
}
";

/// Functions that are ready to run, one at a time.
pub struct Program {
    stage: Stage,
    code: Code,
}

enum Code {
    /// Text with `WHICH` in it.
    Wgsl(String),
    /// With one specialisation constant.
    SpirV(Vec<u32>),
}

impl Program {
    /// From text with an entry point `main`, which does what a constant says: `WHICH` in WGSL, a specialisation constant in
    /// the others. Errors are the compiler's.
    pub fn new(language: Language, stage: Stage, text: &str) -> Result<Self, String> {
        if language == Language::Wgsl {
            return Ok(Self { stage, code: Code::Wgsl(text.to_string()) });
        }
        let bytes = glslang(language, stage, text)?;
        let words = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        Ok(Self { stage, code: Code::SpirV(words) })
    }
}

/// SPIR-V with its specialisation constant made a plain one: the compiler is slow to start, so it runs once for all
/// functions.
fn specialised(words: &[u32], value: u32) -> Vec<u32> {
    const HEADER: usize = 5;
    const SPEC_CONSTANT: u32 = 50;
    const CONSTANT: u32 = 43;
    const DECORATE: u32 = 71;
    const SPEC_ID: u32 = 1;
    let mut out = words[..HEADER].to_vec();
    let mut rest = &words[HEADER..];
    while let Some(&first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        match first & 0xFFFF {
            SPEC_CONSTANT => out.extend([first - SPEC_CONSTANT + CONSTANT, instruction[1], instruction[2], value]),
            DECORATE if instruction[2] == SPEC_ID => {}
            _ => out.extend(instruction),
        }
        rest = after;
    }
    out
}

/// Whether there is a `glslangValidator`.
pub fn has_glslang() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| Command::new("glslangValidator").arg("--version").output().is_ok_and(|o| o.status.success()))
}

/// SPIR-V of a GLSL or HLSL text.
fn glslang(language: Language, stage: Stage, text: &str) -> Result<Vec<u8>, String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let binary = folder.path().join("shader.spv");
    let out = binary.to_str().expect("a path of text");
    let more: &[&str] =
        if language == Language::Hlsl { &["-V", "-D", "-e", "main", "-o", out] } else { &["-V", "-o", out] };
    glslang_with(stage, text, more)?;
    fs::read(&binary).map_err(|e| e.to_string())
}

/// Lets `glslangValidator` read a text; its complaints are the error.
pub fn glslang_with(stage: Stage, text: &str, arguments: &[&str]) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let path = folder.path().join("shader.txt");
    fs::write(&path, text).map_err(|e| e.to_string())?;
    let stage = if stage == Stage::Compute { "comp" } else { "frag" };
    let done = Command::new("glslangValidator").args(["-S", stage]).args(arguments).arg(&path).output();
    let done = done.map_err(|e| format!("glslangValidator: {e}"))?;
    if done.status.success() {
        return Ok(());
    }
    let complaints = String::from_utf8_lossy(&done.stdout);
    // With the line of the text that each is about.
    let line_of = |complaint: &str| complaint.split(':').nth(2).and_then(|n| n.trim().parse::<usize>().ok());
    let about = |c: &str| line_of(c).and_then(|n| text.lines().nth(n.saturating_sub(1))).unwrap_or("").to_string();
    Err(complaints.lines().filter(|c| c.starts_with("ERROR")).map(|c| format!("{c}\n    {}\n", about(c))).collect())
}
