//! Prerequisites of the comparison: Python packages, a C++ compiler, harnesses, our own programs and files of
//! states.

use super::Trouble;
use super::machine::last_core;
use crate::package::assemble;
use crate::python::engines;
use crate::{cargo, succeeds};
use serde_json::Value;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Programs of this project that take part in the comparison.
pub(crate) struct Programs {
    /// The program `stiction`.
    pub(crate) program: PathBuf,
    /// Program that computes our side of the comparison.
    pub(crate) ours: PathBuf,
    /// Folder that contains our Python package.
    pub(crate) package: PathBuf,
    /// Folder of the harnesses, the files of states, and other results.
    pub(crate) place: PathBuf,
    /// Core on which all timed programs run; `None` if they cannot be pinned.
    pub(crate) core: Option<usize>,
}

impl Programs {
    /// Builds the programs.
    pub(crate) fn build() -> Result<Self, Trouble> {
        let packages = ["stiction-cli", "stiction-peers", "stiction-python"];
        let packages = packages.iter().flat_map(|name| ["--package", name]);
        if !succeeds(cargo(&["build", "--release"]).args(packages)) {
            return Err(Trouble::Failed("cargo cannot build our programs".into()));
        }
        // The folder of release builds lies beside that of this program.
        let built = env::current_exe().ok().and_then(|own| Some(own.parent()?.parent()?.into()));
        let built: PathBuf =
            built.ok_or_else(|| Trouble::Failed("the build folder of cargo is unknown".into()))?;
        let programs = Self {
            program: built.join("release/stiction"),
            ours: built.join("release/stiction-peers"),
            package: built.join("peers/python"),
            place: built.join("peers"),
            core: last_core(),
        };
        for program in [&programs.program, &programs.ours] {
            if !program.is_file() {
                return Err(Trouble::Failed(format!("cargo has not built {}", program.display())));
            }
        }
        fs::create_dir_all(&programs.place)
            .map_err(|error| Trouble::Failed(format!("{}: {error}", programs.place.display())))?;
        assemble(&programs.package, &built.join("release")).map_err(Trouble::Failed)?;
        Ok(programs)
    }

    pub(crate) fn ours(&self) -> Runs {
        self.on_core(&self.ours)
    }

    pub(crate) fn program(&self) -> Runs {
        self.on_core(&self.program)
    }

    fn on_core(&self, program: &Path) -> Runs {
        let Some(core) = self.core else { return Runs(Command::new(program)) };
        let mut command = Command::new("taskset");
        command.args(["--cpu-list", &core.to_string()]).arg(program);
        Runs(command)
    }
}

/// Paths of the tools and programs that a comparison uses.
pub(crate) struct Tools<'a> {
    /// Our own programs.
    pub(crate) programs: &'a Programs,
    /// Python interpreter of the environment.
    pub(crate) python: PathBuf,
    /// Folder `peers` of the repository.
    pub(crate) sources: PathBuf,
    /// C++ compiler and its version line.
    pub(crate) compiler: (String, String),
}

/// Optimisation flags of the compiler for all harnesses.
pub(crate) const FLAGS: [&str; 4] = ["-std=c++17", "-O3", "-march=native", "-DNDEBUG"];

/// Flags that the headers of Pinocchio need, from the CMake file of its wheel.
const PINOCCHIO: [&str; 4] = [
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
];

impl<'a> Tools<'a> {
    pub(crate) fn find(programs: &'a Programs) -> Result<Self, Trouble> {
        if cfg!(windows) {
            return Err(Trouble::Missing("the harnesses need Linux or macOS".into()));
        }
        let compiler = compiler().ok_or_else(|| {
            Trouble::Missing(
                "a C++ compiler is missing; install `c++`, `g++` or `clang++`, or name one in \
                 the variable CXX"
                    .into(),
            )
        })?;
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let python = engines(&root.join("validation")).map_err(Trouble::Missing)?;
        let tools = Self { programs, python, sources: root.join("peers"), compiler };
        tools.build_harnesses()?;
        Ok(tools)
    }

    fn build_harnesses(&self) -> Result<(), Trouble> {
        let site = "import sysconfig; print(sysconfig.get_path('platlib'))";
        let site = output(Command::new(&self.python).args(["-c", site]))?;
        let site = Path::new(site.trim());
        let headers = site.join("cmeel.prefix/include");
        let mujoco = site.join("mujoco");
        let eigen = system(&headers.join("eigen3"));
        let library = shared_library(&mujoco)
            .ok_or_else(|| Trouble::Missing("the wheel of MuJoCo lacks its library".into()))?;
        self.build("dense", &eigen)?;
        let mut flags = [eigen.clone(), system(&mujoco.join("include"))].concat();
        flags.push(library.display().to_string());
        flags.push(format!("-Wl,-rpath,{}", mujoco.display()));
        self.build("mujoco", &flags)?;
        self.build("mujoco_simulation", &flags)?;
        let mut flags = [eigen, system(&headers)].concat();
        flags.extend(PINOCCHIO.map(String::from));
        self.build("pinocchio", &flags)
    }

