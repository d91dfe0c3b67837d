//! Folds that have mixtures, through the command: built, read back and judged.

mod common;

use common::desk::Desk;
use common::mipfold;
use mipfold::fold::FOLDS;
use serde_json::Value;

fn report(desk: &Desk, args: &str) -> Value {
    let run = mipfold().args(desk.args(&format!("compare {args} --json"))).output().unwrap();
    assert!(run.status.success(), "{args}: {}", String::from_utf8_lossy(&run.stderr));
    serde_json::from_slice(&run.stdout).unwrap()
}

#[test]
fn mixtures_are_built_read_back_and_judged() {
    for fold in FOLDS.iter().filter(|fold| fold.has_mixtures()) {
        for (lobes, count, words) in [
            ("2", 2, ", 2 lobes"),
            ("3", 3, ", 3 lobes"),
            ("2-aniso", 2, ", 2 lobes, two widths"),
            ("haze", 2, ", 2 lobes sharing a normal"),
        ] {
            let (desk, fold) = (Desk::new(), format!("--fold {} --lobes {lobes}", fold.name));
            desk.build("out", &format!("--normal @n.png --roughness @r.png {fold} --format png,exr"));
            let look = "--texels 4 --directions 20 --levels 0,2,4 --no-plain";
            let report = report(&desk, &format!("@out @out,container=exr @out,container=lobes {fold} {look}"));
            let chains = report["chains"].as_array().unwrap();
            assert_eq!(chains.len(), 4);
            let error = |chain: &Value| chain["levels"][1]["lobe_error"]["mean"].as_f64().unwrap();
            for chain in chains {
                let form = if lobes.ends_with("aniso") { "anisotropic" } else { "isotropic" };
                assert_eq!((&chain["lobes"], &chain["count"]), (&form.into(), &count.into()), "{lobes}");
                assert!(chain["fold"].as_str().unwrap().ends_with(words), "{lobes}: {}", chain["fold"]);
                // The files hold what was folded, but for rounding, and level 0 is the surface.
                assert!((error(chain) - error(&chains[3])).abs() < 0.03, "{lobes}: {report}");
                assert!(chain["levels"][0]["lobe_error"]["mean"].as_f64().unwrap() < 0.02, "{lobes}: {report}");
            }
            assert!(chains[3]["name"].as_str().unwrap().contains(&format!(", {count} lobes")), "{}", chains[3]["name"]);
        }
    }
}
