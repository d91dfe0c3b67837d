//! Reads the folder that `mipfold build` writes: its manifest, and the PNGs that it lists.

use std::error::Error;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use serde_json::Value;

use crate::maps::{Level, Map, Material};

/// The forms of `manifest.json` that are known.
const SCHEMA: u64 = 1;

/// A texture map that was found by the role of one of its channels.
struct Listed<'a> {
    files: Vec<&'a str>,
    /// Of each channel.
    roles: Vec<&'a str>,
}

/// The material's name, and its folded maps.
pub fn read(folder: &Path) -> Result<(String, Material), Box<dyn Error>> {
    let path = folder.join("manifest.json");
    let about = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let text = std::fs::read(&path).map_err(|e| {
        format!("{} (expected: a folder that `mipfold build -o FOLDER` wrote, or the `mips` of a demo)", about(&e))
    })?;
    let manifest: Value = serde_json::from_slice(&text).map_err(|e| about(&e))?;
    material(folder, &manifest).map_err(|e| about(&e).into())
}

fn material(folder: &Path, manifest: &Value) -> Result<(String, Material), Box<dyn Error>> {
    if manifest["schema"].as_u64() != Some(SCHEMA) {
        return Err(format!("schema {}, expected {SCHEMA}", manifest["schema"]).into());
    }
    let lobes = manifest["count"].as_u64().unwrap_or(1);
    if lobes != 1 {
        return Err(format!("{lobes} lobes a texel: this shader adds up none, build with --lobes iso or aniso").into());
    }
    let maps = listed(manifest)?;
    let find = |role: &str| maps.iter().find(|map| map.roles.contains(&role));
    let normals = find("normal.x").ok_or("no normal map among its PNGs")?;
    let (rough, role) = ["perceptual-roughness", "smoothness"]
        .iter()
        .find_map(|role| find(role).map(|map| (map, *role)))
        .ok_or("no roughness or smoothness among its PNGs")?;
    let y_up = match manifest["normal_y"].as_str() {
        Some("opengl") => true,
        Some("directx") => false,
        _ => return Err(format!("normal_y {}, expected opengl or directx", manifest["normal_y"]).into()),
    };
    let two_channels = manifest["normal_z"] == "rebuild" || !normals.roles.contains(&"normal.z");
    let anisotropy = ["anisotropy.direction.x", "anisotropy.direction.y", "anisotropy.strength"];
    let xyz = ["normal.x", "normal.y", "normal.z"];
    let material = Material {
        normal: normals.load(folder, if two_channels { &xyz[..2] } else { &xyz })?,
        roughness: rough.load(folder, &[role])?,
        anisotropy: find(anisotropy[0]).map(|map| map.load(folder, &anisotropy)).transpose()?,
        y_up,
        normal_scale: manifest["normal_scale"].as_f64().unwrap_or(1.0) as f32,
        two_channels,
        gloss: role == "smoothness",
        mirrored: manifest["wrap"] == "mirror",
    };
    material.normal.check("normal")?;
    material.roughness.check("roughness")?;
    material.anisotropy.iter().try_for_each(|map| map.check("anisotropy"))?;
    Ok((manifest["material"].as_str().unwrap_or("material").to_string(), material))
}

/// All maps that are PNGs.
fn listed(manifest: &Value) -> Result<Vec<Listed<'_>>, Box<dyn Error>> {
    let maps = manifest["maps"].as_array().ok_or("no list `maps`")?;
    let mut out = Vec::new();
    for map in maps.iter().filter(|map| map["container"] == "png") {
        let list = |field: &str| map[field].as_array().ok_or_else(|| format!("a map without `{field}`"));
        let files = list("files")?.iter().filter_map(Value::as_str).collect();
        let roles = list("channels")?.iter().map(|channel| channel["role"].as_str().unwrap_or("other")).collect();
        out.push(Listed { files, roles });
    }
    Ok(out)
}

impl Listed<'_> {
    /// Channels of these roles, level by level; several are filled up to four.
    fn load(&self, folder: &Path, roles: &[&str]) -> Result<Map, Box<dyn Error>> {
        let mut from = Vec::new();
        for role in roles {
            let at = self.roles.iter().position(|r| r == role).ok_or_else(|| format!("no channel {role}"))?;
            from.push(at);
        }
        // Gray stored as colour: green, as `build` reads it.
        if roles.len() == 1 && self.roles.get(1) == Some(&roles[0]) {
            from = vec![1];
        }
        let channels = if roles.len() == 1 { 1 } else { 4 };
        let (mut levels, mut bits) = (Vec::new(), 8);
        for file in &self.files {
            let path = folder.join(file);
            if path.parent() != Some(folder) {
                return Err(format!("{file} is not in its folder").into());
            }
            let picture = decode(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            if picture.channels != self.roles.len() {
                let (found, expected) = (picture.channels, self.roles.len());
                return Err(format!("{}: {found} channels, expected {expected}", path.display()).into());
            }
            bits = bits.max(picture.bits);
            let mut values = Vec::with_capacity(picture.level.width * picture.level.height * channels);
            for texel in picture.level.values.chunks_exact(picture.channels) {
                values.extend(from.iter().map(|&c| texel[c]));
                values.extend((from.len()..channels).map(|_| 0.0));
            }
            levels.push(Level { values, ..picture.level });
        }
        Ok(Map { channels, bits, levels })
    }
}

/// A PNG as it is stored.
struct Picture {
    channels: usize,
    bits: u32,
    level: Level,
}

fn decode(path: &Path) -> Result<Picture, Box<dyn Error>> {
    let mut decoder = png::Decoder::new(BufReader::new(File::open(path)?));
    // Less than 8 bits, and palettes, become 8 bits.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("too large")?];
    let info = reader.next_frame(&mut bytes)?;
    let bytes = &bytes[..info.buffer_size()];
    let (bits, values) = match info.bit_depth {
        png::BitDepth::Sixteen => {
            let value = |b: &[u8]| f32::from(u16::from_be_bytes([b[0], b[1]])) / 65535.0;
            (16, bytes.chunks_exact(2).map(value).collect())
        }
        _ => (8, bytes.iter().map(|&b| f32::from(b) / 255.0).collect()),
    };
    let level = Level { width: info.width as usize, height: info.height as usize, values };
    Ok(Picture { channels: info.color_type.samples(), bits, level })
}
