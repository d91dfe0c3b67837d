//! What names say about files that a build does not need.

use std::path::{Path, PathBuf};

use super::NormalY;
use super::detect::is_picture;
use super::names::{Kind, Meaning, common_name, convention, meaning_of};

/// The height map of the same set as a map: the only one in its folder with the same common name.
pub fn height_beside(map: &Path) -> Option<PathBuf> {
    let meaning = |path: &Path| meaning_of(&path.file_stem()?.to_string_lossy());
    let own = meaning(map)?;
    let common = common_name(&own.material);
    let folder = map.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_height = |path: &PathBuf| {
        let same = |m: Meaning| m.kind == Kind::Height && m.tile == own.tile && common_name(&m.material) == common;
        is_picture(path) && meaning(path).is_some_and(same)
    };
    let mut found = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).filter(is_height);
    found.next().filter(|_| found.next().is_none())
}

/// Which way green points, by the name of a normal map.
pub fn named_normal_y(path: &Path) -> Option<NormalY> {
    convention(path)
}

/// Whether a name says gloss or smoothness (true) or roughness (false).
pub fn named_smooth(path: &Path) -> Option<bool> {
    match meaning_of(&path.file_stem()?.to_string_lossy())?.kind {
        Kind::Packed(layout) => Some(layout.smooth),
        Kind::Smoothness => Some(true),
        Kind::Roughness | Kind::NormalRoughness => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_only_height_map_of_the_set_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["wall_normal.png", "Wall_2k_Height.png", "door_normal.png", "door_disp.tif", "door_height.png"] {
            std::fs::write(at(name), "").unwrap();
        }
        assert_eq!(height_beside(&at("wall_normal.png")), Some(at("Wall_2k_Height.png")));
        // Two of them: neither.
        assert_eq!(height_beside(&at("door_normal.png")), None);
        assert_eq!(height_beside(&at("floor_normal.png")), None);
        // Of the same tile.
        for name in ["hall_normal.1001.png", "hall_height.1001.png", "hall_height.1002.png"] {
            std::fs::write(at(name), "").unwrap();
        }
        assert_eq!(height_beside(&at("hall_normal.1001.png")), Some(at("hall_height.1001.png")));
    }

    #[test]
    fn names_say_gloss_or_roughness() {
        let says = |name: &str| named_smooth(Path::new(name));
        assert_eq!(says("wall_gloss.png"), Some(true));
        assert_eq!(says("wall_MaskMap.tga"), Some(true));
        assert_eq!(says("wall_orm.png"), Some(false));
        assert_eq!(says("wall_color.png"), None);
    }
}
