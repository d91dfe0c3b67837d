// The glint ratio from counts of flakes in a grid of cells, after Zirr & Kaplanyan 2016, "Real-time rendering of procedural
// multiscale materials", corrected: the cheaper evaluator for large N_eff, with levels of detail that glint_field has not.
// Needs: glint
//
// Two grids of cells, each twice as wide as the other, are mixed; in each cell a grid over half vectors, as wide as what answers
// and shifted at random; in each of its boxes a count. The published form loses more than half of the variance in its weights.
// Here the weights of all cells are known before anything is counted, so that fewer and brighter flakes make up for it in every
// pixel. Counts are Poisson and change smoothly with their mean.
//
// Cells counted in the finer grid, each with 5 hashes and 4 counts: on average 6, and 19, 75 and 305 for pixels 4, 16 and 64
// times as long as wide, at most 520; in the other grid about a third of that.
//
// Of 100,000 pixels 9 see a count that is one off that of exact arithmetic, the worst by 0.09 of the ratio's deviation: u within
// rounding of a step. Mean and variance know nothing of it, and it stays where it is.

// Squared radius in cells that is added to the kernel: no place is without a cell.
const MF_GLINT_REACH2: f32 = 0.6;

// The finer cells are as wide as the footprint's short radius over this, or up to twice as narrow.
const MF_GLINT_FINEST: f32 = 0.75;

// More cells than any pixel has in a grid: a bound for compilers.
const MF_GLINT_CELLS: u32 = 1024u;

// Poisson counts of one mean that change smoothly with it: those of two neighbours in a series are mixed.
struct MfSmoothPoisson {
    mean: f32,
    low: f32, // the neighbours
    high: f32,
    share: f32, // of the upper neighbour
    some: vec2f, // chances of more than none, of both
    normal: f32, // share of a normal distribution instead, 0 to 1
}

// A grid of cells as one pixel sees it.
struct MfGlintGrid {
    home: vec2i, // the pixel's cell
    own: vec2f, // place in it, 0 to 1
    kernel: MfGlintKernel, // in cells
    level: i32,
    side: f32, // 2^level, in cells of one flake each
    sum: f32, // of weights
    squares: f32,
}

// Prepares counts of a mean, above 0. Between powers of two there are four steps.
fn mf_smooth_poisson(mean: f32) -> MfSmoothPoisson {
    let m: f32 = clamp(mean, 1.0e-30, 1.0e30);
    let octave: f32 = exp2(floor(log2(m)));
    let stair: f32 = floor(4.0 * (m / octave - 1.0));
    var o: MfSmoothPoisson;
    o.mean = m;
    o.low = octave * (1.0 + stair / 4.0);
    o.high = octave * (1.0 + (stair + 1.0) / 4.0);
    o.share = (m - o.low) / (o.high - o.low);
    o.some = vec2f(mf_one_minus_exp(o.low), mf_one_minus_exp(o.high));
    o.normal = clamp((m / MF_COUNT_EXACT - 0.75) * 4.0, 0.0, 1.0);
    return o;
}

// Variance of smooth counts of this mean, above 0, over the mean: 0.94 to 1, within 0.012. Few flakes are counted by both
// neighbours or by one, so that the covariance of the two is the lower mean; many vary together.
fn mf_smooth_variance(mean: f32) -> f32 {
    let s: MfSmoothPoisson = mf_smooth_poisson(mean);
    let t: f32 = s.share;
    let together: f32 = s.low + (sqrt(s.low * s.high) - s.low) * s.mean / (s.mean + 1.0);
    let mixed: f32 = ((1.0 - t) * (1.0 - t) * s.low + t * t * s.high + 2.0 * t * (1.0 - t) * together) / s.mean;
    return mix(mixed, 1.0, s.normal);
}

// The count for a uniform u in (0, 1), whole or between two whole numbers: see mf_poisson. At most 48 steps.
fn mf_smooth_count(s: MfSmoothPoisson, u: f32) -> f32 {
    let v: f32 = 1.0 - u;
    if (s.normal <= 0.0 && v >= s.some.y) {
        return 0.0;
    }
    var k: f32 = 0.0;
    if (s.normal < 1.0) {
        // Both counts in step: the higher mean is the last to pass.
        var more: vec2f = s.some;
        var chance: vec2f = vec2f(exp(-s.low), exp(-s.high));
        for (var i: u32 = 1u; i < 49u; i = i + 1u) { // turns: 2
            if (v >= more.y) {
                break;
            }
            k = k + s.share;
            if (v < more.x) {
                k = k + (1.0 - s.share);
            }
            chance = vec2f(chance.x * s.low, chance.y * s.high) / f32(i);
            more = more - chance;
        }
    }
    if (s.normal > 0.0) {
        let z: f32 = mf_normal_quantile(u);
        k = mix(k, max(mf_skewed_normal(s.mean, sqrt(s.mean), 1.0, z), 0.0), s.normal);
    }
    return k;
}

