//! `cargo xtask audit`: slow, occasional checks: licences and known defects of dependencies, their
//! oldest versions, the oldest compiler, builds without optional features, memory errors, other
//! processors.
//!
//! Most steps need an additional tool. A step whose tool is missing is skipped and does not fail; a table of
//! all results ends the output.

use crate::dist::{has_target, host};
use crate::python::Environment;
use crate::{cargo, runs, succeeds};
use serde_json::Value;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// Result of a step.
enum Ended {
    Passed,
    Failed,
    /// The step was skipped, for this reason.
    Skipped(String),
}

type Step = (&'static str, &'static str, fn() -> Ended);

const STEPS: [Step; 19] = [
    ("features", "builds with and without optional features", features),
    ("platforms", "the program on other systems: cargo check for Windows and macOS", platforms),
    ("packages", "packages as they would be published: cargo package", packaging),
    ("oldest-compiler", "the oldest supported compiler", oldest_compiler),
    ("oldest-versions", "the oldest supported versions of dependencies", oldest_versions),
    ("dependencies", "licences and sources of dependencies (cargo-deny)", dependencies),
    ("advisories", "known defects of dependencies (cargo-deny)", advisories),
    ("memory", "the unsafe code and its machine code under Valgrind", memory),
    ("sanitizer", "the unsafe code under the address sanitizer", sanitizer),
    ("miri", "the unsafe code under Miri, with the interpreter in place of machine code", miri),
    ("arm", "AArch64 machine code in an emulator (QEMU)", arm),
    (
        "export",
        "exported C code of all robots of the gallery, by gcc, clang and cross compilers",
        export,
    ),
    ("playground", "the engine in a browser: WebAssembly and its page", playground),
    ("accessibility", "pages of all commands, examined by axe-core (npm, Chromium)", accessibility),
    ("coverage", "intervals of identified parameters over 200 logs of four robots", coverage),
    ("fmu", "functional mock-up units in FMPy", fmu),
    ("mcap", "logs in MCAP from and for other programs in Python", mcap),
    ("clusters", "studies in Python on local clusters of Dask and Ray", clusters),
    ("fuzz", "one minute of every fuzz target (cargo-fuzz)", fuzz),
];

