//! Files of which none appears before all are written.

use std::collections::BTreeMap;
use std::fs::{self, TryLockError};
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use tempfile::NamedTempFile;

use super::fresh::sha256_of;
use crate::error::{Error, Result};
use crate::material::{Earlier, JOURNAL, MANIFEST};

/// How names of files begin that have not got their own yet.
const TEMPORARY: &str = ".mipfold-";

/// Files written beside their place under a temporary name. [`Stage::commit`] renames all of them; dropping the stage
/// before that removes them, and the folders that were made for them.
pub struct Stage {
    folder: PathBuf,
    /// Folders that did not exist before, outermost first.
    made: Vec<PathBuf>,
    files: Mutex<Vec<(NamedTempFile, PathBuf)>>,
    /// SHA-256 of each file by its name.
    digests: Mutex<BTreeMap<String, String>>,
}

/// While it lives no other build renames files in the folder. Only where the system lets folders be locked; elsewhere the
/// last build's names win, one by one.
pub struct FolderLock {
    _folder: fs::File,
}

/// How long another build may keep a folder: giving names takes a blink.
const LONGEST_LOCK: Duration = Duration::from_secs(20);

impl FolderLock {
    fn new(path: &Path) -> Result<Option<Self>> {
        let Ok(folder) = fs::File::open(path) else { return Ok(None) };
        let start = Instant::now();
        loop {
            match folder.try_lock() {
                Ok(()) => return Ok(Some(Self { _folder: folder })),
                Err(TryLockError::Error(_)) => return Ok(None),
                Err(TryLockError::WouldBlock) if start.elapsed() < LONGEST_LOCK => {
                    std::thread::sleep(Duration::from_millis(20));
                }
                Err(TryLockError::WouldBlock) => {
                    let found = format!("a folder that another program has kept locked for {LONGEST_LOCK:?}");
                    return Err(Error::invalid(path, found, "one that is free; wait, or choose another -o"));
                }
            }
        }
    }
}

impl Stage {
    /// A stage in `folder`, which is made if it is missing.
    ///
    /// # Errors
    /// A folder that cannot be made or written.
    pub fn new(folder: &Path) -> Result<Self> {
        let missing = folder.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists());
        let mut made: Vec<_> = missing.map(Path::to_owned).collect();
        made.reverse();
        fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
        Ok(Self { folder: folder.to_owned(), made, files: Mutex::default(), digests: Mutex::default() })
    }

    /// Writes a file through `fill`, under a temporary name. Safe to call from several threads.
    ///
    /// # Errors
    /// Whatever the system refuses, named by the final path.
    pub fn write(&self, name: &str, fill: impl FnOnce(&mut BufWriter<&fs::File>) -> std::io::Result<()>) -> Result<()> {
        let path = self.folder.join(name);
        let staged = || -> std::io::Result<NamedTempFile> {
            let mut builder = tempfile::Builder::new();
            #[cfg(unix)]
            // Outputs are no secrets: as open as the user's umask has it.
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
            let file = builder.prefix(TEMPORARY).tempfile_in(&self.folder)?;
            let mut out = BufWriter::with_capacity(1 << 18, file.as_file());
            fill(&mut out)?;
            out.flush()?;
            drop(out);
            file.as_file().rewind()?;
            let digest = sha256_of(file.as_file())?;
            self.digests.lock().expect("no writer panics").insert(name.to_owned(), digest);
            Ok(file)
        };
        let file = staged().map_err(|e| Error::io(&path, e))?;
        self.files.lock().expect("no writer panics").push((file, path));
        Ok(())
    }

    /// SHA-256 of the files that are written so far, hexadecimal, by their names.
    pub fn digests(&self) -> BTreeMap<String, String> {
        self.digests.lock().expect("no writer panics").clone()
    }

    /// Keeps other builds from renaming files in this folder at the same time. What builds that were interrupted left
    /// there more than a day ago is removed.
    ///
    /// # Errors
    /// Another program that does not let go of the folder.
    pub fn lock(&self) -> Result<Option<FolderLock>> {
        let lock = FolderLock::new(&self.folder)?;
        for file in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let name = file.file_name();
            let ours = name.to_string_lossy().starts_with(TEMPORARY) && name != JOURNAL;
            let age = file.metadata().and_then(|about| about.modified()).ok().and_then(|time| time.elapsed().ok());
            if ours && age.is_some_and(|age| age > Duration::from_secs(24 * 60 * 60)) {
                fs::remove_file(file.path()).ok();
            }
        }
        Ok(lock)
    }

    /// Gives all files their names; the one called `last` comes last, so that it speaks for finished files only. Then
    /// files called `stale`, which an earlier build left here and this one does not renew, are removed.
    ///
    /// # Errors
    /// A name that cannot be given; then files that replaced nothing are removed again.
    pub fn commit(mut self, last: &str, stale: &[String]) -> Result<()> {
        let mut files = std::mem::take(self.files.get_mut().expect("no writer panics"));
        files.sort_by_key(|(_, path)| path.ends_with(last));
        // Until all have their names, a copy of the manifest says that they are ours.
        let journal = self.folder.join(JOURNAL);
        if let Some((manifest, _)) = files.last().filter(|(_, path)| path.ends_with(MANIFEST)) {
            fs::copy(manifest.path(), &journal).map_err(|e| Error::io(&journal, e))?;
        }
        let mut new = Vec::new();
        for (file, path) in files {
            let existed = path.exists();
            if let Err(error) = file.persist(&path) {
                new.iter().chain([&journal]).for_each(|path| drop(fs::remove_file(path)));
                return Err(Error::io(&path, error.error));
            }
            if !existed {
                new.push(path);
            }
        }
        stale.iter().for_each(|name| drop(fs::remove_file(self.folder.join(name))));
        fs::remove_file(&journal).ok();
        self.made.clear();
        Ok(())
    }
}

