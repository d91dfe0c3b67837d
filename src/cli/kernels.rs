//! `mipfold kernels`.

use super::args::{KernelsArgs, entry};
use super::report::Report;
use crate::error::Result;
use crate::kernels::{KERNELS, Kernel, bundle, by_name};

pub fn run(args: &KernelsArgs, report: &mut Report) -> Result<()> {
    if args.names.is_empty() {
        report.document(serde_json::json!({ "schema": 1, "kernels": listed() }).to_string());
        report.say("Files of shader helpers; `mipfold kernels NAME` prints one:\n");
        for kernel in KERNELS {
            let needs = needed(kernel);
            let needs = if needs.is_empty() { String::new() } else { format!(" (needs {})", needs.join(", ")) };
            report.say(&entry(kernel.name, &format!("{}{needs}", kernel.about)));
        }
        return Ok(());
    }
    let kernels = args.names.iter().map(|name| by_name(name)).collect::<Result<Vec<_>>>()?;
    let text = if args.bundle {
        bundle(&kernels, args.lang)
    } else {
        kernels.iter().map(|kernel| kernel.text(args.lang)).collect::<Vec<_>>().join("\n")
    };
    let json = serde_json::json!({ "schema": 1, "names": args.names, "text": text });
    report.document(json.to_string());
    report.say(text.trim_end());
    Ok(())
}

/// Names of the files that one needs.
fn needed(kernel: &Kernel) -> Vec<&'static str> {
    kernel.needs().iter().map(|kernel| kernel.name).collect()
}

fn listed() -> Vec<serde_json::Value> {
    let entry =
        |kernel: &Kernel| serde_json::json!({ "name": kernel.name, "about": kernel.about, "needs": needed(kernel) });
    KERNELS.iter().map(entry).collect()
}
