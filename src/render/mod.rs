//! A small CPU renderer for evidence: one object under studio lights, shaded from a mip chain or, as the truth, from
//! many samples of level 0.
//!
//! Both ways see the same geometry and the same finite list of directional lights, summed exactly, so a difference
//! between two pictures is a difference between their lobes. Surfaces are bare metal: GGX with height-correlated
//! Smith masking as [`Lobe::specular`](crate::ndf::Lobe::specular) and Schlick's Fresnel term. Pictures depend on
//! nothing but their arguments, however many threads draw them.

#[cfg(test)]
mod evidence;
mod font;
mod geometry;
mod picture;
mod scene;
mod shade;
mod strip;
mod texture;

pub use picture::{Image, Sampling, render, tonemap};
pub use scene::{Light, Scene, Shape};
pub use strip::{DISTANCES, distance_strip};
