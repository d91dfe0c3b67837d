//! `mipfold compare`: chains of every form, what it says and writes, limits and exit codes.

mod common;

use common::desk::Desk;
use common::{bump, encode8, mipfold, names, png8};
use serde_json::Value;

/// A desk with a pair of maps, its build in every container as `out`, and the OpenGL base's flags.
fn built() -> Desk {
    let desk = Desk::new();
    png8(&desk.at("r.png"), (64, 64), |x, y| vec![(60 + x + y) as u8]);
    desk.build("out", "--normal @n.png --roughness @r.png --format png,exr");
    desk
}

const BASE: &str = "--normal @n.png --roughness @r.png";
/// A look that takes no time.
const QUICK: &str = "--texels 4 --directions 8 --levels 0-2 --no-motion";

/// Exit code, standard output, standard error. `^` stands for the `@` of a limit.
fn run(desk: &Desk, args: &str) -> (Option<i32>, String, String) {
    let args: Vec<String> = desk.args(args).into_iter().map(|arg| arg.replace('^', "@")).collect();
    let run = mipfold().arg("compare").args(&args).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let (out, err) = (text(run.stdout), text(run.stderr));
    assert!(!err.contains("panicked"), "{args:?}: {err}");
    (run.status.code(), out, err)
}

/// The JSON of a run that must end well.
fn json(desk: &Desk, args: &str) -> Value {
    let (code, out, err) = run(desk, &format!("{args} --json"));
    assert_eq!((code, err.as_str()), (Some(0), ""), "{args}");
    serde_json::from_str(&out).unwrap_or_else(|e| panic!("{args}: {e}: {out}"))
}

fn chains(report: &Value) -> Vec<String> {
    report["chains"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap().to_owned()).collect()
}

/// Names of the chains that would be judged.
fn would_judge(desk: &Desk, args: &str) -> Vec<String> {
    chains(&json(desk, &format!("{args} --dry-run")))
}

/// The comparison must refuse, on one line that names the culprits, and leave the desk as it was.
fn refuses(desk: &Desk, args: &str, culprits: &[&str]) {
    let before = desk.tree();
    let (code, out, err) = run(desk, args);
    assert_eq!((code, out.contains("lobe error")), (Some(2), false), "{args}: {err}");
    assert_eq!(err.lines().count(), 1, "{args}: {err}");
    assert!(err.starts_with("error: ") && culprits.iter().all(|c| err.contains(c)), "{args}: {err} lacks {culprits:?}");
    assert_eq!(desk.tree(), before, "{args}: files changed");
}

/// Mean lobe error of a level of a chain.
fn error(report: &Value, chain: usize, level: usize) -> f64 {
    let found = &report["chains"][chain]["levels"][level];
    assert_eq!(found["level"], level, "{report}");
    found["lobe_error"]["mean"].as_f64().unwrap()
}

#[test]
fn chains_stand_side_by_side_under_names_of_their_own() {
    let desk = built();
    std::fs::create_dir(desk.at("far")).unwrap();
    let judged = |args: &str| would_judge(&desk, args);
    assert_eq!(judged("@out"), ["out", "plain mips"]);
    assert_eq!(
        judged("@out @out,container=exr @out,container=lobes,name=full"),
        ["out", "out (exr)", "full", "plain mips"]
    );
    assert_eq!(judged("@out/n_lobes.exr --no-plain"), ["n_lobes"]);
    assert_eq!(judged("@out --fold toksvig,lean"), ["out", "toksvig", "lean", "plain mips"]);
    assert_eq!(judged(BASE), ["ggx", "plain mips"]);
    assert_eq!(judged("--base @out --fold average"), ["average", "plain mips"]);
    let all = judged(&format!("{BASE} --fold all"));
    let quick = mipfold::fold::FOLDS.iter().filter(|fold| !fold.is_slow()).count();
    assert_eq!(all.len(), quick, "{all:?}");
    assert_eq!(judged(&format!("{BASE} --fold all --no-plain")).len(), all.len());
    assert_eq!(judged("normal=@out/n_mip%d.png,roughness=@out/r_mip%d.png")[0], "n_mip");
    assert_eq!(judged("normal=@out/n.exr,roughness=0.4,name=mine")[0], "mine");
    // A folder with a comma in its name is a folder.
    std::fs::rename(desk.at("out"), desk.at("out,a=b")).unwrap();
    assert_eq!(judged("@out,a=b")[0], "out,a=b");
    assert_eq!(judged("@out,a=b,container=lobes")[0], "out,a=b (lobes)");
}

