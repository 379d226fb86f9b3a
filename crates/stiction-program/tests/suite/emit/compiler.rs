//! The C compiler of this system.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use stiction_program::emit::SourceFile;

/// Warnings that count as errors.
pub(crate) const STRICT: [&str; 5] = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];

/// Options that abort a program at undefined behaviour, including conversions of NaN to integers.
pub(crate) const SANITIZERS: [&str; 3] =
    ["-O1", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"];

/// Source code in a folder, with a compiler.
pub(crate) struct Code {
    folder: PathBuf,
    /// Prefix of all names in the code.
    name: String,
}

/// Name of the compiler.
fn compiler() -> String {
    std::env::var("STICTION_CC").unwrap_or_else(|_| "gcc".to_owned())
}

/// Returns true if a program is installed. Otherwise prints a message, or panics in continuous
/// integration, where all programs must be installed.
pub(crate) fn is_installed(program: &str) -> bool {
    let runs = Command::new(program).arg("--version").output().is_ok();
    assert!(runs || std::env::var("CI").as_deref() != Ok("true"), "install {program}");
    if !runs {
        println!("skipped: {program} is not installed");
    }
    runs
}

fn text(output: &Output) -> String {
    let read = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    read(&output.stdout) + &read(&output.stderr)
}

/// Writes files into an empty folder and returns its path.
fn written(folder: &str, files: &[SourceFile]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("emit").join(folder);
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

/// Creates a command of the Rust compiler, with warnings as errors.
fn rustc() -> Command {
    let mut command = Command::new(std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned()));
    command.args(["--edition", "2021", "-D", "warnings"]);
    command
}

impl Code {
    /// Writes the files into an empty folder. Returns `None` if no compiler is installed, which
    /// continuous integration does not allow.
    pub(crate) fn new(folder: &str, name: &str, files: &[SourceFile]) -> Option<Self> {
        if !is_installed(&compiler()) {
            return None;
        }
        let folder = written(folder, files);
        Some(Self { folder, name: name.to_owned() })
    }

    /// Writes a file beside the code.
    pub(crate) fn write(&self, name: &str, content: &[u8]) {
        fs::write(self.folder.join(name), content).unwrap();
    }

    /// Reads a file that a program has written.
    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.folder.join(name)).unwrap()
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

    /// Compiles the self-test with another compiler and runs it in an emulator; returns what it
    /// prints.
    pub(crate) fn selftest_by(&self, compiler: &str, emulator: &str, flags: &[&str]) -> String {
        let (source, program) = (format!("{}.c", self.name), self.folder.join("selftest_other"));
        let mut compile = Command::new(compiler);
        compile.args(flags).args(["-o", "selftest_other", "selftest.c", &source, "-lm"]);
        run_in(&self.folder, &mut compile);
        let said = run_in(&self.folder, Command::new(emulator).arg(program));
        assert!(said.contains(" 0 failures"), "{said}");
        said
    }

    /// Builds a target of the Makefile; returns what the command prints.
    pub(crate) fn make(&self, target: &str) -> String {
        run_in(&self.folder, Command::new("make").arg(target))
    }

    /// Runs a Python program in the folder; returns what it prints.
    pub(crate) fn python(&self, program: &str) -> String {
        run_in(&self.folder, Command::new("python3").args(["-c", program]))
    }

    /// Size of code and constants, and sum of the stack usage of all functions, both in bytes.
    pub(crate) fn size(&self, flags: &[&str]) -> (u32, u32) {
        let source = format!("{}.c", self.name);
        let compile = ["-fstack-usage", "-c", "-o", "code.o", &source];
        run_in(&self.folder, Command::new(compiler()).args(flags).args(compile));
        let said = run_in(&self.folder, Command::new("size").args(["-A", "code.o"]));
        let wanted = |line: &&str| line.starts_with(".text") || line.starts_with(".rodata");
        let sizes = said.lines().filter(wanted).map(|line| line.split_whitespace().nth(1));
        let total = sizes.flatten().filter_map(|size| size.parse::<u32>().ok()).sum();
        let stack = fs::read_to_string(self.folder.join("code.su")).unwrap();
        let each = stack.lines().filter_map(|line| line.split('\t').nth(1)?.parse::<u32>().ok());
        (total, each.sum())
    }
}

/// Compiles a main program together with Rust code, and runs it.
pub(crate) fn rust_program(folder: &str, files: &[SourceFile], main: &str) {
    let folder = written(folder, files);
    fs::write(folder.join("main.rs"), main).unwrap();
    run_in(&folder, rustc().args(["-o", "program", "main.rs"]));
    run_in(&folder, &mut Command::new(folder.join("program")));
}

/// Compiles and runs the self-test of Rust code; also compiles the module as a library without the
/// standard library.
pub(crate) fn rust_selftest(folder: &str, name: &str, files: &[SourceFile]) {
    let folder = written(folder, files);
    fs::write(folder.join("bare.rs"), format!("#![no_std]\npub mod {name};\n")).unwrap();
    run_in(&folder, rustc().args(["-O", "--crate-type", "rlib", "bare.rs"]));
    run_in(&folder, rustc().args(["-O", "-o", "selftest", "selftest.rs"]));
    let said = run_in(&folder, Command::new(folder.join("selftest")).arg("vectors.csv"));
    assert!(said.contains(" 0 failures"), "{said}");
}
