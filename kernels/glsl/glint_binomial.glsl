// Generated from kernels/wgsl/glint_binomial.wgsl: change that file, not this one.
// In GLSL ES, include it after `precision highp float;` and `precision highp int;`.
#ifndef MF_GLINT_BINOMIAL_GLSL
#define MF_GLINT_BINOMIAL_GLSL

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
const float MF_GLINT_REACH2 = 0.6;

// The finer cells are as wide as the footprint's short radius over this, or up to twice as narrow.
const float MF_GLINT_FINEST = 0.75;

// More cells than any pixel has in a grid: a bound for compilers.
const uint MF_GLINT_CELLS = 1024u;

// Poisson counts of one mean that change smoothly with it: those of two neighbours in a series are mixed.
struct MfSmoothPoisson {
    float mean;
    float low; // the neighbours
    float high;
    float share; // of the upper neighbour
    vec2 some; // chances of more than none, of both
    float normal; // share of a normal distribution instead, 0 to 1
};

// A grid of cells as one pixel sees it.
struct MfGlintGrid {
    ivec2 home; // the pixel's cell
    vec2 own; // place in it, 0 to 1
    MfGlintKernel kernel; // in cells
    int level;
    float side; // 2^level, in cells of one flake each
    float sum; // of weights
    float squares;
};

// Prepares counts of a mean, above 0. Between powers of two there are four steps.
MfSmoothPoisson mf_smooth_poisson(float mean) {
    float m = clamp(mean, 1.0e-30, 1.0e30);
    float octave = exp2(floor(log2(m)));
    float stair = floor(4.0 * (m / octave - 1.0));
    MfSmoothPoisson o;
    o.mean = m;
    o.low = octave * (1.0 + stair / 4.0);
    o.high = octave * (1.0 + (stair + 1.0) / 4.0);
    o.share = (m - o.low) / (o.high - o.low);
    o.some = vec2(mf_one_minus_exp(o.low), mf_one_minus_exp(o.high));
    o.normal = clamp((m / MF_COUNT_EXACT - 0.75) * 4.0, 0.0, 1.0);
    return o;
}

// Variance of smooth counts of this mean, above 0, over the mean: 0.94 to 1, within 0.012. Few flakes are counted by both
// neighbours or by one, so that the covariance of the two is the lower mean; many vary together.
float mf_smooth_variance(float mean) {
    MfSmoothPoisson s = mf_smooth_poisson(mean);
    float t = s.share;
    float together = s.low + (sqrt(s.low * s.high) - s.low) * s.mean / (s.mean + 1.0);
    float mixed = ((1.0 - t) * (1.0 - t) * s.low + t * t * s.high + 2.0 * t * (1.0 - t) * together) / s.mean;
    return mix(mixed, 1.0, s.normal);
}

// The count for a uniform u in (0, 1), whole or between two whole numbers: see mf_poisson. At most 48 steps.
float mf_smooth_count(MfSmoothPoisson s, float u) {
    float v = 1.0 - u;
    if (s.normal <= 0.0 && v >= s.some.y) {
        return 0.0;
    }
    float k = 0.0;
    if (s.normal < 1.0) {
        // Both counts in step: the higher mean is the last to pass.
        vec2 more = s.some;
        vec2 chance = vec2(exp(-s.low), exp(-s.high));
        for (uint i = 1u; i < 49u; i = i + 1u) { // turns: 2
            if (v >= more.y) {
                break;
            }
            k = k + s.share;
            if (v < more.x) {
                k = k + (1.0 - s.share);
            }
            chance = vec2(chance.x * s.low, chance.y * s.high) / float(i);
            more = more - chance;
        }
    }
    if (s.normal > 0.0) {
        float z = mf_normal_quantile(u);
        k = mix(k, max(mf_skewed_normal(s.mean, sqrt(s.mean), 1.0, z), 0.0), s.normal);
    }
    return k;
}

