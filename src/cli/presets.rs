//! `mipfold presets`.

use serde_json::{Value, json};

use super::args::PresetsArgs;
use super::report::Report;
use crate::error::Result;
use crate::image::Sides;
use crate::material::NormalY;
use crate::output::Format;
use crate::output::preset::{Compress, PRESETS, Preset, fill, said};

pub fn run(args: &PresetsArgs, report: &mut Report) -> Result<()> {
    if let Some(name) = &args.name {
        let preset = Preset::by_name(name)?;
        report.document(whole(preset).to_string());
        report.say(&page(preset));
        return Ok(());
    }
    let presets: Vec<Value> = PRESETS.iter().map(listed).collect();
    report.document(json!({ "schema": 1, "presets": presets }).to_string());
    report.say(&table());
    Ok(())
}

/// All of them, a line each.
fn table() -> String {
    let head = ["name", "container", "normals", "packed", "sides", "engine"].map(String::from);
    let rows: Vec<[String; 6]> = std::iter::once(head).chain(PRESETS.iter().map(row)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default();
    let widths: [usize; 6] = std::array::from_fn(width);
    let line = |row: &[String; 6]| {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let lines: Vec<String> = rows.iter().map(line).collect();
    format!(
        "{}\n\nNormals: the channels, and where green points. Packed: O occlusion, R roughness,\n\
         S smoothness, M metal, from red on; own: as the map came. Sides: see --resize.\n\n\
         `mipfold presets NAME` tells why, and how to load the files;\n\
         `mipfold build --preset NAME` writes them.",
        lines.join("\n")
    )
}

/// In words that `--format`, `--compress` and `--resize` take, where they do.
fn row(preset: &Preset) -> [String; 6] {
    let texels = match preset.compress {
        _ if !preset.format.is_texture() => "",
        Compress::None => " none",
        Compress::Bc => " bc",
        Compress::Uastc => " uastc",
    };
    let green = if preset.normal_y == NormalY::OpenGl { "up" } else { "down" };
    let packed = preset.letters();
    let sides = match preset.sides {
        Sides::Any => "any",
        Sides::MultipleOf4 => "4",
        Sides::PowerOfTwo => "pot",
    };
    [
        preset.name.into(),
        format!("{}{texels}", preset.format.extension()),
        format!("{} {green}", if preset.normal_z { "xyz" } else { "xy" }),
        if packed.is_empty() { "own".into() } else { packed },
        sides.into(),
        preset.engine.into(),
    ]
}

/// All about one.
fn page(preset: &Preset) -> String {
    let [_, container, normals, packed, _, engine] = row(preset);
    let levels = if preset.format == Format::Png { ", a file a level" } else { "" };
    let mut lines = vec![format!("{}: {engine}\n", preset.name)];
    for (what, is) in [
        ("container", format!("{container}{levels}")),
        ("normals", normals),
        ("packed", packed),
        ("sides", preset.sides.describe().into()),
    ] {
        lines.push(format!("  {what:<10} {is}"));
    }
    lines.push("\nHow to load the files:\n".into());
    lines.push(preset.steps());
    lines.push("\nFacts and their sources:\n".into());
    for fact in preset.facts {
        lines.extend(fill(&said(fact), "  - ", "    "));
        lines.extend(fill(&format!("[{}]", fact.source), "      ", "      "));
    }
    lines.join("\n")
}

fn listed(preset: &Preset) -> Value {
    json!({
        "name": preset.name,
        "engine": preset.engine,
        "container": preset.format,
        "compress": preset.format.is_texture().then_some(preset.compress),
        "normal_channels": if preset.normal_z { 3 } else { 2 },
        "normal_y": preset.normal_y,
        "packed": preset.packed,
        "packed_suffix": preset.packed.map(|_| preset.packed_suffix),
        "without_metal": preset.packed.map(|_| preset.without_metal),
        "sides": preset.sides.describe(),
    })
}

fn whole(preset: &Preset) -> Value {
    let mut value = listed(preset);
    value["schema"] = json!(1);
    value["facts"] = json!(preset.facts);
    value["load"] = json!(preset.steps());
    value
}
