use super::*;
use crate::output::Format;

/// What a build of a material "wall" would have written, with these roles.
fn written<R>(preset: &Preset, roles: &[&str], wrap: Wrap, check: impl Fn(&Written) -> R) -> R {
    let levels = 11;
    let files: Vec<Vec<String>> = roles
        .iter()
        .map(|role| {
            let stem = if *role == "packed" { preset.packed_suffix } else { role };
            match preset.format {
                Format::Png => (0..levels).map(|k| format!("wall_{stem}_mip{k}.png")).collect(),
                format => vec![format!("wall_{stem}.{}", format.extension())],
            }
        })
        .collect();
    let maps: Vec<_> = roles
        .iter()
        .zip(&files)
        .map(|(role, files)| WrittenMap { role, files, levels, width: 1024, height: 512 })
        .collect();
    check(&Written { material: "wall", maps: &maps, wrap })
}

fn roles(preset: &Preset) -> [&'static str; 2] {
    ["normal", if preset.packed.is_some() { "packed" } else { "roughness" }]
}

#[test]
fn every_preset_has_facts_with_sources_and_steps() {
    let mut names = std::collections::BTreeSet::new();
    for preset in PRESETS {
        assert!(names.insert(preset.name) && !preset.engine.is_empty(), "{}", preset.name);
        assert_eq!(Preset::by_name(preset.name).unwrap().name, preset.name);
        assert!(preset.facts.len() >= 4 && preset.load.lines().count() >= 4, "{}", preset.name);
        for fact in preset.facts {
            assert!(fact.text.ends_with('.') && !fact.text.contains("  "), "{}: {}", preset.name, fact.text);
            assert!(fact.source.len() > 5 && !fact.source.contains("  "), "{}: {}", preset.name, fact.source);
        }
        assert!(preset.facts.iter().filter(|fact| fact.checked).count() >= 3, "{}", preset.name);
        assert_eq!(preset.packed.is_some(), !preset.packed_suffix.is_empty(), "{}", preset.name);
        assert!((0.0..=1.0).contains(&preset.without_metal), "{}", preset.name);
    }
    let said = Preset::by_name("quake").unwrap_err().to_string();
    assert!(said.contains("'quake'") && names.iter().all(|name| said.contains(name)), "{said}");
}

/// An engine that makes z of two channels gets two where compression has a format for them; and blocks want whole blocks.
#[test]
fn presets_agree_with_themselves() {
    for preset in PRESETS {
        if !preset.normal_z {
            assert_eq!(preset.compress, Compress::Bc, "{}", preset.name);
        }
        if preset.format.is_texture() && preset.compress != Compress::None {
            assert_ne!(preset.sides, Sides::Any, "{}", preset.name);
        }
        assert!(preset.format != Format::Dds || preset.compress != Compress::Uastc, "{}", preset.name);
        let slots = preset.packed.unwrap_or_default();
        let width = slots.iter().filter(|slot| matches!(slot, Slot::Roughness | Slot::Smoothness)).count();
        assert_eq!(width, usize::from(preset.packed.is_some()), "{}", preset.name);
        assert!(slots.len() <= 4 && preset.letters().len() == slots.len(), "{}", preset.name);
    }
}

#[test]
fn readmes_are_short_and_name_only_files_that_are_written() {
    let endings = [".png", ".exr", ".ktx2", ".dds", ".meta", ".cs.txt"];
    for preset in PRESETS {
        for roles in [&roles(preset)[..], &["normal"], &["normal", roles(preset)[1], "anisotropy", "lobe", "energy"]] {
            written(preset, roles, Wrap::Repeat, |written| {
                let asides = preset.asides(written);
                let names: Vec<&str> = asides.iter().map(|aside| aside.name.as_str()).collect();
                let readme = &asides[0].text;
                assert_eq!(names[0], README);
                assert!(readme.lines().count() < 60, "{}: {} lines", preset.name, readme.lines().count());
                let wide = readme.lines().find(|line| line.chars().count() > 80);
                assert_eq!(wide, None, "{}", preset.name);
                assert!(readme.is_ascii() && !readme.contains("{normal") && !readme.contains("{packed"), "{readme}");
                let breaks = |c: char| c.is_whitespace() || "'\",;:()[]{}/".contains(c);
                for word in readme.split(breaks).map(|word| word.trim_end_matches('.').replace("%d", "3")) {
                    if !endings.iter().any(|ending| word.ends_with(ending) && word != *ending) {
                        continue;
                    }
                    let map = written.maps.iter().any(|map| map.files.contains(&word));
                    assert!(map || names.contains(&word.as_str()), "{}: {word} is not written", preset.name);
                }
                for map in written.maps {
                    assert!(readme.contains(&map.files[0]), "{}: {}", preset.name, map.files[0]);
                }
            });
        }
    }
}

#[test]
fn what_was_not_verified_is_told() {
    for preset in PRESETS {
        let readme = written(preset, &roles(preset), Wrap::Repeat, |written| preset.readme(written));
        let unverified = preset.facts.iter().filter(|fact| !fact.checked).count();
        let told = readme.split_whitespace().collect::<Vec<_>>().join(" ").matches("(Not verified.)").count();
        assert_eq!(told, unverified, "{}", preset.name);
    }
}

/// Bevy's setting is one that its files cannot give themselves.
#[test]
fn bevy_has_a_meta_file_for_every_texture() {
    let preset = Preset::by_name("bevy").unwrap();
    for (wrap, mode) in [(Wrap::Repeat, "Repeat"), (Wrap::Mirror, "MirrorRepeat"), (Wrap::Clamp, "ClampToEdge")] {
        written(preset, &["normal", "packed", "anisotropy"], wrap, |written| {
            let asides = preset.asides(written);
            let metas: Vec<_> = asides.iter().filter(|aside| aside.name.ends_with(".meta")).collect();
            assert_eq!(metas.len(), 3);
            for (meta, map) in metas.iter().zip(written.maps) {
                assert_eq!(meta.name, format!("{}.meta", map.files[0]));
                assert!(meta.text.contains("is_srgb: false,"), "{}", meta.text);
                assert_eq!(meta.text.matches(&format!(": {mode},")).count(), 3, "{}", meta.text);
                let count = |c| meta.text.matches(c).count();
                assert_eq!(count('('), count(')'));
            }
        });
    }
}

/// One script for a project: another copy in a format that Unity compiles would be an error there.
#[test]
fn unity_has_its_script_as_a_text() {
    for name in ["unity", "unity-hdrp"] {
        let preset = Preset::by_name(name).unwrap();
        let asides = written(preset, &roles(preset), Wrap::Repeat, |written| preset.asides(written));
        let script = &asides[1];
        assert!(script.name.ends_with(".txt"), "{}", script.name);
        assert!(script.text.contains("not run in the engine") && script.text.contains("void OnPostprocessTexture"));
        // It knows maps by what the manifest calls them.
        for word in [crate::material::MANIFEST, crate::material::GENERATOR, "\"normal\""] {
            assert!(script.text.contains(word), "{word}");
        }
        assert!(script.text.lines().all(|line| line.len() <= 120));
    }
}