// First and last cell of row j with their centres in the kernel. Only rounding may add one or leave one out.
fn mf_glint_centres(grid: MfGlintGrid, j: i32) -> vec2i {
    let c: vec3f = grid.kernel.tensor;
    let d: f32 = f32(j) - (grid.own.y - 0.5);
    let middle: f32 = grid.own.x - 0.5 + d * c.y / c.z;
    let across: f32 = grid.kernel.root * sqrt(max(1.0 - d * d / c.z, 0.0) / c.z);
    return vec2i(i32(ceil(middle - across)), i32(floor(middle + across)));
}

// Both boxes of a half vector along one axis: w is its place, in boxes, u the grid's random shift, 0 to 1; the first box, and the
// share of the second.
fn mf_glint_pair(w: f32, u: f32) -> MfWhole {
    var o: MfWhole;
    o.whole = i32(floor(w));
    o.rest = w - floor(w) + u;
    if (o.rest >= 1.0) {
        o.whole = o.whole + 1;
        o.rest = o.rest - 1.0;
    }
    return o;
}

// Mean of the counts in the four boxes about a half vector, in one cell (i, j counted from the pixel's).
fn mf_glint_count(grid: MfGlintGrid, i: i32, j: i32, widths: vec2f, seed: u32, counts: MfSmoothPoisson) -> f32 {
    let cell: vec4u = mf_pcg4d(vec4u(u32(grid.home.x + i), u32(grid.home.y + j), u32(grid.level), seed));
    let x: MfWhole = mf_glint_pair(widths.x, mf_unit(cell.x));
    let y: MfWhole = mf_glint_pair(widths.y, mf_unit(cell.y));
    var sum: f32 = 0.0;
    for (var n: i32 = 0; n < 4; n = n + 1) { // turns: 4
        let a: i32 = x.whole + (n & 1);
        let b: i32 = y.whole + (n >> 1u);
        // Boxes share hashes in blocks of 2 x 2.
        let words: vec4u = mf_pcg4d(vec4u(cell.z, cell.w, u32(a >> 1u), u32(b >> 1u)));
        var bits: vec2u = vec2u(words.x, words.y);
        if ((b & 1) == 1) {
            bits = vec2u(words.z, words.w);
        }
        var word: u32 = bits.x;
        if ((a & 1) == 1) {
            word = bits.y;
        }
        let wx: f32 = mix(1.0 - x.rest, x.rest, f32(n & 1));
        let wy: f32 = mix(1.0 - y.rest, y.rest, f32(n >> 1u));
        sum = sum + wx * wy * mf_smooth_count(counts, mf_unit(word));
    }
    return sum;
}

// The sum of weights and of their squares over the cells of a grid, or, if counting, of weighted counts and 0.
fn mf_glint_cells(grid: MfGlintGrid, counting: bool, widths: vec2f, seed: u32, counts: MfSmoothPoisson) -> vec2f {
    let root: vec3f = mf_glint_inverse_root(grid.kernel);
    let c: vec2f = grid.own - vec2f(0.5, 0.5);
    let height: f32 = sqrt(grid.kernel.tensor.z);
    let last: i32 = i32(floor(c.y + height));
    var j: i32 = i32(ceil(c.y - height));
    var row: vec2i = mf_glint_centres(grid, j);
    var i: i32 = row.x;
    var sums: vec2f = vec2f(0.0, 0.0);
    for (var n: u32 = 0u; n < MF_GLINT_CELLS; n = n + 1u) { // turns: 6
        if (j > last) {
            break;
        }
        // Rows at the top and bottom may have no cell.
        if (i <= row.y) {
            let d: vec2f = vec2f(f32(i), f32(j)) - c;
            let e: vec2f = vec2f(root.x * d.x + root.y * d.y, root.y * d.x + root.z * d.y);
            let rest: f32 = max(1.0 - dot(e, e), 0.0);
            let w: f32 = rest * rest;
            if (counting) {
                if (w > 0.0) {
                    sums = sums + vec2f(w * mf_glint_count(grid, i, j, widths, seed, counts), 0.0);
                }
            } else {
                sums = sums + vec2f(w, w * w);
            }
        }
        i = i + 1;
        if (i > row.y) {
            j = j + 1;
            row = mf_glint_centres(grid, j);
            i = row.x;
        }
    }
    return sums;
}