#[test]
fn the_base_comes_from_flags_a_folder_or_the_chain() {
    let desk = built();
    let says = |args: &str| run(&desk, &format!("{args} --dry-run")).1;
    assert!(says("@out").contains("judged against level 0 of out"), "{}", says("@out"));
    assert!(says(&format!("@out {BASE}")).contains("judged against the maps given"));
    std::fs::create_dir(desk.at("set")).unwrap();
    for (from, to) in [("n.png", "set/wall_normal.png"), ("r.png", "set/wall_roughness.png")] {
        std::fs::copy(desk.at(from), desk.at(to)).unwrap();
    }
    assert!(says("@out --base @set").contains("judged against the maps of"), "{}", says("@out --base @set"));
    assert!(says("--base @out").contains("judged against level 0 of"));
    std::fs::copy(desk.at("n.png"), desk.at("set/floor_normal.png")).unwrap();
    refuses(&desk, "@out --base @set", &["2 materials", "floor, wall"]);
    refuses(&desk, "", &["nothing to judge"]);
    refuses(&desk, "@out --roughness 0.3", &["no maps"]);
    png8(&desk.at("small.png"), (32, 32), |x, y| bump(x, y, 32).map(encode8).to_vec());
    refuses(&desk, "@out --normal @small.png", &["out", "64x64", "32x32"]);
}

#[test]
fn wrong_chains_are_refused_by_name() {
    let desk = built();
    let pair = "normal=@out/n_mip%d.png,roughness=@out/r_mip%d.png";
    refuses(&desk, "@gone", &["gone", "no such folder or file"]);
    refuses(&desk, "@n.png", &["n.png", "a single file"]);
    refuses(&desk, "@out,container=ktx", &["container=ktx", "png, ktx2, dds, exr or lobes"]);
    refuses(&desk, "@out,normal-y=directx", &["normal-y", "manifest"]);
    refuses(&desk, &format!("{pair},colour=x"), &["colour=x", "normal-scale"]);
    refuses(&desk, &format!("{pair},normal=x"), &["normal twice"]);
    refuses(&desk, &format!("{pair},normal-y=up"), &["normal-y=up", "opengl or directx"]);
    refuses(&desk, &format!("{pair},container=exr"), &["container without a folder"]);
    refuses(&desk, &format!("{pair},normal=x,y_%d.png"), &["normal twice"]);
    refuses(&desk, "normal=@out/n_mip%d.png,roughness=2", &["roughness=2 in normal=", "from 0 to 1"]);
    refuses(&desk, "normal=@out/n_mip%i.png,roughness=0.5", &["n_mip%i.png", "%d for the level"]);
    refuses(&desk, "normal=@a,b_%d.png,roughness=0.5", &["a,b_0.png"]);
    refuses(&desk, &format!("{pair},smoothness=@r.png"), &["roughness, smoothness and orm"]);
    refuses(&desk, "normal=@out/n_mip%d.png", &["without roughness"]);
    refuses(&desk, "normal=@n.png,roughness=@r.png", &["n.png", "%d"]);
    refuses(&desk, "@out/n.exr", &["n.exr", "n.x"]);
    let file = desk.at("out/r_mip2.png");
    let whole = std::fs::read(&file).unwrap();
    png8(&file, (15, 16), |_, _| vec![1]);
    refuses(&desk, pair, &["r_mip2.png", "15x16", "16x16"]);
    refuses(&desk, "@out", &["r_mip2.png", "15x16", "16x16"]);
    std::fs::remove_file(&file).unwrap();
    refuses(&desk, pair, &["r_mip2.png", "no such file"]);
    refuses(&desk, "@out", &["r_mip2.png is not there"]);
    std::fs::write(&file, whole).unwrap();
    std::fs::create_dir(desk.at("none")).unwrap();
    refuses(&desk, "@none", &["none", "no manifest.json"]);
    std::fs::create_dir(desk.at("two")).unwrap();
    std::fs::rename(desk.at("out"), desk.at("two/a")).unwrap();
    refuses(&desk, "@two", &["two/a"]);
}

