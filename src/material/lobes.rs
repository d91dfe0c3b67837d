//! Texels as lobes.

use rayon::prelude::*;

use super::Texels;
use crate::ndf::{Form, Lobes, RoughnessTensor};

/// Level 0 in the form that the surface itself has, so that nothing is lost.
pub fn surface_lobes(texels: &dyn Texels) -> Lobes {
    base_lobes(texels, if texels.is_anisotropic() { Form::Anisotropic } else { Form::Isotropic })
}

/// Level 0 as lobes: what a renderer shades close up.
pub fn base_lobes(texels: &dyn Texels, form: Form) -> Lobes {
    let size = texels.size();
    let mut lobes = Lobes::zeros(form, size);
    let rows: Vec<_> = lobes.bands_mut(1).collect();
    rows.into_par_iter().enumerate().for_each_init(
        || vec![vec![0.0; size.width]; 8],
        |scratch, (y, mut out)| {
            let [nx, ny, nz, perceptual, coverage, xx, xy, yy] = &mut scratch[..] else { unreachable!("eight rows") };
            texels.normals(y, 0, [&mut *nx, &mut *ny, &mut *nz], coverage);
            texels.perceptual(y, 0, perceptual);
            if texels.is_anisotropic() {
                texels.tensors(y, 0, perceptual, [&mut *xx, &mut *xy, &mut *yy]);
            }
            for x in 0..size.width {
                let tensor = if texels.is_anisotropic() {
                    RoughnessTensor { xx: xx[x], xy: xy[x], yy: yy[x] }
                } else {
                    let a2 = perceptual[x].powi(4);
                    RoughnessTensor { xx: a2, xy: 0.0, yy: a2 }
                };
                let values = match form {
                    Form::Isotropic => [nx[x], ny[x], nz[x], tensor.mean(), 0.0, 0.0],
                    Form::Anisotropic => [nx[x], ny[x], nz[x], tensor.xx, tensor.xy, tensor.yy],
                };
                values.iter().take(form.planes()).enumerate().for_each(|(plane, v)| out[(plane, 0, x)] = *v);
            }
        },
    );
    lobes
}
