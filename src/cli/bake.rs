//! `mipfold bake-curvature`.

use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use super::args::{BakeArgs, Global};
use super::build::output_folders;
use super::inputs::{beside_width, given_width, read_as, single};
use super::job::{Job, NORMALS_COMPUTED, Under};
use super::report::{Built, Extent, Report};
use crate::codec;
use crate::curvature::{BakeOptions, LoadOptions, Mesh, load, vertex_curvature};
use crate::error::{Error, Result};
use crate::fold::Options;
use crate::image::Wrap;
use crate::material::{Extra, Inputs, Model, NormalRange, NormalY, NormalZ, RoughnessInput, Surface};
use crate::output::{MANIFEST, Request, file_digest, may_build, vertices_name, write_vertices};

/// Triangles that are baked together: those of the materials that share their maps.
struct Group {
    name: String,
    /// Numbers of the materials in the file; none for triangles without one.
    materials: Vec<Option<usize>>,
    /// The maps that the file itself names.
    surface: Option<Surface>,
    /// Set of texture coordinates.
    uv_set: usize,
}

/// A group's triangles with texture coordinates, or those without, which are baked at their vertices.
struct Bake<'a> {
    name: String,
    group: &'a Group,
    mesh: Mesh,
    textured: bool,
}

pub fn run(args: &BakeArgs, global: &Global, report: &mut Report) -> Result<()> {
    let options = args.folding.options(false)?;
    let flagged = flagged(args)?;
    report.progress.set_message(format!("reading {}", args.mesh.display()));
    let mut meshes = HashMap::from([(args.uv_set, read(args, args.uv_set)?)]);
    let groups = groups(args, &meshes[&args.uv_set], flagged.is_some())?;
    // Where a material that cannot be read would have been, its neighbours stay in folders of their own.
    let mut alone = groups.len() == 1;
    let mut bakes: Vec<Bake> = Vec::new();
    for group in &groups {
        match group {
            Ok(group) => {
                let mesh = match meshes.entry(group.uv_set) {
                    Entry::Occupied(there) => there.into_mut(),
                    Entry::Vacant(free) => free.insert(read(args, group.uv_set)?),
                };
                bakes.extend(parted(args, group, mesh));
            }
            Err(error) => report.error(error),
        }
    }
    drop(meshes);
    alone &= bakes.len() == 1;
    if args.maps.name.is_some() && !alone {
        let expected = "one material; several are named after the file's";
        return Err(Error::invalid_option("--name", format!("{} materials", bakes.len().max(groups.len())), expected));
    }
    if flagged.is_some() {
        let textured = bakes.iter().filter(|bake| bake.textured).count();
        let (found, expected) = match textured {
            0 => ("maps for a mesh without texture coordinates".to_owned(), "a mesh with them, or no maps"),
            _ => (format!("maps for {textured} materials"), "one: name it with --part"),
        };
        if textured != 1 {
            return Err(Error::invalid_option(args.mesh.display().to_string(), found, expected));
        }
    }
    // All materials share the file.
    let textured = bakes.iter().any(|bake| bake.textured);
    let sha256 = if textured { file_digest(&args.mesh)? } else { String::new() };
    let names: Vec<&str> = bakes.iter().map(|bake| bake.name.as_str()).collect();
    let folders = if alone { vec![args.output.clone()] } else { output_folders(&args.output, &names) };
    for (bake, folder) in bakes.iter().zip(folders) {
        let result = if bake.textured {
            let request = Request { extras: vec![Extra::Curvature], ..args.containers.request(&folder, global.force) };
            into_texture(args, bake, flagged.as_ref(), &sha256, &options, &request, global.dry_run, report)
        } else {
            at_vertices(bake, &folder, global)
        };
        match result {
            Ok(built) => report.built(built),
            Err(error) => report.error(&error),
        }
    }
    Ok(())
}

fn read(args: &BakeArgs, uv_set: usize) -> Result<Mesh> {
    load(&args.mesh, &LoadOptions { crease_degrees: args.crease, uv_set })
}

/// The materials that are asked for, by their maps; `given` if options name the maps, and the file's own do not count.
fn groups(args: &BakeArgs, mesh: &Mesh, given: bool) -> Result<Vec<Result<Group>>> {
    let stem = args.mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = |i: usize| mesh.parts[i].material.clone().unwrap_or_else(|| stem.clone());
    let all: BTreeSet<String> = (0..mesh.parts.len()).map(name).collect();
    if let Some(wanted) = args.part.iter().find(|wanted| !all.contains(*wanted)) {
        let names = all.into_iter().collect::<Vec<_>>().join(", ");
        return Err(Error::invalid_option("--part", wanted, format!("one of {names}")));
    }
    let asked = (0..mesh.parts.len()).filter(|&i| args.part.is_empty() || args.part.contains(&name(i)));
    // By number, and once each: a material may have parts with and without texture coordinates.
    let mut materials: Vec<(Option<usize>, String)> = asked.map(|i| (mesh.parts[i].index, name(i))).collect();
    materials.sort();
    materials.dedup_by_key(|(index, _)| *index);
    let mut groups = Vec::new();
    if !given && let Some(model) = Model::read(&args.mesh)? {
        for surface in model.surfaces(materials.iter().filter_map(|(index, _)| *index))? {
            groups.push(surface.map(|surface| Group {
                name: surface.inputs.name.clone(),
                materials: surface.materials.iter().map(|index| Some(*index)).collect(),
                uv_set: surface.uv_set.unwrap_or(args.uv_set),
                surface: Some(surface),
            }));
        }
        materials.retain(|(index, _)| index.is_none());
    }
    let plain = |(index, name)| Ok(Group { name, materials: vec![index], surface: None, uv_set: args.uv_set });
    groups.extend(materials.into_iter().map(plain));
    Ok(groups)
}

