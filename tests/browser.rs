//! The report in a browser: it loads without a word on the console, its controls work, and it stays small.
//!
//! `MIPFOLD_CHROMIUM` is the Chromium or Chrome to use, by default `chromium`.

mod common;

use std::path::Path;
use std::process::Command;

use common::browser::chromium;
use common::or_skip;
use mipfold::codec::{decode, write_png};
use mipfold::compare::{Candidate, Settings, judge};
use mipfold::fold::{DEFAULT_FOLD, FOLDS, Fold, Options, chain};
use mipfold::image::{Raster, Samples};
use mipfold::material::{ChannelRef, Inputs, Material, RoughnessInput, base_lobes, load_with};
use mipfold::ndf::Form;
use mipfold::reference::Reading;
use mipfold::report::{Subject, motion, page};
use mipfold::sample::by_name;
use ndarray::Array3;

/// Megabytes are 10^6 bytes.
const MOST_BYTES: usize = 5_000_000;

/// The page of a sample, judged quickly.
fn report() -> String {
    let maps = (by_name("brushed-metal").unwrap().make)(256, 1);
    let inputs = Inputs {
        name: "brushed metal".into(),
        normal: Some("normal.png".into()),
        roughness: RoughnessInput::Roughness(ChannelRef::parse("orm.png:g")),
        ..Inputs::default()
    };
    let material = load_with(&inputs, &|path| {
        let mut bytes = Vec::new();
        write_png(&mut bytes, if path.ends_with("normal.png") { &maps.normal } else { &maps.orm }).unwrap();
        decode(path, bytes)
    })
    .unwrap();
    let base = base_lobes(&material, Form::Isotropic);
    let folds = [Fold::by_name("average").unwrap(), DEFAULT_FOLD, Fold::by_name("lean").unwrap()];
    let chains = folds.map(|fold| {
        let levels = chain(&material, &Options { fold, ..Options::default() }).into_lobes(base.clone());
        Candidate { name: format!("by {}", fold.name), fold: Some(fold.name.into()), levels }
    });
    let reading = Reading { most_texels: Some(64), ..Reading::default() };
    let settings = Settings { texels: Some(4), directions: 16, reading, ..Settings::default() };
    let judgement = judge(&material, &chains, &settings, &|_| {}).unwrap();
    let subject = Subject {
        material: &material,
        chains: &chains,
        about: &[],
        judgement: &judgement,
        plain: Some(0),
        limits: &["0.3".parse().unwrap(), "energy@1-=0.2".parse().unwrap()],
        settings: &settings,
        command: "mipfold compare --normal normal.png",
        motion: &[],
    };
    page(&subject, &|_| {}).unwrap()
}

/// Every texel another normal and another roughness: nothing of it can be packed well.
fn noise(side: usize) -> Material {
    let byte = |x: usize, y: usize, c: usize| {
        // Knuth's multiplicative hash, twice.
        let mixed = ((x * 3 + c) * 2048 + y + 1).wrapping_mul(2_654_435_761) as u32;
        ((mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519) >> 24) as u8
    };
    let normal = Array3::from_shape_fn((side, side, 3), |(y, x, c)| if c == 2 { 255 } else { byte(x, y, c) / 2 + 64 });
    let width = Array3::from_shape_fn((side, side, 1), |(y, x, _)| byte(x, y, 2) / 2 + 32);
    let inputs = Inputs {
        name: "noise".into(),
        normal: Some("normal.png".into()),
        roughness: RoughnessInput::Roughness(ChannelRef::parse("width.png")),
        ..Inputs::default()
    };
    load_with(&inputs, &|path| {
        let mut bytes = Vec::new();
        let samples = if path.ends_with("normal.png") { normal.clone() } else { width.clone() };
        write_png(&mut bytes, &Raster::new(Samples::U8(samples))).unwrap();
        decode(path, bytes)
    })
    .unwrap()
}

/// The page of all folds of the worst texture there is, with its moving pictures.
#[test]
fn a_page_of_many_chains_in_motion_stays_small() {
    let material = noise(256);
    let base = base_lobes(&material, Form::Isotropic);
    let chains: Vec<Candidate> = (0..9)
        .map(|i| {
            let options = Options { fold: &FOLDS[i % FOLDS.len()], ..Options::default() };
            let levels = chain(&material, &options).into_lobes(base.clone());
            Candidate { name: format!("chain {i}"), fold: Some(options.fold.name.into()), levels }
        })
        .collect();
    let reading = Reading { most_texels: Some(64), ..Reading::default() };
    let settings = Settings { texels: Some(2), directions: 8, reading, ..Settings::default() };
    let judgement = judge(&material, &chains, &settings, &|_| {}).unwrap();
    let motion = motion(&material, &chains, &|_| {});
    let subject = Subject {
        material: &material,
        chains: &chains,
        about: &[],
        judgement: &judgement,
        plain: Some(0),
        limits: &[],
        settings: &settings,
        command: "mipfold compare --fold all",
        motion: &motion,
    };
    let bytes = page(&subject, &|_| {}).unwrap().len();
    assert!(motion.len() == 2 && bytes < MOST_BYTES, "{bytes} bytes");
}

