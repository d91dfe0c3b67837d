// Generated from kernels/wgsl/glint_field.wgsl: change that file, not this one.
#ifndef MF_GLINT_FIELD_HLSL
#define MF_GLINT_FIELD_HLSL

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
static const int MF_GLINT_DEPTH = 12;

// Cells of the finest boxes along a side of the chart.
static const float MF_GLINT_SIDE = 4096.0;

// Effective flakes that are summed one by one.
static const float MF_GLINT_SUMMED = 1.5;

// More flakes than any pixel looks at in a layer: a bound for compilers.
static const uint MF_GLINT_MOST = 8192u;

// The rows of boxes (sides are 1) that a kernel overlaps.
struct MfGlintRows {
    float2 centre;
    float2 reach; // half of the ellipse's width and height
    float slope; // of the line through the middles of rows
    float across; // half of the width of the row through the centre
    float widest; // height above the centre at which the ellipse reaches the furthest right
};

// The keys of a layer's flakes: nets of different seeds or layers have nothing to do with each other.
uint3 mf_glint_net(uint seed, uint layer) {
    uint4 h = mf_pcg4d(uint4(seed, layer, 0x51ED2701u, 0u));
    return uint3(h.x, h.y, h.z);
}

// 32 bits from a block, the digits so far and a key: shorter than mf_pcg4d, for many are needed.
uint mf_glint_mix(int2 block, uint prefix, uint key) {
    uint h = uint(block.x) * 0x9E3779B1u + uint(block.y) * 0x85EBCA77u + key;
    h = h ^ (h >> 15u);
    h = (h ^ (prefix * 0xC2B2AE3Du)) * 0x2C1B3C6Du;
    h = h ^ (h >> 14u);
    return h * 0x297A2D39u;
}

// The permutation of a block's children, an even one: (a shift, what is added). digits: those so far, as two numbers. The
// product x -> m x in the field of four elements, m = 1, 2 or 3, is in the byte of a table that the shift leads to.
uint2 mf_glint_permutation(uint key, int level, int2 block, uint2 digits) {
    uint h = mf_glint_mix(block, digits.x | (digits.y << 16u), key + uint(level) * 0x632BE5ABu);
    return uint2(((((h << 2u) >> 16u) * 3u) >> 16u) * 8u, h >> 30u);
}

// Digits of a cell's direction, `to` of at most 12, as two numbers, from the first k of them.
uint2 mf_glint_digits(uint key, int2 cell, int k, int to, uint2 first) {
    uint2 digits = first;
    for (int level = k; level < to; level = level + 1) { // turns: 4
        uint l = uint(level);
        int2 parent = int2(cell.x >> (l + 1u), cell.y >> (l + 1u));
        uint2 p = mf_glint_permutation(key, level, parent, digits);
        uint child = uint((cell.x >> l) & 1) | (uint((cell.y >> l) & 1) << 1u);
        uint digit = (((0x009C78E4u >> p.x) >> (2u * child)) & 3u) ^ p.y;
        digits = uint2((digits.x << 1u) | (digit & 1u), (digits.y << 1u) | (digit >> 1u));
    }
    return digits;
}

// The cell of the flake in a box of the chart, within a block, both of level k.
int2 mf_glint_cell(uint key, int k, int2 block, uint2 box) {
    uint2 digits = box;
    int2 cell = block;
    for (int level = k - 1; level >= 0; level = level - 1) { // turns: 4
        uint digit = (digits.x & 1u) | ((digits.y & 1u) << 1u);
        digits = uint2(digits.x >> 1u, digits.y >> 1u);
        uint2 p = mf_glint_permutation(key, level, cell, digits);
        int child = int(((0x00789CE4u >> p.x) >> (2u * (digit ^ p.y))) & 3u);
        cell = int2((cell.x << 1u) | (child & 1), (cell.y << 1u) | (child >> 1u));
    }
    return cell;
}

// The flake of a cell of a layer (0: the flakes themselves): for colours of its own, or sums over a close-up's cells.
MfFlake mf_glint_flake(uint seed, uint layer, int2 cell) {
    uint3 net = mf_glint_net(seed, layer);
    uint4 h = mf_pcg4d(uint4(uint(cell.x), uint(cell.y), net.y, net.z));
    uint2 digits = mf_glint_digits(net.x, cell, 0, MF_GLINT_DEPTH, uint2(0u, 0u));
    MfFlake o;
    o.place = float2(mf_unit(h.x), mf_unit(h.y));
    o.y = float2(float(digits.x) + mf_unit(h.z), float(digits.y) + mf_unit(h.w)) / MF_GLINT_SIDE;
    o.mark = mf_fifth(h);
    return o;
}

// Variance times N_eff of g for flakes of equal weight: evenly filled, they vary less than independent ones, the less so the
// longer the footprint. A fit of our own, within 0.025 for N_eff to 6 and anisotropies to 64.
float mf_glint_even_variance(float n_eff, float anisotropy) {
    return 1.0 / (1.0 + 0.79 * sqrt(n_eff * sqrt(n_eff)) / (1.0 + sqrt(anisotropy)));
}

