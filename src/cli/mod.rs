//! Arguments to library calls to exit code; progress. The only room that prints.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod audit;
mod bake;
mod build;
mod chains;
mod compare;
mod compare_args;
mod demo;
mod glint;
mod glint_args;
mod inputs;
mod job;
mod judging;
mod kernels;
mod lobes_arg;
mod model;
mod report;
mod table;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use report::Report;

/// Runs the command line. Exit codes: 0 done, 1 a check failed, 2 bad usage or input.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    if let Some(threads) = cli.global.threads
        && let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global()
    {
        eprintln!("error: --threads {threads}: {error}");
        return ExitCode::from(2);
    }
    let mut report = Report::new(&cli.global);
    let result = match &cli.command {
        Command::Build(args) => build::run(args, &cli.global, &mut report),
        Command::Compare(args) => compare::run(args, &cli.global, &mut report),
        Command::Audit(args) => audit::run(args, &mut report),
        Command::Demo(args) => demo::run(args, &cli.global, &mut report),
        Command::BakeCurvature(args) => bake::run(args, &cli.global, &mut report),
        Command::Glint(args) => glint::run(args, &cli.global, &mut report),
        Command::Kernels(args) => kernels::run(args, &mut report),
    };
    if let Err(error) = result {
        report.error(&error);
    }
    report.finish()
}
