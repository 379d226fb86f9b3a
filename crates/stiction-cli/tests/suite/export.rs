//! The command `stiction export`.

use crate::program::Folder;

const FILES: [&str; 7] =
    ["CMakeLists.txt", "Makefile", "README.md", "selftest.c", "vectors.csv", "NAME.c", "NAME.h"];

fn files(name: &str) -> Vec<String> {
    let mut files: Vec<String> = FILES.iter().map(|file| file.replace("NAME", name)).collect();
    files.sort();
    files
}

/// Checks that all files are written, are the same for the same input, and contain changed values
/// as parameters.
#[test]
fn an_export_is_complete_and_reproducible() {
    let folder = Folder::new("export");
    let export = |out: &str, more: &[&str]| {
        let common = ["export", "five-bar", "--to", "c", "--vectors", "20", "-o", out];
        folder.stiction(&[&common, more].concat()).succeeds();
        Folder(folder.0.join(out))
    };
    let (first, second) = (export("a", &[]), export("b", &[]));
    assert_eq!(first.files(), files("five_bar"));
    for file in first.files() {
        assert_eq!(first.read(&file), second.read(&file), "{file}");
    }
    assert!(first.read("vectors.csv").lines().count() > 10);
    let changed =
        export("c", &["--set", "tool.mass=0.7kg", "--name", "arm", "--precision", "float"]);
    assert_eq!(changed.files(), files("arm"));
    assert!(changed.read("arm.h").contains("typedef float arm_real;"));
    let loaded = export("d", &["--tunable", "masses", "--payload", "tool"]);
    let header = loaded.read("five_bar.h");
    for field in ["mass[", "payload[4]"] {
        assert!(header.contains(field), "{field}");
    }
    assert!(!header.contains(" mu["));
    let functions = "kinematics,reactions,derivatives,accelerations";
    let rich =
        ["--functions", functions, "--force-on", "tool", "--adapters", "ctypes,linuxcnc,cortex-m7"];
    let rich = export("e", &rich);
    let header = rich.read("five_bar.h");
    for text in ["wrench[6]", "five_bar_derivatives(", "five_bar_accelerations(", "five_bar_poses("]
    {
        assert!(header.contains(text), "{text}");
    }
    let mut all = files("five_bar");
    all.extend(
        ["cortex_m7.c", "cortex_m7.ld", "five_bar.py", "five_bar_hal.comp"].map(str::to_owned),
    );
    all.sort();
    assert_eq!(rich.files(), all);
    // Coordinates of the platform, in the order of the option.
    let names = ["--coordinates", "platform.rx,platform.z,platform.ry"];
    folder.stiction(&[&["export", "3rps", "--to", "c", "-o", "p"], &names[..]].concat()).succeeds();
    let header = Folder(folder.0.join("p")).read("robot_3rps.h");
    let at = |name: &str| header.find(name).unwrap_or_else(|| panic!("{name}: {header}"));
    assert!(at("[0] platform.rx [rad]") < at("[1] platform.z [m]"));
    folder.stiction(&["export", "five-bar", "--to", "rust", "-o", "r"]).succeeds();
    let names = ["Makefile", "README.md", "five_bar.rs", "selftest.rs", "vectors.csv"];
    assert_eq!(Folder(folder.0.join("r")).files(), names);
}

/// An FMU is a reproducible archive. Effects that the model applies by default but the code omits
/// are reported.
#[test]
fn an_fmu_is_a_reproducible_archive() {
    let folder = Folder::new("export-fmu");
    let read = |out: &str, fmi: &str| {
        let said = folder.stiction(&["export", "five-bar", "--to", "fmu", "--fmi", fmi, "-o", out]);
        said.succeeds();
        assert!(said.err.contains("does not contain the load"), "{}", said.err);
        std::fs::read(folder.0.join(out)).unwrap()
    };
    for fmi in ["2", "3"] {
        let bytes = read("a.fmu", fmi);
        assert_eq!(bytes, read("b.fmu", fmi));
        let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
        let names: Vec<String> = (0..archive.len())
            .map(|k| archive.by_index(k).unwrap().name().unwrap().into_owned())
            .collect();
        let adapter = format!("sources/fmi{fmi}.c");
        for name in ["modelDescription.xml", "sources/five_bar.c", "sources/five_bar.h", &adapter] {
            assert!(names.iter().any(|n| n == name), "{name}: {names:?}");
        }
        let xml = archive.by_name("modelDescription.xml").unwrap();
        let xml = std::io::read_to_string(xml).unwrap();
        assert!(
            xml.contains(&format!("fmiVersion=\"{fmi}.0\"")) && xml.contains("left_motor.effort")
        );
    }
    assert_eq!(folder.files(), ["a.fmu", "b.fmu"]);
    folder
        .stiction(&["export", "3rps", "--to", "fmu", "--precision", "float", "-o", "c.fmu"])
        .fails(2, &["double precision", "--precision"]);
    folder
        .stiction(&["export", "3rps", "--to", "fmu", "--fmi", "1", "-o", "c.fmu"])
        .fails(2, &["--fmi"]);
}

