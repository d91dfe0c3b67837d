//! A disk that fills up, and a file that may not grow: exit code 2, the file named, nothing left.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stderr)]

mod common;

use std::path::Path;
use std::process::{Command, Output};

use common::{bumps, mipfold, names};

/// Runs a shell script with the binary as `$0`, then the arguments of a build of a 512x512 map.
fn run(script: &str, normal: &Path, out: &Path) -> Output {
    let mut shell = Command::new("sh");
    shell.args(["-c", script]).arg(mipfold().get_program());
    shell.args(["build", "--format", "png,exr", "--moments", "--normal"]).arg(normal).arg("-o").arg(out);
    shell.output().unwrap()
}

fn refused(run: &Output, reason: &str) {
    let stderr = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    let names_a_file = [".png: ", ".exr: "].iter().any(|end| stderr.contains(end));
    assert!(stderr.starts_with("error: ") && names_a_file && stderr.to_lowercase().contains(reason), "{stderr}");
}

#[test]
fn a_file_that_may_not_grow_leaves_nothing() {
    let desk = tempfile::tempdir().unwrap();
    let normal = bumps(&desk.path().join("n.png"), (512, 512));
    // Without its signal, the limit is an error of the write itself.
    let script = r#"trap "" XFSZ; ulimit -f 8; exec "$0" "$@""#;
    refused(&run(script, &normal, &desk.path().join("out/deep")), "file too large");
    assert_eq!(names(desk.path()), ["n.png"]);
    // A folder that was there stays, and stays empty.
    std::fs::create_dir(desk.path().join("there")).unwrap();
    refused(&run(script, &normal, &desk.path().join("there")), "file too large");
    assert_eq!(names(&desk.path().join("there")), [""; 0]);
}

/// On a file system of 200 KB in a mount namespace of its own, which ends with the shell; needs the right to mount.
#[test]
fn a_full_disk_leaves_nothing() {
    let desk = tempfile::tempdir().unwrap();
    let normal = bumps(&desk.path().join("n.png"), (512, 512));
    let disk = desk.path().join("disk");
    std::fs::create_dir(&disk).unwrap();
    let mounted = format!("mount -t tmpfs -o size=200k tmpfs '{}'", disk.display());
    let possible = Command::new("unshare").args(["-m", "sh", "-c", &mounted]).output();
    if !possible.is_ok_and(|run| run.status.success()) {
        // The limit above is the same path through the code, so nothing fails for want of this.
        eprintln!("SKIPPED: no right to mount a file system");
        return;
    }
    for old in ["", "echo old > keep; "] {
        let script = format!(
            r#"exec unshare -m sh -c '{}; cd "{}"; {old}"$0" "$@"; code=$?; ls -A >&2; exit $code' "$0" "$@""#,
            mounted.replace('\'', ""),
            disk.display()
        );
        let mut run = run(&script, &normal, &disk.join("out"));
        let stderr = String::from_utf8_lossy(&run.stderr).into_owned();
        let (message, listed) = stderr.split_once('\n').unwrap();
        assert_eq!(listed, if old.is_empty() { "" } else { "keep\n" }, "left behind");
        run.stderr = message.as_bytes().to_vec();
        refused(&run, "no space left");
    }
}
