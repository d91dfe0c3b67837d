//! Meshes of glTF 2.0 files, .glb and .gltf: every triangle of the scene, with the transforms of its nodes.
//!
//! Skins and morph targets are ignored: the mesh is in the pose that its vertices have. Points and lines are skipped.
//! What the file says of textures (`KHR_texture_transform`) is ignored too; the coordinates are those of the vertices.

use std::path::Path;

use glam::{DMat3, DMat4, DQuat, DVec3, Vec2, Vec3};

use super::mesh::{Piece, Pieces, too_many};
use crate::error::{Error, Result};
use crate::gltf::{Buffers, Document, Material, Node, Primitive, Reader, item, open};

/// The most primitives that a scene may show, each counted as often as nodes show its mesh: 2^20, ten times what large
/// scenes have. Without a limit a file of N nodes that show one mesh of P primitives takes the time and memory of N * P.
const MOST_SHOWN: usize = 1 << 20;

/// The pieces of the scene: one for each primitive of each node that shows it.
pub(super) fn read(path: &Path, bytes: &[u8], uv_set: usize) -> Result<Pieces> {
    let (document, binary) = open(path, bytes)?;
    for extension in &document.extensions_required {
        if ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"].contains(&&**extension)
        {
            return Err(Error::unsupported(path, format!("compression ({extension})"), "plain vertices"));
        }
    }
    let placed = placed(path, &document)?;
    let mut shown = 0usize;
    for &(mesh, _) in &placed {
        shown = shown.saturating_add(item(path, &document.meshes, mesh, "mesh")?.primitives.len());
    }
    if shown > MOST_SHOWN {
        return Err(Error::unsupported(path, format!("a scene of {shown} primitives"), format!("up to {MOST_SHOWN}")));
    }
    let buffers = Buffers::new(path, &document.buffers, binary);
    let reader = Reader { path, document: &document, buffers: &buffers };
    let (mut pieces, mut vertices, mut triangles) = (Vec::new(), 0, 0);
    for (mesh, transform) in placed {
        for primitive in &item(path, &document.meshes, mesh, "mesh")?.primitives {
            let Some(piece) = piece(&reader, primitive, &transform, uv_set)? else { continue };
            (vertices, triangles) = (vertices + piece.positions.len(), triangles + piece.triangles.len());
            too_many(&path.display().to_string(), vertices, triangles)?;
            pieces.push(piece);
        }
    }
    let name = |(i, material): (usize, &Material)| material.name.clone().unwrap_or_else(|| format!("material {i}"));
    Ok(Pieces { pieces, materials: document.materials.iter().enumerate().map(name).collect() })
}

/// Every mesh that the scene shows, with where it stands. The scene is the file's own, or its first, or all nodes
/// that nothing holds, or else simply all meshes.
fn placed(path: &Path, document: &Document) -> Result<Vec<(usize, DMat4)>> {
    if document.nodes.is_empty() {
        return Ok((0..document.meshes.len()).map(|mesh| (mesh, DMat4::IDENTITY)).collect());
    }
    let roots: Vec<usize> = if document.scenes.is_empty() {
        let mut held = vec![false; document.nodes.len()];
        let children = document.nodes.iter().flat_map(|node| &node.children);
        children.filter(|&&i| i < document.nodes.len()).for_each(|&i| held[i] = true);
        (0..document.nodes.len()).filter(|&i| !held[i]).collect()
    } else {
        item(path, &document.scenes, document.scene.unwrap_or(0), "scene")?.nodes.clone()
    };
    let mut seen = vec![false; document.nodes.len()];
    let mut open: Vec<(usize, DMat4)> = roots.into_iter().rev().map(|i| (i, DMat4::IDENTITY)).collect();
    let mut found = Vec::new();
    while let Some((i, above)) = open.pop() {
        let node = item(path, &document.nodes, i, "node")?;
        if std::mem::replace(&mut seen[i], true) {
            return Err(Error::invalid(path, format!("node {i} held twice"), "a tree of nodes"));
        }
        let transform = above * local(path, i, node)?;
        found.extend(node.mesh.map(|mesh| (mesh, transform)));
        open.extend(node.children.iter().rev().map(|&child| (child, transform)));
    }
    Ok(found)
}

/// Where a node stands in its parent.
fn local(path: &Path, index: usize, node: &Node) -> Result<DMat4> {
    let wrong = |what: &str, length: usize, expected: usize| {
        Error::invalid(path, format!("{what} of {length} numbers in node {index}"), format!("{expected} numbers"))
    };
    if let Some(m) = &node.matrix {
        let m: [f64; 16] = m.as_slice().try_into().map_err(|_| wrong("a matrix", m.len(), 16))?;
        return Ok(DMat4::from_cols_array(&m));
    }
    let vector = |v: &Option<Vec<f64>>, what, default| match v {
        Some(v) => v.as_slice().try_into().map(DVec3::from_array).map_err(|_| wrong(what, v.len(), 3)),
        None => Ok(default),
    };
    let rotation = match &node.rotation {
        Some(q) => {
            let q: [f64; 4] = q.as_slice().try_into().map_err(|_| wrong("a rotation", q.len(), 4))?;
            let q = DQuat::from_array(q);
            if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY }
        }
        None => DQuat::IDENTITY,
    };
    let (scale, translation) =
        (vector(&node.scale, "a scale", DVec3::ONE)?, vector(&node.translation, "a translation", DVec3::ZERO)?);
    Ok(DMat4::from_scale_rotation_translation(scale, rotation, translation))
}

