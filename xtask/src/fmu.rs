//! `cargo xtask fmu` builds the library of plant FMUs for this platform, in the folder where the
//! program finds it.

use crate::{cargo, succeeds};
use std::env;
use std::process::ExitCode;

pub(crate) fn fmu() -> ExitCode {
    if !build(&[]) {
        return ExitCode::FAILURE;
    }
    let (prefix, suffix) = (env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    let name = format!("{prefix}stiction_fmu{suffix}");
    eprintln!("== target/release/{name}");
    eprintln!("   a program elsewhere finds it in its own folder or in ../lib");
    ExitCode::SUCCESS
}

/// Builds the library with additional options of cargo. The program itself is built separately.
pub(crate) fn build(options: &[&str]) -> bool {
    let build = ["build", "--release", "--lib", "-p", "stiction-fmu"];
    succeeds(cargo(&build).args(options))
}
