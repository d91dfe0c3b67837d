// The glint ratio as the sum over the pixel's own flakes: the evaluator to use.
// Needs: glint
//
// There are no levels of detail: the flakes are fixed on the surface, one in each cell of a grid without bounds, such that every
// block of 2^k x 2^k cells has exactly one flake in each of the 4^k boxes of side 2^-k of the chart, for every k to 12. A flake's
// direction is a string of digits in base 4, coarsest first; the digit at level l is the flake's place among the four children
// of its block of level l + 1, permuted by a hash of that block and of the digits before (nets after Niederreiter 1987,
// scrambling after Owen 1995). Read backwards, the digits of a box lead from a block to its one flake, so that a pixel looks at
// a few flakes at whatever level is cheapest, and all levels agree.
//
// g = sum of W K w over flakes: W and K are biweights of integral 1 over place and direction, w weights of mean 1. Above 1.5
// effective flakes two sparser grids stand for the flakes, with deviations from 1 that are scaled down accordingly.
//
// Flakes looked at in a layer: on average 6, 11, 35 and 105 for N_eff of 0.01, 0.1, 1 and 6, the most a layer has; 12, 35, 110 and
// 310 for pixels 64 times as long as wide; at most 500. Only where less than 1e-7 of all flakes answers there are more, up to
// 3700. Each costs up to 12 short hashes, by far most of the work, and a long one; many are passed over after a few. Above 1.5
// effective flakes there are two layers.

// Digits of a direction.
const MF_GLINT_DEPTH: i32 = 12;

// Cells of the finest boxes along a side of the chart.
const MF_GLINT_SIDE: f32 = 4096.0;

// Effective flakes that are summed one by one.
const MF_GLINT_SUMMED: f32 = 1.5;

// More flakes than any pixel looks at in a layer: a bound for compilers.
const MF_GLINT_MOST: u32 = 8192u;

// The rows of boxes (sides are 1) that a kernel overlaps.
struct MfGlintRows {
    centre: vec2f,
    reach: vec2f, // half of the ellipse's width and height
    slope: f32, // of the line through the middles of rows
    across: f32, // half of the width of the row through the centre
    widest: f32, // height above the centre at which the ellipse reaches the furthest right
}

// The keys of a layer's flakes: nets of different seeds or layers have nothing to do with each other.
fn mf_glint_net(seed: u32, layer: u32) -> vec3u {
    let h: vec4u = mf_pcg4d(vec4u(seed, layer, 0x51ED2701u, 0u));
    return vec3u(h.x, h.y, h.z);
}

// 32 bits from a block, the digits so far and a key: shorter than mf_pcg4d, for many are needed.
fn mf_glint_mix(block: vec2i, prefix: u32, key: u32) -> u32 {
    var h: u32 = u32(block.x) * 0x9E3779B1u + u32(block.y) * 0x85EBCA77u + key;
    h = h ^ (h >> 15u);
    h = (h ^ (prefix * 0xC2B2AE3Du)) * 0x2C1B3C6Du;
    h = h ^ (h >> 14u);
    return h * 0x297A2D39u;
}

// The permutation of a block's children, an even one: (a shift, what is added). digits: those so far, as two numbers. The
// product x -> m x in the field of four elements, m = 1, 2 or 3, is in the byte of a table that the shift leads to.
fn mf_glint_permutation(key: u32, level: i32, block: vec2i, digits: vec2u) -> vec2u {
    let h: u32 = mf_glint_mix(block, digits.x | (digits.y << 16u), key + u32(level) * 0x632BE5ABu);
    return vec2u(((((h << 2u) >> 16u) * 3u) >> 16u) * 8u, h >> 30u);
}

// Digits of a cell's direction, `to` of at most 12, as two numbers, from the first k of them.
fn mf_glint_digits(key: u32, cell: vec2i, k: i32, to: i32, first: vec2u) -> vec2u {
    var digits: vec2u = first;
    for (var level: i32 = k; level < to; level = level + 1) { // turns: 4
        let l: u32 = u32(level);
        let parent: vec2i = vec2i(cell.x >> (l + 1u), cell.y >> (l + 1u));
        let p: vec2u = mf_glint_permutation(key, level, parent, digits);
        let child: u32 = u32((cell.x >> l) & 1) | (u32((cell.y >> l) & 1) << 1u);
        let digit: u32 = (((0x009C78E4u >> p.x) >> (2u * child)) & 3u) ^ p.y;
        digits = vec2u((digits.x << 1u) | (digit & 1u), (digits.y << 1u) | (digit >> 1u));
    }
    return digits;
}

