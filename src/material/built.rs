//! What an earlier build left in a folder.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

/// Name of the manifest in a material's folder.
pub const MANIFEST: &str = "manifest.json";

/// Name of its copy while files get their names.
pub const JOURNAL: &str = ".mipfold-commit.json";

/// The value of `generator` in our manifests.
pub const GENERATOR: &str = "mipfold";

/// Pictures for people that may lie beside a chain: of flakes.
pub const PICTURES: [&str; 4] = ["glints.png", "glints_zoom.png", "glints_pan.png", "glints_light.png"];

/// Version of the manifest's form; fields are added, never renamed.
pub const SCHEMA: u32 = 1;

/// Whether a text of this name may lie beside maps of these files: what engines are told about them.
fn is_aside(name: &str, maps: &[String]) -> bool {
    ASIDES.contains(&name) || name.strip_suffix(".meta").is_some_and(|file| maps.iter().any(|map| map == file))
}

/// Names of texts that may lie beside a chain.
pub const ASIDES: [&str; 2] = ["README.txt", "MipfoldMips.cs.txt"];

/// An earlier build, by its manifest.
#[derive(Debug, Default)]
pub struct Earlier {
    /// Name of the material.
    pub material: String,
    /// The files that it wrote, the manifest among them.
    pub files: Vec<String>,
    /// All that it was made of, as one number.
    pub key: Option<String>,
    /// SHA-256 of each file but the manifest, hexadecimal.
    pub digests: BTreeMap<String, String>,
    /// What looked wrong with the inputs.
    pub warnings: Vec<String>,
}

impl Earlier {
    /// What the manifest in `folder` says, and the journal of a build that was interrupted; `None` where none of ours lies.
    pub fn read(folder: &Path) -> Option<Self> {
        let [manifest, journal] = [MANIFEST, JOURNAL].map(|name| Self::of_file(&folder.join(name)));
        match (manifest, journal) {
            (manifest, None) => manifest,
            (None, Some(journal)) => Some(Self { key: None, ..journal }),
            (Some(manifest), Some(mut journal)) => {
                let further = manifest.files.into_iter().filter(|file| !journal.files.contains(file));
                journal.files.extend(further.collect::<Vec<_>>());
                Some(Self { key: None, ..journal })
            }
        }
    }

    fn of_file(path: &Path) -> Option<Self> {
        #[derive(Deserialize)]
        struct Map {
            files: Vec<String>,
        }
        #[derive(Deserialize)]
        struct Manifest {
            generator: String,
            material: String,
            maps: Vec<Map>,
            #[serde(default)]
            pictures: Vec<String>,
            #[serde(default)]
            asides: Vec<String>,
            key: Option<String>,
            #[serde(default)]
            sha256: BTreeMap<String, String>,
            #[serde(default)]
            warnings: Vec<String>,
        }
        let text = std::fs::read(path).ok()?;
        let manifest: Manifest = serde_json::from_slice(&text).ok()?;
        // The manifest may have been edited: names that leave the folder, or are none that we give, are nobody's.
        let ours = |file: &String| {
            let plain = Path::new(file).components().count() == 1 && Path::new(file).file_name().is_some();
            plain
                && ([".exr", ".ktx2", ".dds"].iter().any(|ending| file.ends_with(ending))
                    || file.ends_with("_curvature.ply")
                    || (file.ends_with(".png") && file.contains("_mip")))
        };
        let pictures = manifest.pictures.into_iter().filter(|name| PICTURES.contains(&name.as_str()));
        let maps: Vec<_> = manifest.maps.into_iter().flat_map(|map| map.files).filter(ours).collect();
        let asides = manifest.asides.into_iter().filter(|name| is_aside(name, &maps)).collect::<Vec<_>>();
        let files: Vec<_> = maps.into_iter().chain(pictures).chain(asides).chain([MANIFEST.to_owned()]).collect();
        let mut digests = manifest.sha256;
        digests.retain(|name, _| files.contains(name));
        let (material, key, warnings) = (manifest.material, manifest.key, manifest.warnings);
        (manifest.generator == GENERATOR).then_some(Self { material, files, key, digests, warnings })
    }

    /// Whether it wrote a file of this name; file systems that ignore case exist.
    pub fn wrote(&self, name: &str) -> bool {
        self.files.iter().any(|file| file.to_lowercase() == name.to_lowercase())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edited_manifest_names_no_files_of_others() {
        let folder = tempfile::tempdir().unwrap();
        let text = r#"{"generator": "mipfold", "material": "m", "pictures":
            ["me.png", "glints.png"], "maps": [{"files":
            ["../x_mip0.png", "..", "sub/y.exr", "notes.txt", "Wall_mip0.png", "wall.exr"]}]}"#;
        std::fs::write(folder.path().join(MANIFEST), text).unwrap();
        let earlier = Earlier::read(folder.path()).unwrap();
        assert_eq!(earlier.files, ["Wall_mip0.png", "wall.exr", "glints.png", MANIFEST]);
        assert!(earlier.wrote("wall_mip0.PNG") && !earlier.wrote("notes.txt"));
    }
}
