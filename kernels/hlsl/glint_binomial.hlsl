// Generated from kernels/wgsl/glint_binomial.wgsl: change that file, not this one.
#ifndef MF_GLINT_BINOMIAL_HLSL
#define MF_GLINT_BINOMIAL_HLSL

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
static const float MF_GLINT_REACH2 = 0.58;

// Squared ratio of the kernel over cells to the pixel's, which is less flat and as wide.
static const float MF_GLINT_NARROW2 = 0.8333333;

// The finer cells are as wide as the footprint's short radius over this, or up to twice as narrow.
static const float MF_GLINT_FINEST = 0.7;

// More cells than any pixel has in a grid: a bound for compilers.
static const uint MF_GLINT_CELLS = 1024u;

// Variance of smooth counts over their mean: 2 / ln 2 - 2.
static const float MF_SMOOTH_VARIANCE = 0.8853901;

// Poisson counts of one mean that change smoothly with it: a sum of ramps for few, the square of a normal number for many.
struct MfSmoothPoisson {
    float mean;
    float none; // chance of none, and of some
    float some;
    float2 normal; // mean and deviation of the root of many
    float many; // share of many, 0 to 1
};

// A grid of cells as one pixel sees it.
struct MfGlintGrid {
    int2 home; // the pixel's cell
    float2 own; // place in it, 0 to 1
    MfGlintKernel kernel; // in cells
    int level;
    float side; // 2^level, in cells of one flake each
    float sum; // of weights
    float squares;
};

// Prepares counts of a mean, above 0.
MfSmoothPoisson mf_smooth_poisson(float mean) {
    float m = clamp(mean, 1.0e-30, 1.0e30);
    float a = sqrt(max(1.0 - 0.5 * MF_SMOOTH_VARIANCE / m, 0.0));
    MfSmoothPoisson o;
    o.mean = m;
    o.none = exp(-m);
    o.some = mf_one_minus_exp(m);
    o.normal = float2(sqrt(m * a), sqrt(0.5 * MF_SMOOTH_VARIANCE / (1.0 + a)));
    o.many = clamp(2.0 * m - 1.0, 0.0, 1.0);
    return o;
}

// A number with the first five moments of a standard normal one, for a uniform t from -1 to 1: within 0.05 of the normal
// quantile to 2.5, ending at 2.92.
float mf_nearly_normal(float t) {
    float s = t * t;
    return t * (1.2945762 - 0.9652395 * s) / (1.0 - 0.88715417 * s);
}

// The count for v, uniform in 0..1; small v are many flakes. For few, where the count passes k at a chance G for more than k,
// G / (v ln 2) - 1 between 0 and 1 is added, whose integral is G too: a flake fades while the mean changes by a factor of 2.
float mf_smooth_count(MfSmoothPoisson s, float v) {
    float few = 0.0;
    if (s.many < 1.0) {
        float scale = 1.442695 / v;
        float more = s.some;
        float chance = s.none;
        // At a mean of 1, more than 11 have a chance of 1e-9, which f32 does not tell from rounding.
        for (uint i = 1u; i < 12u; i = i + 1u) { // turns: 2
            float form = more * scale - 1.0;
            if (form <= 0.0) {
                break;
            }
            few = few + min(form, 1.0);
            chance = chance * s.mean / float(i);
            more = more - chance;
        }
    }
    if (s.many <= 0.0) {
        return few;
    }
    float root = s.normal.x + s.normal.y * mf_nearly_normal(1.0 - 2.0 * v);
    return lerp(few, root * root, s.many);
}

