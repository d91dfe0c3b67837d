// The mean of each block of rays: one pixel of the picture, by one group of threads.

struct Blocks {
    rays: u32, // along a side of a block
    width: u32, // of the whole picture, pixels
    corner: vec2u, // of this part of it
}

@group(0) @binding(0) var<uniform> blocks: Blocks;
@group(0) @binding(1) var rays: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> picture: array<vec4f>;

var<workgroup> parts: array<vec4f, 64>;

@compute @workgroup_size(64)
fn mean(@builtin(workgroup_id) pixel: vec3u, @builtin(local_invocation_index) thread: u32) {
    var sum = vec4f(0.0);
    for (var i = thread; i < blocks.rays * blocks.rays; i += 64u) {
        let place = pixel.xy * blocks.rays + vec2u(i % blocks.rays, i / blocks.rays);
        sum += textureLoad(rays, place, 0);
    }
    parts[thread] = sum;
    workgroupBarrier();
    for (var other = 32u; other > 0u; other /= 2u) {
        if (thread < other) {
            parts[thread] += parts[thread + other];
        }
        workgroupBarrier();
    }
    if (thread == 0u) {
        let to = blocks.corner + pixel.xy;
        picture[to.y * blocks.width + to.x] = parts[0] / f32(blocks.rays * blocks.rays);
    }
}