// The cell of the flake in a box of the chart, within a block, both of level k.
fn mf_glint_cell(key: u32, k: i32, block: vec2i, box: vec2u) -> vec2i {
    var digits: vec2u = box;
    var cell: vec2i = block;
    for (var level: i32 = k - 1; level >= 0; level = level - 1) { // turns: 4
        let digit: u32 = (digits.x & 1u) | ((digits.y & 1u) << 1u);
        digits = vec2u(digits.x >> 1u, digits.y >> 1u);
        let p: vec2u = mf_glint_permutation(key, level, cell, digits);
        let child: i32 = i32(((0x00789CE4u >> p.x) >> (2u * (digit ^ p.y))) & 3u);
        cell = vec2i((cell.x << 1u) | (child & 1), (cell.y << 1u) | (child >> 1u));
    }
    return cell;
}

// The flake of a cell of a layer (0: the flakes themselves): for colours of its own, or sums over a close-up's cells.
fn mf_glint_flake(seed: u32, layer: u32, cell: vec2i) -> MfFlake {
    let net: vec3u = mf_glint_net(seed, layer);
    let h: vec4u = mf_pcg4d(vec4u(u32(cell.x), u32(cell.y), net.y, net.z));
    let digits: vec2u = mf_glint_digits(net.x, cell, 0, MF_GLINT_DEPTH, vec2u(0u, 0u));
    var o: MfFlake;
    o.place = vec2f(mf_unit(h.x), mf_unit(h.y));
    o.y = vec2f(f32(digits.x) + mf_unit(h.z), f32(digits.y) + mf_unit(h.w)) / MF_GLINT_SIDE;
    o.mark = mf_fifth(h);
    return o;
}

// Variance times N_eff of g for flakes of equal weight: evenly filled, they vary less than independent ones, the less so the
// longer the footprint. A fit of our own, within 0.025 for N_eff to 6 and anisotropies to 64.
fn mf_glint_even_variance(n_eff: f32, anisotropy: f32) -> f32 {
    return 1.0 / (1.0 + 0.79 * sqrt(n_eff * sqrt(n_eff)) / (1.0 + sqrt(anisotropy)));
}

// Exponent a of the weights (1 + a) t^a, t uniform in 0..1, with mean 1 and this variance: a^2 / (1 + 2a).
fn mf_glint_exponent(variance: f32) -> f32 {
    let v: f32 = max(variance, 0.0);
    return v + sqrt(v + v * v);
}

// The rows of boxes of this side (cells) that a kernel about `centre` (cells) overlaps.
fn mf_glint_rows(kernel: MfGlintKernel, centre: vec2f, side: f32) -> MfGlintRows {
    let reach: vec2f = vec2f(sqrt(kernel.tensor.x), sqrt(kernel.tensor.z));
    var o: MfGlintRows;
    o.centre = centre / side;
    o.reach = reach / side;
    o.slope = kernel.tensor.y / kernel.tensor.z;
    o.across = kernel.root / (reach.y * side);
    o.widest = kernel.tensor.y / (reach.x * side);
    return o;
}

// First and last box of row j. Only rounding may add a box that the kernel does not overlap, or leave one out where it weighs
// nothing.
fn mf_glint_row(rows: MfGlintRows, j: i32) -> vec2i {
    let low: f32 = max(f32(j) - rows.centre.y, -rows.reach.y);
    let high: f32 = min(f32(j) + 1.0 - rows.centre.y, rows.reach.y);
    let a: f32 = low / rows.reach.y;
    let b: f32 = high / rows.reach.y;
    let c: f32 = rows.across * sqrt(max(1.0 - a * a, 0.0));
    let d: f32 = rows.across * sqrt(max(1.0 - b * b, 0.0));
    var right: f32 = max(low * rows.slope + c, high * rows.slope + d);
    var left: f32 = min(low * rows.slope - c, high * rows.slope - d);
    if (low <= rows.widest && rows.widest <= high) {
        right = rows.reach.x;
    }
    if (low <= -rows.widest && -rows.widest <= high) {
        left = -rows.reach.x;
    }
    return vec2i(i32(floor(rows.centre.x + left)), i32(floor(rows.centre.x + right)));
}

