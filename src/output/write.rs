//! Writing a plan.

use std::io::Write;

use rayon::prelude::*;

use super::exr::{write_lobes, write_moments};
use super::layer::Layer;
use super::manifest::Manifest;
use super::plan::{self, Content, Format, Plan, Request};
use super::stage::may_build_alone;
use super::texture::texture_of;
use super::{MANIFEST, Stage, stale};
use crate::codec::texture::{write_dds, write_dds9, write_ktx2};
use crate::codec::write_png;
use crate::error::{Error, Result};
use crate::fold::{Chain, Options};
use crate::material::{Extra, MapFile, Material, Origin};

/// Writes all files of a plan and the manifest, side by side. None appears before all are written; then each is renamed
/// into its place; `done` is called after each.
///
/// # Errors
/// Whatever the system refuses, and outputs that would replace an input or a stranger's file.
pub fn write(
    material: &Material,
    chain: &Chain,
    options: &Options,
    plan: &Plan,
    request: &Request,
    done: &(dyn Fn() + Sync),
) -> Result<()> {
    write_with(material, chain, options, plan, request, &[], done)
}

/// [`write()`], with the files of [`Request::pictures`] beside the maps.
///
/// # Errors
/// As [`write()`]; and another number of pictures than names.
pub fn write_with(
    material: &Material,
    chain: &Chain,
    options: &Options,
    plan: &Plan,
    request: &Request,
    pictures: &[Vec<u8>],
    done: &(dyn Fn() + Sync),
) -> Result<()> {
    if pictures.len() != request.pictures.len() {
        let expected = format!("{}, one for each name", request.pictures.len());
        return Err(Error::invalid_option("pictures", pictures.len().to_string(), expected));
    }
    plan.check(material, request)?;
    if request.extras.contains(&Extra::Curvature) && material.mesh.is_none() {
        return Err(Error::invalid_option("curvature map", "no mesh", "a material with a baked mesh"));
    }
    if request.extras.contains(&Extra::Flakes) && material.flakes.as_ref().is_none_or(|flakes| flakes.levels.is_empty())
    {
        return Err(Error::invalid_option("map of flakes", "none", "a material with maps of its flakes"));
    }
    let names: Vec<&str> = plan.outputs.iter().map(|output| output.name.as_str()).collect();
    let stage = Stage::new(&request.folder)?;
    plan.outputs.par_iter().try_for_each(|output| {
        let rows = |layer| plan.rows(material, chain, request, layer);
        stage.write(&output.name, |out| match output.content {
            Content::Level { layer, level } => match level_0_file(material, plan, layer, level) {
                Some(bytes) => out.write_all(bytes),
                None => write_png(out, &rows(layer).raster(level)),
            },
            Content::Levels { layer, format: Format::Exr } => rows(layer).write_exr(out, request.depth),
            Content::Levels { layer, format } => {
                let rows = rows(layer);
                let texels = request.texels(&rows, format);
                let texture = texture_of(&rows, texels, request.effort, None);
                match format {
                    Format::Ktx2 => write_ktx2(out, &texture, Some(request.effort)),
                    _ if request.dds9 => write_dds9(out, &texture),
                    _ => write_dds(out, &texture),
                }
            }
            Content::Lobes => write_lobes(out, material, chain),
            Content::Moments => write_moments(out, material, chain, request.normal_y(material)),
            Content::Picture { index } => out.write_all(&pictures[index]),
            Content::Aside { index } => out.write_all(plan.asides[index].text.as_bytes()),
        })?;
        done();
        Ok(())
    })?;
    let manifest = Manifest::new(material, chain, options, plan, request, stage.digests());
    let text = serde_json::to_string_pretty(&manifest).expect("plain data");
    stage.write(MANIFEST, |out| out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")))?;
    let _alone = stage.lock()?;
    // What came there since the plan was checked.
    may_build_alone(&request.folder, &material.name, names.iter().copied(), request.force)?;
    let mut stale = stale(&request.folder, &material.name, &names);
    stale.retain(|name| !plan::reads(material, &request.folder.join(name)));
    stage.commit(MANIFEST, &stale)
}

/// The input file, where it can stand for level 0 as it is: a plain PNG of the material's size.
fn level_0_file<'a>(material: &'a Material, plan: &Plan, layer: Layer, level: usize) -> Option<&'a [u8]> {
    let Layer::Sheet(sheet) = layer else { return None };
    let map: &MapFile = &material.maps[plan.sheets[sheet].map?];
    match &map.origin {
        Origin::File { size, plain_png, .. } if level == 0 && *size == map.raster.size() => plain_png.as_deref(),
        _ => None,
    }
}
