//! The `mipfold` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    mipfold::cli::run()
}
