//! What a fold sees of a material.

use crate::curvature;
use crate::image::Size;

/// The level-0 texels of a material, read by parts of rows. Every `out` slice of a call has the same length: the
/// texels from column `x` of row `y` on.
pub trait Texels: Sync {
    /// Size of level 0.
    fn size(&self) -> Size;

    /// Unit normals with z > 0 (OpenGL frame, normal scale applied), and 1 where the normal can be used, else 0.
    fn normals(&self, y: usize, x: usize, out: [&mut [f32]; 3], coverage: &mut [f32]);

    /// Perceptual roughness, 0 to 1.
    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]);

    /// Whether the base lobes have two widths, so that [`Texels::tensors`] must be asked.
    fn is_anisotropic(&self) -> bool {
        false
    }

    /// Base roughness tensors xx xy yy in the bent frames of the normals; only where
    /// [`Texels::is_anisotropic`]. `perceptual` is what [`Texels::perceptual`] gave for the same texels.
    fn tensors(&self, _y: usize, _x: usize, _perceptual: &[f32], _out: [&mut [f32]; 3]) {
        unreachable!("isotropic texels have no tensors")
    }

    /// What the mesh under the texture adds, by level, if that was baked ([`curvature::bake()`]): folds widen the levels from 1
    /// on by it.
    fn curvature(&self) -> Option<&[curvature::Level]> {
        None
    }

    /// Number of further channels that are averaged plainly (occlusion, metal, ...).
    fn extras(&self) -> usize {
        0
    }

    /// A further channel, as stored.
    fn extra(&self, _index: usize, _y: usize, _x: usize, _out: &mut [f32]) {
        unreachable!("no extra channels")
    }
}
