//! The options of `mipfold build` as words that can be put together anew.

use std::ffi::{OsStr, OsString};

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, FromArgMatches};

use super::args::BuildArgs;

/// Options that no file sets: where outputs go is said by whoever runs the command.
const UNSET: [&str; 3] = ["output", "config", "help"];

/// An option and its values, as words of a command line.
#[derive(Clone)]
pub struct Word {
    pub id: String,
    pub words: Vec<OsString>,
    /// As a file has it, for people.
    pub said: String,
}

/// The options that there are, and those that the command line gave.
pub struct Vocabulary {
    command: clap::Command,
    pub given: Vec<Word>,
}

impl Vocabulary {
    /// With the options that `given` has from the command line.
    pub fn new(given: &ArgMatches) -> Self {
        let mut command = BuildArgs::augment_args(clap::Command::new("build").no_binary_name(true));
        command.build();
        let options =
            command.get_arguments().filter(|arg| !arg.is_positional() && given.try_contains_id(id(arg)).is_ok());
        let options = options.filter(|arg| given.value_source(id(arg)) == Some(ValueSource::CommandLine));
        let given = options.map(|arg| {
            let long = arg.get_long().expect("an option");
            let words = if takes_values(arg) {
                given.get_raw(id(arg)).into_iter().flatten().map(|value| word(long, value)).collect()
            } else {
                vec![OsString::from(format!("--{long}"))]
            };
            Word { id: id(arg).to_owned(), words, said: String::new() }
        });
        let given = given.collect();
        Self { command, given }
    }

    fn settable(&self) -> impl Iterator<Item = &Arg> {
        self.command.get_arguments().filter(|arg| !arg.is_positional() && !UNSET.contains(&id(arg)))
    }

    /// What a file may set by this name.
    pub fn option(&self, key: &str) -> Option<&Arg> {
        let named = |arg: &&Arg| {
            arg.get_long() == Some(key) || arg.get_all_aliases().is_some_and(|aliases| aliases.contains(&key))
        };
        self.settable().find(named)
    }

    pub fn names(&self) -> String {
        self.settable().filter_map(Arg::get_long).collect::<Vec<_>>().join(", ")
    }

    /// Whether two options say the same thing, or cannot be said together.
    pub fn rivals(&self, a: &str, b: &str) -> bool {
        let conflict = |a: &str, b: &str| {
            let arg = self.command.get_arguments().find(|arg| id(arg) == a);
            arg.is_some_and(|arg| self.command.get_arg_conflicts_with(arg).iter().any(|other| id(other) == b))
        };
        a == b || conflict(a, b) || conflict(b, a)
    }

    pub fn parse(&self, words: Vec<OsString>) -> std::result::Result<BuildArgs, clap::Error> {
        let matches = self.command.clone().try_get_matches_from(words)?;
        BuildArgs::from_arg_matches(&matches)
    }
}

pub fn id(arg: &Arg) -> &str {
    arg.get_id().as_str()
}

pub fn takes_values(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Set | ArgAction::Append)
}

pub fn word(long: &str, value: &OsStr) -> OsString {
    let mut word = OsString::from(format!("--{long}="));
    word.push(value);
    word
}

/// What is wrong with a value, and what would have been right.
pub fn reason(error: &clap::Error) -> (String, String) {
    use clap::error::{ContextKind, ContextValue};
    use std::error::Error as _;
    let value = match error.get(ContextKind::InvalidValue) {
        Some(ContextValue::String(value)) => format!("'{value}'"),
        _ => "a value that does not fit".into(),
    };
    let expected = match (error.source(), error.get(ContextKind::ValidValue)) {
        (Some(source), _) => source.to_string().trim_start_matches("expected ").to_owned(),
        (_, Some(ContextValue::Strings(valid))) if !valid.is_empty() => format!("one of {}", valid.join(", ")),
        _ => {
            let text = error.render().to_string();
            let text = text.split("\n\n").next().unwrap_or_default().trim_start_matches("error: ");
            text.split_whitespace().collect::<Vec<_>>().join(" ")
        }
    };
    (value, expected)
}
