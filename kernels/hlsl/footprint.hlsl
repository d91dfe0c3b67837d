// Generated from kernels/wgsl/footprint.wgsl: change that file, not this one.
#ifndef MF_FOOTPRINT_HLSL
#define MF_FOOTPRINT_HLSL

// The lobe to shade a pixel with: the mip chain's lobe, widened by what the pixel sees beyond it, with no variance counted
// twice.
// Needs: moments, geometric_aa, shading
//
// What a pixel sees of a surface varies for two reasons. The mesh curves under it: that is in no texture, and is added in
// full. And the normal map varies: within a texel, which the mip chain has folded into the lobe already, and from texel to
// texel, which an interpolated lobe does not hold, for the GPU interpolates normals and widths apart from each other. Of
// normals that change steadily by a per pixel, a pixel's filter of variance sigma2 sees the variance sigma2 a a^T in all. The
// texels, boxes w pixels wide, have folded w^2 / 12 a a^T of that: the rest is what derivatives of the normal map may add. Say
// K is the kernel of these derivatives, O = K w^2 / (12 sigma2) its part within a texel, and V = R - base what was folded.
// The chain tells V + (K - O) of the whole, the derivatives tell K; each may miss some, so that the pixel gets the tensor of
// least trace that is below neither:
//     added = (K - O) + positive part of (O - V)
// Where the chain has folded the change (V above O), this adds K - O; where it has not (level 0), K; never less than the
// former, nor in the mean of both axes more than the latter. For steady change it is exact. On random normal maps in one
// dimension, from smooth to noise, the variance comes out at 0.89 to 1.03 of a pixel's at full size, where the chain alone
// holds 0.53 to 0.80 of it and the sum of both 0.98 to 1.48.
//
// 1. Decode the lobe: moments.
// 2. Fill an MfFootprint. dndx, dndy: screen derivatives of the interpolated mesh normal. dmdx, dmdy: of the decoded normal in
//    the tangent frame (that of the lobe itself), or 0 to leave the change from texel to texel out. All in the tangent frame:
//    (dot(d, tangent), dot(d, bitangent), dot(d, normal)).
//    A deferred renderer that has the shading normal alone passes its derivatives as dm, and 0 as dn. The share
//    w^2 / (12 sigma2) of the mesh's curvature is then taken for folded where the map is rough enough to hold it.
// 3. mf_footprint_normals, or mf_footprint_half_vectors once for each light.
// 4. Shade each light with mf_footprint_shade, or with your own BRDF: D and V of the lobe's tensor, of a glint ratio g (mean 1)
//    times D alone, and mf_diffuse_cosine for diffuse light. Of a mixture, each lobe by itself, and the sum by weights. The file
//    glint tells how a ratio is found for this lobe and a light.
//
// Derivatives that are 0 give the chain's lobe back, bit by bit.

// What is known of a pixel.
struct MfFootprint {
    float3 normal; // of the mip chain's lobe: unit, in the surface's tangent frame
    float3 tensor; // its roughness tensor (xx, xy, yy) in its bent frame, widths up to 1
    float3 base; // the material's own tensor before folding, or 0: all of the tensor counts as folded then
    float3 dndx; // derivative of the mesh normal, or of the half vector, along screen x, per pixel
    float3 dndy; // the same along screen y
    float3 dmdx; // derivative of the lobe's normal in the tangent frame, along screen x, per pixel
    float3 dmdy; // the same along screen y
    float sigma2; // variance of the pixel's filter, pixels^2: MF_SIGMA2_PEAK
    float most; // most that either source adds to alpha^2: MF_MOST_ADDED
    float texel; // width of a texel in pixels: 1 for mip levels that the GPU chose, 0 at level 0 and above it
};

// Components of d along the bent frame of the unit normal n: the +u axis made orthogonal to n (-z where n is that axis), and
// n x that.
float2 mf_bent_components(float3 n, float3 d) {
    float root = sqrt(n.y * n.y + n.z * n.z);
    if (root < 1.0e-6) {
        return float2(-d.z, d.y * sign(n.x));
    }
    float across = (n.y * d.y + n.z * d.z) / root;
    return float2(root * d.x - n.x * across, (n.z * d.y - n.y * d.z) / root);
}

// By how much the lobe's normal n turns where the mesh normal, z in the tangent frame, turns by dn (its x and y count) and
// the frame does not turn about it: (z x dn) x n.
float3 mf_carried_derivative(float3 n, float3 dn) {
    return float3(dn.x * n.z, dn.y * n.z, -(dn.x * n.x + dn.y * n.y));
}

// A kernel k (xx, xy, yy) of the mesh normal, in the surface's tangent frame, as `bake-curvature` writes it, in the bent frame of
// the lobe's unit normal n, which turns with the mesh. What mf_add_kernel_projected then adds to the lobe.
float3 mf_carried_kernel(float3 n, float3 k) {
    float2 a = mf_bent_components(n, mf_carried_derivative(n, float3(1.0, 0.0, 0.0)));
    float2 b = mf_bent_components(n, mf_carried_derivative(n, float3(0.0, 1.0, 0.0)));
    float xx = k.x * a.x * a.x + 2.0 * k.y * a.x * b.x + k.z * b.x * b.x;
    float xy = k.x * a.x * a.y + k.y * (a.x * b.y + a.y * b.x) + k.z * b.x * b.y;
    float yy = k.x * a.y * a.y + 2.0 * k.y * a.y * b.y + k.z * b.y * b.y;
    return float3(xx, xy, yy);
}

