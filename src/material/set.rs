//! The files of one common name, and the part that each plays. Nothing is guessed between two candidates: that is an
//! error that lists them and names the flag.

use std::path::{Path, PathBuf};

use super::detect::PassedOver;
use super::names::{Kind, Kind::*, Layout, MASK_MAP, Tile, common_name};
use super::{ChannelRef, Inputs, NormalY, RoughnessInput, same_path};
use crate::codec;
use crate::error::{Error, Result};
use crate::image::Wrap;

/// What is known of a material without its names.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// Convention of a normal map whose name does not tell.
    pub normal_y: NormalY,
    /// Whether the normal map is given, and none is looked for.
    pub normal: bool,
    /// Likewise the roughness or smoothness.
    pub width: bool,
    /// Likewise the anisotropy.
    pub anisotropy: bool,
    /// Likewise the height map.
    pub height: bool,
}

/// A file that may play a part.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub kind: Kind,
    pub file: ChannelRef,
    /// What decided, as it stands in the name.
    pub word: String,
}

/// The files of a folder that share a name: a material, if there is something to fold.
#[derive(Clone, Debug)]
pub struct TextureSet {
    /// The common name, or that of the folder; tiles have theirs at the end.
    pub name: String,
    /// The same without the tile.
    pub base: String,
    /// The tile, of a texture that is cut into several.
    pub tile: Option<Tile>,
    /// Where the files are.
    pub folder: PathBuf,
    /// The same, below the folder that was looked through.
    pub below: PathBuf,
    pub(super) files: Vec<Candidate>,
}

/// A map of a material, as its files were understood.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedMap {
    /// `normal`, `roughness`, `smoothness`, `occlusion`, `metal`, `anisotropy` or `height`.
    pub role: &'static str,
    /// The picture.
    pub path: PathBuf,
    /// The channel, where it is a part of a packed map or was named.
    pub channel: Option<usize>,
    /// The word in the name that decided; none where an option did.
    pub word: Option<String>,
}

impl TextureSet {
    /// Path of the material below the folder that was looked through: its folder's, if it is called like that, else its own
    /// below it.
    pub fn place(&self) -> PathBuf {
        let folder = self.below.file_name().unwrap_or_default().to_string_lossy();
        let as_folder = !folder.is_empty() && common_name(&self.base) == common_name(&folder);
        if as_folder && self.tile.is_none() { self.below.clone() } else { self.below.join(&self.name) }
    }

    /// The only file that `wanted` accepts, if there is one; two are an error.
    fn one(&self, what: &str, flag: &str, wanted: impl Fn(Kind) -> bool) -> Result<Option<&Candidate>> {
        let found: Vec<_> = self.files.iter().filter(|c| wanted(c.kind)).collect();
        match found[..] {
            [] => Ok(None),
            [only] => Ok(Some(only)),
            _ => {
                let names: Vec<_> = found.iter().map(|c| file_name(&c.file.path)).collect();
                let alone = if ["--roughness", "--smoothness"].contains(&flag) { "" } else { " without the folder" };
                let found = format!("{} candidates for the {what} map: {}", names.len(), names.join(", "));
                let expected = format!("one; choose with {flag} FILE{alone}, or in mipfold.toml");
                Err(Error::invalid(&self.folder, found, expected))
            }
        }
    }

    fn any(&self, wanted: impl Fn(Kind) -> bool) -> bool {
        self.files.iter().any(|c| wanted(c.kind))
    }

    /// What the material is made from; `None` if there is nothing to fold.
    ///
    /// # Errors
    /// Several files for one part.
    pub fn inputs(&self, given: &Given) -> Result<Option<Inputs>> {
        let mut inputs = Inputs { name: self.name.clone(), normal_y: given.normal_y, ..Inputs::default() };
        if !given.normal {
            self.find_normal(given.normal_y, &mut inputs)?;
        }
        if !given.width {
            let bumpy = inputs.normal.is_some() || given.normal || given.height || self.any(|k| k == Height);
            inputs.roughness = self.roughness(bumpy, &mut inputs.notes)?;
        }
        let path = |found: Option<&Candidate>| found.map(|c| c.file.path.clone());
        if !given.anisotropy {
            inputs.anisotropy = path(self.one("anisotropy", "--anisotropy", |k| k == Anisotropy)?);
        }
        if inputs.normal.is_none() && !given.normal && !given.height {
            inputs.height = path(self.one("height", "--height", |k| k == Height)?);
        }
        let found = inputs.normal.is_some() || inputs.height.is_some() || inputs.roughness != RoughnessInput::Missing;
        if !found && !given.normal && !given.height {
            return Ok(None);
        }
        inputs.occlusion = self.beside("occlusion", Occlusion, |layout| layout.occlusion, &mut inputs);
        inputs.metal = self.beside("metal", Metal, |layout| layout.metal, &mut inputs);
        if self.tile.is_some() {
            inputs.wrap = Wrap::Clamp;
        }
        Ok(Some(inputs))
    }