// The grid of a level, -16 to 30, in a pixel, with the sums of its weights.
fn mf_glint_grid(seen: MfGlintPixel, level: i32) -> MfGlintGrid {
    let up: u32 = u32(max(level, 0));
    let down: u32 = u32(max(-level, 0));
    let side: f32 = f32(1u << up) / f32(1u << down);
    let mask: i32 = i32((1u << up) - 1u);
    // The place in the cell, in units of the grid's cells where these are finer, in units of flakes' cells else.
    let fine: vec2f = seen.within * f32(1u << down);
    let whole: vec2f = vec2f(floor(fine.x), floor(fine.y));
    let x: i32 = (seen.cell.x << down) + i32(whole.x);
    let y: i32 = (seen.cell.y << down) + i32(whole.y);
    let c: vec3f = seen.kernel.tensor / (side * side);
    let root: f32 = seen.kernel.root / (side * side);
    var kernel: MfGlintKernel;
    kernel.tensor = vec3f(c.x + MF_GLINT_REACH2, c.y, c.z + MF_GLINT_REACH2);
    kernel.root = sqrt(root * root + MF_GLINT_REACH2 * (c.x + c.z + MF_GLINT_REACH2));
    var o: MfGlintGrid;
    o.home = vec2i(x >> up, y >> up);
    o.own = (vec2f(f32(x & mask), f32(y & mask)) + (fine - whole)) / f32(1u << up);
    o.kernel = kernel;
    o.level = level;
    o.side = side;
    o.sum = 0.0;
    o.squares = 0.0;
    let sums: vec2f = mf_glint_cells(o, false, vec2f(0.0, 0.0), 0u, mf_smooth_poisson(1.0));
    o.sum = sums.x;
    o.squares = sums.y;
    return o;
}

// Variance of a grid's weighted counts for one expected flake per unit area and box. 4/9 is the mean sum of squared weights of
// the four boxes about a half vector.
fn mf_glint_grid_variance(grid: MfGlintGrid) -> f32 {
    return 0.44444444 * grid.squares / (grid.sum * grid.sum * grid.side * grid.side);
}

// Mean of a grid's counts over their mean; density: flakes per unit area and box.
fn mf_glint_grid_ratio(grid: MfGlintGrid, widths: vec2f, seed: u32, density: f32) -> f32 {
    let counts: MfSmoothPoisson = mf_smooth_poisson(density * grid.side * grid.side);
    return mf_glint_cells(grid, true, widths, seed, counts).x / (grid.sum * counts.mean);
}

// The glint ratio g, 0 or more, with mean 1: see glint for how to ask. 1 where nothing can be asked.
fn mf_glint_binomial(seen: MfGlintPixel, light: MfGlintLight, flakes: MfFlakes) -> f32 {
    let n_eff: f32 = mf_glint_effective(seen, light);
    if (n_eff <= 0.0 || n_eff >= MF_GLINT_SMOOTH) {
        return 1.0;
    }
    let varied: f32 = clamp(flakes.variation, 0.0, MF_FLAKE_MOST_VARIATION);
    // Half the logarithm of the short radius squared, which is the root over the anisotropy.
    let finest2: f32 = MF_GLINT_FINEST * MF_GLINT_FINEST;
    let position: f32 = 0.5 * log2(seen.kernel.root / (mf_glint_anisotropy(seen.kernel) * finest2));
    let level: i32 = i32(floor(position));
    let share: f32 = position - floor(position);
    let fine: MfGlintGrid = mf_glint_grid(seen, level);
    let coarse: MfGlintGrid = mf_glint_grid(seen, level + 1);
    // Flakes per area and chart that leave the variance of independent flakes, (1 + variation^2) / N_eff.
    let a: f32 = (1.0 - share) * (1.0 - share) * mf_glint_grid_variance(fine);
    let b: f32 = share * share * mf_glint_grid_variance(coarse);
    let per_flake: f32 = n_eff / (1.0 + varied * varied);
    let area: f32 = fine.side * fine.side;
    // Smooth counts keep a share of the variance that depends on their mean; two rounds find it to a thousandth.
    var density: f32 = per_flake * (a + b);
    for (var i: u32 = 0u; i < 2u; i = i + 1u) { // turns: 2
        let more: f32 = b * mf_smooth_variance(4.0 * density * area);
        density = per_flake * (a * mf_smooth_variance(density * area) + more);
    }
    var g: f32 = 0.0;
    var grid: MfGlintGrid = fine;
    var weight: f32 = 1.0 - share;
    for (var n: u32 = 0u; n < 2u; n = n + 1u) { // turns: 2
        g = g + weight * mf_glint_grid_ratio(grid, light.widths, flakes.seed, density);
        grid = coarse;
        weight = share;
    }
    return 1.0 + min(2.0 - 2.0 * n_eff / MF_GLINT_SMOOTH, 1.0) * (g - 1.0);
}
