//! Numbers as colours.

use ndarray::{Array2, Array3};

use crate::image::{Raster, Samples};

/// An error map as a picture: 0 is nearly black, `most` and above nearly white; from violet over red and orange to yellow
/// in between. What is not a number is drawn as 0.
///
/// Lightness grows evenly, so that equal steps of error look equally large: the ramp is a line in lightness and an arc
/// in hue of Oklab (Ottosson 2020), as saturated as sRGB can show.
pub fn heat(error: &Array2<f32>, most: f32) -> Raster {
    let (rows, columns) = error.dim();
    let mut out = Array3::zeros((rows, columns, 3));
    for ((y, x), error) in error.indexed_iter() {
        let colour = ramp((error / most).clamp(0.0, 1.0));
        (0..3).for_each(|c| out[(y, x, c)] = (255.0 * colour[c] + 0.5) as u8);
    }
    Raster::new(Samples::U8(out))
}

/// Lightness, a and b.
fn path(t: f32) -> [f32; 3] {
    // From violet (295 degrees) through red (20) to yellow (105).
    let hue = (295.0 + 170.0 * t).to_radians();
    // The largest arc that stays inside sRGB all the way, which a test holds.
    let chroma = 0.16 * 2.0 * (t * (1.0 - t)).sqrt();
    [0.12 + 0.86 * t, chroma * hue.cos(), chroma * hue.sin()]
}

/// sRGB, 0 to 1.
fn ramp(t: f32) -> [f32; 3] {
    let t = if t.is_nan() { 0.0 } else { t };
    oklab(path(t)).map(|linear| {
        let linear = linear.clamp(0.0, 1.0);
        if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
    })
}

/// Linear sRGB of an Oklab colour (Ottosson 2020, "A perceptual color space for image processing").
fn oklab([lightness, a, b]: [f32; 3]) -> [f32; 3] {
    let cone = |ka: f32, kb: f32| (lightness + ka * a + kb * b).powi(3);
    let (l, m, s) = (cone(0.39633778, 0.21580376), cone(-0.105561346, -0.06385417), cone(-0.08948418, -1.2914855));
    [
        4.0767417 * l - 3.3077116 * m + 0.23096994 * s,
        -1.268438 * l + 2.6097574 * m - 0.3413194 * s,
        -0.0041960863 * l - 0.7034186 * m + 1.7076147 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lightness_grows_and_nothing_is_cut_off() {
        // L* of CIELAB, from Rec. 709 luminance.
        let light = |t: f32| {
            let [r, g, b] = ramp(t).map(|v| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) });
            let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            if y > 0.008856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
        };
        for i in 0..64 {
            let t = i as f32 / 64.0;
            let step = 64.0 * (light(t + 1.0 / 64.0) - light(t));
            assert!(step > 15.0 && step < 150.0, "{t}: {step}");
            assert!(oklab(path(t)).iter().all(|v| (-1e-3..=1.001).contains(v)), "{t}: {:?}", oklab(path(t)));
        }
    }

    #[test]
    fn ends_worked_by_hand() {
        // Gray at both ends: the cubes of 0.12 and 0.98, sRGB-encoded: 5.7 and 248.3 or so.
        let error = Array2::from_shape_vec((1, 5), vec![0.0, 2.0, 9.0, f32::NAN, -1.0]).unwrap();
        let raster = heat(&error, 2.0);
        let at = |x| [0, 1, 2].map(|c| (255.0 * raster.at(x, 0, c)).round());
        assert_eq!(at(0), [6.0; 3]);
        assert_eq!(at(1), at(2));
        assert!(at(1).iter().all(|v| (v - 248.0).abs() <= 1.0), "{:?}", at(1));
        assert_eq!((at(3), at(4)), (at(0), at(0)));
    }
}
