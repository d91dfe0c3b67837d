//! Marks of JPEG: jumps at the borders of 8 x 8 blocks.
//!
//! Quantised blocks do not meet (Wallace 1991). Each border is compared with the seven places around it, and the borders of
//! a picture vote, so that neither rough surfaces nor a few strong edges are taken for blocks.

use super::subject::bands;
use super::{Check, Finding, Picture, Severity, Subject, percent};
use crate::image::Raster;
use crate::material::Role;

/// Blocks.
pub const CHECK: Check = Check { name: "jpeg", about: "jumps at the borders of 8 x 8 blocks, also in PNGs", run };

/// Jumps along one axis at the borders of blocks against those around them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocks {
    /// Jump at a border over the mean of the seven places around it: the median over borders, so that a few joints and
    /// edges that lie on borders do not count.
    pub ratio: f64,
    /// Share of the borders with a larger jump than any of those seven; 1/8 by chance.
    pub peaks: f64,
    /// How far that is from chance, in its standard deviations.
    pub deviations: f64,
    /// The same for the least of four classes: each takes every fourth border. Joints of tiles and other features in steps
    /// of 16 or 32 texels leave some classes to chance, blocks do not.
    pub evenly: f64,
    /// Column or row, 0 to 7, of the borders: 0 unless the picture was cut after compression.
    pub phase: usize,
}

/// Texels of a block.
const BLOCK: usize = 8;

/// Blocks of one channel, along x and along y; none if the picture is too small to tell.
pub fn blocks(raster: &Raster, channel: usize) -> Option<[Blocks; 2]> {
    let size = raster.size();
    let width = size.width;
    let parts = bands(size.height, |rows| {
        let mut columns = vec![0.0f64; width];
        let mut along_y = Vec::with_capacity(rows.len());
        let mut ring: [Vec<f32>; 4] = std::array::from_fn(|_| vec![0.0; width]);
        for y in rows {
            for (i, row) in ring.iter_mut().enumerate() {
                raster.read(channel, (y + i).saturating_sub(2).min(size.height - 1), 0, row);
            }
            let [before2, before, here, after] = &ring;
            for x in 2..width.saturating_sub(1) {
                columns[x] += f64::from(jump(here[x - 2], here[x - 1], here[x], here[x + 1]));
            }
            let inside = y >= 2 && y + 1 < size.height;
            let row = (0..width).map(|x| f64::from(jump(before2[x], before[x], here[x], after[x]))).sum::<f64>();
            along_y.push(if inside { row } else { 0.0 });
        }
        (columns, along_y)
    });
    let mut columns = vec![0.0; width];
    let mut rows = Vec::with_capacity(size.height);
    for (part, along_y) in parts {
        columns.iter_mut().zip(part).for_each(|(all, jump)| *all += jump);
        rows.extend(along_y);
    }
    Some([axis(&columns)?, axis(&rows)?])
}

/// The phase whose places are peaks most often.
fn axis(jumps: &[f64]) -> Option<Blocks> {
    let of = |phase: usize| {
        let places = (0..).map(|i| phase + i * BLOCK).skip_while(|x| *x < 6).take_while(|x| x + 6 <= jumps.len());
        let mut ratios: Vec<f64> = Vec::new();
        let mut classes = [[0.0f64; 2]; CLASSES];
        for x in places {
            let around = || (x - 4..x + 4).filter(|other| *other != x).map(|other| jumps[other]);
            let mean = around().sum::<f64>() / 7.0;
            if mean > 0.0 {
                let peak = around().all(|other| jumps[x] > other);
                let [borders, peaks] = &mut classes[x / BLOCK % CLASSES];
                *borders += 1.0;
                *peaks += f64::from(u8::from(peak));
                ratios.push(jumps[x] / mean);
            }
        }
        let middle = ratios.len() / 2;
        if ratios.len() < FEWEST || classes.iter().any(|[borders, _]| *borders == 0.0) {
            return None;
        }
        let ratio = *ratios.select_nth_unstable_by(middle, f64::total_cmp).1;
        let deviations =
            |borders: f64, peaks: f64| (peaks / borders - CHANCE) / (CHANCE * (1.0 - CHANCE) / borders).sqrt();
        let [borders, peaks] = classes.iter().fold([0.0; 2], |all, class| [all[0] + class[0], all[1] + class[1]]);
        Some(Blocks {
            ratio,
            peaks: peaks / borders,
            deviations: deviations(borders, peaks),
            evenly: classes.iter().map(|[borders, peaks]| deviations(*borders, *peaks)).fold(f64::INFINITY, f64::min),
            phase,
        })
    };
    let phases: Option<Vec<Blocks>> = (0..BLOCK).map(of).collect();
    phases?.into_iter().max_by(|a, b| a.evenly.total_cmp(&b.evenly).then(a.peaks.total_cmp(&b.peaks)))
}