/// The triangles of a primitive in the scene's space; nothing for points, lines and primitives without triangles.
fn piece(reader: &Reader, primitive: &Primitive, transform: &DMat4, uv_set: usize) -> Result<Option<Piece>> {
    let Some(&positions) = primitive.attributes.get("POSITION") else { return Ok(None) };
    if !matches!(primitive.mode, 4..=6) {
        return Ok(None);
    }
    if primitive.extensions.contains_key("KHR_draco_mesh_compression")
        && item(reader.path, &reader.document.accessors, positions, "accessor")?.buffer_view.is_none()
    {
        return Err(Error::unsupported(reader.path, "compression (KHR_draco_mesh_compression)", "plain vertices"));
    }
    let attribute = |name: &str| primitive.attributes.get(name).copied();
    let positions = reader.elements::<3>(positions)?;
    let normals = attribute("NORMAL").map(|i| reader.elements::<3>(i)).transpose()?;
    let uvs = attribute(&format!("TEXCOORD_{uv_set}")).map(|i| reader.elements::<2>(i)).transpose()?;
    let indices = primitive.indices.map(|i| reader.elements::<1>(i).map(|elements| (i, elements))).transpose()?;
    // Lengths are compared before anything is copied, which a scene may ask for many times.
    let counts =
        [("normals", normals.as_ref().map(|e| e.count)), ("texture coordinates", uvs.as_ref().map(|e| e.count))];
    for (what, count) in counts {
        if let Some(count) = count.filter(|&count| count != positions.count) {
            let found = format!("{count} {what} for {} vertices", positions.count);
            return Err(Error::invalid(reader.path, found, "one a vertex"));
        }
    }
    if indices.as_ref().map_or(positions.count, |(_, e)| e.count) < 3 {
        return Ok(None);
    }
    let indices: Vec<u32> = match indices {
        Some((i, elements)) => elements.indices().ok_or_else(|| {
            let found = format!("accessor {i} of signed or float indices");
            Error::invalid(reader.path, found, "unsigned indices")
        })?,
        None => (0..positions.count as u32).collect(),
    };
    let turned = DMat3::from_mat4(*transform);
    let mirrored = turned.determinant() < 0.0;
    // Normals turn with the cofactors of the transform, which exist where its inverse does not.
    let cofactors = DMat3::from_cols(
        turned.y_axis.cross(turned.z_axis),
        turned.z_axis.cross(turned.x_axis),
        turned.x_axis.cross(turned.y_axis),
    ) * if mirrored { -1.0 } else { 1.0 };
    let point = |p: [f32; 3]| transform.transform_point3(Vec3::from(p).as_dvec3()).as_vec3();
    let direction = |n: [f32; 3]| (cofactors * Vec3::from(n).as_dvec3()).normalize_or_zero().as_vec3();
    primitive.material.map(|i| item(reader.path, &reader.document.materials, i, "material")).transpose()?;
    Ok(Some(Piece {
        material: primitive.material,
        positions: positions.floats().into_iter().map(point).collect(),
        normals: normals.iter().flat_map(|normals| normals.floats()).map(direction).collect(),
        // glTF's v points down.
        uvs: uvs.map(|uvs| uvs.floats().into_iter().map(|[u, v]| Vec2::new(u, 1.0 - v)).collect()),
        triangles: triangles(&indices, primitive.mode, mirrored),
    }))
}

/// Triangles from a list (mode 4), a strip (5) or a fan (6) of indices; a mirror turns them over.
fn triangles(indices: &[u32], mode: u32, mirrored: bool) -> Vec<[u32; 3]> {
    let mut triangles: Vec<[u32; 3]> = match mode {
        4 => indices.as_chunks().0.to_vec(),
        5 => (indices.windows(3).enumerate())
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        _ => indices.get(1..).unwrap_or_default().windows(2).map(|w| [w[0], w[1], indices[0]]).collect(),
    };
    if mirrored {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_one_side_out() {
        assert_eq!(triangles(&[0, 1, 2, 3, 4, 5, 6], 4, false), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(triangles(&[0, 1, 2, 3], 5, false), [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(triangles(&[0, 1, 2, 3], 6, false), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(triangles(&[0, 1, 2], 4, true), [[0, 2, 1]]);
        assert_eq!(triangles(&[], 6, false), [[0; 3]; 0]);
    }
}
