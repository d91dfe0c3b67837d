//! Whether a build is already there, by content and not by date.

use std::fmt::Write;
use std::path::Path;
use std::sync::OnceLock;

use sha2::{Digest, Sha256};

use super::plan::Request;
use crate::codec::sha256;
use crate::error::{Error, Result};
use crate::fold::Options;
use crate::material::{Earlier, Inputs};
use crate::ndf::Form;

/// A number for all that decides on the files of a build: the program, options, inputs as given and their content. `digest` is
/// that of a file.
///
/// # Errors
/// Those of `digest`.
pub fn key(
    inputs: &Inputs,
    options: &Options,
    form: Option<Form>,
    request: &Request,
    digest: impl Fn(&Path) -> Result<String>,
) -> Result<String> {
    let Options {
        fold,
        form: _,
        lobes,
        shared_normal,
        strength,
        at_least_average,
        min_alpha,
        max_alpha,
        slope_moments,
        mean_length,
    } = options;
    let Request {
        folder: _,
        formats,
        depth,
        resize,
        compress,
        effort,
        dds9,
        preset,
        moments,
        extras,
        pictures,
        force: _,
        key: _,
    } = request;
    let mut text = format!("{} {:?}", program(), inputs);
    write!(
        text,
        "\n{} {form:?} {lobes} {shared_normal} {strength} {at_least_average} {min_alpha:?} {max_alpha:?} {slope_moments} \
         {mean_length}\n{formats:?} {depth:?} {resize:?} {compress:?} {effort:?} {dds9} {:?} {moments} {extras:?} {pictures:?}",
        fold.name,
        preset.map(|preset| preset.name)
    )
    .expect("text grows");
    for path in inputs.files() {
        write!(text, "\n{}", digest(path)?).expect("text grows");
    }
    Ok(sha256(text.as_bytes()))
}

/// The program that runs, by content where that can be told: versions under work share a number.
fn program() -> &'static str {
    static PROGRAM: OnceLock<String> = OnceLock::new();
    let digest = || std::env::current_exe().ok().and_then(|path| file_digest(&path).ok());
    PROGRAM.get_or_init(|| digest().unwrap_or_else(|| env!("CARGO_PKG_VERSION").to_owned()))
}

/// The build of this key, if the folder holds all its files, byte for byte.
pub fn fresh(folder: &Path, key: &str) -> Option<Earlier> {
    Earlier::read(folder).filter(|earlier| {
        let is_there = |(name, digest): (&String, &String)| {
            std::fs::File::open(folder.join(name)).is_ok_and(|file| sha256_of(file).is_ok_and(|found| found == *digest))
        };
        earlier.key.as_deref() == Some(key) && !earlier.digests.is_empty() && earlier.digests.iter().all(is_there)
    })
}

/// SHA-256 of a file, hexadecimal.
///
/// # Errors
/// [`Error::Io`] if it cannot be read.
pub fn file_digest(path: &Path) -> Result<String> {
    std::fs::File::open(path).and_then(sha256_of).map_err(|error| Error::io(path, error))
}

/// The same of what a reader gives.
pub fn sha256_of(mut reader: impl std::io::Read) -> std::io::Result<String> {
    let mut hasher = Sha256::new();
    std::io::copy(&mut reader, &mut hasher)?;
    Ok(format!("{:x}", hasher.finalize()))
}