// First and last box of side 1 / blocks of the chart that reach from y - radius to y + radius; all, once, where they meet: the
// chart closes like a torus, so that the mean is 1 at its rim too.
fn mf_glint_boxes(y: f32, radius: f32, blocks: i32) -> vec2i {
    let a: i32 = i32(floor((y - radius) * f32(blocks)));
    let b: i32 = i32(floor((y + radius) * f32(blocks)));
    if (b - a + 1 >= blocks) {
        return vec2i(0, blocks - 1);
    }
    return vec2i(a, b);
}

// A difference of places in the chart, in finest boxes, the shorter way round.
fn mf_glint_apart(d: f32) -> f32 {
    return d - MF_GLINT_SIDE * floor(d / MF_GLINT_SIDE + 0.5);
}

// The level at which blocks are as large beside the footprint as boxes are beside the lobe: the fewest flakes to look at.
fn mf_glint_level(root: f32, radius: f32) -> i32 {
    return i32(clamp(floor(0.25 * log2(root) - 0.5 * log2(radius) + 0.5), 0.0, f32(MF_GLINT_DEPTH)));
}

// The sum over the flakes of a layer, a quarter as many per area as those of the layer before, at most 16 layers; weights vary
// by this variance. g for layer 0.
fn mf_glint_layer(seen: MfGlintPixel, light: MfGlintLight, seed: u32, layer: u32, variance: f32) -> f32 {
    let thin: f32 = 1.0 / f32(1u << layer);
    let mask: i32 = i32((1u << layer) - 1u);
    let home: vec2i = vec2i(seen.cell.x >> layer, seen.cell.y >> layer);
    let own: vec2f = (vec2f(f32(seen.cell.x & mask), f32(seen.cell.y & mask)) + seen.within) * thin;
    var kernel: MfGlintKernel;
    kernel.tensor = seen.kernel.tensor * (thin * thin);
    kernel.root = seen.kernel.root * (thin * thin);
    let root: vec3f = mf_glint_inverse_root(kernel);
    let radius: f32 = sqrt(light.area / MF_BIWEIGHT_AREA);
    let k: i32 = mf_glint_level(kernel.root, radius);
    let level: u32 = u32(k);
    let blocks: i32 = i32(1u << level);
    let block: vec2i = vec2i(home.x >> level, home.y >> level);
    let centre: vec2f = vec2f(f32(home.x & (blocks - 1)), f32(home.y & (blocks - 1))) + own;
    let rows: MfGlintRows = mf_glint_rows(kernel, centre, f32(blocks));
    let last: i32 = i32(floor(rows.centre.y + rows.reach.y));
    let xs: vec2i = mf_glint_boxes(light.y.x, radius, blocks);
    let ys: vec2i = mf_glint_boxes(light.y.y, radius, blocks);
    // The direction as whole finest boxes and a rest, so that differences are small numbers.
    let whole: vec2f = vec2f(floor(light.y.x * MF_GLINT_SIDE), floor(light.y.y * MF_GLINT_SIDE));
    let rest: vec2f = light.y * MF_GLINT_SIDE - whole;
    let per_radius: f32 = 1.0 / (MF_GLINT_SIDE * radius);
    let closer: i32 = min(k + 2, MF_GLINT_DEPTH);
    let wide: f32 = f32(1u << u32(MF_GLINT_DEPTH - closer));
    // Half of such a box, and the rest.
    let reach: f32 = 0.5 * wide + 1.0;
    // A cell's middle is at most half a diagonal from its flake; a little more for rounding.
    let far: f32 = 1.001 + 0.70710678 * sqrt(mf_glint_anisotropy(kernel) / kernel.root);
    let beyond: f32 = far * far;
    let net: vec3u = mf_glint_net(seed, layer);
    let exponent: f32 = mf_glint_exponent(variance);
    var j: i32 = i32(floor(rows.centre.y - rows.reach.y));
    var row: vec2i = mf_glint_row(rows, j);
    var i: i32 = row.x;
    var a: i32 = xs.x;
    var b: i32 = ys.x;
    var sum: f32 = 0.0;
    // One loop over blocks and boxes: threads that run together wait for the most flakes, not for the longest of each row.
    for (var n: u32 = 0u; n < MF_GLINT_MOST; n = n + 1u) { // turns: 35
        if (j > last) {
            break;
        }
        // Blocks repeat after 2^32 cells.
        let at: vec2i = vec2i(((block.x + i) << level) >> level, ((block.y + j) << level) >> level);
        let box: vec2u = vec2u(u32(a & (blocks - 1)), u32(b & (blocks - 1)));
        let cell: vec2i = mf_glint_cell(net.x, k, at, box);
        let base: vec2f = vec2f(f32(cell.x - home.x), f32(cell.y - home.y)) - own;
        let m: vec2f = base + vec2f(0.5, 0.5);
        let e: vec2f = vec2f(root.x * m.x + root.y * m.y, root.y * m.x + root.z * m.y);
        // Cells that the kernel cannot reach, before anything more is hashed.
        if (dot(e, e) < beyond) {
            let h: vec4u = mf_pcg4d(vec4u(u32(cell.x), u32(cell.y), net.y, net.z));
            let d: vec2f = base + vec2f(mf_unit(h.x), mf_unit(h.y));
            let f: vec2f = vec2f(root.x * d.x + root.y * d.y, root.y * d.x + root.z * d.y);
            let t: f32 = dot(f, f);
            if (t < 1.0) {
                // Boxes of two more digits that the lobe cannot reach, before all digits are made.
                let some: vec2u = mf_glint_digits(net.x, cell, k, closer, box);
                let x: f32 = max(abs(mf_glint_apart(f32(some.x) * wide + 0.5 * wide - whole.x)) - reach, 0.0);
                let y: f32 = max(abs(mf_glint_apart(f32(some.y) * wide + 0.5 * wide - whole.y)) - reach, 0.0);
                if ((x * x + y * y) * per_radius * per_radius < 1.0) {
                    let digits: vec2u = mf_glint_digits(net.x, cell, closer, MF_GLINT_DEPTH, some);
                    let c: vec2f = vec2f(mf_glint_apart(f32(digits.x) - whole.x), mf_glint_apart(f32(digits.y) - whole.y));
                    let g: vec2f = c + (vec2f(mf_unit(h.z), mf_unit(h.w)) - rest);
                    let s: f32 = dot(g, g) * per_radius * per_radius;
                    if (s < 1.0) {
                        let both: f32 = (1.0 - t) * (1.0 - s);
                        sum = sum + both * both * pow(mf_fifth(h), exponent);
                    }
                }
            }
        }
        a = a + 1;
        if (a > xs.y) {
            a = xs.x;
            b = b + 1;
            if (b > ys.y) {
                b = ys.x;
                i = i + 1;
                if (i > row.y) {
                    j = j + 1;
                    row = mf_glint_row(rows, j);
                    i = row.x;
                }
            }
        }
    }
    // Heights of both kernels, 3 / area, and the weights' factor.
    let height: f32 = 3.0 / (MF_PI * radius);
    return sum * (1.0 + exponent) * height * height / kernel.root;
}

