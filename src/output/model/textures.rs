//! The folded textures of a model's material, as KTX 2.

use std::path::Path;
use std::sync::Mutex;

use rayon::prelude::*;
use serde::Serialize;

use super::ModelOptions;
use super::proofs::{Proof, Seen, proofs};
use crate::codec::texture::{TexelFormat, write_ktx2};
use crate::codec::write_png;
use crate::error::{Error, Result};
use crate::fold::{Chain, Options};
use crate::image::{Raster, Samples, Sides, Size, each_texel, from_rows};
use crate::material::{Encoding, Foldable, Inputs, MapFile, Material, Role, load_with, turn};
use crate::ndf::Form;
use crate::output::preset::Compress;
use crate::output::sheet::{Sheet, Source};
use crate::output::{ChangeTexel, Gain, Layer, Rows, fold_for, gain, texture_of};

/// Which texture of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Slot {
    /// `normalTexture`.
    Normal,
    /// `metallicRoughnessTexture`, and occlusion in the same image.
    Roughness,
    /// `anisotropyTexture`.
    Anisotropy,
}

impl Slot {
    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Roughness => "roughness",
            Self::Anisotropy => "anisotropy",
        }
    }
}

/// One folded texture.
pub struct Folded {
    /// What it is for.
    pub slot: Slot,
    /// A KTX 2 file.
    pub bytes: Vec<u8>,
    /// Level 0 as PNG, if that is among [`FoldedMaterial::pictures`].
    pub picture: Option<Vec<u8>>,
    /// Its texel format.
    pub format: TexelFormat,
    /// Of every channel that stems from an image.
    pub level_0: Vec<Proof>,
}

/// Why a material stays as it is.
#[derive(Clone, Debug)]
pub struct Left {
    /// In words.
    pub reason: String,
    /// Whether that was asked for, and so nothing to wonder about.
    pub plain: bool,
}

/// A material that was folded, or can be.
pub struct FoldedMaterial {
    /// Of level 0; unknown before it is read.
    pub size: Option<Size>,
    /// Without pictures in a dry run.
    pub textures: Vec<Folded>,
    /// Which textures there are, or will be.
    pub slots: Vec<Slot>,
    /// Those of them that get another picture as their fallback, for the old one, if there is any, does not fit what the
    /// material says then; before the work all that might.
    pub pictures: Vec<Slot>,
    /// How far it is from plain mips; unknown in a dry run.
    pub gain: Option<Gain>,
    /// Whether `roughnessFactor` stays; else it is in the texture, and 1 in the file.
    pub keeps_factor: bool,
    /// Whether `anisotropyStrength` stays, likewise.
    pub keeps_strength: bool,
    /// What was understood, ignored or assumed.
    pub notes: Vec<String>,
    /// What is probably wrong with the input.
    pub warnings: Vec<String>,
}

impl FoldedMaterial {
    /// What a material will be folded to, as far as that is known before it is read; or why it stays as it is: there is no
    /// form that its anisotropy would survive in.
    pub fn planned(foldable: &Foldable, options: &ModelOptions) -> std::result::Result<Self, Left> {
        let lost = |why: String| {
            let reason = format!("its anisotropy (KHR_materials_anisotropy) needs two widths, and {why}");
            Err(Left { reason, plain: false })
        };
        let fold = options.fold.fold;
        let form = match (foldable.anisotropy.is_some(), options.form) {
            (true, Some(Form::Isotropic)) => return lost("lobes of one were asked for (iso)".into()),
            (true, None) if !fold.has_two_widths() => return lost(format!("the fold {} has one", fold.name)),
            (true, None) => Form::Anisotropic,
            (_, form) => form.unwrap_or(Form::Isotropic),
        };
        let mut slots = vec![Slot::Normal, Slot::Roughness];
        slots.extend((form == Form::Anisotropic).then_some(Slot::Anisotropy));
        let fits = |slot: &Slot| match slot {
            Slot::Normal => true,
            Slot::Roughness => foldable.roughness.is_some() && foldable.factor == 1.0,
            Slot::Anisotropy => foldable.anisotropy.as_ref().is_some_and(|a| a.texture.is_some() && a.strength == 1.0),
        };
        let pictures = slots.iter().copied().filter(|slot| options.fallback && !fits(slot)).collect();
        Ok(Self {
            size: None,
            textures: Vec::new(),
            slots,
            pictures,
            gain: None,
            keeps_factor: true,
            keeps_strength: true,
            notes: Vec::new(),
            warnings: Vec::new(),
        })
    }

    fn form(&self) -> Form {
        if self.slots.contains(&Slot::Anisotropy) { Form::Anisotropic } else { Form::Isotropic }
    }
}

/// What is done to the channels of every texel on their way into a texture.
type Change = Box<dyn Fn(&mut [f32]) + Sync>;