/// Share of peaks where all eight places are alike.
const CHANCE: f64 = 1.0 / BLOCK as f64;

/// See [`Blocks::evenly`].
const CLASSES: usize = 4;

/// Borders from which chance can be told from blocks.
const FEWEST: usize = 12;

/// How far the texels on both sides of a border are from going on smoothly over it, with those inside their sides: a third
/// difference, 0 for slopes and even curves. Large ones count alike, for they are features.
fn jump(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let jump = (a - 3.0 * b + 3.0 * c - d).abs();
    if jump.is_finite() { jump / (jump + LARGE) } else { 0.0 }
}

/// Ten 8-bit steps.
const LARGE: f32 = 10.0 / 255.0;

/// Deviations from chance along both axes. Of about 150 channels of real maps that show no blocks, none passes 3.5 along both
/// but a perforated metal sheet (copper_tiles), whose channels disagree about the phase.
const DEVIATIONS: f64 = 4.0;

/// Jumps over those around, the mean of both axes, from which blocks are seen in a highlight: roughness of the knit (1.7)
/// and of the woven cloth (1.3) have visible squares, good JPEG normals (1.02 to 1.12) have none.
const SEEN: f64 = 1.25;

fn run(subject: &Subject) -> Vec<Finding> {
    subject.pictures.iter().chain(&subject.height).filter_map(in_picture).collect()
}

fn in_picture(picture: &Picture) -> Option<Finding> {
    let colours = picture.raster.channels.len().min(3);
    // What the fold reads; all of a height map. Gray stored as colour is looked at once.
    let alike = picture.roles.iter().filter(|role| matches!(role, Role::Roughness | Role::Smoothness)).count() == 3;
    let read = |channel: &usize| picture.roles.get(*channel).is_none_or(|role| !matches!(role, Role::Other(_)));
    let channels = if alike || picture.roles.is_empty() { 1 } else { colours };
    let found: Vec<[Blocks; 2]> =
        (0..channels).filter(read).map(|channel| blocks(&picture.raster, channel)).collect::<Option<_>>()?;
    let strongest = found.iter().max_by(|a, b| weaker(a).total_cmp(&weaker(b)))?;
    let phases = strongest.map(|blocks| blocks.phase);
    // Blocks of one picture begin at the same place in all channels that show them; those at odd places must show twice.
    let agreeing =
        found.iter().filter(|blocks| blocks.map(|b| b.phase) == phases && weaker(blocks) > DEVIATIONS).count();
    let disagree = found.iter().any(|blocks| blocks.map(|b| b.phase) != phases && weaker(blocks) > DEVIATIONS);
    let certain = phases == [0, 0] || agreeing >= 2 || weaker(strongest) > 4.0 * DEVIATIONS;
    if agreeing == 0 || disagree || !certain {
        return None;
    }
    let ratio = 0.5 * (strongest[0].ratio + strongest[1].ratio);
    let peaks = 0.5 * (strongest[0].peaks + strongest[1].peaks);
    let [x, y] = phases;
    let place = if phases == [0, 0] { String::new() } else { format!(", beginning at column {x}, row {y}") };
    let jpeg = picture.format == "JPEG";
    let origin = if jpeg { "" } else { ": it was a JPEG once" };
    Some(Finding {
        check: CHECK.name,
        severity: if ratio < SEEN { Severity::Note } else { Severity::Warning },
        map: picture.file.clone(),
        channel: None,
        evidence: format!(
            "8 x 8 blocks{place}: values jump {ratio:.2} times as far at their borders as around them, and furthest there in \
             {} of the borders (13 % by chance){origin}",
            percent(peaks)
        ),
        confidence: (0.6 + 0.5 * peaks).min(0.98),
        fix: "export it again without loss (PNG, TIFF, EXR) from the source; mips spread blocks, and the fold takes their \
              steps for roughness"
            .into(),
    })
}

/// Deviations along the axis that shows blocks less; a quarter of the borders has half of those of all.
fn weaker(blocks: &[Blocks; 2]) -> f64 {
    let along = |blocks: &Blocks| blocks.deviations.min(2.0 * blocks.evenly);
    along(&blocks[0]).min(along(&blocks[1]))
}
