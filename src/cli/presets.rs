//! `mipfold presets`.

use serde_json::{Value, json};

use super::args::PresetsArgs;
use super::report::Report;
use crate::error::Result;
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
    let head = ["name", "container", "texels", "normals", "green", "packed", "sides", "engine"];
    let rows: Vec<[String; 8]> = std::iter::once(head.map(String::from)).chain(PRESETS.iter().map(row)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default();
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let line = |row: &[String; 8]| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let lines: Vec<String> = rows.iter().map(line).collect();
    format!(
        "{}\n\nPacked: O occlusion, R roughness, S smoothness, M metal, from red on; own: as the map came.\n\
         `mipfold presets NAME` tells why, and how to load the files; `mipfold build --preset NAME` writes them.",
        lines.join("\n")
    )
}

fn row(preset: &Preset) -> [String; 8] {
    let texels = match preset.compress {
        _ if !preset.format.is_texture() => "-",
        Compress::None => "plain",
        Compress::Bc => "bc",
        Compress::Uastc => "uastc",
    };
    let packed = preset.letters();
    [
        preset.name,
        preset.format.extension(),
        texels,
        if preset.normal_z { "xyz" } else { "xy" },
        if preset.normal_y == NormalY::OpenGl { "up" } else { "down" },
        if packed.is_empty() { "own" } else { &packed },
        preset.sides.describe(),
        preset.engine,
    ]
    .map(String::from)
}

/// All about one.
fn page(preset: &Preset) -> String {
    let [_, container, texels, normals, green, packed, sides, engine] = row(preset);
    let levels = if preset.format == Format::Png { ", a file a level" } else { "" };
    let mut lines = vec![format!("{}: {engine}\n", preset.name)];
    for (what, is) in [
        ("container", format!("{container}{levels}")),
        ("texels", texels),
        ("normals", format!("{normals}, green {green}")),
        ("packed", packed),
        ("sides", sides),
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