#[test]
fn wrong_options_are_refused() {
    let desk = built();
    refuses(&desk, "@out --levels 7", &["--levels", "levels from 0 to 6"]);
    refuses(&desk, "@out --levels 0-2 --limit ^3=0.1", &["--limit lobe-error@3=0.1", "'out'", "0, 1, 2"]);
    refuses(&desk, "@out --lobes aniso", &["--lobes", "--fold"]);
    refuses(&desk, &format!("{BASE} --fold toksvig --lobes aniso"), &["toksvig", "one width only"]);
    refuses(&desk, &format!("{BASE} --fold toksvig --lobes 3"), &["--lobes 3", "toksvig", "one lobe only"]);
    for args in
        ["--levels x", "--texels 0", "--limit tv=1", "--limit ^4-1=1", "--fold mine", "--directions 0", "--subset 0"]
    {
        let (code, _, err) = run(&desk, &format!("@out {args}"));
        let value = args.split(' ').nth(1).unwrap();
        assert!(code == Some(2) && err.contains(&value.replace('^', "@")), "{args}: {err}");
    }
}

/// A chain that lacks the levels of a limit must not pass it.
#[test]
fn limits_must_meet_a_judged_level_of_every_chain() {
    let desk = built();
    for k in 0..3 {
        for map in ["n", "r"] {
            std::fs::copy(desk.at(&format!("out/{map}_mip{k}.png")), desk.at(&format!("{map}_{k}.png"))).unwrap();
        }
    }
    let short = "normal=@n_%d.png,roughness=@r_%d.png,name=short";
    let look = "--texels 4 --directions 8";
    refuses(&desk, &format!("@out {short} {look} --limit ^5=2"), &["--limit lobe-error@5=2", "'short'", "0 to 2"]);
    refuses(&desk, &format!("@out {short} {look} --levels 4"), &["short", "levels 0 to 2", "--levels 4"]);
    refuses(&desk, &format!("{short} {look} --levels 1,4 --limit 2 --limit energy^2=1"), &["energy@2=1", "0 to 2"]);
    // Levels that a limit names must all be there; one without an end takes what there is.
    refuses(&desk, &format!("@out {short} {look} --levels 1,5 --limit ^1-5=2"), &["@1-5=2", "'short'", "0 to 2"]);
    assert_eq!(run(&desk, &format!("@out {short} {look} --levels 1,5 --limit ^1-=2")).0, Some(0));
    // The input itself passes any limit; it is no proof, unless it was asked for.
    let alone = "normal=@only_%d.png,roughness=@only_r_%d.png,name=alone";
    std::fs::copy(desk.at("n_0.png"), desk.at("only_0.png")).unwrap();
    std::fs::copy(desk.at("r_0.png"), desk.at("only_r_0.png")).unwrap();
    refuses(&desk, &format!("{alone} {look} --limit 0.01"), &["--limit lobe-error=0.01", "'alone'"]);
    assert_eq!(run(&desk, &format!("{alone} {look} --levels 0 --limit 0.01")).0, Some(0));
}

/// What stands in the way of a report is found before anything is judged.
#[test]
fn reports_need_a_folder() {
    let desk = built();
    let file = desk.file("taken", b"mine");
    let file = file.to_str().unwrap();
    for place in ["taken", "taken/sub/deep"] {
        refuses(&desk, &format!("@out -o @{place}"), &[file, "found a file", "a folder"]);
        refuses(&desk, &format!("@out -o @{place} --dry-run"), &[file, "found a file"]);
    }
}