/// Reads and folds a material, or says why it stays as it is: its maps cannot be read or are no material, they have
/// anisotropy that would be lost, or folding gains too little. A dry run reads it only.
///
/// # Errors
/// Sides that no compressed texture has; Zstandard that does not unpack to what it was made of.
pub fn fold_material(
    foldable: &Foldable,
    options: &ModelOptions,
    dry_run: bool,
    done: &(dyn Fn(f64) + Sync),
) -> Result<std::result::Result<FoldedMaterial, Left>> {
    let mut folded = match FoldedMaterial::planned(foldable, options) {
        Ok(planned) => planned,
        Err(left) => return Ok(Err(left)),
    };
    let seen: Mutex<Vec<Seen>> = Mutex::default();
    // Each picture is decoded once, and gone when it is a map of the material.
    let read = |path: &Path| {
        let mut decoded = foldable.picture(path)?;
        if decoded.bytes_len > 0 {
            seen.lock().expect("no reader panics").push(Seen::new(path, &decoded.raster));
        }
        foldable.apply_factors(path, &mut decoded);
        Ok(decoded)
    };
    let inputs = Inputs { sides: options.sides, ..foldable.inputs.clone() };
    let mut material = match load_with(&inputs, &read) {
        Ok(material) => material,
        Err(error) => return Ok(Err(Left { reason: error.to_string(), plain: false })),
    };
    let seen = seen.into_inner().expect("no reader panics");
    check_sides(&inputs, material.size)?;
    if folded.form() == Form::Anisotropic {
        material.ensure_anisotropy_map();
    }
    // A model leaves no choice there.
    material.notes.retain(|note| !note.starts_with("even anisotropy") && !note.starts_with("normal map read as"));
    if foldable.wraps_differ && seen.iter().any(|seen| seen.size != material.size) {
        material.warnings.push("its sampler wraps u and v differently; maps are enlarged as if both were u".into());
    }
    folded.size = Some(material.size);
    if !dry_run {
        let options_here = Options { form: folded.form(), ..options.fold };
        let chain = fold_for(&material, &options_here, &[], &|share| done(0.5 * share));
        let gain = gain(&chain);
        if options.skip_if_below.is_some_and(|least| gain.roughness < least) {
            return Ok(Err(Left { reason: gain.describe(), plain: true }));
        }
        folded.gain = Some(gain);
        write_textures(foldable, options, &mut material, &chain, &seen, &mut folded)?;
        done(1.0);
    }
    (folded.notes, folded.warnings) = (material.notes, material.warnings);
    Ok(Ok(folded))
}

/// Refuses a material, before the work, whose sides will be none that compressed textures have. Headers of pictures are
/// believed if they tell of other sides; else the material is read, for it may stay as it is.
///
/// # Errors
/// As [`fold_material`].
pub fn check_early(foldable: &Foldable, options: &ModelOptions) -> Result<()> {
    match foldable.size() {
        Some(size) if !Sides::MultipleOf4.holds(options.sides.fit(size)) => {
            fold_material(foldable, options, true, &|_| {}).map(drop)
        }
        _ => Ok(()),
    }
}

fn check_sides(inputs: &Inputs, size: Size) -> Result<()> {
    if Sides::MultipleOf4.holds(size) {
        return Ok(());
    }
    let path = inputs.normal.as_deref().unwrap_or(Path::new(""));
    let expected = "sides that are multiples of 4, since texels are compressed in blocks of 4x4; --resize 4 enlarges";
    Err(Error::unsupported(path, format!("a texture of {size} texels"), expected))
}

