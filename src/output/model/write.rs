//! A model and all that belongs to it, onto the disk: whole or not at all.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::package::Beside;
use crate::error::{Error, Result};
use crate::material::{GENERATOR, same_path};
use crate::output::Stage;

/// What is written.
pub struct ModelFiles {
    /// The model itself.
    pub main: Vec<u8>,
    pub(super) beside: Vec<(String, Beside)>,
    /// Files of the input, beside the model.
    pub(super) inputs: Vec<PathBuf>,
}

/// The name of the file that says what was done, for a model of this name.
pub fn sidecar_name(output: &Path) -> String {
    format!("{}.mipfold.json", output.file_stem().unwrap_or_default().to_string_lossy())
}

impl ModelFiles {
    /// Names of all files, from the output's folder on, the model first and its sidecar last. Files of the input that lie
    /// there already are not among them.
    pub fn names(&self, output: &Path) -> Vec<String> {
        let folder = folder(output);
        let there =
            |file: &&(String, Beside)| !matches!(&file.1, Beside::Copy(from) if same_path(from, &folder.join(&file.0)));
        let main = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let beside = self.beside.iter().filter(there).map(|(name, _)| name.clone());
        let mut names: Vec<String> = [main].into_iter().chain(beside).collect();
        let mut seen = std::collections::HashSet::new();
        names.retain(|name| seen.insert(name.clone()));
        names.push(sidecar_name(output));
        names
    }

    /// Refuses to write over an input, or over files that no earlier run wrote.
    ///
    /// # Errors
    /// [`Error::Invalid`] that names the first file in the way.
    pub fn check(&self, input: &Path, output: &Path, force: bool) -> Result<()> {
        let folder = folder(output);
        if let Some(there) = folder.ancestors().find(|path| path.exists())
            && !there.is_dir()
        {
            return Err(Error::invalid(there, "a file", "a folder; choose another -o"));
        }
        self.apart(output)?;
        let earlier = earlier(output);
        let main = output.file_name().unwrap_or_default().to_string_lossy();
        if let Some(other) = earlier.first().filter(|other| !force && !other.eq_ignore_ascii_case(&main)) {
            let found = format!("what goes with {other}, whose name differs in its ending alone");
            let expected = format!("another name than {main}, or --force to replace it");
            return Err(Error::invalid(&folder.join(sidecar_name(output)), found, expected));
        }
        let inputs: Vec<&Path> = self.inputs.iter().map(PathBuf::as_path).chain([input]).collect();
        for name in self.names(output) {
            let path = folder.join(&name);
            if inputs.iter().any(|input| same_path(input, &path)) {
                return Err(Error::invalid(&path, "an output that is also an input", "another name for -o"));
            }
            match path.metadata() {
                Err(_) => {}
                Ok(there) if !there.is_file() => {
                    return Err(Error::invalid(
                        &path,
                        "something that is not a file",
                        "a free place; choose another -o",
                    ));
                }
                Ok(_) if !force && !earlier.iter().any(|file| file.eq_ignore_ascii_case(&name)) => {
                    let expected = "a free name where a new one may be written, or --force to replace it";
                    return Err(Error::invalid(&path, "a file that mipfold did not write", expected));
                }
                Ok(_) => {}
            }
        }
        Ok(())
    }

    /// Refuses two files of one name, and a file in the place of another's folder.
    fn apart(&self, output: &Path) -> Result<()> {
        let main = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let own = [(main, None), (sidecar_name(output), None)];
        let beside = self.beside.iter().map(|(name, beside)| (name.clone(), Some(beside)));
        let mut taken: BTreeMap<String, Option<&Beside>> = BTreeMap::new();
        for (name, beside) in own.into_iter().chain(beside) {
            let same = |there: &Option<&Beside>| match (there, beside) {
                // One file that is named twice.
                (Some(Beside::Copy(a)), Some(Beside::Copy(b))) => same_path(a, b),
                _ => false,
            };
            let lower = name.to_lowercase();
            if taken.get(&lower).is_some_and(|there| !same(there)) {
                let found = "two files of this name, one of them of the model's own";
                return Err(Error::invalid(&folder(output).join(name), found, "another name for -o"));
            }
            taken.insert(lower, beside);
        }
        let folders = taken.keys().flat_map(|name| Path::new(name).ancestors().skip(1).map(Path::to_owned));
        let folders: Vec<PathBuf> = folders.collect();
        match taken.keys().find(|name| folders.iter().any(|folder| folder == Path::new(name))) {
            None => Ok(()),
            Some(name) => {
                let found = "a file and a folder of this name";
                Err(Error::invalid(&folder(output).join(name), found, "another name for -o"))
            }
        }
    }

    /// Writes all files; none appears before all are written. The sidecar comes last.
    ///
    /// # Errors
    /// As [`ModelFiles::check`]; whatever the system refuses.
    pub fn write(&self, input: &Path, output: &Path, sidecar: &str, force: bool) -> Result<()> {
        self.check(input, output, force)?;
        let names = self.names(output);
        let (main, last) = (&names[0], names.last().expect("two at least"));
        // Each in its own folder, since stages rename inside one.
        let mut stages: BTreeMap<PathBuf, Stage> = BTreeMap::new();
        stages.insert(folder(output), Stage::new(&folder(output))?);
        for name in &names {
            let path = folder(output).join(name);
            let inside = path.parent().unwrap_or(Path::new("")).to_owned();
            if !stages.contains_key(&inside) {
                stages.insert(inside.clone(), Stage::new(&inside)?);
            }
            let beside = self.beside.iter().find(|(other, _)| other == name).map(|(_, beside)| beside);
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            let stage = &stages[&inside];
            match beside {
                _ if name == main => stage.write(&file, |out| out.write_all(&self.main))?,
                _ if name == last => stage.write(&file, |out| out.write_all(sidecar.as_bytes()))?,
                Some(Beside::Bytes(bytes)) => stage.write(&file, |out| out.write_all(bytes))?,
                Some(Beside::Copy(from)) => {
                    let mut from = fs::File::open(from).map_err(|error| Error::io(from, error))?;
                    stage.write(&file, |out| std::io::copy(&mut from, out).map(drop))?;
                }
                None => {}
            }
        }
        // The model's own folder last: its files speak for the others.
        let own = stages.remove(&folder(output)).expect("made first");
        stages.into_values().try_for_each(|stage| stage.commit("", &[]))?;
        own.commit(last, &[])
    }
}

fn folder(output: &Path) -> PathBuf {
    match output.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// The files of an earlier run that wrote this model.
fn earlier(output: &Path) -> Vec<String> {
    #[derive(Deserialize)]
    struct Sidecar {
        generator: String,
        files: Vec<String>,
    }
    let text = fs::read(folder(output).join(sidecar_name(output))).ok();
    let sidecar = text.and_then(|text| serde_json::from_slice::<Sidecar>(&text).ok());
    sidecar.filter(|sidecar| sidecar.generator == GENERATOR).map_or_else(Vec::new, |sidecar| sidecar.files)
}