// The share of a steady change that texels of this width (pixels) have folded, under a pixel's filter of variance sigma2
// (pixels^2): w^2 / (12 sigma2), 0 to 1.
float mf_folded_share(float sigma2, float texel) {
    return min(texel * texel / max(12.0 * sigma2, 1.0e-12), 1.0);
}

// What a kernel k of the normal map's derivatives adds to a lobe that holds `folded` (V, xx, xy, yy) already, where the fold
// holds a share (0 to 1) of steady change: (1 - share) K + positive part of (share K - V).
float3 mf_residual_kernel(float3 k, float3 folded, float share) {
    if (k.x + k.z <= 0.0) {
        return float3(0.0, 0.0, 0.0);
    }
    return (1.0 - share) * k + mf_tensor_positive(share * k - mf_tensor_positive(folded));
}

// The lobe with a kernel of the mesh (a, b along screen x and y, in the lobe's bent frame) and one of the normal map added in
// projected space.
MfLobe mf_footprint_lobe(MfFootprint f, float2 a, float2 b) {
    float3 mesh = mf_kernel_clamp(mf_kernel(a, b, f.sigma2), f.most);
    float2 c = mf_bent_components(f.normal, f.dmdx);
    float2 d = mf_bent_components(f.normal, f.dmdy);
    float3 map = mf_kernel_clamp(mf_kernel(c, d, f.sigma2), f.most);
    float3 more = mf_residual_kernel(map, f.tensor - f.base, mf_folded_share(f.sigma2, f.texel));
    MfLobe o;
    o.normal = f.normal;
    o.tensor = mf_add_kernel_projected(f.tensor, mesh + more);
    return o;
}

// The lobe to shade with, for all lights: dndx and dndy are derivatives of the mesh normal.
MfLobe mf_footprint_normals(MfFootprint f) {
    float3 a = mf_carried_derivative(f.normal, f.dndx);
    float3 b = mf_carried_derivative(f.normal, f.dndy);
    return mf_footprint_lobe(f, mf_bent_components(f.normal, a), mf_bent_components(f.normal, b));
}

// The lobe to shade one light with, near lights and viewers too: dndx and dndy are derivatives of the half vector's
// components in the mesh's tangent frame (not in one that follows the normal map), which turn with the mesh.
MfLobe mf_footprint_half_vectors(MfFootprint f) {
    return mf_footprint_lobe(f, mf_bent_components(f.normal, f.dndx), mf_bent_components(f.normal, f.dndy));
}

// The cosine of diffuse light for a mip level, in place of max(0, dot(n, l)): scale r is the `diffuse` map's value, the length
// of the mean normal (0 to 1), cosine = dot(n, l) (-1 to 1). r cosine for light from above, softened at the terminator, where
// some of the bumps still see the light: for the mean of max(0, x) over a Gaussian x of mean m = r cosine and variance
// (1 - r^2) (1 - cosine^2) / 2 stands tau log(1 + exp(m / tau)). tau is the deviation over sqrt(2 pi) ln 2 = 1.7375, which
// makes both the same at m = 0; elsewhere they differ by 0.012 deviations at most.
float mf_diffuse_cosine(float scale, float cosine) {
    float mean = scale * cosine;
    float variance = 0.5 * (1.0 - scale) * (1.0 + scale) * (1.0 - cosine) * (1.0 + cosine);
    float tau = sqrt(max(variance, 1.0e-12)) / 1.7375;
    return max(mean, 0.0) + tau * log(1.0 + exp(-abs(mean) / tau));
}

// Light that a pixel reflects from one direction, times that light's irradiance.
struct MfReflection {
    float3 specular; // F D V n.l
    float diffuse; // in place of n.l: times albedo / pi
};

// What a lobe reflects of one light: unit view v and light l in the surface's tangent frame; f0: reflectance at normal
// incidence; glint: a ratio by which this pixel's D differs from its mean, as of a glint model, 1 for none; scale: the `diffuse`
// map's value, 1 for none. GGX with height-correlated Smith masking of the same lobe (shading). Nothing specular below the
// lobe's own horizon. Of the mesh's horizon it knows nothing: for a light with l.z below 0 it still gives what the bent lobe
// reflects, specular and softened diffuse, so cut such lights off or fade them out, with the shadowing of the mesh.
MfReflection mf_footprint_shade(MfLobe lobe, float3 v, float3 l, float3 f0, float glint, float scale) {
    float n_l = dot(lobe.normal, l);
    float2 a = mf_bent_components(lobe.normal, v);
    float2 b = mf_bent_components(lobe.normal, l);
    float3 local_v = float3(a.x, a.y, dot(lobe.normal, v));
    float3 local_l = float3(b.x, b.y, n_l);
    MfReflection o;
    o.specular = (glint * max(n_l, 0.0)) * mf_specular_ggx_tensor(local_l, local_v, f0, lobe.tensor);
    o.diffuse = mf_diffuse_cosine(scale, n_l);
    return o;
}

#endif
