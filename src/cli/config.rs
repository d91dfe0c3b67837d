//! `mipfold.toml`: options by the names of the command line, for all materials or for some. They become words of a command
//! line, so that there is one way through the code, with one set of checks.

use std::cell::Cell;
use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::{Arg, ArgAction};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::args::BuildArgs;
use super::glob::matches;
use super::vocabulary::{Vocabulary, Word, id, reason, takes_values, word};
use crate::error::{Error, Result};
use crate::material::detect::TextureSet;

/// What it is called in a folder of textures.
pub const NAME: &str = "mipfold.toml";

/// Bytes; one that people write has a few thousand.
const LONGEST: u64 = 1 << 20;

/// Options that are about one material, and so stand in a `[[material]]` only.
const OF_ONE: [&str; 5] = ["name", "normal", "orm", "anisotropy", "height"];

/// One file.
pub struct Config {
    file: PathBuf,
    /// Path of its folder below that of the textures, if it was found there.
    below: Option<PathBuf>,
    /// What holds for all materials, and then, in order, for those that match.
    sections: Vec<Section>,
}

/// Options of all materials, or of those that a pattern matches.
struct Section {
    line: usize,
    /// None for all.
    patterns: Option<Vec<(String, Cell<bool>)>>,
    skip: Option<bool>,
    words: Vec<Word>,
}

/// What holds for one material.
pub struct Settings {
    pub args: BuildArgs,
    /// Where it is said that the material is to be left out.
    pub skipped: Option<String>,
    /// What the files said and nothing overrode.
    pub notes: Vec<String>,
}

impl Config {
    /// Reads a file.
    ///
    /// # Errors
    /// One that names the file, the line and the key.
    pub fn read(file: &Path, below: Option<PathBuf>, vocabulary: &Vocabulary) -> Result<Self> {
        if !file.is_file() {
            let found = if file.exists() { "no plain file" } else { "no such file" };
            return Err(Error::invalid(file, found, format!("a file of options, like {NAME}")));
        }
        let length = file.metadata().map_err(|e| Error::io(file, e))?.len();
        if length > LONGEST {
            return Err(Error::invalid(file, format!("{length} bytes"), format!("{LONGEST} bytes of options at most")));
        }
        let bytes = std::fs::read(file).map_err(|e| Error::io(file, e))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let found = format!("bytes that are no UTF-8, from byte {} on", e.utf8_error().valid_up_to());
            Error::invalid(file, found, "TOML, which is UTF-8")
        })?;
        let reader = Reader { file, text: &text, vocabulary };
        let table = DeTable::parse(&text).map_err(|e| {
            let subject = e.span().map_or_else(|| file.display().to_string(), |span| reader.place(span));
            let found = e.message().lines().next().unwrap_or_default().trim().to_owned();
            Error::invalid_option(subject, found, "TOML")
        })?;
        let sections = reader.sections(table.get_ref())?;
        Ok(Self { file: file.to_owned(), below, sections })
    }

    /// As notes name it.
    fn name(&self) -> String {
        self.below.as_ref().map_or_else(|| self.file.clone(), |below| below.join(NAME)).display().to_string()
    }

    /// What patterns may match: the name, and the path below the file's folder.
    fn names(&self, name: &str, set: Option<&TextureSet>) -> Vec<String> {
        let Some(set) = set else { return vec![name.to_owned()] };
        let own = self.file.parent().and_then(|folder| folder.canonicalize().ok());
        let stripped = match &self.below {
            Some(below) => set.below.strip_prefix(below).ok().map(Path::to_owned),
            None => own.and_then(|own| Some(set.folder.canonicalize().ok()?.strip_prefix(own).ok()?.to_owned())),
        };
        let below = stripped.as_ref().unwrap_or(&set.below);
        let path = |path: PathBuf| {
            let parts: Vec<_> = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            parts.join("/")
        };
        let mut names = vec![set.name.clone(), set.base.clone()];
        names.extend([below.join(&set.name), below.join(&set.base)].map(path));
        if set.place() == set.below {
            names.push(path(below.clone()));
        }
        names.retain(|name| !name.is_empty());
        names
    }

    /// Patterns that matched no material.
    pub fn unmatched(&self) -> Vec<String> {
        let sections = self.sections.iter().flat_map(|section| {
            let patterns = section.patterns.iter().flatten().filter(|(_, used)| !used.get());
            patterns.map(|(pattern, _)| (section.line, pattern))
        });
        let said = |(line, pattern)| {
            let file = self.file.display();
            format!(
                "{file}:{line}: match = \"{pattern}\" matches no material (* and ? within a folder's name, ** across)"
            )
        };
        sections.map(said).collect()
    }
}

