//! Folds a normal map and a roughness map from files, and reads lobes of the chain.
//!
//! `cargo run --example fold_files -- wall_normal.png wall_orm.png:g`
#![allow(clippy::print_stdout)]

use mipfold::fold::{Options, chain};
use mipfold::material::{ChannelRef, Inputs, RoughnessInput, load};

fn main() -> mipfold::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [normal, roughness] = &arguments[..] else {
        println!("usage: fold_files NORMAL ROUGHNESS[:r|g|b|a]");
        return Ok(());
    };
    let material = load(&Inputs {
        name: "files".into(),
        normal: Some(normal.into()),
        roughness: RoughnessInput::Roughness(ChannelRef::parse(roughness)),
        ..Inputs::default()
    })?;
    // What was assumed about the files, and what looks wrong with them.
    material.notes.iter().chain(&material.warnings).for_each(|line| println!("{line}"));

    let folded = chain(&material, &Options::default());
    println!("level 0 is the input: {}", folded.size);
    for (k, level) in (1..).zip(&folded.levels) {
        let size = level.lobes.size();
        let lobe = level.lobes.at(size.width / 2, size.height / 2);
        let alpha = lobe.axes().alpha_x;
        println!(
            "level {k}, {size}: in the middle normal {:.3}, alpha {:.3}, perceptual roughness {:.3}",
            lobe.normal,
            alpha.0,
            alpha.perceptual().0
        );
    }
    Ok(())
}
