//! A small CPU renderer for evidence: one object under lights and a sky, shaded from a mip chain or, as the truth,
//! from many samples of level 0; still pictures, and sequences of a zoom or a pan.
//!
//! Both ways see the same geometry, the same finite list of lights, summed exactly, and the same sky, integrated over the
//! same points of the lobe, so a difference between two pictures is a difference between their lobes. Nothing casts
//! shadows. Surfaces are bare metal: GGX with height-correlated
//! Smith masking as [`ShapeInvariant::specular`](crate::ndf::ShapeInvariant::specular) and Schlick's Fresnel term. Pictures depend on
//! nothing but their arguments, however many threads draw them.

mod environment;
#[cfg(test)]
mod evidence;
mod font;
mod geometry;
mod glint;
mod heat;
mod mesh;
mod motion;
mod picture;
mod scene;
mod shade;
mod sheet;
mod strip;
mod texture;

pub use environment::Environment;
pub use glint::Glints;
pub use heat::heat;
pub use mesh::{Fragment, LobeMap, MeshScene, MeshView, PointLobe, Step, SurfacePoint, Truth};
pub use motion::{Motion, glinting_sequence, sequence};
pub use picture::{Image, Sampling, display, render, render_glints, tonemap};
pub use scene::{Light, Scene, Shape};
pub use sheet::{grid, side_by_side};
pub use strip::{DISTANCES, distance_strip};
pub use texture::{Filter, Pairs};