/// What holds for a material: of several files the nearer one goes before the farther one, a later section before an
/// earlier one, and the command line before all.
pub fn settings(
    vocabulary: &Vocabulary,
    configs: &[&Config],
    name: &str,
    set: Option<&TextureSet>,
) -> Result<Settings> {
    let mut words: Vec<(Word, Option<&Config>)> = Vec::new();
    let mut skipped = None;
    let mut add = |word: &Word, from| {
        words.retain(|(other, _)| !vocabulary.rivals(&other.id, &word.id));
        words.push((word.clone(), from));
    };
    for config in configs {
        let names = config.names(name, set);
        for section in &config.sections {
            let mut holds = section.patterns.is_none();
            for (pattern, used) in section.patterns.iter().flatten() {
                if names.iter().any(|name| matches(pattern, name)) {
                    used.set(true);
                    holds = true;
                }
            }
            if holds {
                section.words.iter().for_each(|word| add(word, Some(*config)));
                if let Some(skip) = section.skip {
                    skipped = skip.then(|| format!("skip in {}:{}", config.name(), section.line));
                }
            }
        }
    }
    vocabulary.given.iter().for_each(|word| add(word, None));
    let mut notes = Vec::new();
    for config in configs {
        let own = words.iter().filter(|(_, from)| from.is_some_and(|from| std::ptr::eq(from, *config)));
        let said: Vec<_> = own.map(|(word, _)| word.said.as_str()).filter(|said| !said.is_empty()).collect();
        if !said.is_empty() {
            notes.push(format!("options of {}: {}", config.name(), said.join(", ")));
        }
    }
    let words = words.into_iter().flat_map(|(word, _)| word.words).collect();
    let args = vocabulary.parse(words).map_err(|e| Error::invalid_option(name, reason(&e).0, reason(&e).1))?;
    Ok(Settings { args, skipped, notes })
}

/// Turns a table into sections.
struct Reader<'a> {
    file: &'a Path,
    text: &'a str,
    vocabulary: &'a Vocabulary,
}