    /// Of maps in both conventions the one that is wanted; an unmarked map stands for the wanted one.
    fn find_normal(&self, want: NormalY, inputs: &mut Inputs) -> Result<()> {
        let other = if want == NormalY::OpenGl { NormalY::DirectX } else { NormalY::OpenGl };
        let wanted: [&dyn Fn(Kind) -> bool; 3] =
            [&|k| k == Normal(Some(want)), &|k| k == Normal(None) || k == NormalRoughness, &|k| {
                k == Normal(Some(other))
            }];
        let Some(best) = wanted.iter().position(|wanted| self.any(wanted)) else { return Ok(()) };
        let Some(found) = self.one("normal", "--normal", wanted[best])? else { return Ok(()) };
        if best == 2 {
            inputs.normal_y = other;
            inputs.notes.push(format!("the normal map's name says {}", other.describe()));
        }
        if wanted.iter().filter(|wanted| self.any(wanted)).count() > 1 {
            let file = file_name(&found.file.path);
            inputs.notes.push(format!("several normal maps: {file} taken as {}", want.describe()));
        }
        inputs.normal = Some(found.file.path.clone());
        Ok(())
    }

    /// A roughness map before a packed one, a packed one before smoothness, and, of a surface with bumps, that before what
    /// may be a mask map.
    fn roughness(&self, bumpy: bool, notes: &mut Vec<String>) -> Result<RoughnessInput> {
        type Wanted = fn(Kind) -> bool;
        let kinds: [(&str, Wanted); 5] = [
            ("roughness", |k| k == Roughness),
            ("roughness", |k| k == NormalRoughness),
            ("packed", |k| matches!(k, Packed(Layout { smooth: false, .. }))),
            ("smoothness", |k| k == Smoothness),
            ("packed smoothness", |k| matches!(k, Packed(Layout { smooth: true, .. }))),
        ];
        for (what, wanted) in kinds {
            let smooth = what.ends_with("smoothness");
            let flag = if smooth { "--smoothness" } else { "--roughness" };
            let Some(Candidate { kind, file, .. }) = self.one(what, flag, wanted)? else { continue };
            let channel = file.channel.or(match kind {
                NormalRoughness => Some(3),
                Packed(layout) => Some(layout.width),
                _ => None,
            });
            let file = ChannelRef { path: file.path.clone(), channel };
            return Ok(if smooth { RoughnessInput::Smoothness(file) } else { RoughnessInput::Roughness(file) });
        }
        // The name alone does not tell Unity's mask maps from others.
        let masks = self.files.iter().filter(|c| bumpy && c.kind == Mask && has_alpha(&c.file.path));
        let masks: Vec<_> = masks.collect();
        if let ([mask], Packed(layout)) = (&masks[..], MASK_MAP) {
            let name = file_name(&mask.file.path);
            notes.push(format!("{name} has an alpha channel: taken as Unity's mask map (--smoothness names another)"));
            let file = ChannelRef { path: mask.file.path.clone(), channel: Some(layout.width) };
            return Ok(RoughnessInput::Smoothness(file));
        }
        Ok(RoughnessInput::Missing)
    }

    /// What is not folded: the only file of its own, or else a channel of the packed map that is used or the only one.
    fn beside(
        &self,
        what: &str,
        kind: Kind,
        channel: impl Fn(Layout) -> Option<usize>,
        inputs: &mut Inputs,
    ) -> Option<ChannelRef> {
        let own: Vec<_> = self.files.iter().filter(|c| c.kind == kind).collect();
        match own[..] {
            [only] => return Some(only.file.clone()),
            [_, ..] => {
                let names: Vec<_> = own.iter().map(|c| file_name(&c.file.path)).collect();
                inputs.notes.push(format!("several {what} maps, of which none is taken: {}", names.join(", ")));
                return None;
            }
            [] => {}
        }
        let used = inputs.roughness.file();
        let packed = |c: &&Candidate| match c.kind {
            Packed(layout) => Some(layout),
            Mask if used == Some(c.file.path.as_path()) => match MASK_MAP {
                Packed(layout) => Some(layout),
                _ => None,
            },
            _ => None,
        };
        let holds: Vec<_> = self.files.iter().filter_map(|c| Some((&c.file.path, channel(packed(&c)?)?))).collect();
        let of_used = holds.iter().find(|(path, _)| Some(path.as_path()) == used);
        let (path, channel) = of_used.or(if holds.len() == 1 { holds.first() } else { None })?;
        Some(ChannelRef { path: (*path).clone(), channel: Some(*channel) })
    }

