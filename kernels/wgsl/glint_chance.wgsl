// Chance for glints: integers to integers by hashing, the same bits on every device, and numbers of given distributions from
// uniform ones.
// Needs: nothing
//
// Uniform numbers have 23 bits and a half, which f32 holds exactly. Counts are inversions of distribution functions: exact, and
// monotonic, so that the same uniform number gives nearly the same count when the mean changes a little. A count differs from
// that of exact arithmetic where u is within rounding of a step.

// Counts of at most this mean are exact; above, a normal distribution with their skewness stands for them.
const MF_COUNT_EXACT: f32 = 12.0;

// Four words from four, well mixed in every bit: pcg4d of Jarzynski & Olano 2020, "Hash functions for GPU rendering".
fn mf_pcg4d(v: vec4u) -> vec4u {
    var x: u32 = v.x * 1664525u + 1013904223u;
    var y: u32 = v.y * 1664525u + 1013904223u;
    var z: u32 = v.z * 1664525u + 1013904223u;
    var w: u32 = v.w * 1664525u + 1013904223u;
    x = x + y * w;
    y = y + z * x;
    z = z + x * y;
    w = w + y * z;
    x = x ^ (x >> 16u);
    y = y ^ (y >> 16u);
    z = z ^ (z >> 16u);
    w = w ^ (w >> 16u);
    x = x + y * w;
    y = y + z * x;
    z = z + x * y;
    w = w + y * z;
    return vec4u(x, y, z, w);
}

// A uniform number from the top 23 bits, in the middle of its interval: never 0, never 1, and exact in f32, as is 1 minus it.
fn mf_unit(bits: u32) -> f32 {
    return (f32(bits >> 9u) + 0.5) * 1.1920929e-7;
}

// A fifth uniform number of a hash, from the low bytes of its words, which mf_unit leaves alone.
fn mf_fifth(h: vec4u) -> f32 {
    return mf_unit(((h.x & 255u) << 24u) | ((h.y & 255u) << 16u) | ((h.z & 255u) << 8u) | (h.w & 255u));
}

// The value that a standard normal number stays below with probability u, 0 to 1 (counted from 1e-17 to 1 - 6e-8): a
// polynomial of our own in w = -ln(4 u (1 - u)), the variable of Giles 2010, "Approximating the erfinv function".
fn mf_normal_quantile(u: f32) -> f32 {
    let c: f32 = clamp(u, 1.0e-17, 0.99999994);
    let w: f32 = -log(4.0 * c * (1.0 - c));
    var r: f32 = 0.0;
    if (w < 5.0) {
        let x: f32 = w - 2.5;
        r = 3.2855959e-8 - 1.2432505e-8 * x;
        r = 6.592659e-7 + r * x;
        r = -4.8970045e-6 + r * x;
        r = -7.0192385e-6 + r * x;
        r = 3.0878567e-4 + r * x;
        r = -1.7716445e-3 + r * x;
        r = -5.907717e-3 + r * x;
        r = 0.34880204 + r * x;
        r = 2.1233135 + r * x;
    } else {
        let x: f32 = sqrt(min(w, 40.0)) - 4.0;
        r = 2.7404813e-5 - 2.626231e-6 * x;
        r = -9.192903e-5 + r * x;
        r = 1.1644361e-4 + r * x;
        r = -8.860296e-5 + r * x;
        r = 3.7979379e-4 + r * x;
        r = -1.2865433e-3 + r * x;
        r = 1.821376e-3 + r * x;
        r = 1.4276529 + r * x;
        r = 5.4302713 + r * x;
    }
    return r * (2.0 * c - 1.0);
}

// 1 - erf(x), any x: exp(-x^2) times a polynomial of our own in t = 1 / (1 + x/2).
fn mf_erfc(x: f32) -> f32 {
    let a: f32 = min(abs(x), 15.0);
    let t: f32 = 1.0 / (1.0 + 0.5 * a);
    let s: f32 = t - 0.5;
    var r: f32 = -0.019094537 + 0.042352707 * s;
    r = -0.0762139 + r * s;
    r = 0.055307974 + r * s;
    r = 0.097792874 + r * s;
    r = -0.10382097 + r * s;
    r = -0.1720215 + r * s;
    r = 0.14577519 + r * s;
    r = 0.5589429 + r * s;
    r = 0.6871606 + r * s;
    r = 0.51079136 + r * s;
    let upper: f32 = t * r * exp(-a * a);
    if (x < 0.0) {
        return 2.0 - upper;
    }
    return upper;
}