/// What there is to bake of a group.
fn parted<'a>(args: &BakeArgs, group: &'a Group, mesh: &Mesh) -> Vec<Bake<'a>> {
    let of = |textured: bool| -> Vec<usize> {
        let parts = mesh.parts.iter().enumerate();
        let own = parts.filter(|(_, part)| part.has_uvs == textured && group.materials.contains(&part.index));
        own.map(|(i, _)| i).collect()
    };
    let (with, without) = (of(true), of(false));
    let both = !with.is_empty() && !without.is_empty();
    let name = args.maps.name.clone().unwrap_or_else(|| group.name.clone());
    let mut bakes = Vec::new();
    if !with.is_empty() {
        bakes.push(Bake { name: name.clone(), group, mesh: mesh.select(&with), textured: true });
    }
    if !without.is_empty() {
        let name = if both { format!("{name}_vertices") } else { name };
        bakes.push(Bake { name, group, mesh: mesh.select(&without), textured: false });
    }
    bakes
}

/// The material that options describe, if they name any map.
fn flagged(args: &BakeArgs) -> Result<Option<Inputs>> {
    let (maps, width) = (&args.maps, given_width(&args.maps)?);
    let named = [&maps.normal, &maps.height, &maps.anisotropy].iter().any(|map| map.is_some());
    if named || width.file().is_some() {
        return single(maps, &args.reading, "bake-curvature").map(Some);
    }
    let reading = &args.reading;
    let as_they_are = reading.normal_y == NormalY::default()
        && reading.normal_z == NormalZ::default()
        && reading.normal_range == NormalRange::default()
        && reading.normal_scale == 1.0
        && reading.height_scale.is_none()
        && reading.wrap() == Wrap::default();
    if as_they_are {
        return Ok(None);
    }
    let expected = "--normal, --height or --roughness FILE beside them: a model says how its own maps are read";
    Err(Error::invalid_option("bake-curvature", "options that say how to read maps, and no map", expected))
}

/// Bakes and folds a texture.
#[expect(clippy::too_many_arguments, reason = "what one material takes of the run")]
fn into_texture(
    args: &BakeArgs,
    bake: &Bake,
    flagged: Option<&Inputs>,
    sha256: &str,
    options: &Options,
    request: &Request,
    dry_run: bool,
    report: &Report,
) -> Result<Built> {
    let surface = bake.group.surface.as_ref();
    let width = given_width(&args.maps)?;
    let mut inputs = match (flagged, surface.map(|surface| surface.inputs.clone())) {
        (Some(flagged), _) => read_as(flagged.clone(), &args.maps, &args.reading)?,
        (None, own) => own.unwrap_or_default(),
    };
    if width != RoughnessInput::Missing {
        inputs.roughness = width;
    }
    beside_width(&mut inputs, &args.maps);
    let inputs = Inputs { name: bake.name.clone(), flat: Some(args.size), ..inputs };
    let read = |path: &Path| surface.map_or_else(|| codec::read(path), |surface| surface.read(path));
    let baking = BakeOptions { padding: usize::from(args.padding) };
    let (mesh, file, uv_set) = (&bake.mesh, &args.mesh, bake.group.uv_set);
    let under = Some(Under { mesh, file, sha256, uv_set, options: baking });
    let form = args.folding.form();
    let job = Job {
        inputs: &inputs,
        read: &read,
        under,
        flakes: None,
        draw: None,
        options,
        form,
        request,
        skip_if_below: None,
    };
    job.run(dry_run, &report.progress).map(|done| done.built)
}

/// Curvature at the vertices, for what has no texture coordinates.
fn at_vertices(bake: &Bake, folder: &Path, global: &Global) -> Result<Built> {
    let Bake { name, mesh, .. } = bake;
    let file = vertices_name(name);
    if global.dry_run {
        may_build(folder, name, [file.as_str()], global.force)?;
    } else {
        write_vertices(folder, name, mesh, &vertex_curvature(mesh), global.force)?;
    }
    Ok(Built {
        gain: None,
        skipped: false,
        name: name.clone(),
        folder: folder.to_string_lossy().into_owned(),
        extent: Extent::Vertices { vertices: mesh.positions.len(), triangles: mesh.triangles.len() },
        files: vec![file, MANIFEST.into()],
        maps: Vec::new(),
        notes: vec!["no texture coordinates: curvature at the vertices".into()],
        warnings: if mesh.normals_computed { vec![NORMALS_COMPUTED.into()] } else { vec![] },
    })
}
