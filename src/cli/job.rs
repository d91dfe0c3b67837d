//! One material from inputs to files.

use indicatif::ProgressBar;

use super::report::Built;
use crate::error::Result;
use crate::fold::{Chain, Options, chain};
use crate::material::{Inputs, Material, load};
use crate::ndf::Form;
use crate::output::{MANIFEST, Plan, Request, write};

/// A material after its build.
pub struct Done {
    pub material: Material,
    /// Absent in a dry run.
    pub chain: Option<Chain>,
    pub built: Built,
}

/// Reads, folds and writes one material.
pub fn build(inputs: &Inputs, options: &Options, request: &Request, dry_run: bool, bar: &ProgressBar) -> Result<Done> {
    bar.set_message(format!("reading {}", inputs.name));
    let mut material = load(inputs)?;
    if options.form == Form::Anisotropic {
        material.ensure_anisotropy_map();
    }
    let plan = Plan::new(&material, request);
    plan.check(&material, request)?;
    let mut built = Built {
        name: material.name.clone(),
        folder: request.folder.clone(),
        width: material.size.width,
        height: material.size.height,
        levels: material.size.level_count(),
        fold: options.fold.name,
        files: plan.outputs.iter().map(|o| o.name.clone()).collect(),
        notes: material.notes.clone(),
        warnings: material.warnings.clone(),
    };
    built.files.push(MANIFEST.into());
    if dry_run {
        return Ok(Done { material, chain: None, built });
    }
    bar.inc_length(plan.outputs.len() as u64 + 1);
    bar.set_message(format!("folding {}", inputs.name));
    let chain = chain(&material, options);
    bar.inc(1);
    bar.set_message(format!("writing {}", inputs.name));
    write(&material, &chain, options, &plan, request, &|| bar.inc(1))?;
    Ok(Done { material, chain: Some(chain), built })
}