// Exponent a of the weights (1 + a) t^a, t uniform in 0..1, with mean 1 and this variance: a^2 / (1 + 2a).
float mf_glint_exponent(float variance) {
    float v = max(variance, 0.0);
    return v + sqrt(v + v * v);
}

// The rows of boxes of this side (cells) that a kernel about `centre` (cells) overlaps.
MfGlintRows mf_glint_rows(MfGlintKernel kernel, float2 centre, float side) {
    float2 reach = float2(sqrt(kernel.tensor.x), sqrt(kernel.tensor.z));
    MfGlintRows o;
    o.centre = centre / side;
    o.reach = reach / side;
    o.slope = kernel.tensor.y / kernel.tensor.z;
    o.across = kernel.root / (reach.y * side);
    o.widest = kernel.tensor.y / (reach.x * side);
    return o;
}

// First and last box of row j. Only rounding may add a box that the kernel does not overlap, or leave one out where it weighs
// nothing.
int2 mf_glint_row(MfGlintRows rows, int j) {
    float low = max(float(j) - rows.centre.y, -rows.reach.y);
    float high = min(float(j) + 1.0 - rows.centre.y, rows.reach.y);
    float a = low / rows.reach.y;
    float b = high / rows.reach.y;
    float c = rows.across * sqrt(max(1.0 - a * a, 0.0));
    float d = rows.across * sqrt(max(1.0 - b * b, 0.0));
    float right = max(low * rows.slope + c, high * rows.slope + d);
    float left = min(low * rows.slope - c, high * rows.slope - d);
    if (low <= rows.widest && rows.widest <= high) {
        right = rows.reach.x;
    }
    if (low <= -rows.widest && -rows.widest <= high) {
        left = -rows.reach.x;
    }
    return int2(int(floor(rows.centre.x + left)), int(floor(rows.centre.x + right)));
}

// First and last box of side 1 / blocks of the chart that reach from y - radius to y + radius; all, once, where they meet: the
// chart closes like a torus, so that the mean is 1 at its rim too.
int2 mf_glint_boxes(float y, float radius, int blocks) {
    int a = int(floor((y - radius) * float(blocks)));
    int b = int(floor((y + radius) * float(blocks)));
    if (b - a + 1 >= blocks) {
        return int2(0, blocks - 1);
    }
    return int2(a, b);
}

// A difference of places in the chart, in finest boxes, the shorter way round.
float mf_glint_apart(float d) {
    return d - MF_GLINT_SIDE * floor(d / MF_GLINT_SIDE + 0.5);
}

// The level at which blocks are as large beside the footprint as boxes are beside the lobe: the fewest flakes to look at.
int mf_glint_level(float root, float radius) {
    return int(clamp(floor(0.25 * log2(root) - 0.5 * log2(radius) + 0.5), 0.0, float(MF_GLINT_DEPTH)));
}

