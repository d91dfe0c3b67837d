//! Meshes as GPUs draw them, small and with one sample a pixel; and the truth, with many.
//!
//! Both see the same triangles, normals and lights, so a difference between two pictures is a difference between the lobes
//! that their pixels were shaded with. [`MeshScene::fragments`] hands out what a fragment shader knows of each pixel: attributes
//! at its centre, interpolated in perspective, and their differences within a quad of 2x2 pixels. [`MeshScene::shade`] asks
//! for a lobe a fragment and light; [`MeshScene::truth`] shades every sample by itself.

mod attributes;
mod draw;
mod projected;
mod visible;

#[cfg(test)]
mod tests;

pub use attributes::{Fragment, Step, SurfacePoint};
pub use draw::{LobeMap, MeshScene, PointLobe, Truth};
pub use projected::MeshView;
