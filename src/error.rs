//! What can go wrong and whose fault it is.

use std::path::{Path, PathBuf};

/// The result of every fallible call in this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Every message names the subject (usually a file), what was found there and what was expected.
///
/// Numerical code never returns an error: it is total over finite input.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The input is well formed, but asks for something that mipfold does not do.
    #[error("{subject}: {found} is not supported; supported: {expected}")]
    Unsupported {
        /// The file or option at fault.
        subject: String,
        /// What was found.
        found: String,
        /// What would have been accepted.
        expected: String,
    },
    /// The input is broken or contradicts itself.
    #[error("{subject}: found {found}; expected {expected}")]
    Invalid {
        /// The file or option at fault.
        subject: String,
        /// What was found.
        found: String,
        /// What would have been accepted.
        expected: String,
    },
    /// The operating system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's own error.
        source: std::io::Error,
    },
}

impl Error {
    /// An [`Error::Invalid`] about a file.
    pub fn invalid(path: &Path, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::invalid_option(path.display().to_string(), found, expected)
    }

    /// An [`Error::Invalid`] about an option or anything else that is not a file.
    pub fn invalid_option(subject: impl Into<String>, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Invalid { subject: subject.into(), found: found.into(), expected: expected.into() }
    }

    /// An [`Error::Unsupported`] about a file.
    pub fn unsupported(path: &Path, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Unsupported { subject: path.display().to_string(), found: found.into(), expected: expected.into() }
    }

    /// An [`Error::Io`] about a file.
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }
}