/// Whether files of these names may be written into a folder: it is a folder or can be made, nothing but a regular file
/// stands in the way, and what is there is in the manifest of an earlier build, or `force` allows to replace it.
///
/// # Errors
/// [`Error::Invalid`] that names the first file in the way.
pub fn may_write<'a>(folder: &Path, names: impl IntoIterator<Item = &'a str>, force: bool) -> Result<()> {
    if let Some(there) = folder.ancestors().find(|path| path.exists())
        && !there.is_dir()
    {
        return Err(Error::invalid(there, "a file", "a folder; choose another -o"));
    }
    let ours = Earlier::read(folder).unwrap_or_default();
    for name in names {
        let path = folder.join(name);
        match path.metadata() {
            Err(_) => {}
            Ok(there) if !there.is_file() => {
                return Err(Error::invalid(&path, "something that is not a file", "a free place; choose another -o"));
            }
            Ok(_) if !force && !ours.wrote(name) => {
                let expected = "a folder of its own, or --force to replace it";
                return Err(Error::invalid(&path, "a file that mipfold did not write", expected));
            }
            Ok(_) => {}
        }
    }
    Ok(())
}

/// Whether a build of this material may write files of these names and a manifest into a folder: as [`may_write`], and no
/// other material was built there.
///
/// # Errors
/// As [`may_write`].
pub fn may_build<'a>(
    folder: &Path,
    material: &str,
    names: impl IntoIterator<Item = &'a str>,
    force: bool,
) -> Result<()> {
    // Another build may be between its first file and its manifest.
    let _alone = FolderLock::new(folder)?;
    may_build_alone(folder, material, names, force)
}

/// The same, for whoever holds the folder's lock.
pub fn may_build_alone<'a>(
    folder: &Path,
    material: &str,
    names: impl IntoIterator<Item = &'a str>,
    force: bool,
) -> Result<()> {
    if let Some(earlier) = Earlier::read(folder)
        && earlier.material != material
        && !force
    {
        let found = format!("the build of another material, '{}'", earlier.material);
        return Err(Error::invalid(folder, found, "a folder for each material, or --force"));
    }
    may_write(folder, names.into_iter().chain([MANIFEST]), force)
}

/// Files of an earlier build of this material that a new one, of files of these names, does not write again.
pub fn stale(folder: &Path, material: &str, names: &[&str]) -> Vec<String> {
    let earlier = Earlier::read(folder).filter(|earlier| earlier.material == material).unwrap_or_default();
    // File systems that ignore case exist.
    let renewed = |file: &str| names.iter().chain([&MANIFEST]).any(|name| name.to_lowercase() == file.to_lowercase());
    earlier.files.into_iter().filter(|file| !renewed(file)).collect()
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.files.get_mut().map(Vec::clear).ok();
        // Only empty folders go; what others put there stays.
        self.made.iter().rev().for_each(|folder| {
            fs::remove_dir(folder).ok();
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    #[test]
    fn a_full_disk_leaves_nothing_behind() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("a/b");
        let stage = Stage::new(&folder).unwrap();
        stage.write("one.png", |out| out.write_all(b"whole")).unwrap();
        let full = stage.write("two.png", |_| Err(io::Error::from(io::ErrorKind::StorageFull)));
        let message = full.unwrap_err().to_string();
        assert!(message.contains("two.png") && message.contains("no storage space"), "{message}");
        drop(stage);
        assert!(!root.path().join("a").exists());
    }

    #[test]
    fn nothing_has_its_name_before_all_are_written() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("one.png"), b"old").unwrap();
        let stage = Stage::new(root.path()).unwrap();
        stage.write("one.png", |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(root.path().join("one.png")).unwrap(), b"old");
        stage.commit("manifest.json", &[]).unwrap();
        assert_eq!(fs::read(root.path().join("one.png")).unwrap(), b"new");
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }
}
