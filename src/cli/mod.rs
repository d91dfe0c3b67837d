//! Arguments to library calls to exit code; progress. The only room that prints.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod audit;
mod bake;
mod build;
mod chains;
mod compare;
mod compare_args;
mod config;
mod container_args;
mod demo;
mod glint;
mod glint_args;
mod glob;
mod inputs;
mod job;
mod judging;
mod kernels;
mod lobes_arg;
mod model;
mod presets;
mod report;
mod table;
mod vocabulary;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};

use args::{Cli, Command};
use report::Report;

/// Runs the command line. Exit codes: 0 done, 1 a check failed, 2 bad usage or input.
pub fn run() -> ExitCode {
    let matches = Cli::command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    if let Some(threads) = cli.global.threads
        && let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global()
    {
        eprintln!("error: --threads {threads}: {error}");
        return ExitCode::from(2);
    }
    let said = || matches.subcommand_matches("build").expect("that is the command");
    let mut report = Report::new(&cli.global);
    let result = match &cli.command {
        Command::Build(args) => build::run(args, said(), &cli.global, &mut report),
        Command::Compare(args) => compare::run(args, &cli.global, &mut report),
        Command::Audit(args) => audit::run(args, &mut report),
        Command::Demo(args) => demo::run(args, &cli.global, &mut report),
        Command::BakeCurvature(args) => bake::run(args, &cli.global, &mut report),
        Command::Glint(args) => glint::run(args, &cli.global, &mut report),
        Command::Kernels(args) => kernels::run(args, &mut report),
        Command::Presets(args) => presets::run(args, &mut report),
    };
    if let Err(error) = result {
        report.error(&error);
    }
    report.finish()
}
