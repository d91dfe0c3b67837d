//! Whether slopes are those of the height map beside them.

use super::Picture;
use super::stats::correlation;
use super::subject::{Normals, bands};

/// Correlations of the slopes as read with the gradient of a height map.
#[derive(Clone, Copy, Debug)]
pub struct Relief {
    /// Slope along u with dh/du.
    pub u: f64,
    /// Slope along v with dh/dv.
    pub v: f64,
    /// Slope along u with dh/dv.
    pub u_with_v: f64,
    /// Slope along v with dh/du.
    pub v_with_u: f64,
}

/// Height maps hide walls in one step; a slope is clamped so that such texels do not decide.
const STEEP: f32 = 3.0;

impl Relief {
    /// None if the sizes differ. Central differences of the first channel.
    pub fn of(normals: &Normals, height: &Picture) -> Option<Self> {
        let size = normals.size();
        if height.raster.size() != size || size.width < 3 || size.height < 3 {
            return None;
        }
        let width = size.width;
        let parts = bands(size.height, |rows| {
            let mut sums = [[0.0f64; 6]; 4];
            let [mut p, mut q, mut z, mut above, mut here, mut below] = std::array::from_fn(|_| vec![0.0f32; width]);
            for y in rows.start.max(1)..rows.end.min(size.height - 1) {
                normals.slopes(y, &mut p, &mut q, &mut z);
                for (row, y) in [(&mut above, y - 1), (&mut here, y), (&mut below, y + 1)] {
                    height.raster.read(0, y, 0, row);
                }
                for x in 1..width - 1 {
                    let (hu, hv) = (here[x + 1] - here[x - 1], above[x] - below[x]);
                    if !(p[x].is_finite() && q[x].is_finite() && hu.is_finite() && hv.is_finite()) {
                        continue;
                    }
                    let (p, q) = (p[x].clamp(-STEEP, STEEP), q[x].clamp(-STEEP, STEEP));
                    for (sums, (s, h)) in sums.iter_mut().zip([(p, hu), (q, hv), (p, hv), (q, hu)]) {
                        let (s, h) = (f64::from(s), f64::from(h));
                        [1.0, s, h, s * s, h * h, s * h].iter().zip(sums).for_each(|(v, sum)| *sum += v);
                    }
                }
            }
            sums
        });
        let mut all = [[0.0; 6]; 4];
        for part in &parts {
            for (all, part) in all.iter_mut().zip(part) {
                all.iter_mut().zip(part).for_each(|(all, sum)| *all += sum);
            }
        }
        let [u, v, u_with_v, v_with_u] = all.map(correlation);
        Some(Self { u, v, u_with_v, v_with_u })
    }
}