/// Loads a page, lets 5 seconds pass for its timers, and returns the document as it is then and the console's lines.
fn open(chromium: &str, page: &Path, flags: &[&str]) -> (String, Vec<String>) {
    let profile = tempfile::tempdir().unwrap();
    let run = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=5000", "--window-size=1200,900"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(flags)
        .arg("--dump-dom")
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let document = String::from_utf8(run.stdout).unwrap();
    assert!(run.status.success() && document.contains("</html>"), "{}", String::from_utf8_lossy(&run.stderr));
    let console =
        String::from_utf8_lossy(&run.stderr).lines().filter(|l| l.contains("CONSOLE")).map(str::to_owned).collect();
    (document, console)
}

/// Drives the controls and writes what it found, line by line, into an element that is looked for afterwards.
const DRIVER: &str = r##"<script>
(function () {
  var lines = [], say = function (name, value) { lines.push(name + "=" + value); };
  var at = function (id) { return document.getElementById("compare" + id); };
  var fire = function (element, kind) { element.dispatchEvent(new Event(kind, { bubbles: true })); };
  var stage = at("-stage"), left = stage.querySelector(".left"), right = stage.querySelector(".right");
  var picture = function (row, far) { return document.getElementById("p-" + row + "-" + far).src; };
  say("shown", !at("").hidden && getComputedStyle(at("")).display !== "none");
  var clip = function () { return getComputedStyle(left).clipPath; };
  var before = clip();
  at("-split").value = "20"; fire(at("-split"), "input");
  say("slider", clip() !== before && stage.style.getPropertyValue("--split") === "20%");
  say("spoken", /^20% /.test(at("-split").getAttribute("aria-valuetext")));
  at("-left").value = "1"; fire(at("-left"), "change");
  at("-right").value = "2"; fire(at("-right"), "change");
  at("-far").value = "3"; fire(at("-far"), "change");
  say("select", left.src === picture(1, 3) && right.src === picture(2, 3) && left.src !== right.src);
  say("pictures", Array.from(document.images).every(function (i) { return i.loading === "lazy" || (i.complete && i.naturalWidth > 0); }));
  say("overflow", document.documentElement.scrollWidth <= window.innerWidth);
  say("named", Array.from(document.querySelectorAll("select, input")).every(function (e) { return e.labels.length > 0 || e.getAttribute("aria-label"); }));
  at("-blink").click();
  say("pressed", at("-blink").getAttribute("aria-pressed"));
  var seen = {};
  var look = setInterval(function () { seen[getComputedStyle(left).visibility] = true; }, 50);
  setTimeout(function () {
    clearInterval(look);
    say("blink", Object.keys(seen).sort().join(" "));
    var free = clip();
    at("-split").value = "70"; fire(at("-split"), "input");
    say("freed", !stage.classList.contains("blinking") && getComputedStyle(left).visibility === "visible" && clip() !== "none" && clip() !== free && !at("-split").disabled);
    at("-blink").click();
    at("-blink").click();
    say("steady", at("-blink").getAttribute("aria-pressed") === "false" && !stage.classList.contains("blinking"));
    var out = document.createElement("pre");
    out.id = "driven";
    out.textContent = lines.join("\n");
    document.body.appendChild(out);
  }, 2500);
}());
</script></body>"##;

fn driven(chromium: &str, page: &Path, flags: &[&str]) -> Vec<String> {
    let (document, console) = open(chromium, page, flags);
    assert!(console.is_empty(), "{console:?}");
    let found = document.split("<pre id=\"driven\">").nth(1).expect("the driver came to its end");
    found.split("</pre>").next().unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn report_works_in_a_browser() {
    let Some(chromium) = or_skip(chromium()) else { return };
    let html = report();
    assert!(html.len() < MOST_BYTES, "{} bytes", html.len());
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("report.html");
    std::fs::write(&plain, &html).unwrap();
    let (_, console) = open(&chromium, &plain, &[]);
    assert!(console.is_empty(), "{console:?}");

    let copy = folder.path().join("driven.html");
    std::fs::write(&copy, html.replace("</body>", DRIVER)).unwrap();
    let good = ["shown", "slider", "spoken", "select", "pictures", "overflow", "named", "pressed"]
        .map(|n| format!("{n}=true"));
    let moving = driven(&chromium, &copy, &[]);
    assert_eq!(moving[..8], good);
    assert_eq!(moving[8..], ["blink=hidden visible", "freed=true", "steady=true"]);
    // Narrow and dark.
    let narrow = driven(&chromium, &copy, &["--window-size=500,900", "--blink-settings=preferredColorScheme=0"]);
    assert_eq!(narrow[..8], good);
    // Who asked for no motion sees the other picture on each press, and nothing moves by itself.
    let still = driven(&chromium, &copy, &["--force-prefers-reduced-motion"]);
    assert_eq!(still[..8], good);
    assert_eq!(still[8..], ["blink=hidden", "freed=true", "steady=true"]);
}

/// The console is really listened to: a page that complains must be heard.
#[test]
fn a_complaint_on_the_console_is_heard() {
    let Some(chromium) = or_skip(chromium()) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("loud.html");
    std::fs::write(&page, "<!DOCTYPE html><html><body><script>nothing.here();</script></body></html>").unwrap();
    let (_, console) = open(&chromium, &page, &[]);
    assert!(console.iter().any(|line| line.contains("nothing is not defined")), "{console:?}");
}