// The sum over the flakes of a layer, a quarter as many per area as those of the layer before, at most 16 layers; weights vary
// by this variance. g for layer 0.
float mf_glint_layer(MfGlintPixel seen, MfGlintLight light, uint seed, uint layer, float variance) {
    float thin = 1.0 / float(1u << layer);
    int mask = int((1u << layer) - 1u);
    int2 home = int2(seen.cell.x >> layer, seen.cell.y >> layer);
    float2 own = (float2(float(seen.cell.x & mask), float(seen.cell.y & mask)) + seen.within) * thin;
    MfGlintKernel kernel;
    kernel.tensor = seen.kernel.tensor * (thin * thin);
    kernel.root = seen.kernel.root * (thin * thin);
    float3 root = mf_glint_inverse_root(kernel);
    float radius = sqrt(light.area / MF_BIWEIGHT_AREA);
    int k = mf_glint_level(kernel.root, radius);
    uint level = uint(k);
    int blocks = int(1u << level);
    int2 block = int2(home.x >> level, home.y >> level);
    float2 centre = float2(float(home.x & (blocks - 1)), float(home.y & (blocks - 1))) + own;
    MfGlintRows rows = mf_glint_rows(kernel, centre, float(blocks));
    int last = int(floor(rows.centre.y + rows.reach.y));
    int2 xs = mf_glint_boxes(light.y.x, radius, blocks);
    int2 ys = mf_glint_boxes(light.y.y, radius, blocks);
    // The direction as whole finest boxes and a rest, so that differences are small numbers.
    float2 whole = float2(floor(light.y.x * MF_GLINT_SIDE), floor(light.y.y * MF_GLINT_SIDE));
    float2 rest = light.y * MF_GLINT_SIDE - whole;
    float per_radius = 1.0 / (MF_GLINT_SIDE * radius);
    int closer = min(k + 2, MF_GLINT_DEPTH);
    float wide = float(1u << uint(MF_GLINT_DEPTH - closer));
    // Half of such a box, and the rest.
    float reach = 0.5 * wide + 1.0;
    // A cell's middle is at most half a diagonal from its flake; a little more for rounding.
    float far = 1.001 + 0.70710678 * sqrt(mf_glint_anisotropy(kernel) / kernel.root);
    float beyond = far * far;
    uint3 net = mf_glint_net(seed, layer);
    float exponent = mf_glint_exponent(variance);
    int j = int(floor(rows.centre.y - rows.reach.y));
    int2 row = mf_glint_row(rows, j);
    int i = row.x;
    int a = xs.x;
    int b = ys.x;
    float sum = 0.0;
    // One loop over blocks and boxes: threads that run together wait for the most flakes, not for the longest of each row.
    for (uint n = 0u; n < MF_GLINT_MOST; n = n + 1u) { // turns: 35
        if (j > last) {
            break;
        }
        // Blocks repeat after 2^32 cells.
        int2 at = int2(((block.x + i) << level) >> level, ((block.y + j) << level) >> level);
        uint2 box = uint2(uint(a & (blocks - 1)), uint(b & (blocks - 1)));
        int2 cell = mf_glint_cell(net.x, k, at, box);
        float2 base = float2(float(cell.x - home.x), float(cell.y - home.y)) - own;
        float2 m = base + float2(0.5, 0.5);
        float2 e = float2(root.x * m.x + root.y * m.y, root.y * m.x + root.z * m.y);
        // Cells that the kernel cannot reach, before anything more is hashed.
        if (dot(e, e) < beyond) {
            uint4 h = mf_pcg4d(uint4(uint(cell.x), uint(cell.y), net.y, net.z));
            float2 d = base + float2(mf_unit(h.x), mf_unit(h.y));
            float2 f = float2(root.x * d.x + root.y * d.y, root.y * d.x + root.z * d.y);
            float t = dot(f, f);
            if (t < 1.0) {
                // Boxes of two more digits that the lobe cannot reach, before all digits are made.
                uint2 some = mf_glint_digits(net.x, cell, k, closer, box);
                float x = max(abs(mf_glint_apart(float(some.x) * wide + 0.5 * wide - whole.x)) - reach, 0.0);
                float y = max(abs(mf_glint_apart(float(some.y) * wide + 0.5 * wide - whole.y)) - reach, 0.0);
                if ((x * x + y * y) * per_radius * per_radius < 1.0) {
                    uint2 digits = mf_glint_digits(net.x, cell, closer, MF_GLINT_DEPTH, some);
                    float2 c = float2(mf_glint_apart(float(digits.x) - whole.x), mf_glint_apart(float(digits.y) - whole.y));
                    float2 g = c + (float2(mf_unit(h.z), mf_unit(h.w)) - rest);
                    float s = dot(g, g) * per_radius * per_radius;
                    if (s < 1.0) {
                        float both = (1.0 - t) * (1.0 - s);
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
    float height = 3.0 / (MF_PI * radius);
    return sum * (1.0 + exponent) * height * height / kernel.root;
}

// The glint ratio g, 0 or more, with mean 1: see glint for how to ask. 1 where nothing can be asked.
float mf_glint_field(MfGlintPixel seen, MfGlintLight light, MfFlakes flakes) {
    float n_eff = mf_glint_effective(seen, light);
    if (n_eff <= 0.0 || n_eff >= MF_GLINT_SMOOTH) {
        return 1.0;
    }
    float anisotropy = mf_glint_anisotropy(seen.kernel);
    float varied = clamp(flakes.variation, 0.0, MF_FLAKE_MOST_VARIATION);
    // Layers j and j + 1 have between MF_GLINT_SUMMED and four times that, and a quarter of it.
    float position = max(0.5 * log2(n_eff / MF_GLINT_SUMMED), 0.0);
    float first = floor(position);
    float s = sin(0.5 * MF_PI * (position - first));
    float c = cos(0.5 * MF_PI * (position - first));
    if (first < 0.5) {
        // The sparser layer alone could take g below 0 where both are dark: less of the other then, and more variance in each.
        c = min(c, 1.0 - 0.5 * s);
    }
    float variance = (1.0 + varied * varied) / (s * s + c * c);
    float sum = 0.0;
    float share = c;
    for (uint i = 0u; i < 2u; i = i + 1u) { // turns: 2
        if (share > 0.0) {
            uint layer = uint(first) + i;
            float thin = 1.0 / float(1u << layer);
            float even = mf_glint_even_variance(n_eff * thin * thin, anisotropy);
            sum = sum + share * thin * (mf_glint_layer(seen, light, flakes.seed, layer, variance - even) - 1.0);
        }
        share = s;
    }
    return max(1.0 + min(2.0 - 2.0 * n_eff / MF_GLINT_SMOOTH, 1.0) * sum, 0.0);
}

#endif