// First and last cell of row j with their centres in the kernel. Only rounding may add one or leave one out.
ivec2 mf_glint_centres(MfGlintGrid grid, int j) {
    vec3 c = grid.kernel.tensor;
    float d = float(j) - (grid.own.y - 0.5);
    float middle = grid.own.x - 0.5 + d * c.y / c.z;
    float across = grid.kernel.root * sqrt(max(1.0 - d * d / c.z, 0.0) / c.z);
    return ivec2(int(ceil(middle - across)), int(floor(middle + across)));
}

// Both boxes of a half vector along one axis: w is its place, in boxes, u the grid's random shift, 0 to 1; the first box, and the
// share of the second.
MfWhole mf_glint_pair(float w, float u) {
    MfWhole o;
    o.whole = int(floor(w));
    o.rest = w - floor(w) + u;
    if (o.rest >= 1.0) {
        o.whole = o.whole + 1;
        o.rest = o.rest - 1.0;
    }
    return o;
}

// Mean of the counts in the four boxes about a half vector, in one cell (i, j counted from the pixel's).
float mf_glint_count(MfGlintGrid grid, int i, int j, vec2 widths, uint seed, MfSmoothPoisson counts) {
    uvec4 cell = mf_pcg4d(uvec4(uint(grid.home.x + i), uint(grid.home.y + j), uint(grid.level), seed));
    MfWhole x = mf_glint_pair(widths.x, mf_unit(cell.x));
    MfWhole y = mf_glint_pair(widths.y, mf_unit(cell.y));
    float sum = 0.0;
    for (int n = 0; n < 4; n = n + 1) { // turns: 4
        int a = x.whole + (n & 1);
        int b = y.whole + (n >> 1u);
        // Boxes share hashes in blocks of 2 x 2.
        uvec4 words = mf_pcg4d(uvec4(cell.z, cell.w, uint(a >> 1u), uint(b >> 1u)));
        uvec2 bits = uvec2(words.x, words.y);
        if ((b & 1) == 1) {
            bits = uvec2(words.z, words.w);
        }
        uint word = bits.x;
        if ((a & 1) == 1) {
            word = bits.y;
        }
        float wx = mix(1.0 - x.rest, x.rest, float(n & 1));
        float wy = mix(1.0 - y.rest, y.rest, float(n >> 1u));
        sum = sum + wx * wy * mf_smooth_count(counts, mf_unit(word));
    }
    return sum;
}

