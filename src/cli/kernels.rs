//! `mipfold kernels`.

use super::args::{KernelsArgs, entry};
use super::report::Report;
use crate::error::Result;
use crate::kernels::{KERNELS, bundle, by_name};

pub fn run(args: &KernelsArgs, report: &mut Report) -> Result<()> {
    if args.names.is_empty() {
        report.document(serde_json::json!({ "schema": 1, "kernels": listed() }).to_string());
        report.say("Files of shader helpers; `mipfold kernels NAME` prints one:\n");
        for kernel in KERNELS {
            let needs: Vec<_> = kernel.needs().iter().map(|kernel| kernel.name).collect();
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

fn listed() -> Vec<serde_json::Value> {
    let entry = |kernel: &crate::kernels::Kernel| {
        let needs: Vec<_> = kernel.needs().iter().map(|kernel| kernel.name).collect();
        serde_json::json!({ "name": kernel.name, "about": kernel.about, "needs": needs })
    };
    KERNELS.iter().map(entry).collect()
}
