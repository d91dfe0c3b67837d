//! Distributions of normals under single texels: the truth beside the chain's lobe.

use ndarray::Array2;
use rayon::prelude::*;

use super::Subject;
use super::pictures::png;
use super::verdict::{short, worst};
use crate::compare::{LevelScore, Place};
use crate::error::Result;
use crate::image::{Size, spans};
use crate::material::Texels;
use crate::ndf::{Lobe, Lobes, RoughnessTensor};
use crate::reference::{Footprint, Reading};
use crate::render::heat;
use crate::roughness::Alpha;

/// Texels of a footprint that a picture shows, at most: more would not be seen.
const MOST_TEXELS: usize = 2048;

/// Texels of a footprint along one side, at most, that the window is fitted to.
const WINDOW_TEXELS: usize = 48;

/// The window holds this many widths around every lobe: 1 - 1 / (1 + 2.5^2), 86 percent of a GGX lobe's normals.
const WIDTHS: f64 = 2.5;

/// Powers of ten of density between black and white, from the peak of both pictures down.
const DECADES: f64 = 3.0;

/// Two pictures of one texel.
pub(super) struct Disk {
    /// "worst texel" or "median texel".
    pub which: &'static str,
    pub truth: String,
    pub lobe: String,
    pub place: String,
    pub figures: String,
    pub window: String,
}

/// Pictures of one chain.
pub(super) struct Panel {
    pub name: String,
    pub level: usize,
    pub disks: Vec<Disk>,
}

/// The worst and the median texel of the worst level of each chain; nothing for chains without figures, and
/// nothing where there is no density to show.
pub(super) fn panels(subject: &Subject, base: &Lobes, cells: usize) -> Result<Vec<Panel>> {
    let mut panels = Vec::new();
    for (score, candidate) in subject.judgement.chains.iter().zip(subject.chains) {
        let Some(level) = worst(score).or(score.levels.first()) else { continue };
        let Some(lobes) = candidate.levels.get(level.level) else { continue };
        let desk = Desk { subject, base, lobes, level: level.level, cells };
        let disks: Vec<_> = wanted(level).into_par_iter().map(|wanted| desk.disk(wanted)).collect();
        let disks = disks.into_iter().flatten().collect::<Result<Vec<_>>>()?;
        if !disks.is_empty() {
            panels.push(Panel { name: score.name.clone(), level: level.level, disks });
        }
    }
    Ok(panels)
}

/// Which texel, where it is, and its lobe error.
type Wanted = (&'static str, Place, f64);

fn wanted(level: &LevelScore) -> Vec<Wanted> {
    let worst = level.worst.first().map(|w| ("worst texel", Place { x: w.x, y: w.y }, w.lobe_error));
    let median = ("median texel", level.median_texel, level.lobe_error.median);
    // A level with one judged texel has one picture.
    worst.into_iter().chain((level.samples > 1).then_some(median)).collect()
}

/// What is drawn for one chain.
struct Desk<'a> {
    subject: &'a Subject<'a>,
    base: &'a Lobes,
    lobes: &'a Lobes,
    level: usize,
    cells: usize,
}

impl Desk<'_> {
    /// Nothing where there is no density, or no such texel.
    fn disk(&self, (which, place, error): Wanted) -> Option<Result<Disk>> {
        let size = self.lobes.size();
        if place.x >= size.width || place.y >= size.height {
            return None;
        }
        let lobes: Vec<(Lobe, f32)> = self.lobes.mixture(place.x, place.y).collect();
        let Subject { material, settings, .. } = self.subject;
        let most = settings.reading.most_texels.unwrap_or(usize::MAX).min(MOST_TEXELS);
        let reading = Reading { most_texels: Some(most), ..settings.reading };
        let (centre, half) = window(self.base, self.lobes, place, &lobes);
        // Of a lobe narrower than a cell, cell centres would see a part or nothing.
        let least = (2.0 * half / self.cells as f64) as f32;
        let widened = Widened { texels: *material, least };
        let truth = Footprint::of_texel(&widened, reading, settings.seed, self.level, (place.x, place.y));
        let truth = truth.disk(centre, half, self.cells);
        let seen = |&(lobe, weight): &(Lobe, f32)| {
            (Lobe { roughness: lobe.roughness.clamped(least * least, 1.0), ..lobe }, f64::from(weight))
        };
        let found = Footprint::of_lobes(&lobes.iter().map(seen).collect::<Vec<_>>()).disk(centre, half, self.cells);
        let peak = truth.iter().chain(&found).copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
        if peak <= 0.0 {
            return None;
        }
        let paint = |density: &Array2<f64>| {
            let shade = |d: f64| (1.0 + (d / peak).max(1e-30).log10() / DECADES) as f32;
            png(&heat(&density.mapv(shade), 1.0))
        };
        let span = |c: f64| format!("{:.2} to {:.2}", c - half, c + half);
        let pictures = paint(&truth).and_then(|truth| Ok((truth, paint(&found)?)));
        Some(pictures.map(|(truth, lobe)| Disk {
            which,
            truth,
            lobe,
            place: format!("column {}, row {}", place.x, place.y),
            figures: format!("lobe error {}, alpha {}", short(error), widths(&lobes)),
            window: format!("x {}, y {}", span(centre.0), span(centre.1)),
        }))
    }
}