// The glint ratio g, 0 or more, with mean 1: see glint for how to ask. 1 where nothing can be asked.
fn mf_glint_field(seen: MfGlintPixel, light: MfGlintLight, flakes: MfFlakes) -> f32 {
    let n_eff: f32 = mf_glint_effective(seen, light);
    if (n_eff <= 0.0 || n_eff >= MF_GLINT_SMOOTH) {
        return 1.0;
    }
    let anisotropy: f32 = mf_glint_anisotropy(seen.kernel);
    let varied: f32 = clamp(flakes.variation, 0.0, MF_FLAKE_MOST_VARIATION);
    // Layers j and j + 1 have between MF_GLINT_SUMMED and four times that, and a quarter of it.
    let position: f32 = max(0.5 * log2(n_eff / MF_GLINT_SUMMED), 0.0);
    let first: f32 = floor(position);
    let s: f32 = sin(0.5 * MF_PI * (position - first));
    var c: f32 = cos(0.5 * MF_PI * (position - first));
    if (first < 0.5) {
        // The sparser layer alone could take g below 0 where both are dark: less of the other then, and more variance in each.
        c = min(c, 1.0 - 0.5 * s);
    }
    let variance: f32 = (1.0 + varied * varied) / (s * s + c * c);
    var sum: f32 = 0.0;
    var share: f32 = c;
    for (var i: u32 = 0u; i < 2u; i = i + 1u) { // turns: 2
        if (share > 0.0) {
            let layer: u32 = u32(first) + i;
            let thin: f32 = 1.0 / f32(1u << layer);
            let even: f32 = mf_glint_even_variance(n_eff * thin * thin, anisotropy);
            sum = sum + share * thin * (mf_glint_layer(seen, light, flakes.seed, layer, variance - even) - 1.0);
        }
        share = s;
    }
    return max(1.0 + min(2.0 - 2.0 * n_eff / MF_GLINT_SMOOTH, 1.0) * sum, 0.0);
}
