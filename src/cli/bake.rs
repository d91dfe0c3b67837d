//! `mipfold bake-curvature`.

use std::collections::HashMap;
use std::path::Path;

use super::args::{BakeArgs, Global, depth};
use super::build::output_folders;
use super::inputs::{given_width, single};
use super::job::{Job, NORMALS_COMPUTED, Under};
use super::report::{Built, Extent, Report};
use crate::codec;
use crate::curvature::{BakeOptions, LoadOptions, Mesh, load, vertex_curvature};
use crate::error::{Error, Result};
use crate::material::{Extra, Inputs, Model, RoughnessInput, Surface};
use crate::output::{MANIFEST, Request, may_write, vertices_name, write_vertices};

/// Parts of a mesh that share their maps.
struct Group {
    /// By number in the mesh.
    parts: Vec<usize>,
    /// The maps that the file itself names.
    surface: Option<Surface>,
    name: String,
}

pub fn run(args: &BakeArgs, global: &Global, report: &mut Report) -> Result<()> {
    let options = args.folding.options(false)?;
    let mut meshes = Meshes { args, read: HashMap::new() };
    report.progress.set_message(format!("reading {}", args.mesh.display()));
    let groups = groups(args, meshes.with(args.uv_set)?, report)?;
    let flagged = flagged(args)?;
    let textured = |mesh: &Mesh, group: &Group| group.parts.iter().any(|&i| mesh.parts[i].has_uvs);
    let mesh = meshes.with(args.uv_set)?;
    let with_maps = groups.iter().filter(|group| textured(mesh, group)).count();
    if flagged.is_some() && with_maps != 1 {
        let found = format!("maps given for {with_maps} materials with texture coordinates");
        return Err(Error::invalid_option("bake-curvature", found, "one: name it with --part"));
    }
    // A part without texture coordinates is baked at its vertices.
    let mut jobs: Vec<(String, Group, bool)> = Vec::new();
    for group in groups {
        let (with, without): (Vec<_>, Vec<_>) = group.parts.iter().partition(|&&i| mesh.parts[i].has_uvs);
        let both = !with.is_empty() && !without.is_empty();
        if !without.is_empty() {
            let name = if both { format!("{}_vertices", group.name) } else { group.name.clone() };
            let group = Group { parts: without, surface: None, name: group.name.clone() };
            jobs.push((name, group, false));
        }
        if !with.is_empty() {
            jobs.push((group.name.clone(), Group { parts: with, ..group }, true));
        }
    }
    if args.maps.name.is_some() && jobs.len() != 1 {
        let expected = "one material; several are named after the file's";
        return Err(Error::invalid_option("--name", format!("{} materials", jobs.len()), expected));
    }
    let names: Vec<&str> = jobs.iter().map(|(name, ..)| name.as_str()).collect();
    let folders = if let [_] = jobs[..] { vec![args.output.clone()] } else { output_folders(&args.output, &names) };
    for ((name, group, textured), folder) in jobs.into_iter().zip(folders) {
        let uv_set = group.surface.as_ref().and_then(|surface| surface.uv_set).unwrap_or(args.uv_set);
        let mesh = meshes.with(uv_set)?.select(&group.parts);
        let result = if textured {
            let request = Request {
                folder,
                formats: args.format.clone(),
                depth: depth(args.float),
                moments: false,
                extras: vec![Extra::Curvature],
                force: global.force,
            };
            let inputs = inputs(args, &group, flagged.as_ref())?;
            let read = |path: &Path| group.surface.as_ref().map_or_else(|| codec::read(path), |s| s.read(path));
            let baking = BakeOptions { padding: usize::from(args.padding) };
            let form = args.folding.form();
            let under = Some(Under { mesh: &mesh, file: &args.mesh, options: baking });
            let job = Job { inputs: &inputs, read: &read, under, options: &options, form, request: &request };
            job.run(global.dry_run, &report.progress).map(|done| done.built)
        } else {
            at_vertices(&name, &folder, &mesh, global)
        };
        match result {
            Ok(built) => report.built(built),
            Err(error) => report.error(&error),
        }
    }
    Ok(())
}

/// The mesh by sets of texture coordinates: most files have one.
struct Meshes<'a> {
    args: &'a BakeArgs,
    read: HashMap<usize, Mesh>,
}