/// A JSON of ours speaks for itself alone.
#[test]
fn strangers_files_beside_a_report_stay() {
    let desk = built();
    assert_eq!(run(&desk, &format!("@out -o @report {QUICK}")).0, Some(0));
    for (name, text) in [("report.html", "<html>mine</html>"), ("report.csv", "name,age\r\n")] {
        let ours = std::fs::read(desk.at("report").join(name)).unwrap();
        desk.file(&format!("report/{name}"), text.as_bytes());
        refuses(&desk, "@out -o @report --dry-run", &[name, "--force"]);
        std::fs::write(desk.at("report").join(name), ours).unwrap();
    }
    assert_eq!(run(&desk, "@out -o @report --dry-run").0, Some(0));
}

/// What was judged stands in the report.
#[test]
fn reports_name_the_source_of_every_chain() {
    let desk = built();
    // A name that contradicts the option is warned about.
    for k in 0..7 {
        std::fs::copy(desk.at(&format!("out/n_mip{k}.png")), desk.at(&format!("NormalDX_{k}.png"))).unwrap();
    }
    let foreign = "normal=@NormalDX_%d.png,roughness=0.5,name=theirs";
    let args = desk.args(&format!("@out,container=exr {foreign} --fold lean {QUICK} --json"));
    let run = mipfold().arg("compare").args(&args).output().unwrap();
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    let chain = |i: usize| &report["chains"][i];
    assert_eq!((&chain(0)["name"], &chain(0)["container"]), (&"out (exr)".into(), &"exr".into()));
    assert_eq!(chain(0)["source"], args[0].as_str());
    assert_eq!((&chain(1)["source"], &chain(1)["container"]), (&args[1].as_str().into(), &Value::Null));
    assert!(chain(1)["warnings"][0].as_str().unwrap().contains("NormalDX_0"), "{}", chain(1));
    assert_eq!(chain(2)["source"], "folded from the surface");
    assert!(chain(3)["source"].as_str().unwrap().contains("averaged"));
}

#[test]
fn a_dry_run_reads_everything_and_writes_nothing() {
    let desk = built();
    let before = desk.tree();
    let (code, out, err) = run(&desk, "@out --fold lean -o @report --dry-run");
    assert_eq!((code, err.as_str()), (Some(0), ""));
    assert!(out.contains("would judge out, lean, plain mips") && out.contains("report/report.html"), "{out}");
    assert_eq!(desk.tree(), before);
    let said = json(&desk, "@out -o @report --dry-run --levels 1-");
    assert_eq!((&said["dry_run"], &said["chains"][0]["levels"]), (&true.into(), &7.into()));
    assert_eq!(said["settings"]["levels"].as_array().unwrap().len(), 6);
    assert_eq!(said["files"].as_array().unwrap().len(), 3);
    std::fs::remove_file(desk.at("out/r_mip2.png")).unwrap();
    refuses(&desk, "@out --dry-run", &["r_mip2.png"]);
}

#[test]
fn reports_are_written_by_the_rules_of_the_house() {
    let desk = built();
    let report = |name: &str| desk.at(name).join("report.json");
    let (code, out, err) = run(&desk, &format!("@out -o @report {QUICK}"));
    assert_eq!((code, err.as_str()), (Some(0), ""));
    assert!(out.contains("plain mips") && out.contains("wrote report"), "{out}");
    assert_eq!(names(&desk.at("report")), ["report.csv", "report.html", "report.json"]);
    let written: Value = serde_json::from_slice(&std::fs::read(report("report")).unwrap()).unwrap();
    assert_eq!(written["generator"], "mipfold");
    // Ours again, and beside a chain of ours.
    assert_eq!(run(&desk, &format!("@out -o @report {QUICK}")).0, Some(0));
    assert_eq!(run(&desk, &format!("@out -o @out {QUICK}")).0, Some(0));
    std::fs::create_dir(desk.at("mine")).unwrap();
    desk.file("mine/report.json", b"{\"generator\": \"mine\"}");
    refuses(&desk, &format!("@out -o @mine {QUICK}"), &["mine/report.json", "--force"]);
    assert_eq!(run(&desk, &format!("@out -o @mine --force {QUICK}")).0, Some(0));
    std::fs::create_dir_all(desk.at("way/report.csv")).unwrap();
    refuses(&desk, &format!("@out -o @way --force {QUICK}"), &["way/report.csv"]);
}

