//! What an earlier build left in a folder.

use std::path::Path;

use serde::Deserialize;

/// Name of the manifest in a material's folder.
pub const MANIFEST: &str = "manifest.json";

/// The value of `generator` in our manifests.
pub const GENERATOR: &str = "mipfold";

/// The files that an earlier build wrote into `folder`; `None` where no manifest of ours lies.
pub fn built_files(folder: &Path) -> Option<Vec<String>> {
    #[derive(Deserialize)]
    struct Map {
        files: Vec<String>,
    }
    #[derive(Deserialize)]
    struct Manifest {
        generator: String,
        maps: Vec<Map>,
    }
    let text = std::fs::read(folder.join(MANIFEST)).ok()?;
    let manifest: Manifest = serde_json::from_slice(&text).ok()?;
    // The manifest may have been edited: names that leave the folder are nobody's.
    let inside = |file: &String| Path::new(file).components().count() == 1 && Path::new(file).file_name().is_some();
    let files = manifest.maps.into_iter().flat_map(|map| map.files).filter(inside);
    (manifest.generator == GENERATOR).then(|| files.chain([MANIFEST.to_owned()]).collect())
}