impl Meshes<'_> {
    fn with(&mut self, uv_set: usize) -> Result<&Mesh> {
        if !self.read.contains_key(&uv_set) {
            let mesh = load(&self.args.mesh, &LoadOptions { crease_degrees: self.args.crease, uv_set })?;
            self.read.insert(uv_set, mesh);
        }
        Ok(&self.read[&uv_set])
    }
}

/// The parts that are asked for, by material.
fn groups(args: &BakeArgs, mesh: &Mesh, report: &mut Report) -> Result<Vec<Group>> {
    let stem = args.mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = |i: usize| mesh.parts[i].material.clone().unwrap_or_else(|| stem.clone());
    let all: Vec<usize> = (0..mesh.parts.len()).collect();
    for wanted in &args.part {
        if !all.iter().any(|&i| name(i) == *wanted) {
            let mut names: Vec<String> = all.iter().map(|&i| name(i)).collect();
            names.dedup();
            return Err(Error::invalid_option("--part", wanted, format!("one of {}", names.join(", "))));
        }
    }
    let asked: Vec<usize> = all.into_iter().filter(|&i| args.part.is_empty() || args.part.contains(&name(i))).collect();
    let mut groups: Vec<Group> = Vec::new();
    let mut left = asked.clone();
    if let Some(model) = Model::read(&args.mesh)? {
        let mut used: Vec<usize> = asked.iter().filter_map(|&i| mesh.parts[i].index).collect();
        used.dedup();
        left.retain(|&i| mesh.parts[i].index.is_none());
        for surface in model.surfaces(&used)? {
            match surface {
                Ok(surface) => {
                    let of = |&i: &usize| mesh.parts[i].index.is_some_and(|index| surface.materials.contains(&index));
                    let parts = asked.iter().copied().filter(of).collect();
                    groups.push(Group { parts, name: surface.inputs.name.clone(), surface: Some(surface) });
                }
                Err(error) => report.error(&error),
            }
        }
    }
    for i in left {
        match groups.iter_mut().find(|group| group.surface.is_none() && group.name == name(i)) {
            Some(group) => group.parts.push(i),
            None => groups.push(Group { parts: vec![i], surface: None, name: name(i) }),
        }
    }
    Ok(groups)
}

/// The material that flags describe, if they name any map.
fn flagged(args: &BakeArgs) -> Result<Option<Inputs>> {
    let (maps, width) = (&args.maps, given_width(&args.maps)?);
    let named = [&maps.normal, &maps.height, &maps.anisotropy].iter().any(|map| map.is_some());
    let width = matches!(width, RoughnessInput::Roughness(_) | RoughnessInput::Smoothness(_));
    (named || width).then(|| single(maps, &args.reading, "bake-curvature")).transpose()
}

/// What a group's texture is folded from: the maps of flags, else those of the file, else a flat surface.
fn inputs(args: &BakeArgs, group: &Group, flagged: Option<&Inputs>) -> Result<Inputs> {
    let width = given_width(&args.maps)?;
    let own = group.surface.as_ref().map(|surface| surface.inputs.clone());
    let name = args.maps.name.clone().unwrap_or_else(|| group.name.clone());
    let inputs = match (flagged, own) {
        (Some(flagged), _) => super::inputs::read_as(flagged.clone(), &args.maps, &args.reading)?,
        (None, Some(own)) if width == RoughnessInput::Missing => own,
        (None, own) => Inputs { roughness: width, ..own.unwrap_or_default() },
    };
    Ok(Inputs { name, flat: Some(args.size), ..inputs })
}

/// Curvature at the vertices, for what has no texture coordinates.
fn at_vertices(name: &str, folder: &Path, mesh: &Mesh, global: &Global) -> Result<Built> {
    let file = vertices_name(name);
    if global.dry_run {
        may_write(folder, [file.as_str(), MANIFEST], global.force)?;
    } else {
        write_vertices(folder, name, mesh, &vertex_curvature(mesh), global.force)?;
    }
    Ok(Built {
        name: name.into(),
        folder: folder.to_string_lossy().into_owned(),
        extent: Extent::Vertices { vertices: mesh.positions.len(), triangles: mesh.triangles.len() },
        files: vec![file, MANIFEST.into()],
        notes: vec!["no texture coordinates: curvature at the vertices".into()],
        warnings: if mesh.normals_computed { vec![NORMALS_COMPUTED.into()] } else { vec![] },
    })
}