#[test]
fn json_is_the_report_and_quiet_is_silent() {
    let desk = built();
    let printed = json(&desk, &format!("@out {QUICK} --fold lean -o @report"));
    let written: Value = serde_json::from_slice(&std::fs::read(desk.at("report/report.json")).unwrap()).unwrap();
    assert_eq!(printed, written);
    assert_eq!(chains(&printed), ["out", "lean", "plain mips"]);
    assert_eq!(run(&desk, &format!("@out {QUICK} --quiet --limit 2")), (Some(0), String::new(), String::new()));
    let (code, out, _) = run(&desk, "@gone --json");
    let said: Value = serde_json::from_str(&out).unwrap();
    assert!(code == Some(2) && said["errors"][0].as_str().unwrap().contains("gone"), "{out}");
}

/// The same surface in other packings and conventions is the same chain.
#[test]
fn conventions_of_foreign_chains_are_understood() {
    let desk = built();
    let copy = |name: &str, from: &str, texel: &dyn Fn(&[u8]) -> Vec<u8>| {
        for k in 0..7 {
            let raster = common::read(&desk.at(&format!("out/{from}_mip{k}.png")));
            let size = raster.size();
            let (samples, channels) = (common::integers(&raster).0, raster.channels.len());
            let samples: Vec<u8> = samples.into_iter().map(|v| v as u8).collect();
            let at = |x: usize, y: usize| texel(&samples[(y * size.width + x) * channels..][..channels]);
            png8(&desk.at(&format!("{name}_{k}.png")), (size.width, size.height), at);
        }
    };
    copy("dx", "n", &|n| vec![n[0], 255 - n[1], n[2]]);
    copy("xy", "n", &|n| vec![n[0], n[1]]);
    copy("smooth", "r", &|r| vec![0, 9, 200, 255 - r[0]]);
    copy("orm", "r", &|r| vec![0, r[0], 200]);
    let specs = [
        "@out",
        "normal=@dx_%d.png,normal-y=directx,roughness=@orm_%d.png:g",
        "normal=@out/n_mip%d.png,smoothness=@smooth_%d.png:a",
        "normal=@xy_%d.png,orm=@orm_%d.png",
        "normal=@dx_%d.png,orm=@orm_%d.png,name=wrong",
    ];
    let report = json(&desk, &format!("{} {BASE} {QUICK}", specs.join(" ")));
    let at = |chain| [0, 1, 2].map(|level| error(&report, chain, level));
    let own = at(0);
    assert_eq!(own[0], 0.0);
    // Turned signs and 1 - smoothness round in the last bit of a float. z of two channels is rebuilt: equal up to the
    // rounding of a stored z.
    for (chain, most) in [(1, 1e-4), (2, 1e-4), (3, 0.05)] {
        assert!(at(chain).iter().zip(own).all(|(a, b)| (a - b).abs() < most), "{:?} {own:?}", at(chain));
    }
    assert!(at(4)[0] > 0.2, "a convention read wrongly must show: {:?}", at(4));
}

