// Units of width, and conversions between them.
// Needs: nothing

// GGX width from perceptual roughness (what textures hold), 0 to 1: `alpha = perceptual^2` (Burley 2012, sec. 5.4).
fn mf_alpha_from_perceptual(perceptual: f32) -> f32 {
    return perceptual * perceptual;
}
