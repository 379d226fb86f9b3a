//! The C compiler of this system.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use stiction_program::emit::SourceFile;

/// Warnings that are errors.
pub(crate) const STRICT: [&str; 5] = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];

/// Source code in a folder, with a compiler.
pub(crate) struct Code {
    folder: PathBuf,
    /// Beginning of all names in the code.
    name: String,
}

/// Name of the compiler.
fn compiler() -> String {
    std::env::var("STICTION_CC").unwrap_or_else(|_| "gcc".to_owned())
}

fn text(output: &Output) -> String {
    let read = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    read(&output.stdout) + &read(&output.stderr)
}

/// Writes files into an empty folder.
fn written(folder: &str, files: &[SourceFile]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("export").join(folder);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    for file in files {
        fs::write(folder.join(&file.name), &file.text).unwrap();
    }
    folder
}

/// Runs a command in a folder; returns what it prints.
fn run_in(folder: &Path, command: &mut Command) -> String {
    let output = command.current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}: {}", folder.display(), text(&output));
    text(&output)
}

/// The Rust compiler, with warnings as errors.
fn rustc() -> Command {
    let mut command = Command::new(std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned()));
    command.args(["--edition", "2021", "-D", "warnings"]);
    command
}

impl Code {
    /// Writes the files into an empty folder; `None` without a compiler, which continuous
    /// integration has.
    pub(crate) fn new(folder: &str, name: &str, files: &[SourceFile]) -> Option<Self> {
        let compiler = compiler();
        if Command::new(&compiler).arg("--version").output().is_err() {
            assert!(std::env::var("CI").as_deref() != Ok("true"), "install {compiler}");
            println!("skipped: {compiler} is not installed");
            return None;
        }
        let folder = written(folder, files);
        Some(Self { folder, name: name.to_owned() })
    }

    /// Compiles the code with a main program; returns the messages of the compiler if it fails.
    pub(crate) fn compile(&self, main: &str, flags: &[&str]) -> Result<PathBuf, String> {
        let program = self.folder.join("program");
        let output = Command::new(compiler())
            .args(flags)
            .args(["-o", "program", main, &format!("{}.c", self.name), "-lm"])
            .current_dir(&self.folder)
            .output()
            .unwrap();
        if output.status.success() { Ok(program) } else { Err(text(&output)) }
    }

    fn run(&self, main: &str, flags: &[&str]) -> String {
        let program = self.compile(main, flags).unwrap_or_else(|e| panic!("{flags:?}: {e}"));
        let output = Command::new(program).current_dir(&self.folder).output().unwrap();
        let said = text(&output);
        assert!(output.status.success(), "{}: {flags:?}: {said}", self.folder.display());
        said
    }

    /// Compiles and runs the self-test.
    pub(crate) fn selftest(&self, flags: &[&str]) {
        let said = self.run("selftest.c", flags);
        assert!(said.contains(" 0 failures"), "{said}");
    }

    /// Compiles and runs a main program, in which `NAME` stands for the name of the code; returns
    /// its standard output.
    pub(crate) fn run_with(&self, file: &str, main: &str, flags: &[&str]) -> String {
        let main = main.replace("UPPER", &self.name.to_uppercase()).replace("NAME", &self.name);
        let file = format!("{file}.c");
        fs::write(self.folder.join(&file), main).unwrap();
        self.run(&file, flags)
    }

    /// Sizes of the sections of the compiled code.
    pub(crate) fn size(&self, flags: &[&str]) -> String {
        let source = format!("{}.c", self.name);
        let run = |command: &mut Command| command.current_dir(&self.folder).output().unwrap();
        run(Command::new(compiler()).args(flags).args([
            "-fstack-usage",
            "-c",
            "-o",
            "code.o",
            &source,
        ]));
        let said = text(&run(Command::new("size").args(["-A", "code.o"])));
        let wanted = |line: &&str| line.starts_with(".text") || line.starts_with(".rodata");
        let sizes = said.lines().filter(wanted).map(|line| line.split_whitespace().nth(1));
        let total: u32 = sizes.flatten().filter_map(|size| size.parse::<u32>().ok()).sum();
        let stack = fs::read_to_string(self.folder.join("code.su")).unwrap_or_default();
        let deepest = stack.lines().filter_map(|line| line.split('\t').nth(1)?.parse::<u32>().ok());
        format!(
            ".text and .rodata {total} bytes, stack {} bytes in all functions",
            deepest.sum::<u32>()
        )
    }
}

/// Compiles a main program beside code in Rust, and runs it.
pub(crate) fn rust_program(folder: &str, files: &[SourceFile], main: &str) {
    let folder = written(folder, files);
    fs::write(folder.join("main.rs"), main).unwrap();
    run_in(&folder, rustc().args(["-o", "program", "main.rs"]));
    run_in(&folder, &mut Command::new(folder.join("program")));
}

/// Compiles and runs the self-test of code in Rust; the module also as a library without the standard
/// library.
pub(crate) fn rust_selftest(folder: &str, name: &str, files: &[SourceFile]) {
    let folder = written(folder, files);
    fs::write(folder.join("bare.rs"), format!("#![no_std]\npub mod {name};\n")).unwrap();
    run_in(&folder, rustc().args(["-O", "--crate-type", "rlib", "bare.rs"]));
    run_in(&folder, rustc().args(["-O", "-o", "selftest", "selftest.rs"]));
    let said = run_in(&folder, Command::new(folder.join("selftest")).arg("vectors.csv"));
    assert!(said.contains(" 0 failures"), "{said}");
}
