//! What became of the images of a model, by their content.

use serde::Serialize;

use super::package::{Package, image_bytes};
use super::{Group, Rewritten};
use crate::codec::sha256;
use crate::error::Result;
use crate::material::Model;

/// An image before and after.
#[derive(Clone, Debug, Serialize)]
pub struct ImageDigest {
    /// Its number.
    pub image: usize,
    /// `kept`, `folded` (another content under the same number), `gone` (it shows another that is new), `added`, or
    /// `unread`.
    pub state: &'static str,
    /// SHA-256 of what the model had.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<String>,
    /// SHA-256 of what it has; of new contents unknown in a dry run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
}

/// Digests of all images of a model, of which some are new.
///
/// # Errors
/// A file that is no glTF. An image that cannot be read has no digest.
pub fn digests(model: &Model, rewritten: &Rewritten, groups: &[Group]) -> Result<Vec<ImageDigest>> {
    let package = Package::new(model, true)?;
    let buffers = package.buffers();
    let Rewritten { images, gone, .. } = rewritten;
    let after = |image: usize| {
        let about = images.iter().find(|about| about.image == image || about.picture == Some(image))?;
        let textures = &groups[about.group].folded.textures;
        let texture = textures.iter().find(|texture| texture.slot == about.slot)?;
        let bytes = if about.image == image { Some(&texture.bytes) } else { texture.picture.as_ref() };
        bytes.map(|bytes| sha256(bytes))
    };
    let count = package.document.images.len();
    let mut out = Vec::new();
    for image in 0..count {
        let before = image_bytes(&package, &buffers, image).ok().map(|bytes| sha256(&bytes));
        let (state, after) = match gone.get(&image) {
            Some(new) => ("gone", after(*new)),
            None if images.iter().any(|about| about.image == image) => ("folded", after(image)),
            None if before.is_none() => ("unread", None),
            None => ("kept", before.clone()),
        };
        out.push(ImageDigest { image, state, before, after });
    }
    let numbers = images.iter().flat_map(|about| [about.image].into_iter().chain(about.picture));
    let added = numbers.filter(|image| *image >= count);
    out.extend(added.map(|image| ImageDigest { image, state: "added", before: None, after: after(image) }));
    Ok(out)
}