// First and last cell of row j with their centres in the kernel. Only rounding may add one or leave one out.
int2 mf_glint_centres(MfGlintGrid grid, int j) {
    float3 c = grid.kernel.tensor;
    float d = float(j) - (grid.own.y - 0.5);
    float middle = grid.own.x - 0.5 + d * c.y / c.z;
    float across = grid.kernel.root * sqrt(max(1.0 - d * d / c.z, 0.0) / c.z);
    return int2(int(ceil(middle - across)), int(floor(middle + across)));
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

// Words for the four boxes of a half vector, from the first box and two words of the cell: shorter than mf_pcg4d.
uint4 mf_glint_words(int x, int y, uint prefix, uint key) {
    uint first = uint(x) * 0x9E3779B1u + uint(y) * 0x85EBCA77u + key;
    uint mask = prefix * 0xC2B2AE3Du;
    uint4 h = uint4(first, first + 0x9E3779B1u, first + 0x85EBCA77u, first + 0x9E3779B1u + 0x85EBCA77u);
    h = h ^ (h >> uint4(15u, 15u, 15u, 15u));
    h = (h ^ uint4(mask, mask, mask, mask)) * 0x2C1B3C6Du;
    h = h ^ (h >> uint4(14u, 14u, 14u, 14u));
    return h * 0x297A2D39u;
}

// A chance from all bits of a word: small ones keep their digits.
float mf_glint_chance(uint word) {
    return (float(word) + 0.5) * 2.3283064e-10;
}

// Mean of the counts in the four boxes about a half vector, in one cell (i, j counted from the pixel's).
float mf_glint_count(MfGlintGrid grid, int i, int j, float2 widths, uint seed, MfSmoothPoisson counts) {
    uint4 cell = mf_pcg4d(uint4(uint(grid.home.x + i), uint(grid.home.y + j), uint(grid.level), seed));
    MfWhole x = mf_glint_pair(widths.x, mf_unit(cell.x));
    MfWhole y = mf_glint_pair(widths.y, mf_unit(cell.y));
    uint4 words = mf_glint_words(x.whole, y.whole, cell.z, cell.w);
    float f = x.rest * x.rest * (3.0 - 2.0 * x.rest);
    float g = y.rest * y.rest * (3.0 - 2.0 * y.rest);
    float a = mf_smooth_count(counts, mf_glint_chance(words.x));
    float b = mf_smooth_count(counts, mf_glint_chance(words.y));
    float c = mf_smooth_count(counts, mf_glint_chance(words.z));
    float d = mf_smooth_count(counts, mf_glint_chance(words.w));
    return lerp(lerp(a, b, f), lerp(c, d, f), g);
}

// The sum of weights and of their squares over the cells of a grid, or, if counting, of weighted counts and 0.
float2 mf_glint_cells(MfGlintGrid grid, bool counting, float2 widths, uint seed, MfSmoothPoisson counts) {
    float3 root = mf_glint_inverse_root(grid.kernel);
    float2 c = grid.own - float2(0.5, 0.5);
    float height = sqrt(grid.kernel.tensor.z);
    int last = int(floor(c.y + height));
    int j = int(ceil(c.y - height));
    int2 row = mf_glint_centres(grid, j);
    int i = row.x;
    float2 sums = float2(0.0, 0.0);
    for (uint n = 0u; n < MF_GLINT_CELLS; n = n + 1u) { // turns: 5
        if (j > last) {
            break;
        }
        // Rows at the top and bottom may have no cell.
        if (i <= row.y) {
            float2 d = float2(float(i), float(j)) - c;
            float2 e = float2(root.x * d.x + root.y * d.y, root.y * d.x + root.z * d.y);
            float rest = max(1.0 - dot(e, e), 0.0);
            float w = rest * rest * (3.0 - 2.0 * rest);
            if (counting) {
                if (w > 0.0) {
                    sums = sums + float2(w * mf_glint_count(grid, i, j, widths, seed, counts), 0.0);
                }
            } else {
                sums = sums + float2(w, w * w);
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
    float2 fine = seen.within * float(1u << down);
    float2 whole = float2(floor(fine.x), floor(fine.y));
    int x = (seen.cell.x << down) + int(whole.x);
    int y = (seen.cell.y << down) + int(whole.y);
    float3 c = seen.kernel.tensor * (MF_GLINT_NARROW2 / (side * side));
    float root = seen.kernel.root * (MF_GLINT_NARROW2 / (side * side));
    MfGlintKernel kernel;
    kernel.tensor = float3(c.x + MF_GLINT_REACH2, c.y, c.z + MF_GLINT_REACH2);
    kernel.root = sqrt(root * root + MF_GLINT_REACH2 * (c.x + c.z + MF_GLINT_REACH2));
    MfGlintGrid o;
    o.home = int2(x >> up, y >> up);
    o.own = (float2(float(x & mask), float(y & mask)) + (fine - whole)) / float(1u << up);
    o.kernel = kernel;
    o.level = level;
    o.side = side;
    o.sum = 0.0;
    o.squares = 0.0;
    float2 sums = mf_glint_cells(o, false, float2(0.0, 0.0), 0u, mf_smooth_poisson(1.0));
    o.sum = sums.x;
    o.squares = sums.y;
    return o;
}

// Variance of a grid's weighted Poisson counts for one expected flake per unit area and box. The factor is the mean sum of
// squared weights of the four boxes about a half vector, (26 / 35)^2.
float mf_glint_grid_variance(MfGlintGrid grid) {
    return 0.55183673 * grid.squares / (grid.sum * grid.sum * grid.side * grid.side);
}

// Mean of a grid's counts over their mean; density: flakes per unit area and box.
float mf_glint_grid_ratio(MfGlintGrid grid, float2 widths, uint seed, float density) {
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
    // The short radius, squared, is the root over the anisotropy.
    float position = sqrt(seen.kernel.root / mf_glint_anisotropy(seen.kernel)) / MF_GLINT_FINEST;
    int level = int(floor(log2(position)));
    MfGlintGrid fine = mf_glint_grid(seen, level);
    MfGlintGrid coarse = mf_glint_grid(seen, level + 1);
    // Nearly the logarithm's rest.
    float rest = position / fine.side - 1.0;
    float share = clamp(rest * (1.344 - 0.344 * rest), 0.0, 1.0);
    // Flakes per area and box that leave the variance of independent flakes, (1 + variation^2) / N_eff.
    float a = (1.0 - share) * (1.0 - share) * mf_glint_grid_variance(fine);
    float b = share * share * mf_glint_grid_variance(coarse);
    float density = MF_SMOOTH_VARIANCE * n_eff / (1.0 + varied * varied) * (a + b);
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
