//! Mip chains that keep a material looking the same at every distance.
//!
//! A texel is a **lobe**: a normal and a roughness. The texels of level 0 under a mip texel are its **footprint**. A
//! plain mip averages the normals of a footprint and loses their spread; a **fold** ([`fold::FOLDS`]) replaces the
//! footprint by one lobe that keeps it, as roughness. [`fold::chain`] does that for every level of a
//! [`material::Material`], or of anything else that hands out [`material::Texels`].
//!
//! ```
//! use mipfold::fold::{Options, chain};
//! use mipfold::material::{ChannelRef, Inputs, RoughnessInput, load};
//!
//! fn main() -> mipfold::Result<()> {
//! #     let folder = tempfile::tempdir().unwrap();
//! #     std::env::set_current_dir(&folder).unwrap();
//! #     let maps = (mipfold::sample::SAMPLES[0].make)(32, 1);
//! #     for (name, map) in [("wall_normal.png", &maps.normal), ("wall_orm.png", &maps.orm)] {
//! #         mipfold::codec::write_png(std::fs::File::create(name).unwrap(), map).unwrap();
//! #     }
//!     let material = load(&Inputs {
//!         normal: Some("wall_normal.png".into()),
//!         roughness: RoughnessInput::Roughness(ChannelRef::parse("wall_orm.png:g")),
//!         ..Inputs::default()
//!     })?;
//!     let folded = chain(&material, &Options::default());
//!     // The texel at (0, 0) of level 1: a unit normal and a width.
//!     let lobe = folded.levels[0].lobes.at(0, 0);
//!     println!("normal {}, roughness {}", lobe.normal, lobe.axes().alpha_x.perceptual().0);
//!     Ok(())
//! }
//! ```
//!
//! # Scope
//!
//! - Tangent-space normal maps with roughness, gloss or packed maps, of any size; heights and glTF anisotropy too.
//! - Lobes of one width, which every engine can shade today, or of two widths and a direction; mixtures of up to four
//!   for shaders that add them up.
//! - Exact footprints, published methods side by side, and the same bytes on any number of threads.
//! - A judge ([`compare`](mod@compare)) that measures how far any mip chain is from the exact footprint, in f64, and knows
//!   nothing of folds.
//! - A renderer that draws plain mips, folded mips and the truth, so that eyes can judge too.
//!
//! # Not in scope
//!
//! - Specular anti-aliasing of geometry at run time, and normals that only the shader knows: detail maps, animation.
//! - Colour textures, colour management and mip filters for pictures.
//! - Speed before exactness: no level is made from a rounded one.
//!
//! # Rooms
//!
//! A room uses only rooms above it in this table.
//!
//! | room | what is there |
//! |---|---|
//! | [`error`] | what can go wrong, with the file, what was found there and what was expected |
//! | [`roughness`] | the units of width, as types, and the only conversions |
//! | [`random`] | seeded random numbers, and evenly spread ones |
//! | [`image`] | rasters, sizes of levels, wrap modes, footprints and their weights |
//! | [`codec`] | bytes to images and back; knows formats, not meaning |
//! | [`ndf`] | what a normal distribution is: the GGX lobe, its tensor, images of lobes |
//! | [`glint`] | procedural flakes and the texels of a normal map as glints: ratios, mean 1, for any lobe |
//! | `gltf` | glTF files as they are: documents, buffers, numbers (not public) |
//! | [`curvature`] | meshes to roughness: what a mesh's own normals add under each texel of every level |
//! | [`material`] | what channels mean, both ways: roles, packing, file names, repair |
//! | [`mod@audit`] | what is wrong with a material's maps: findings with evidence, confidence and the fix |
//! | [`mod@reference`] | the exact NDF and the exact shading of a footprint, in f64 |
//! | [`compare`] | how far a chain is from that, and a picture from another |
//! | [`moments`] | sums over a footprint that merge without loss |
//! | [`summary`] | a footprint in a bounded number of lobes |
//! | [`fold`] | a footprint becomes a lobe: the list of folds, and the loop over levels |
//! | [`output`] | a chain becomes files: PNG, EXR, KTX 2, DDS, glTF, what engines want, manifest; whole or not at all |
//! | [`sample`] | six materials made by code |
//! | [`render`] | a small CPU renderer for evidence |
//! | [`report`] | the judge's findings for people (one HTML page) and for programs (JSON, CSV) |
//! | [`kernels`] | shader helpers as texts, in three languages, and their twins in f64 |
//! | [`cli`] | arguments to library calls to exit code; the only room that prints |
//!
//! # Symbols and units
//!
//! | symbol | meaning | unit, range |
//! |---|---|---|
//! | u, v | texture coordinates; v points up, rows go down | texture widths |
//! | `n` | normal in tangent space: x along +u, y along +v (OpenGL), z out of the surface | unit vector, `n.z > 0` |
//! | `s` | slope, `(-n.x / n.z, -n.y / n.z)` | height over length |
//! | `r` in [`roughness::PerceptualRoughness`] | what textures hold; gloss and smoothness are `1 - r` | 0 to 1 |
//! | alpha, [`roughness::Alpha`] | width of a GGX or Beckmann lobe, `r^2` | slope, 0 to 1 |
//! | `R`, [`ndf::RoughnessTensor`] | symmetric 2x2 with eigenvalues alpha_x^2 and alpha_y^2, in the lobe's own tangent frame | slope squared |
//! | angle, [`ndf::Axes`] | from the lobe's tangent (+u made orthogonal to `n`) to the axis of the larger width | radians |
//! | `D` | density of microfacet normals, `integral D(m) (m . n) dm = 1` | 1/sr |
//! | kappa, [`roughness::Concentration`] | concentration of a von Mises-Fisher distribution of normals | 0 up |
//! | level `k` | 0 is the input; each side is `max(1, size >> k)` texels | |
//!
//! A Beckmann lobe has the slope variance `alpha^2 / 2` along each axis ([`roughness::SlopeVariance`]). GGX has none,
//! so nothing of GGX is called a variance here.

pub mod audit;
pub mod cli;
pub mod codec;
pub mod compare;
pub mod curvature;
pub mod error;
pub mod fold;
pub mod glint;
mod gltf;
pub mod image;
pub mod kernels;
pub mod material;
pub mod moments;
pub mod ndf;
pub mod output;
pub mod random;
pub mod reference;
pub mod render;
pub mod report;
pub mod roughness;
pub mod sample;
pub mod summary;

pub use error::{Error, Result};

/// The README's programs, compiled with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
