//! The curvature of a mesh as roughness: what its own shading normals add where a texel or a pixel holds many of them.
//!
//! [`load`] reads a [`Mesh`] from glTF, OBJ or PLY; [`bake()`] gives a texture's chain of added [roughness
//! tensors](crate::ndf::RoughnessTensor) for a mesh with texture coordinates; [`vertex_curvature`] gives one
//! [`Curvature`] a vertex for a mesh without.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `K` | added to the roughness tensor `R`: twice the covariance of the normals in a footprint | slope squared |
//! | `W` | shape operator, `dn = W dp` | 1 / length |
//!
//! ```
//! # fn main() -> mipfold::Result<()> {
//! # let (positions, triangles) = (vec![glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y], vec![[0, 1, 2]]);
//! # let uvs = positions.iter().map(|p| p.truncate()).collect();
//! # let mesh = mipfold::curvature::Mesh::new(positions, None, Some(uvs), triangles, 60.0)?;
//! use mipfold::curvature::{BakeOptions, bake};
//! use mipfold::image::Size;
//!
//! let baked = bake(&mesh, Size::new(64, 64), &BakeOptions::default(), &|_| ())?;
//! let wider = baked.levels[2].isotropic(3, 10);
//! println!("alpha^2 grows by {}", wider.squared());
//! # Ok(())
//! # }
//! ```

mod bake;
mod gltf;
mod grid;
mod mesh;
mod moments;
mod normals;
mod obj;
mod pad;
mod ply;
mod raster;
mod surface;
mod vertex;
mod weld;

#[cfg(test)]
mod tests;

pub use bake::{BakeOptions, Baked, Level, Summary, bake, check};
pub use mesh::{LoadOptions, MOST_VERTICES, Mesh, Part, load};
pub use surface::{LONGEST_SIDE, MOST_COVERS};
pub use vertex::{Curvature, vertex_curvature};
