//! `mipfold kernels`.

mod common;

use common::mipfold;
use mipfold::kernels::{KERNELS, Language, bundle, by_name};

fn printed(args: &[&str]) -> String {
    let run = mipfold().arg("kernels").args(args).output().unwrap();
    assert!(run.status.success(), "{args:?}: {}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap()
}

#[test]
fn without_names_the_files_are_listed() {
    let list = printed(&[]);
    for kernel in KERNELS {
        assert!(list.lines().any(|line| line.trim_start().starts_with(kernel.name)), "{list}");
    }
    let json: serde_json::Value = serde_json::from_str(&printed(&["--json"])).unwrap();
    let names: Vec<_> = json["kernels"].as_array().unwrap().iter().map(|kernel| &kernel["name"]).collect();
    assert_eq!(names, KERNELS.iter().map(|kernel| kernel.name).collect::<Vec<_>>());
}

#[test]
fn files_are_printed_alone_or_with_all_that_they_need() {
    for (word, language) in [("wgsl", Language::Wgsl), ("glsl", Language::Glsl), ("hlsl", Language::Hlsl)] {
        for kernel in KERNELS {
            assert_eq!(printed(&[kernel.name, "--lang", word]).trim_end(), kernel.text(language).trim_end());
        }
        let footprint = by_name("footprint").unwrap();
        let whole = printed(&["footprint", "--lang", word, "--bundle"]);
        assert_eq!(whole.trim_end(), bundle(&[footprint], language).trim_end());
        for needed in footprint.needs() {
            assert_eq!(whole.matches(needed.text(language)).count(), 1, "{word}: {}", needed.name);
        }
    }
}

#[test]
fn an_unknown_file_is_told_with_all_that_there_are() {
    let run = mipfold().args(["kernels", "nfd"]).output().unwrap();
    assert_eq!(run.status.code(), Some(2));
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(said.contains("'nfd'") && KERNELS.iter().all(|kernel| said.contains(kernel.name)), "{said}");
}
