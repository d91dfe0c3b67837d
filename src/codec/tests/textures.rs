//! Real textures, where there are any: the folder named by `MIPFOLD_TEXTURES`, or `../shared/textures`.

use super::*;

fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, found);
        } else {
            found.push(path);
        }
    }
}

#[test]
#[allow(clippy::print_stdout)]
fn decodes_every_real_texture() {
    let folder = std::env::var_os("MIPFOLD_TEXTURES")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/textures"), PathBuf::from);
    if !folder.is_dir() {
        println!("SKIPPED: no textures at {}", folder.display());
        assert!(std::env::var_os("MIPFOLD_NO_SKIP").is_none(), "no textures at {}", folder.display());
        return;
    }
    let mut files = Vec::new();
    files_below(&folder, &mut files);
    let pictures = files.iter().filter(|path| {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        ["png", "jpg", "jpeg", "tif", "tiff", "tga", "bmp", "webp", "hdr", "exr"].iter().any(|e| extension == *e)
    });
    let mut count = 0;
    for path in pictures {
        let decoded = read(path).unwrap_or_else(|error| panic!("{error}"));
        assert!(decoded.raster.size().texels() > 1, "{}", path.display());
        count += 1;
    }
    assert!(count > 0, "no pictures in {}", folder.display());
}