fn write_textures(
    foldable: &Foldable,
    options: &ModelOptions,
    material: &mut Material,
    chain: &Chain,
    seen: &[Seen],
    folded: &mut FoldedMaterial,
) -> Result<()> {
    let notes = &mut Vec::new();
    let sheets: Vec<Sheet> = folded.slots.iter().map(|slot| sheet(material, *slot)).collect();
    for (i, slot) in folded.slots.clone().into_iter().enumerate() {
        let rows = Rows { material, chain, sheets: &sheets, layer: Layer::Sheet(i), flipped: false };
        let format = texel_format(options.compress, slot);
        let mut change: Change = Box::new(|_| ());
        match (slot, &foldable.anisotropy) {
            (Slot::Roughness, _) => {
                let (factor, largest) = (foldable.factor, largest(&rows, 1));
                folded.keeps_factor = factor == 1.0 || foldable.roughness.is_some() && fits(largest, factor);
                if folded.keeps_factor && factor != 1.0 {
                    change = Box::new(move |texel| texel[1] = (texel[1] / factor).min(1.0));
                } else if !folded.keeps_factor && foldable.roughness.is_some() {
                    notes.push(format!(
                        "roughnessFactor {factor} is multiplied into the texture and set to 1: folded roughness goes up to \
                         {largest:.3}"
                    ));
                } else if foldable.roughness.is_none() {
                    notes.push(format!(
                        "no roughness texture: one is added, {factor} at level 0, metal left to metallicFactor"
                    ));
                }
            }
            (Slot::Anisotropy, Some(anisotropy)) => {
                let (strength, rotation, largest) = (anisotropy.strength, anisotropy.rotation, largest(&rows, 2));
                folded.keeps_strength = anisotropy.texture.is_some() && fits(largest, strength);
                if !folded.keeps_strength {
                    notes.push(format!("anisotropyStrength {strength} is multiplied into the texture and set to 1"));
                }
                let divisor = if folded.keeps_strength { strength } else { 1.0 };
                if (divisor, rotation) != (1.0, 0.0) {
                    change = Box::new(move |texel| {
                        turn(texel, -rotation);
                        texel[2] = (texel[2] / divisor).min(1.0);
                    });
                }
            }
            (Slot::Anisotropy, None) => folded.keeps_strength = false,
            (Slot::Normal, _) => {}
        }
        let changed: Option<ChangeTexel> = if slot == Slot::Normal { None } else { Some(&change) };
        let texture = texture_of(&rows, format, options.effort, changed);
        let mut bytes = Vec::new();
        write_ktx2(&mut bytes, &texture, Some(options.effort)).map_err(|error| {
            let subject = format!("{}: the folded {slot:?} texture", material.name);
            Error::invalid_option(subject, error.to_string(), "Zstandard data that unpacks to what it is made of")
        })?;
        let kept = match slot {
            Slot::Normal => true,
            Slot::Roughness => folded.keeps_factor && foldable.roughness.is_some(),
            Slot::Anisotropy => folded.keeps_strength,
        };
        folded.pictures.retain(|other| *other != slot || !kept);
        let picture = folded.pictures.contains(&slot).then(|| level_0_png(&rows, &change));
        let level_0 = proofs(&rows, &sheets[i], seen, &change);
        folded.textures.push(Folded { slot, bytes, picture, format, level_0 });
    }
    material.notes.append(notes);
    Ok(())
}

/// Level 0 in 8 bit, as the renderer reads it with the new factors.
fn level_0_png(rows: &Rows, change: ChangeTexel) -> Vec<u8> {
    let read = |channel: usize, y: usize, row: &mut [f32]| rows.row(0, channel, Encoding::Unsigned, y, 0, row);
    let mut values = from_rows(rows.size(0), 3, read);
    each_texel(&mut values, change);
    let mut bytes = Vec::new();
    let samples = Samples::U8(values.mapv(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8));
    write_png(&mut bytes, &Raster::new(samples)).expect("memory takes everything");
    bytes
}

/// Whether what goes up to `largest` can be written under a factor. The folded values of a flat map are those of level 0,
/// but for rounding.
fn fits(largest: f32, factor: f32) -> bool {
    factor > 0.0 && largest <= factor * (1.0 + 1e-5)
}

/// Red, green and blue as glTF has them.
fn sheet(material: &Material, slot: Slot) -> Sheet {
    let role = match slot {
        Slot::Normal => Role::NormalX,
        Slot::Roughness => Role::Roughness,
        Slot::Anisotropy => Role::AnisotropyX,
    };
    let of = |file: &MapFile| file.channel(role).is_some();
    let map = material.maps.iter().position(of).expect("a material has its maps");
    let count = material.maps[map].roles.len();
    let own = |channel| Source::Channel { map, channel, inverted: false };
    let sources = match (slot, count) {
        (Slot::Normal, 2) => [own(0), own(1), Source::NormalZ { map }],
        (Slot::Roughness, 1) => [Source::Constant(1.0), own(0), Source::Constant(1.0)],
        _ => [own(0), own(1), own(2)],
    };
    Sheet::arranged(material.maps[map].stem.clone(), &sources)
}

fn texel_format(compress: Compress, slot: Slot) -> TexelFormat {
    match (compress, slot) {
        (Compress::Uastc, _) => TexelFormat::Uastc,
        (Compress::Bc, Slot::Normal) => TexelFormat::Bc5,
        (Compress::Bc, _) => TexelFormat::Bc7,
        (Compress::None, _) => TexelFormat::Rgba8,
    }
}

/// The largest value of a channel at any level.
fn largest(rows: &Rows, channel: usize) -> f32 {
    let of_row = |level: usize, y: usize| {
        let mut row = vec![0.0; rows.size(level).width];
        rows.row(level, channel, Encoding::Unsigned, y, 0, &mut row);
        row.into_iter().fold(0.0, f32::max)
    };
    let of_level =
        |level: usize| (0..rows.size(level).height).into_par_iter().map(|y| of_row(level, y)).reduce(|| 0.0, f32::max);
    (0..rows.levels()).map(of_level).fold(0.0, f32::max)
}