    /// Builds a harness if its source, flags or compiler have changed.
    fn build(&self, name: &str, flags: &[String]) -> Result<(), Trouble> {
        let source = self.sources.join(format!("{name}.cpp"));
        let read = |path: &Path| {
            fs::read_to_string(path)
                .map_err(|error| Trouble::Failed(format!("{}: {error}", path.display())))
        };
        let texts = read(&source)? + &read(&self.sources.join("harness.hpp"))?;
        let expected = format!("{:?} {FLAGS:?} {flags:?}\n{texts}", self.compiler);
        let (program, stamp) =
            (self.programs.place.join(name), self.programs.place.join(format!("{name}.stamp")));
        if program.is_file() && fs::read_to_string(&stamp).is_ok_and(|built| built == expected) {
            return Ok(());
        }
        eprintln!("== building the harness of {name}; this may take minutes");
        let mut command = Command::new(&self.compiler.0);
        // Warnings would come from the headers of the engines.
        command.args(FLAGS).arg("-w").arg(&source).args(flags).arg("-o").arg(&program);
        if !succeeds(&mut command) {
            return Err(Trouble::Failed(format!("the compiler cannot build {}", source.display())));
        }
        fs::write(&stamp, expected)
            .map_err(|error| Trouble::Failed(format!("{}: {error}", stamp.display())))
    }

    /// Writes models and states for the engines; returns their folder.
    pub(crate) fn states(&self, models: &[&str]) -> Result<PathBuf, Trouble> {
        let folder = self.programs.place.join("states");
        let mut command = Command::new(&self.python);
        command.arg(self.sources.join("states.py")).arg("--stiction").arg(&self.programs.program);
        command.arg("--out").arg(&folder).args(models);
        output(&mut command).map(|_| folder)
    }

    pub(crate) fn harness(&self, name: &str) -> Runs {
        self.programs.on_core(&self.programs.place.join(name))
    }

    /// Determines the versions of the engines, libraries and compilers.
    pub(crate) fn versions(&self) -> Result<Value, Trouble> {
        let question = "\
import json, platform
from importlib.metadata import version
names = ['mujoco', 'pin', 'drake', 'exudyn', 'cmeel-eigen', 'cmeel-boost', 'numpy']
print(json.dumps({'python': platform.python_version(), **{name: version(name) for name in names}}))";
        let text = output(Command::new(&self.python).args(["-c", question]))?;
        let mut versions: Value =
            serde_json::from_str(&text).map_err(|error| Trouble::Failed(error.to_string()))?;
        versions["stiction"] = env!("CARGO_PKG_VERSION").into();
        let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        versions["rustc"] = output(Command::new(rustc).arg("--version"))?.trim().into();
        versions["compiler"] = self.compiler.1.clone().into();
        versions["flags"] = FLAGS.join(" ").into();
        versions["rustflags"] = env::var("RUSTFLAGS").unwrap_or_default().into();
        Ok(versions)
    }
}

/// Command to which arguments are added one at a time.
pub(crate) struct Runs(Command);

impl Runs {
    pub(crate) fn arg(mut self, argument: impl AsRef<std::ffi::OsStr>) -> Self {
        self.0.arg(argument);
        self
    }

    pub(crate) fn command(self) -> Command {
        self.0
    }
}

/// Standard output of a command.
pub(crate) fn output(command: &mut Command) -> Result<String, Trouble> {
    let done = command
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| Trouble::Failed(format!("cannot run {command:?}: {error}")))?;
    if !done.status.success() {
        return Err(Trouble::Failed(format!("{command:?} has failed")));
    }
    String::from_utf8(done.stdout).map_err(|error| Trouble::Failed(error.to_string()))
}

/// Compiler flags for an include folder whose headers cause no warnings.
fn system(folder: &Path) -> Vec<String> {
    vec!["-isystem".into(), folder.display().to_string()]
}

fn compiler() -> Option<(String, String)> {
    let named = env::var("CXX").ok();
    let names = named.into_iter().chain(["c++", "g++", "clang++"].map(String::from));
    names.filter(|name| !name.is_empty()).find_map(|name| {
        let answer = Command::new(&name).arg("--version").output().ok()?;
        let text = String::from_utf8(answer.stdout).ok().filter(|_| answer.status.success())?;
        Some((name, text.lines().next()?.to_string()))
    })
}

/// File of MuJoCo's library, whose name contains its version.
fn shared_library(folder: &Path) -> Option<PathBuf> {
    let names = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    names
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            name.starts_with("libmujoco.") && (name.contains(".so") || name.ends_with(".dylib"))
        })
        .min()
}
