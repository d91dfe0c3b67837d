//! Tangent frames about a bent normal.
//!
//! Two are in use. The **bent** frame is the one that renderers build and files refer to: the +u axis made
//! orthogonal to n. The **transported** frame is the basis carried from z to n by the smallest rotation: the
//! only continuous one in which turning a texture about z turns the tensors like plain 2x2 matrices, so
//! tensors of different texels are averaged in it.

use glam::Vec3;

use super::RoughnessTensor;

/// Tangent and bitangent of a unit normal; with the normal a right-handed basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First axis.
    pub tangent: Vec3,
    /// Second axis.
    pub bitangent: Vec3,
}

impl Frame {
    /// The +u axis made orthogonal to `n`: what a renderer builds from the mesh's tangent. For `n` along +u
    /// itself, where that is undefined, the tangent is -z.
    pub fn bent(n: Vec3) -> Self {
        let flat = Vec3::new(1.0 - n.x * n.x, -n.x * n.y, -n.x * n.z);
        let tangent = flat.try_normalize().unwrap_or(Vec3::NEG_Z);
        Self { tangent, bitangent: n.cross(tangent) }
    }

    /// The basis (u, v) carried along by the smallest rotation that takes z to `n`, `n.z > -1`
    /// (Duff et al. 2017 write the same basis for sampling).
    #[inline(always)]
    pub fn transported(n: Vec3) -> Self {
        let a = 1.0 / (1.0 + n.z);
        let mixed = -n.x * n.y * a;
        Self {
            tangent: Vec3::new(1.0 - n.x * n.x * a, mixed, -n.x),
            bitangent: Vec3::new(mixed, 1.0 - n.y * n.y * a, -n.y),
        }
    }
}

/// Cosine and sine of the angle that turns components in the transported frame of `n` into components in its
/// bent frame: `tensor.rotated(cos, sin)` goes from transported to bent, `rotated(cos, -sin)` back.
#[inline(always)]
pub fn bent_from_transported(n: Vec3) -> (f32, f32) {
    // The bent tangent in transported coordinates is proportional to (t.x, b.x), since both project +u.
    let a = 1.0 / (1.0 + n.z);
    let (x, y) = (1.0 - n.x * n.x * a, -n.x * n.y * a);
    let length2 = x * x + y * y;
    let inverse = 1.0 / length2.max(f32::MIN_POSITIVE).sqrt();
    (x * inverse, -y * inverse)
}

impl RoughnessTensor {
    /// From the transported to the bent frame of `n`.
    #[inline(always)]
    pub fn to_bent(self, n: Vec3) -> Self {
        let (cos, sin) = bent_from_transported(n);
        self.rotated(cos, sin)
    }

    /// From the bent to the transported frame of `n`.
    #[inline(always)]
    pub fn to_transported(self, n: Vec3) -> Self {
        let (cos, sin) = bent_from_transported(n);
        self.rotated(cos, -sin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The tensor as a 3x3 form, `T R T^t`, evaluated on a direction: independent of the choice of frame.
    fn form(r: RoughnessTensor, frame: Frame, direction: Vec3) -> f32 {
        let (x, y) = (frame.tangent.dot(direction), frame.bitangent.dot(direction));
        r.xx * x * x + 2.0 * r.xy * x * y + r.yy * y * y
    }

    proptest! {
        #[test]
        fn both_frames_are_right_handed_bases(x in -0.99f32..0.99, y in -0.99f32..0.99) {
            prop_assume!(x * x + y * y < 0.999);
            let n = Vec3::new(x, y, (1.0 - x * x - y * y).sqrt());
            for frame in [Frame::bent(n), Frame::transported(n)] {
                prop_assert!(frame.tangent.dot(n).abs() < 1e-5);
                prop_assert!(frame.tangent.dot(frame.bitangent).abs() < 1e-5);
                prop_assert!((frame.tangent.length() - 1.0).abs() < 1e-5);
                prop_assert!((frame.tangent.cross(frame.bitangent) - n).length() < 1e-5);
            }
        }

        #[test]
        fn changing_frames_keeps_the_tensor(x in -0.9f32..0.9, y in -0.9f32..0.9, xx in 0.0f32..1.0, yy in 0.0f32..1.0) {
            prop_assume!(x * x + y * y < 0.95);
            let n = Vec3::new(x, y, (1.0 - x * x - y * y).sqrt());
            let r = RoughnessTensor { xx, xy: 0.3 * (xx * yy).sqrt(), yy };
            let bent = r.to_bent(n);
            for direction in [Vec3::X, Vec3::Y, Vec3::new(0.6, -0.5, 0.3)] {
                let (a, b) = (form(r, Frame::transported(n), direction), form(bent, Frame::bent(n), direction));
                prop_assert!((a - b).abs() < 1e-4, "{a} {b}");
            }
            let back = bent.to_transported(n);
            prop_assert!((back.xx - r.xx).abs() < 1e-5 && (back.xy - r.xy).abs() < 1e-5);
        }
    }
}