pub(crate) fn audit(arguments: impl Iterator<Item = String>) -> ExitCode {
    let names: Vec<String> = arguments.collect();
    if let Some(unknown) = names.iter().find(|name| STEPS.iter().all(|(known, ..)| known != name)) {
        eprintln!("unknown step `{unknown}`; the steps are:");
        STEPS.iter().for_each(|(name, what, _)| eprintln!("  {name:<16} {what}"));
        return ExitCode::from(2);
    }
    let selected =
        STEPS.iter().filter(|(name, ..)| names.is_empty() || names.iter().any(|n| n == name));
    let mut results = Vec::new();
    let mut good = true;
    for (name, what, step) in selected {
        eprintln!("\n== {name}: {what}");
        let word = match step() {
            Ended::Passed => "passed".to_owned(),
            Ended::Skipped(why) => format!("skipped: {why}"),
            Ended::Failed => {
                good = false;
                "FAILED".to_owned()
            }
        };
        eprintln!("== {name}: {word}");
        results.push((name, word));
    }
    println!();
    results.iter().for_each(|(name, word)| println!("{name:<16} {word}"));
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Builds the playground and uses it in a browser.
fn playground() -> Ended {
    if let Err(why) = crate::playground::build() {
        let is_absent = why.contains("rustup target add");
        return if is_absent { Ended::Skipped(why) } else { Ended::Failed };
    }
    ended(succeeds(&mut cargo(&["test", "--locked", "-p", "stiction-playground"])))
}

/// Installs axe-core below `target` by its lock file, and examines the pages of all commands with
/// it. Includes the pages of the playground if they are built.
fn accessibility() -> Ended {
    if !runs(Command::new("npm").arg("--version")) {
        return Ended::Skipped("npm is not installed".to_owned());
    }
    let Ok(tools) = crate::npm::install("axe") else {
        return Ended::Skipped("axe-core cannot be installed".to_owned());
    };
    let axe = tools.join("node_modules/axe-core/axe.min.js");
    let only = ["--", "--ignored", "axe_finds_nothing_serious"];
    let test = ["test", "--locked", "--workspace", "--test", "suite"];
    ended(succeeds(cargo(&[&test[..], &only].concat()).env("STICTION_AXE", axe)))
}

/// Identifies four robots from 200 logs each, in release mode, because this takes many minutes.
fn coverage() -> Ended {
    let test = ["test", "--locked", "--release", "-p", "stiction-cli", "--test", "suite", "--"];
    let only = ["--ignored", "--nocapture", "two_hundred_seeds_of_four_robots"];
    ended(succeeds(&mut cargo(&[&test[..], &only].concat())))
}

fn ended(good: bool) -> Ended {
    if good { Ended::Passed } else { Ended::Failed }
}

/// Creates a cargo command of another toolchain, without the environment variables that select the
/// current toolchain.
fn cargo_of(toolchain: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new("cargo");
    command.arg(format!("+{toolchain}")).args(arguments);
    for variable in ["CARGO", "RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN"] {
        command.env_remove(variable);
    }
    command
}

fn has_toolchain(toolchain: &str) -> bool {
    runs(&mut cargo_of(toolchain, &["--version"]))
}

/// Packages of this workspace and, if `all` is true, their dependencies.
fn packages(all: bool) -> Option<Vec<Value>> {
    let scope: &[&str] = if all { &[] } else { &["--no-deps"] };
    let output =
        cargo(&["metadata", "--format-version=1", "--locked"]).args(scope).output().ok()?;
    let value: Value = serde_json::from_slice(&output.stdout).ok()?;
    value["packages"].as_array().cloned()
}

/// Checks every package alone, because other packages enable features of shared dependencies.
fn features() -> Ended {
    let Some(packages) = packages(false) else { return Ended::Failed };
    let good = packages.iter().filter_map(|package| package["name"].as_str()).all(|name| {
        ["--no-default-features", "--all-features"].iter().all(|features| {
            eprintln!("   {name} {features}");
            succeeds(&mut cargo(&["check", "--quiet", "--all-targets", "-p", name, features]))
        })
    });
    ended(good)
}

/// Checks that the program compiles for other systems, as far as their standard libraries are installed.
fn platforms() -> Ended {
    const TARGETS: [&str; 4] = [
        "x86_64-pc-windows-gnu",
        "aarch64-apple-darwin",
        "x86_64-unknown-linux-musl",
        "aarch64-unknown-linux-musl",
    ];
    let (installed, missing): (Vec<&str>, Vec<&str>) =
        TARGETS.into_iter().partition(|target| has_target(target));
    let good = installed.iter().all(|target| {
        eprintln!("   {target}");
        let arguments =
            ["check", "--quiet", "-p", "stiction-cli", "-p", "stiction", "--target", target];
        succeeds(&mut cargo(&arguments))
    });
    match (good, missing.as_slice()) {
        (false, _) => Ended::Failed,
        (true, []) => Ended::Passed,
        (true, missing) if installed.is_empty() => {
            Ended::Skipped(format!("rustup target add {}", missing.join(" ")))
        }
        (true, missing) => {
            eprintln!("   not installed: rustup target add {}", missing.join(" "));
            Ended::Passed
        }
    }
}

/// Packs all crates as for a registry, without compiling them again.
fn packaging() -> Ended {
    ended(succeeds(&mut cargo(&[
        "package",
        "--workspace",
        "--locked",
        "--no-verify",
        "--allow-dirty",
    ])))
}

/// Parses a version as three numbers; `1.89` means 1.89.0.
fn number(version: &str) -> [u32; 3] {
    let mut parts = version.split('.').map(|part| part.parse().unwrap_or(0));
    [(); 3].map(|()| parts.next().unwrap_or(0))
}

/// Checks the oldest supported compiler against the versions that dependencies declare. Compiles
/// our own code with it if it is installed; otherwise checks our code by clippy's lint for newer
/// library functions.
fn oldest_compiler() -> Ended {
    let Some(packages) = packages(true) else { return Ended::Failed };
    let of = |package: &Value| package["rust_version"].as_str().map(str::to_owned);
    // All packages of the workspace state the same compiler.
    let ours = self::packages(false).and_then(|own| own.iter().find_map(of));
    let Some(ours) = ours else { return Ended::Failed };
    let newer: Vec<String> = packages
        .iter()
        .filter(|package| of(package).is_some_and(|own| number(&own) > number(&ours)))
        .map(|package| format!("{} {}", package["name"], package["version"]))
        .collect();
    if !newer.is_empty() {
        eprintln!(
            "   the oldest supported compiler is {ours}, but these packages need a newer one: {}",
            newer.join(", ")
        );
        return Ended::Failed;
    }
    if has_toolchain(&ours) {
        let arguments =
            ["check", "--workspace", "--locked", "--target-dir", "target/audit/oldest-compiler"];
        return ended(succeeds(&mut cargo_of(&ours, &arguments)));
    }
    let lint = ["clippy", "--workspace", "--", "-D", "clippy::incompatible_msrv"];
    if !succeeds(&mut cargo(&lint)) {
        return Ended::Failed;
    }
    Ended::Skipped(format!(
        "toolchain {ours} is not installed; all dependencies declare support for it, and clippy finds no newer \
         library function"
    ))
}

/// Checks the oldest versions in a copy of the sources, because they change `Cargo.lock`.
fn oldest_versions() -> Ended {
    if !has_toolchain("nightly") {
        return Ended::Skipped("it needs the cargo of a nightly toolchain".to_owned());
    }
    let copy = Path::new("target/audit/oldest-versions");
    let _ = fs::remove_dir_all(copy);
    let listed = Command::new("git")
        .args(["ls-files", "--cached", "--others", "--exclude-standard"])
        .output();
    let Ok(listed) = listed else { return Ended::Skipped("git is not installed".to_owned()) };
    for name in String::from_utf8_lossy(&listed.stdout).lines() {
        let (from, to) = (Path::new(name), copy.join(name));
        let folder = to.parent().unwrap_or(copy);
        // Git also lists deleted files whose deletion is not yet committed.
        if from.is_file() && (fs::create_dir_all(folder).is_err() || fs::copy(from, &to).is_err()) {
            eprintln!("   cannot copy {name}");
            return Ended::Failed;
        }
    }
    let run = |arguments: &[&str]| succeeds(cargo_of("nightly", arguments).current_dir(copy));
    ended(
        run(&["update", "-Z", "direct-minimal-versions"])
            && run(&[
                "check",
                "--workspace",
                "--all-targets",
                "--target-dir",
                "../oldest-versions-target",
            ]),
    )
}

/// Returns the reason to skip a step if cargo-deny is not installed.
fn without_deny() -> Option<Ended> {
    let installed = runs(&mut cargo(&["deny", "--version"]));
    (!installed).then(|| Ended::Skipped("cargo install cargo-deny --locked".to_owned()))
}

fn dependencies() -> Ended {
    without_deny().unwrap_or_else(|| {
        ended(succeeds(&mut cargo(&["deny", "check", "licenses", "bans", "sources"])))
    })
}

/// Checks dependencies against the advisory database; skipped if the database cannot be fetched.
fn advisories() -> Ended {
    without_deny().unwrap_or_else(|| match runs(&mut cargo(&["deny", "fetch", "db"])) {
        true => ended(succeeds(&mut cargo(&["deny", "check", "advisories"]))),
        false => Ended::Skipped("cannot fetch the advisory database".to_owned()),
    })
}

/// Builds the unit tests of the crate that contains the unsafe code with `command`; returns their
/// path.
fn unit_tests(command: &mut Command) -> Option<PathBuf> {
    let output = command.stderr(Stdio::inherit()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let messages = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mut tests = messages.filter(|message| message["target"]["name"] == "stiction_program");
    tests.find_map(|message| message["executable"].as_str().map(PathBuf::from))
}

fn memory() -> Ended {
    if !runs(Command::new("valgrind").arg("--version")) {
        return Ended::Skipped("valgrind is not installed".to_owned());
    }
    let build = ["test", "-p", "stiction-program", "--lib", "--no-run", "--message-format=json"];
    let Some(tests) = unit_tests(&mut cargo(&build)) else { return Ended::Failed };
    let mut command = Command::new("valgrind");
    command
        .args(["--error-exitcode=1", "--quiet", "--smc-check=all"])
        .arg(tests)
        .arg("machine_code_touches_only");
    ended(succeeds(&mut command))
}

fn sanitizer() -> Ended {
    if !has_toolchain("nightly") {
        return Ended::Skipped("it needs a nightly toolchain".to_owned());
    }
    let Some(host) = host() else { return Ended::Failed };
    let mut test =
        cargo_of("nightly", &["test", "-p", "stiction-program", "--tests", "--target", &host]);
    test.args(["--target-dir", "target/audit/sanitizer"]).env("RUSTFLAGS", "-Zsanitizer=address");
    ended(succeeds(&mut test))
}

/// Runs the unit tests under Miri, where recorded programs are interpreted.
fn miri() -> Ended {
    if !has_toolchain("nightly") || !runs(&mut cargo_of("nightly", &["miri", "--version"])) {
        return Ended::Skipped("rustup component add --toolchain nightly miri".to_owned());
    }
    let test =
        ["miri", "test", "-p", "stiction-program", "--lib", "--target-dir", "target/audit/miri"];
    ended(succeeds(&mut cargo_of("nightly", &test)))
}

/// Tests recorded programs on AArch64, linked by `rust-lld` and run in an emulator.
fn arm() -> Ended {
    const TARGET: &str = "aarch64-unknown-linux-musl";
    if !has_target(TARGET) {
        return Ended::Skipped(format!("rustup target add {TARGET}"));
    }
    let mut emulators = ["qemu-aarch64", "qemu-aarch64-static"].into_iter();
    let Some(emulator) = emulators.find(|name| runs(Command::new(name).arg("--version"))) else {
        return Ended::Skipped("qemu-aarch64 is not installed".to_owned());
    };
    let mut test =
        cargo(&["test", "--release", "-p", "stiction-program", "--tests", "--target", TARGET]);
    test.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_LINKER", "rust-lld")
        .env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_RUNNER", emulator);
    ended(succeeds(&mut test))
}

/// Compiles and tests exported code with every installed compiler. With the first compiler, also
/// compares the code with the solver at many random states, runs it in emulators of other
/// processors and in LinuxCNC if they are installed, and measures its speed.
fn export() -> Ended {
    let compilers = ["gcc", "clang"];
    let installed = compilers.iter().filter(|name| runs(Command::new(name).arg("--version")));
    let installed: Vec<_> = installed.collect();
    if installed.is_empty() {
        return Ended::Skipped("neither gcc nor clang is installed".to_owned());
    }
    let test = ["test", "--release", "-p", "stiction-program", "--test", "suite"];
    let all = ["--", "--include-ignored"];
    let by_all = installed.iter().all(|compiler| {
        eprintln!("   {compiler}");
        let only = ["emit::generated_c", "emit::functions"];
        succeeds(cargo(&[&test[..], &all, &only].concat()).env("STICTION_CC", compiler))
    });
    let only = ["--nocapture", "emit::agreement", "emit::adapters", "emit::speed"];
    ended(
        by_all
            && succeeds(cargo(&[&test[..], &all, &only].concat()).env("STICTION_CC", installed[0])),
    )
}

/// Checks and simulates functional mock-up units with FMPy.
fn fmu() -> Ended {
    by_python("fmu", &["fmu.py", "fmu_plant.py"], || {
        succeeds(&mut cargo(&["build", "--release", "-p", "stiction-cli"]))
            && crate::fmu::build(&[])
    })
}

/// Reads MCAP logs of another program, and lets another program read the logs that this project
/// writes.
fn mcap() -> Ended {
    if !succeeds(&mut cargo(&[
        "test",
        "--locked",
        "-p",
        "stiction-format",
        "--features",
        "mcap",
        "mcap",
    ])) || !succeeds(&mut cargo(&[
        "test",
        "--locked",
        "-p",
        "stiction-cli",
        "--features",
        "mcap",
        "--test",
        "suite",
        "mcap",
    ])) {
        return Ended::Failed;
    }
    by_python("mcap_logs", &["mcap_logs.py"], || {
        succeeds(&mut cargo(&["build", "--release", "-p", "stiction-cli", "--features", "mcap"]))
    })
}

/// Builds the program with `build` and runs scripts of `validation/` with it, in an environment
/// with the packages of `name`.
fn by_python(name: &str, scripts: &[&str], build: impl FnOnce() -> bool) -> Ended {
    let validation = Path::new(env!("CARGO_MANIFEST_DIR")).join("../validation");
    let requirements = validation.join(format!("{name}-requirements.txt"));
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/audit").join(name);
    let environment = Environment { place, requirements: &requirements, least: (3, 11) };
    let python = match environment.interpreter() {
        Ok(python) => python,
        Err(missing) => return Ended::Skipped(missing.text().to_owned()),
    };
    if !build() {
        return Ended::Failed;
    }
    let program = format!("target/release/stiction{}", env::consts::EXE_SUFFIX);
    let mut scripts = scripts.iter().map(|name| validation.join(name));
    ended(scripts.all(|script| succeeds(Command::new(&python).arg(script).arg(&program))))
}

fn clusters() -> Ended {
    match crate::package::clusters() {
        Ok(good) => ended(good),
        Err(why) => Ended::Skipped(why),
    }
}

fn fuzz() -> Ended {
    if !has_toolchain("nightly") || !runs(&mut cargo_of("nightly", &["fuzz", "--version"])) {
        return Ended::Skipped(
            "rustup toolchain install nightly; cargo install cargo-fuzz".to_owned(),
        );
    }
    let output = cargo_of("nightly", &["fuzz", "list"]).output();
    let list = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    let list = list.unwrap_or_default();
    let seconds = env::var("SECONDS_PER_TARGET").unwrap_or_else(|_| "60".to_owned());
    let time = format!("-max_total_time={seconds}");
    let mut names = list.lines().peekable();
    let any = names.peek().is_some();
    ended(
        any && names.all(|name| {
            let own = format!("fuzz/corpus/{name}");
            let seeds = format!("fuzz/seeds/{name}");
            let made = fs::create_dir_all(&own).is_ok() && fs::create_dir_all(&seeds).is_ok();
            let run = [
                "fuzz",
                "run",
                "--sanitizer",
                "none",
                name,
                &own,
                &seeds,
                "--",
                &time,
                "-timeout=60",
            ];
            made && succeeds(&mut cargo_of("nightly", &run))
        }),
    )
}