/// A plant FMU contains the model and the shared library; unsuitable libraries are refused.
#[test]
fn a_plant_contains_its_model_and_the_library() {
    let folder = Folder::new("export-plant");
    let library = |name: &str, version: &str| {
        let content = format!("\u{1}stiction-fmu version {version};\u{2}");
        std::fs::write(folder.0.join(name), content).unwrap();
    };
    library("own.so", env!("CARGO_PKG_VERSION"));
    library("old.so", "0.0.1");
    std::fs::write(folder.0.join("other.so"), "no library").unwrap();
    let common = ["export", "five-bar", "--to", "fmu", "--plant", "-o", "a.fmu"];
    let export = |more: &[&str]| folder.stiction(&[&common, more].concat());
    for fmi in ["2", "3"] {
        let options = ["--library", "own.so", "--fmi", fmi, "--from", "rest", "--force-on", "tool"];
        export(&options).succeeds();
        let bytes = std::fs::read(folder.0.join("a.fmu")).unwrap();
        export(&options).succeeds();
        assert_eq!(bytes, std::fs::read(folder.0.join("a.fmu")).unwrap());
        let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
        let names: Vec<String> = (0..archive.len())
            .map(|k| archive.by_index(k).unwrap().name().unwrap().into_owned())
            .collect();
        let count = |place: &str| names.iter().filter(|name| name.starts_with(place)).count();
        assert_eq!((count("binaries/"), count("resources/model.toml")), (1, 1), "{names:?}");
        assert!(names.iter().any(|name| name.contains("/five_bar_plant.")), "{names:?}");
        let xml = archive.by_name("modelDescription.xml").unwrap();
        let xml = std::io::read_to_string(xml).unwrap();
        for name in ["left_motor.effort", "tool.fz", "tip.sticks", "left_elbow.mu", "tool.qw"] {
            assert!(xml.contains(&format!("name=\"{name}\"")), "{name}");
        }
    }
    std::fs::remove_file(folder.0.join("a.fmu")).unwrap();
    let wrong = [
        (&["--library", "none.so"][..], &["none.so", "cargo xtask fmu"][..]),
        (&["--library", "old.so"], &["does not have version"]),
        (&["--library", "other.so"], &["is not the library"]),
        (&["--library", "own.so", "--force-on", "tol"], &["no body `tol`", "`tool`"]),
        (&["--library", "own.so", "--from", "A"], &["error"]),
        (&["--tunable", "masses"], &["--tunable"]),
    ];
    for (more, texts) in wrong {
        export(more).fails(2, texts);
    }
    folder.stiction(&["export", "3rps", "--to", "c", "--plant", "-o", "b"]).fails(2, &["--to fmu"]);
    folder
        .stiction(&["export", "3rps", "--to", "fmu", "--from", "rest", "-o", "b"])
        .fails(2, &["--plant"]);
    assert_eq!(folder.files(), ["old.so", "other.so", "own.so"]);
}

/// Robots and options that cannot be exported are refused with a reason, and no file is written.
#[test]
fn impossible_exports_are_refused() {
    let folder = Folder::new("export-wrong");
    let refused = |arguments: &[&str], texts: &[&str]| {
        folder.stiction(&[&["export"], arguments, &["-o", "code"]].concat()).fails(2, texts);
        assert!(folder.files().is_empty(), "{arguments:?}");
    };
    refused(&["zhang2018", "--to", "c"], &["cannot generate code for `zhang2018`", "help: "]);
    refused(&["five-bar", "--to", "c", "--name", "a/b"], &["for example `a_b`"]);
    refused(&["five-bar", "--to", "c", "--payload", "tol"], &["no body `tol`", "`tool`"]);
    refused(&["five-bar", "--to", "c", "--force-on", "ground"], &["no body `ground`"]);
    refused(
        &["3rps", "--to", "c", "--coordinates", "platform.z"],
        &["platform.z", "--coordinates"],
    );
    refused(&["3rps", "--to", "c", "--coordinates", "platform.q"], &["platform.q"]);
    refused(&["five-bar", "--to", "rust", "--own-math"], &["--own-math"]);
    refused(&["five-bar", "--to", "rust", "--adapters", "ctypes"], &["--adapters"]);
    refused(&["five-bar", "--to", "pascal"], &["pascal"]);
}

/// A model with several motions and no default.
#[test]
fn code_is_recorded_and_laws_are_compared_along_the_chosen_motion() {
    let folder = Folder::new("export-motion");
    let text = stiction_format::gallery::get("slider-crank").unwrap();
    let text = text.split("[default]").next().unwrap();
    folder.write("robot.toml", &format!("{text}\n[motions.other]\nduration = 1\nA = \"t\"\n"));
    let export = ["export", "robot.toml", "--to", "c", "--vectors", "10", "-o", "code"];
    folder.stiction(&export).fails(2, &["turn, other", "--motion"]);
    folder.stiction(&[&export[..], &["--motion", "other"]].concat()).succeeds();
    let compare = ["compensate", "robot.toml", "--controller", "pd", "--motion", "other"];
    assert!(folder.stiction(&compare).succeeds().contains("motion other"));
}
