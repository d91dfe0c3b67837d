//! `mipfold demo`: what it leaves behind.

mod common;

use common::desk::Desk;
use common::{mipfold, names};
use serde_json::Value;

/// The sample is judged too.
#[test]
fn the_demo_writes_a_report_beside_its_picture() {
    let desk = Desk::empty();
    let run = |args: &str| mipfold().args(desk.args(args)).output().unwrap();
    let demo = run("demo --size 32 -o @demo");
    assert_eq!(demo.status.code(), Some(0), "{}", String::from_utf8_lossy(&demo.stderr));
    let folder = desk.at("demo/woven-cloth");
    let expected = ["distance.png", "mips", "normal.png", "orm.png", "report.csv", "report.html", "report.json"];
    assert_eq!(names(&folder), expected);
    let report: Value = serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap();
    let chains: Vec<_> = report["chains"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(chains, ["folded", "plain mips"]);
    // Again, over its own files; not over a stranger's.
    assert_eq!(run("demo --size 32 --dry-run -o @demo").status.code(), Some(0));
    desk.file("demo/woven-cloth/report.json", b"mine");
    assert_eq!(run("demo --size 32 --dry-run -o @demo").status.code(), Some(2));
}
