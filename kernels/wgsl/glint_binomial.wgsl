// The glint ratio from counts of flakes in a grid of cells, after Zirr & Kaplanyan 2016, "Real-time rendering of procedural
// multiscale materials", corrected: the cheaper evaluator for large N_eff, with levels of detail that glint_field has not.
// Needs: glint
//
// Two grids of cells, each twice as wide as the other, are mixed; in each cell a grid over half vectors, as wide as what answers
// and shifted at random; in each of its boxes a count. The published form loses more than half of the variance in its weights.
// Here the weights of all cells are known before anything is counted, so that fewer and brighter flakes make up for it in every
// pixel. Counts are Poisson and change smoothly with their mean and with u, so that rounding moves none.
//
// Cells counted in the finer grid, each with a long and 4 short hashes and 4 counts: on average 5, and 15, 57 and 230 for pixels
// 4, 16 and 64 times as long as wide, at most 410; in the other grid about half of that.

// Squared radius in cells that is added to the kernel: no place is without a cell.
const MF_GLINT_REACH2: f32 = 0.58;

// Squared ratio of the kernel over cells to the pixel's, which is less flat and as wide.
const MF_GLINT_NARROW2: f32 = 0.8333333;

// The finer cells are as wide as the footprint's short radius over this, or up to twice as narrow.
const MF_GLINT_FINEST: f32 = 0.7;

// More cells than any pixel has in a grid: a bound for compilers.
const MF_GLINT_CELLS: u32 = 1024u;

// Variance of smooth counts over their mean: 2 / ln 2 - 2.
const MF_SMOOTH_VARIANCE: f32 = 0.8853901;

