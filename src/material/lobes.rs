//! Texels as lobes.

use rayon::prelude::*;

use super::Texels;
use crate::ndf::{Form, Lobes};

/// Level 0 in the form that the surface itself has, so that nothing is lost.
pub fn surface_lobes(texels: &dyn Texels) -> Lobes {
    base_lobes(texels, if texels.is_anisotropic() { Form::Anisotropic } else { Form::Isotropic })
}

/// Level 0 as lobes: what a renderer shades close up.
pub fn base_lobes(texels: &dyn Texels, form: Form) -> Lobes {
    let size = texels.size();
    let mut lobes = Lobes::zeros(form, size);
    let rows: Vec<_> = lobes.bands_mut(1).collect();
    rows.into_par_iter().enumerate().for_each_init(BaseRows::default, |buffers, (y, mut out)| {
        let planes = buffers.read(texels, form, y, 0, size.width);
        for (plane, values) in planes.iter().enumerate() {
            values.iter().enumerate().for_each(|(x, v)| out[(plane, 0, x)] = *v);
        }
    });
    lobes
}

/// Parts of rows of level 0 as lobes.
#[derive(Default)]
pub(super) struct BaseRows([Vec<f32>; 8]);

impl BaseRows {
    /// The planes of [`Lobes`] for `n` texels from column `x` of row `y` on.
    pub fn read(&mut self, texels: &dyn Texels, form: Form, y: usize, x: usize, n: usize) -> &[Vec<f32>] {
        self.0.iter_mut().for_each(|row| row.resize(n, 0.0));
        let [nx, ny, nz, xx, xy, yy, perceptual, coverage] = &mut self.0;
        texels.normals(y, x, [nx, ny, nz], coverage);
        texels.perceptual(y, x, perceptual);
        if texels.is_anisotropic() {
            texels.tensors(y, x, perceptual, [xx, xy, yy]);
            if form == Form::Isotropic {
                xx.iter_mut().zip(yy).for_each(|(xx, yy)| *xx = 0.5 * (*xx + *yy));
            }
        } else {
            for i in 0..n {
                let a2 = perceptual[i].powi(4);
                (xx[i], xy[i], yy[i]) = (a2, 0.0, a2);
            }
        }
        &self.0[..form.planes()]
    }
}
