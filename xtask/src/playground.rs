//! `cargo xtask playground` builds the engine for browsers and its page, in `target/playground`.

use crate::dist::has_target;
use crate::{cargo, runs, succeeds};
use std::env::consts::EXE_SUFFIX;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const TARGET: &str = "wasm32-unknown-unknown";
const FOLDER: &str = "target/playground";
/// Profile of the module, without the names of its functions.
const PROFILE: &str = "playground";

pub(crate) fn playground() -> ExitCode {
    match build() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Builds the folder for a web server, and the page that can be opened as a file.
pub(crate) fn build() -> Result<(), String> {
    if !has_target(TARGET) {
        return Err(format!("its standard library is not installed: rustup target add {TARGET}"));
    }
    eprintln!("== the engine for {TARGET}");
    let mut engine =
        cargo(&["build", "--profile", PROFILE, "--locked", "--lib", "-p", "stiction-playground"]);
    // Assembly searches recurse deeper than the default stack of one megabyte allows.
    engine
        .args(["--target", TARGET])
        .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", "-C link-arg=-zstack-size=4194304");
    // The pages state the digest of the script of reports as this workspace builds it.
    let shaded = crate::viewer::include_shaded_in(&mut engine);
    if !succeeds(&mut engine) {
        return Err("the build failed".to_owned());
    }
    let _ = fs::remove_dir_all(FOLDER);
    let module =
        shortened(Path::new(&format!("target/{TARGET}/{PROFILE}/stiction_playground.wasm")));
    // The features are those of the whole workspace, as in the tests; if the program were built
    // alone, its dependencies would be compiled again.
    let pages = ["build", "--quiet", "--locked", "--workspace", "--bin", "playground-pages"];
    let program = Path::new("target/debug").join(format!("playground-pages{EXE_SUFFIX}"));
    let mut write = Command::new(program);
    write.arg(&module).arg(FOLDER).args(shaded);
    if !succeeds(&mut cargo(&pages)) || !succeeds(&mut write) {
        return Err("the pages could not be written".to_owned());
    }
    for name in ["index.html", "stiction.wasm", "stiction-playground.html"] {
        let file = Path::new(FOLDER).join(name);
        let size = fs::metadata(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        eprintln!("   {}, {} kB", file.display(), size.len() / 1000);
    }
    eprintln!("   index.html needs a web server; stiction-playground.html opens from disk");
    Ok(())
}

/// Features of WebAssembly that the compiler uses by default. The module does not name them, because
/// the section with their names is removed with the names of functions.
const FEATURES: [&str; 6] = [
    "--enable-bulk-memory",
    "--enable-multivalue",
    "--enable-mutable-globals",
    "--enable-nontrapping-float-to-int",
    "--enable-reference-types",
    "--enable-sign-ext",
];

/// Shortens the module with `wasm-opt` of Binaryen, if that is installed and understands the module; returns the module to
/// use.
fn shortened(module: &Path) -> PathBuf {
    if !runs(Command::new("wasm-opt").arg("--version")) {
        eprintln!("   wasm-opt (Binaryen) is not installed: the module is a tenth larger");
        return module.to_owned();
    }
    let short = module.with_extension("short.wasm");
    let mut shorten = Command::new("wasm-opt");
    shorten.arg("-Os").args(FEATURES).arg(module).arg("-o").arg(&short);
    match succeeds(&mut shorten) {
        true => short,
        false => {
            eprintln!("   wasm-opt failed: the module is used as it was compiled");
            module.to_owned()
        }
    }
}