impl Reader<'_> {
    fn line(&self, at: usize) -> usize {
        1 + self.text.as_bytes()[..at.min(self.text.len())].iter().filter(|byte| **byte == b'\n').count()
    }

    fn place(&self, span: Range<usize>) -> String {
        format!("{}:{}", self.file.display(), self.line(span.start))
    }

    fn wrong(&self, key: &Spanned<impl AsRef<str>>, found: impl Into<String>, expected: impl Into<String>) -> Error {
        Error::invalid_option(format!("{}: {}", self.place(key.span()), key.get_ref().as_ref()), found, expected)
    }

    fn sections(&self, table: &DeTable) -> Result<Vec<Section>> {
        let mut all = Section { line: 1, patterns: None, skip: None, words: Vec::new() };
        let mut sections = Vec::new();
        for (key, value) in table {
            if key.get_ref() == "material" {
                let expected = "[[material]], which may be repeated";
                let found = || self.wrong(key, found(value.get_ref()), expected);
                for material in value.get_ref().as_array().ok_or_else(found)?.iter() {
                    let table = material.get_ref().as_table();
                    let table = table.ok_or_else(|| self.wrong(key, "an array of something else", expected))?;
                    sections.push(self.section(table, self.line(material.span().start))?);
                }
            } else {
                self.entry(key, value, &mut all)?;
            }
        }
        sections.insert(0, all);
        Ok(sections)
    }

    fn section(&self, table: &DeTable, line: usize) -> Result<Section> {
        let mut section = Section { line, patterns: Some(Vec::new()), skip: None, words: Vec::new() };
        for (key, value) in table {
            if key.get_ref() == "match" {
                let patterns = self.texts(key, value)?;
                section.patterns = Some(patterns.into_iter().map(|pattern| (pattern, Cell::new(false))).collect());
            } else {
                self.entry(key, value, &mut section)?;
            }
        }
        if section.patterns.as_ref().is_none_or(Vec::is_empty) {
            let place = format!("{}:{line}: [[material]]", self.file.display());
            let expected = "match = \"PATTERN\", of a material's name or path";
            return Err(Error::invalid_option(place, "no match", expected));
        }
        Ok(section)
    }

    fn entry(&self, key: &Spanned<impl AsRef<str>>, value: &Spanned<DeValue>, section: &mut Section) -> Result<()> {
        let name = key.get_ref().as_ref();
        if name == "skip" {
            let skip = value.get_ref().as_bool();
            section.skip = Some(skip.ok_or_else(|| self.wrong(key, found(value.get_ref()), "true or false"))?);
            return Ok(());
        }
        let unknown = || {
            let also = if section.patterns.is_some() { "match, skip" } else { "[[material]], skip" };
            self.wrong(
                key,
                "an unknown key",
                format!("{also}, or an option of mipfold build: {}", self.vocabulary.names()),
            )
        };
        let arg = self.vocabulary.option(name).ok_or_else(unknown)?;
        if section.patterns.is_none() && OF_ONE.contains(&id(arg)) {
            return Err(self.wrong(key, "one map or name for all materials", "it in a [[material]]"));
        }
        if let Some(other) = section.words.iter().find(|word| self.vocabulary.rivals(&word.id, id(arg))) {
            return Err(self.wrong(key, format!("it beside {}", other.said), "one of them"));
        }
        section.words.push(self.word(key, value, arg)?);
        Ok(())
    }

    fn word(&self, key: &Spanned<impl AsRef<str>>, value: &Spanned<DeValue>, arg: &Arg) -> Result<Word> {
        let (long, name) = (arg.get_long().expect("an option"), key.get_ref().as_ref());
        if !takes_values(arg) {
            let on = value.get_ref().as_bool();
            let on = on.ok_or_else(|| self.wrong(key, found(value.get_ref()), "true or false"))?;
            // What is not said is false: this takes back what a farther file said.
            let words = if on { vec![OsString::from(format!("--{long}"))] } else { Vec::new() };
            return Ok(Word { id: id(arg).into(), words, said: format!("{name} = {on}") });
        }
        let several = matches!(arg.get_action(), ArgAction::Append);
        if value.get_ref().is_array() && !several {
            return Err(self.wrong(key, "an array", "one value"));
        }
        let texts = self.texts(key, value)?;
        let is_file = arg.get_value_names().is_some_and(|names| names.first().is_some_and(|n| n.starts_with("FILE")));
        let whole = |text: &String| {
            let number = arg.get_value_names().is_some_and(|names| names.first().is_some_and(|n| n.contains('[')));
            let beside = is_file && !(number && text.parse::<f32>().is_ok());
            let folder = self.file.parent().unwrap_or(Path::new(""));
            if beside { folder.join(text).into_os_string() } else { OsString::from(text) }
        };
        let words: Vec<_> = texts.iter().map(|text| word(long, &whole(text))).collect();
        let alone = [OsString::from("--output=out")].into_iter().chain(words.iter().cloned()).collect();
        if let Err(error) = self.vocabulary.parse(alone) {
            let (found, expected) = reason(&error);
            return Err(self.wrong(key, found, expected));
        }
        Ok(Word { id: id(arg).into(), words, said: format!("{name} = {}", texts.join(", ")) })
    }

    /// A scalar, or several.
    fn texts(&self, key: &Spanned<impl AsRef<str>>, value: &Spanned<DeValue>) -> Result<Vec<String>> {
        let scalar = |value: &DeValue| {
            Ok(match value {
                DeValue::String(text) => text.to_string(),
                DeValue::Float(number) => number.as_str().to_owned(),
                DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
                    .map_err(|_| self.wrong(key, "a number that is too large", "a smaller one"))?
                    .to_string(),
                other => return Err(self.wrong(key, found(other), "a string or a number")),
            })
        };
        match value.get_ref() {
            DeValue::Array(values) => values.iter().map(|value| scalar(value.get_ref())).collect(),
            value => Ok(vec![scalar(value)?]),
        }
    }
}

/// The kind of a value.
fn found(value: &DeValue) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}