// The sum of weights and of their squares over the cells of a grid, or, if counting, of weighted counts and 0.
vec2 mf_glint_cells(MfGlintGrid grid, bool counting, vec2 widths, uint seed, MfSmoothPoisson counts) {
    vec3 root = mf_glint_inverse_root(grid.kernel);
    vec2 c = grid.own - vec2(0.5, 0.5);
    float height = sqrt(grid.kernel.tensor.z);
    int last = int(floor(c.y + height));
    int j = int(ceil(c.y - height));
    ivec2 row = mf_glint_centres(grid, j);
    int i = row.x;
    vec2 sums = vec2(0.0, 0.0);
    for (uint n = 0u; n < MF_GLINT_CELLS; n = n + 1u) { // turns: 6
        if (j > last) {
            break;
        }
        // Rows at the top and bottom may have no cell.
        if (i <= row.y) {
            vec2 d = vec2(float(i), float(j)) - c;
            vec2 e = vec2(root.x * d.x + root.y * d.y, root.y * d.x + root.z * d.y);
            float rest = max(1.0 - dot(e, e), 0.0);
            float w = rest * rest;
            if (counting) {
                if (w > 0.0) {
                    sums = sums + vec2(w * mf_glint_count(grid, i, j, widths, seed, counts), 0.0);
                }
            } else {
                sums = sums + vec2(w, w * w);
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
MfGlintGrid mf_glint_grid(MfGlintPixel seen, int level) {
    uint up = uint(max(level, 0));
    uint down = uint(max(-level, 0));
    float side = float(1u << up) / float(1u << down);
    int mask = int((1u << up) - 1u);
    // The place in the cell, in units of the grid's cells where these are finer, in units of flakes' cells else.
    vec2 fine = seen.within * float(1u << down);
    vec2 whole = vec2(floor(fine.x), floor(fine.y));
    int x = (seen.cell.x << down) + int(whole.x);
    int y = (seen.cell.y << down) + int(whole.y);
    vec3 c = seen.kernel.tensor / (side * side);
    float root = seen.kernel.root / (side * side);
    MfGlintKernel kernel;
    kernel.tensor = vec3(c.x + MF_GLINT_REACH2, c.y, c.z + MF_GLINT_REACH2);
    kernel.root = sqrt(root * root + MF_GLINT_REACH2 * (c.x + c.z + MF_GLINT_REACH2));
    MfGlintGrid o;
    o.home = ivec2(x >> up, y >> up);
    o.own = (vec2(float(x & mask), float(y & mask)) + (fine - whole)) / float(1u << up);
    o.kernel = kernel;
    o.level = level;
    o.side = side;
    o.sum = 0.0;
    o.squares = 0.0;
    vec2 sums = mf_glint_cells(o, false, vec2(0.0, 0.0), 0u, mf_smooth_poisson(1.0));
    o.sum = sums.x;
    o.squares = sums.y;
    return o;
}

// Variance of a grid's weighted counts for one expected flake per unit area and box. 4/9 is the mean sum of squared weights of
// the four boxes about a half vector.
float mf_glint_grid_variance(MfGlintGrid grid) {
    return 0.44444444 * grid.squares / (grid.sum * grid.sum * grid.side * grid.side);
}

// Mean of a grid's counts over their mean; density: flakes per unit area and box.
float mf_glint_grid_ratio(MfGlintGrid grid, vec2 widths, uint seed, float density) {
    MfSmoothPoisson counts = mf_smooth_poisson(density * grid.side * grid.side);
    return mf_glint_cells(grid, true, widths, seed, counts).x / (grid.sum * counts.mean);
}

// The glint ratio g, 0 or more, with mean 1: see glint for how to ask. 1 where nothing can be asked.
float mf_glint_binomial(MfGlintPixel seen, MfGlintLight light, MfFlakes flakes) {
    float n_eff = mf_glint_effective(seen, light);
    if (n_eff <= 0.0 || n_eff >= MF_GLINT_SMOOTH) {
        return 1.0;
    }
    float varied = clamp(flakes.variation, 0.0, MF_FLAKE_MOST_VARIATION);
    // Half the logarithm of the short radius squared, which is the root over the anisotropy.
    float finest2 = MF_GLINT_FINEST * MF_GLINT_FINEST;
    float position = 0.5 * log2(seen.kernel.root / (mf_glint_anisotropy(seen.kernel) * finest2));
    int level = int(floor(position));
    float share = position - floor(position);
    MfGlintGrid fine = mf_glint_grid(seen, level);
    MfGlintGrid coarse = mf_glint_grid(seen, level + 1);
    // Flakes per area and chart that leave the variance of independent flakes, (1 + variation^2) / N_eff.
    float a = (1.0 - share) * (1.0 - share) * mf_glint_grid_variance(fine);
    float b = share * share * mf_glint_grid_variance(coarse);
    float per_flake = n_eff / (1.0 + varied * varied);
    float area = fine.side * fine.side;
    // Smooth counts keep a share of the variance that depends on their mean; two rounds find it to a thousandth.
    float density = per_flake * (a + b);
    for (uint i = 0u; i < 2u; i = i + 1u) { // turns: 2
        float more = b * mf_smooth_variance(4.0 * density * area);
        density = per_flake * (a * mf_smooth_variance(density * area) + more);
    }
    float g = 0.0;
    MfGlintGrid grid = fine;
    float weight = 1.0 - share;
    for (uint n = 0u; n < 2u; n = n + 1u) { // turns: 2
        g = g + weight * mf_glint_grid_ratio(grid, light.widths, flakes.seed, density);
        grid = coarse;
        weight = share;
    }
    return 1.0 + min(2.0 - 2.0 * n_eff / MF_GLINT_SMOOTH, 1.0) * (g - 1.0);
}

#endif