    /// The maps of a material that was made from this set, and what decided.
    pub fn maps(&self, inputs: &Inputs) -> Vec<NamedMap> {
        let mut maps = named_maps(inputs);
        for map in &mut maps {
            let found = self.files.iter().find(|c| same_path(&c.file.path, &map.path));
            map.word = found.filter(|c| plays(c.kind, map.role)).map(|c| c.word.clone());
        }
        maps
    }

    /// The files that are not used, of a set that became a material or of one that did not.
    pub fn passed_over(&self, inputs: Option<&Inputs>) -> Vec<PassedOver> {
        let used = inputs.map(named_maps).unwrap_or_default();
        let unused = self.files.iter().filter(|c| !used.iter().any(|map| same_path(&map.path, &c.file.path)));
        unused.map(|c| PassedOver { path: c.file.path.clone(), why: why(c.kind, inputs) }).collect()
    }
}

/// The maps of a material, without what decided.
pub fn named_maps(inputs: &Inputs) -> Vec<NamedMap> {
    let width = match &inputs.roughness {
        RoughnessInput::Roughness(file) => Some(("roughness", file.clone())),
        RoughnessInput::Smoothness(file) => Some(("smoothness", file.clone())),
        RoughnessInput::Missing | RoughnessInput::Constant(_) => None,
    };
    let whole = |path: &Option<PathBuf>| path.clone().map(|path| ChannelRef { path, channel: None });
    let height = if inputs.normal.is_none() { whole(&inputs.height) } else { None };
    let maps = [
        whole(&inputs.normal).map(|file| ("normal", file)),
        height.map(|file| ("height", file)),
        width,
        inputs.occlusion.clone().map(|file| ("occlusion", file)),
        inputs.metal.clone().map(|file| ("metal", file)),
        whole(&inputs.anisotropy).map(|file| ("anisotropy", file)),
    ];
    let named = |(role, ChannelRef { path, channel })| NamedMap { role, path, channel, word: None };
    maps.into_iter().flatten().map(named).collect()
}

/// Whether a name that says this can have decided for a role.
fn plays(kind: Kind, role: &str) -> bool {
    match role {
        "normal" => matches!(kind, Normal(_) | NormalRoughness),
        "height" => kind == Height,
        "roughness" => matches!(kind, Roughness | NormalRoughness | Packed(Layout { smooth: false, .. })),
        "smoothness" => matches!(kind, Smoothness | Mask | Packed(Layout { smooth: true, .. })),
        "anisotropy" => kind == Anisotropy,
        "occlusion" => matches!(kind, Occlusion | Packed(_) | Mask),
        _ => matches!(kind, Metal | Packed(_) | Mask),
    }
}

/// Why a file is passed over.
fn why(kind: Kind, inputs: Option<&Inputs>) -> String {
    let what = match kind {
        Ignored(what) => return format!("{what}, nothing to fold"),
        Normal(_) => "a normal map",
        Roughness => "roughness",
        Smoothness => "smoothness",
        Packed(_) => "a packed map",
        Mask => "a mask",
        NormalRoughness => "normals and roughness",
        Anisotropy => "anisotropy",
        Height => "height",
        Occlusion => "occlusion",
        Metal => "metal",
    };
    match inputs {
        None => format!("{what}, without a normal map of its name"),
        Some(inputs) if kind == Height && inputs.normal.is_some() => "height, not needed beside a normal map".into(),
        Some(_) if kind == Mask => "a mask; if it holds smoothness, --smoothness FILE:a names it".into(),
        Some(_) => format!("{what}, for which another was taken or given"),
    }
}

fn has_alpha(path: &Path) -> bool {
    codec::read(path).is_ok_and(|decoded| decoded.raster.channels.len() >= 4)
}

pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