// The error function, any x.
fn mf_erf(x: f32) -> f32 {
    return 1.0 - mf_erfc(x);
}

// ln(1 - p), p from 0 to 1, left out: a series where 1 - p would lose the digits of p.
fn mf_ln_one_minus(p: f32) -> f32 {
    if (p < 0.03) {
        return -p * (1.0 + p * (0.5 + p * (0.33333333 + p * (0.25 + p * 0.2))));
    }
    return log(1.0 - p);
}

// 1 - exp(-x), x from 0: a series where the difference would lose the digits of x.
fn mf_one_minus_exp(x: f32) -> f32 {
    if (x < 0.125) {
        return x * (1.0 - x * (0.5 - x * (0.16666667 - x * (0.041666667 - x * 0.0083333333))));
    }
    return 1.0 - exp(-x);
}

// A normal number of this mean and deviation, z of a standard one, with a skewness of skew / deviation (Cornish & Fisher 1938,
// first term).
fn mf_skewed_normal(mean: f32, deviation: f32, skew: f32, z: f32) -> f32 {
    return mean + deviation * z + skew * (z * z - 1.0) / 6.0;
}

// A Poisson count for a uniform u in (0, 1): mean and variance are `mean`, from 0. From above: the count passes k where 1 - u is
// less than the chance of more than k, so that rare counts keep all digits. At most 48 steps, that of mean 12 and u = 1 - 2^-24.
fn mf_poisson(mean: f32, u: f32) -> f32 {
    if (mean > MF_COUNT_EXACT) {
        return max(floor(mf_skewed_normal(mean, sqrt(mean), 1.0, mf_normal_quantile(u)) + 0.5), 0.0);
    }
    let m: f32 = max(mean, 0.0);
    let v: f32 = 1.0 - u;
    var more: f32 = mf_one_minus_exp(m);
    var chance: f32 = exp(-m);
    var k: f32 = 0.0;
    for (var i: u32 = 0u; i < 48u; i = i + 1u) { // turns: 3
        if (v >= more) {
            break;
        }
        k = k + 1.0;
        chance = chance * m / k;
        more = more - chance;
    }
    return k;
}

// A count of n trials of chance p each, 0 to 1, for a uniform u in (0, 1): mean n p, variance n p (1 - p). n is 0 or more and
// need not be whole: ceil(n) trials of chance p n / ceil(n) have the same mean. At most 48 steps.
fn mf_binomial(n: f32, p: f32, u: f32) -> f32 {
    let trials: f32 = ceil(max(n, 0.0));
    if (trials < 1.0) {
        return 0.0;
    }
    let chance: f32 = clamp(p, 0.0, 1.0) * (n / trials);
    // Chances above a half by their failures, so that the recursion starts from a number that is not 0.
    let turned: bool = chance > 0.5;
    var q: f32 = chance;
    var v: f32 = 1.0 - u;
    if (turned) {
        q = 1.0 - chance;
        v = u;
    }
    let mean: f32 = trials * q;
    var k: f32 = 0.0;
    if (mean > MF_COUNT_EXACT) {
        let z: f32 = -mf_normal_quantile(v);
        k = clamp(floor(mf_skewed_normal(mean, sqrt(mean * (1.0 - q)), 1.0 - 2.0 * q, z) + 0.5), 0.0, trials);
    } else {
        let none: f32 = trials * mf_ln_one_minus(q);
        let odds: f32 = q / (1.0 - q);
        var more: f32 = mf_one_minus_exp(-none);
        var next: f32 = exp(none);
        for (var i: u32 = 0u; i < 48u; i = i + 1u) { // turns: 3
            if (v >= more) {
                break;
            }
            next = next * odds * (trials - k) / (k + 1.0);
            k = k + 1.0;
            more = more - next;
        }
        k = min(k, trials);
    }
    if (turned) {
        return trials - k;
    }
    return k;
}