#[test]
fn every_container_is_right_at_level_0_and_close_to_the_others() {
    let desk = built();
    let report = json(&desk, &format!("@out @out,container=exr @out,container=lobes @out/n_lobes.exr {BASE} {QUICK}"));
    assert_eq!([0, 2, 3].map(|chain| error(&report, chain, 0)), [0.0; 3]);
    for level in 0..3 {
        let lossless = error(&report, 2, level);
        assert_eq!(error(&report, 3, level), lossless);
        for chain in [0, 1] {
            let found = error(&report, chain, level);
            assert!((found - lossless).abs() < 0.05, "level {level} of chain {chain}: {found}, lossless {lossless}");
        }
    }
    // A fold on the fly is the fold that was built.
    let report = json(&desk, &format!("@out,container=lobes --fold ggx {QUICK}"));
    for level in 0..3 {
        assert!((error(&report, 0, level) - error(&report, 1, level)).abs() < 1e-4);
    }
}

#[test]
fn limits_decide_the_exit_code() {
    let desk = built();
    let limited = |args: &str| run(&desk, &format!("@out {BASE} {QUICK} {args}"));
    let (code, out, err) = limited("--limit ^0=0");
    assert_eq!((code, err.as_str()), (Some(0), ""), "{out}");
    assert!(out.contains("64x64") && out.contains("0.000 +- 0.000"), "{out}");
    let (code, _, err) = limited("--limit 0");
    assert_eq!((code, err.lines().count()), (Some(1), 1), "{err}");
    let worst = err.contains("out: level 1: lobe-error") || err.contains("out: level 2: lobe-error");
    assert!(worst && err.contains("over the limit 0; 1 more level fails"), "{err}");
    // Each chain has its line, plain mips have none.
    let (code, _, err) = limited("@out/n_lobes.exr --fold toksvig --limit ^2=0");
    assert_eq!((code, err.lines().count()), (Some(1), 3), "{err}");
    assert!(!err.contains("plain mips") && err.lines().all(|line| line.contains("level 2")), "{err}");
    let (code, out, err) = limited("--limit 0 --quiet -o @report");
    assert_eq!((code, out.as_str(), err.lines().count()), (Some(1), "", 1));
    assert!(desk.at("report/report.html").is_file(), "a report is wanted most where something fails");
    // Bad input wins.
    assert_eq!(limited("--limit 0 @gone").0, Some(2));
}

#[test]
fn equal_seeds_give_equal_reports() {
    let desk = built();
    let report = |args: &str| json(&desk, &format!("@out --texels 4 --directions 8 {args}"))["chains"].clone();
    let differ = |a: &str, b: &str| assert!(report(a) != report(b), "{a} is {b}");
    assert_eq!(report("--levels 0-2 --seed 7 --threads 1"), report("--levels 0-2 --seed 7 --threads 2"));
    differ("--levels 0-2 --seed 7", "--levels 0-2 --seed 8");
    differ("--levels 2 --interpolation constant", "--levels 2 --interpolation bilinear");
    differ("--levels 5", "--levels 5 --subset 16");
}

/// Real textures: what was built is right at level 0, whatever its packing, depth or convention.
#[test]
fn real_textures_are_right_at_level_0() {
    let Some(textures) = common::textures() else { return };
    let desk = Desk::empty();
    // Folders and files of the textures are marked.
    let cases = [
        ("packed", "^ground037_packed"),
        ("set", "^metal027"),
        ("directx", "--normal ^metal027/normal_dx.jpg --normal-y directx --roughness ^metal027/roughness.jpg"),
        (
            "sixteen",
            "--normal ^rosewood_veneer1_16bit/normal.png --roughness ^rosewood_veneer1_16bit/roughness_in_g.png:g",
        ),
    ];
    let root = format!("{}/", textures.display());
    for (name, args) in cases {
        let args: Vec<String> = args.split(' ').map(|word| word.replace('^', &root)).collect();
        common::build(&args, &desk.at(name));
        let base: Vec<String> = if args.len() == 1 { vec!["--base".into(), args[0].clone()] } else { args };
        let mut command = mipfold();
        command.arg("compare").arg(desk.at(name)).args(base).args(QUICK.split(' ')).args(["--limit", "@0=0"]);
        let run = command.output().unwrap();
        assert_eq!(run.status.code(), Some(0), "{name}: {}", String::from_utf8_lossy(&run.stderr));
    }
}
