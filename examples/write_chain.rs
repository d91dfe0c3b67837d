//! Builds what `mipfold build --lobes aniso --format png,exr` builds, from a program.
//!
//! `cargo run --example write_chain -- wall_normal.png wall_orm.png:g out`
#![allow(clippy::print_stdout)]

use mipfold::fold::{Options, chain};
use mipfold::material::{ChannelRef, Inputs, RoughnessInput, load};
use mipfold::ndf::Form;
use mipfold::output::{Format, Plan, Request, write};

fn main() -> mipfold::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [normal, roughness, folder] = &arguments[..] else {
        println!("usage: write_chain NORMAL ROUGHNESS[:r|g|b|a] FOLDER");
        return Ok(());
    };
    let mut material = load(&Inputs {
        name: "wall".into(),
        normal: Some(normal.into()),
        roughness: RoughnessInput::Roughness(ChannelRef::parse(roughness)),
        ..Inputs::default()
    })?;
    // Two widths and a direction need a map to live in.
    material.ensure_anisotropy_map();
    let options = Options { form: Form::Anisotropic, ..Options::default() };
    let request = Request { formats: vec![Format::Png, Format::Exr, Format::Ktx2], ..Request::new(folder) };
    // The plan names every file before anything is folded; `write` makes all of them or none.
    let plan = Plan::new(&material, &options, &request);
    let folded = chain(&material, &options);
    write(&material, &folded, &options, &plan, &request, &|| ())?;
    plan.outputs.iter().for_each(|file| println!("{}", file.name));
    Ok(())
}