/// Widths of lobes: "0.3", "0.3 and 0.1" of two widths, "0.3 (70 %), 0.1 (30 %)" of two lobes.
fn widths(lobes: &[(Lobe, f32)]) -> String {
    let one = |(lobe, weight): &(Lobe, f32)| {
        let axes = lobe.axes();
        let (wide, narrow) = (short(axes.alpha_x.0.into()), short(axes.alpha_y.0.into()));
        let alpha = if wide == narrow { wide } else { format!("{wide} and {narrow}") };
        if lobes.len() == 1 { alpha } else { format!("{alpha} ({:.0} %)", 100.0 * weight) }
    };
    lobes.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// A surface of which no lobe is narrower than `least` (alpha).
struct Widened<'a> {
    texels: &'a dyn Texels,
    least: f32,
}

impl Texels for Widened<'_> {
    fn size(&self) -> Size {
        self.texels.size()
    }

    fn normals(&self, y: usize, x: usize, out: [&mut [f32]; 3], coverage: &mut [f32]) {
        self.texels.normals(y, x, out, coverage);
    }

    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]) {
        self.texels.perceptual(y, x, out);
        // Tensors are derived from these, and widened by themselves.
        if !self.is_anisotropic() {
            let least = Alpha(self.least).perceptual().0;
            out.iter_mut().for_each(|r| *r = r.max(least));
        }
    }

    fn is_anisotropic(&self) -> bool {
        self.texels.is_anisotropic()
    }

    fn tensors(&self, y: usize, x: usize, perceptual: &[f32], [xx, xy, yy]: [&mut [f32]; 3]) {
        self.texels.tensors(y, x, perceptual, [&mut *xx, &mut *xy, &mut *yy]);
        for ((xx, xy), yy) in xx.iter_mut().zip(xy).zip(yy) {
            let wide = RoughnessTensor { xx: *xx, xy: *xy, yy: *yy }.clamped(self.least * self.least, 1.0);
            (*xx, *xy, *yy) = (wide.xx, wide.xy, wide.yy);
        }
    }
}

/// Centre and half width of a square that holds most of the normals under a texel and most of its lobes.
fn window(base: &Lobes, level: &Lobes, place: Place, lobes: &[(Lobe, f32)]) -> ((f64, f64), f64) {
    let (from, to) = (base.size(), level.size());
    let across = &spans(from.width, to.width)[place.x];
    let down = &spans(from.height, to.height)[place.y];
    let step = |n: usize| n.div_ceil(WINDOW_TEXELS).max(1);
    let mut around: Vec<(f64, f64, f64)> = Vec::new();
    let spot = |lobe: Lobe| {
        let alpha = f64::from(lobe.axes().alpha_x.0);
        (f64::from(lobe.normal.x), f64::from(lobe.normal.y), alpha)
    };
    for y in (0..down.weights.len()).step_by(step(down.weights.len())) {
        for x in (0..across.weights.len()).step_by(step(across.weights.len())) {
            around.push(spot(base.at(across.first + x, down.first + y)));
        }
    }
    let n = around.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64, f64)) -> f64| around.iter().map(f).sum::<f64>() / n;
    let (cx, cy) = (mean(&|s| s.0), mean(&|s| s.1));
    // Of the texels, spread and width together; of each lobe, its distance and width.
    let spread = mean(&|s| (s.0 - cx).powi(2) + (s.1 - cy).powi(2) + s.2 * s.2).sqrt();
    let far = |&(lobe, _): &(Lobe, f32)| {
        let (lx, ly, alpha) = spot(lobe);
        (lx - cx).hypot(ly - cy) + WIDTHS * alpha
    };
    let reach = lobes.iter().map(far).fold(WIDTHS * spread, f64::max);
    // There is nothing to see beyond the disk.
    let half = reach.clamp(0.02, 1.0);
    let inside = |c: f64| c.clamp(half - 1.0, 1.0 - half);
    ((inside(cx), inside(cy)), half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Interpolation;
    use glam::Vec3;

    /// 4 x 4 texels that lean to two sides, of alpha 0.0025.
    struct Mirrors;

    impl Texels for Mirrors {
        fn size(&self) -> Size {
            Size::new(4, 4)
        }

        fn normals(&self, _: usize, x: usize, [nx, ny, nz]: [&mut [f32]; 3], coverage: &mut [f32]) {
            for i in 0..nx.len() {
                let n = Vec3::new(if (x + i).is_multiple_of(2) { 0.5013 } else { -0.3007 }, 0.111, 1.0).normalize();
                (nx[i], ny[i], nz[i], coverage[i]) = (n.x, n.y, n.z, 1.0);
            }
        }

        fn perceptual(&self, _: usize, _: usize, out: &mut [f32]) {
            out.fill(0.05);
        }
    }

    /// Over all cells the density makes 1, wherever the lobes fall between the centres of cells.
    #[test]
    fn narrow_lobes_are_seen_whole() {
        const CELLS: usize = 48;
        let cell = 2.0 / CELLS as f64;
        let sum = |texels: &dyn Texels| {
            let reading = Reading { interpolation: Interpolation::Constant, ..Reading::default() };
            Footprint::of_texel(texels, reading, 1, 2, (0, 0)).disk((0.0, 0.0), 1.0, CELLS).sum() * cell * cell
        };
        let widened = sum(&Widened { texels: &Mirrors, least: cell as f32 });
        assert!((widened - 1.0).abs() < 0.05, "{widened}");
        assert!((sum(&Mirrors) - 1.0).abs() > 0.3, "{}", sum(&Mirrors));
    }
}