// Poisson counts of one mean that change smoothly with it: a sum of ramps for few, the square of a normal number for many.
struct MfSmoothPoisson {
    mean: f32,
    none: f32, // chance of none, and of some
    some: f32,
    normal: vec2f, // mean and deviation of the root of many
    many: f32, // share of many, 0 to 1
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

// Prepares counts of a mean, above 0.
fn mf_smooth_poisson(mean: f32) -> MfSmoothPoisson {
    let m: f32 = clamp(mean, 1.0e-30, 1.0e30);
    let a: f32 = sqrt(max(1.0 - 0.5 * MF_SMOOTH_VARIANCE / m, 0.0));
    var o: MfSmoothPoisson;
    o.mean = m;
    o.none = exp(-m);
    o.some = mf_one_minus_exp(m);
    o.normal = vec2f(sqrt(m * a), sqrt(0.5 * MF_SMOOTH_VARIANCE / (1.0 + a)));
    o.many = clamp(2.0 * m - 1.0, 0.0, 1.0);
    return o;
}

// A number with the first five moments of a standard normal one, for a uniform t from -1 to 1: within 0.05 of the normal
// quantile to 2.5, ending at 2.92.
fn mf_nearly_normal(t: f32) -> f32 {
    let s: f32 = t * t;
    return t * (1.2945762 - 0.9652395 * s) / (1.0 - 0.88715417 * s);
}

// The count for v, uniform in 0..1; small v are many flakes. For few, where the count passes k at a chance G for more than k,
// G / (v ln 2) - 1 between 0 and 1 is added, whose integral is G too: a flake fades while the mean changes by a factor of 2.
fn mf_smooth_count(s: MfSmoothPoisson, v: f32) -> f32 {
    var few: f32 = 0.0;
    if (s.many < 1.0) {
        let scale: f32 = 1.442695 / v;
        var more: f32 = s.some;
        var chance: f32 = s.none;
        // At a mean of 1, more than 11 have a chance of 1e-9, which f32 does not tell from rounding.
        for (var i: u32 = 1u; i < 12u; i = i + 1u) { // turns: 2
            let form: f32 = more * scale - 1.0;
            if (form <= 0.0) {
                break;
            }
            few = few + min(form, 1.0);
            chance = chance * s.mean / f32(i);
            more = more - chance;
        }
    }
    if (s.many <= 0.0) {
        return few;
    }
    let root: f32 = s.normal.x + s.normal.y * mf_nearly_normal(1.0 - 2.0 * v);
    return mix(few, root * root, s.many);
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

// Words for the four boxes of a half vector, from the first box and two words of the cell: shorter than mf_pcg4d.
fn mf_glint_words(x: i32, y: i32, prefix: u32, key: u32) -> vec4u {
    let first: u32 = u32(x) * 0x9E3779B1u + u32(y) * 0x85EBCA77u + key;
    let mask: u32 = prefix * 0xC2B2AE3Du;
    var h: vec4u = vec4u(first, first + 0x9E3779B1u, first + 0x85EBCA77u, first + 0x9E3779B1u + 0x85EBCA77u);
    h = h ^ (h >> vec4u(15u, 15u, 15u, 15u));
    h = (h ^ vec4u(mask, mask, mask, mask)) * 0x2C1B3C6Du;
    h = h ^ (h >> vec4u(14u, 14u, 14u, 14u));
    return h * 0x297A2D39u;
}

// A chance from all bits of a word: small ones keep their digits.
fn mf_glint_chance(word: u32) -> f32 {
    return (f32(word) + 0.5) * 2.3283064e-10;
}

// Mean of the counts in the four boxes about a half vector, in one cell (i, j counted from the pixel's).
fn mf_glint_count(grid: MfGlintGrid, i: i32, j: i32, widths: vec2f, seed: u32, counts: MfSmoothPoisson) -> f32 {
    let cell: vec4u = mf_pcg4d(vec4u(u32(grid.home.x + i), u32(grid.home.y + j), u32(grid.level), seed));
    let x: MfWhole = mf_glint_pair(widths.x, mf_unit(cell.x));
    let y: MfWhole = mf_glint_pair(widths.y, mf_unit(cell.y));
    let words: vec4u = mf_glint_words(x.whole, y.whole, cell.z, cell.w);
    let f: f32 = x.rest * x.rest * (3.0 - 2.0 * x.rest);
    let g: f32 = y.rest * y.rest * (3.0 - 2.0 * y.rest);
    let a: f32 = mf_smooth_count(counts, mf_glint_chance(words.x));
    let b: f32 = mf_smooth_count(counts, mf_glint_chance(words.y));
    let c: f32 = mf_smooth_count(counts, mf_glint_chance(words.z));
    let d: f32 = mf_smooth_count(counts, mf_glint_chance(words.w));
    return mix(mix(a, b, f), mix(c, d, f), g);
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
    for (var n: u32 = 0u; n < MF_GLINT_CELLS; n = n + 1u) { // turns: 5
        if (j > last) {
            break;
        }
        // Rows at the top and bottom may have no cell.
        if (i <= row.y) {
            let d: vec2f = vec2f(f32(i), f32(j)) - c;
            let e: vec2f = vec2f(root.x * d.x + root.y * d.y, root.y * d.x + root.z * d.y);
            let rest: f32 = max(1.0 - dot(e, e), 0.0);
            let w: f32 = rest * rest * (3.0 - 2.0 * rest);
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
    let c: vec3f = seen.kernel.tensor * (MF_GLINT_NARROW2 / (side * side));
    let root: f32 = seen.kernel.root * (MF_GLINT_NARROW2 / (side * side));
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

// Variance of a grid's weighted Poisson counts for one expected flake per unit area and box. The factor is the mean sum of
// squared weights of the four boxes about a half vector, (26 / 35)^2.
fn mf_glint_grid_variance(grid: MfGlintGrid) -> f32 {
    return 0.55183673 * grid.squares / (grid.sum * grid.sum * grid.side * grid.side);
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
    // The short radius, squared, is the root over the anisotropy.
    let position: f32 = sqrt(seen.kernel.root / mf_glint_anisotropy(seen.kernel)) / MF_GLINT_FINEST;
    let level: i32 = i32(floor(log2(position)));
    let fine: MfGlintGrid = mf_glint_grid(seen, level);
    let coarse: MfGlintGrid = mf_glint_grid(seen, level + 1);
    // Nearly the logarithm's rest.
    let rest: f32 = position / fine.side - 1.0;
    let share: f32 = clamp(rest * (1.344 - 0.344 * rest), 0.0, 1.0);
    // Flakes per area and box that leave the variance of independent flakes, (1 + variation^2) / N_eff.
    let a: f32 = (1.0 - share) * (1.0 - share) * mf_glint_grid_variance(fine);
    let b: f32 = share * share * mf_glint_grid_variance(coarse);
    let density: f32 = MF_SMOOTH_VARIANCE * n_eff / (1.0 + varied * varied) * (a + b);
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
