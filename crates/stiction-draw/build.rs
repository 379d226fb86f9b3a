//! Assembles the scripts of pages: that of the moving robot from the files of `src/viewer`, and the bundled script of
//! the shaded view if `STICTION_SHADED` names it.
//!
//! Comments and indentation are removed. If `STICTION_ESBUILD` names the program of esbuild, as in builds by
//! `cargo xtask`, it also shortens the script of the moving robot by half.

use std::ffi::OsString;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::{env, fs};

/// Files of the script of the moving robot, in their order in the script.
const VIEWER: [&str; 10] = [
    "data", "camera", "shapes", "ghost", "shading", "stage", "readout", "saving", "plots", "panel",
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let shaded = variable("STICTION_SHADED").map_or(String::new(), |path| read(Path::new(&path)));
    let mut viewer = assembled();
    if let Some(esbuild) = variable("STICTION_ESBUILD") {
        viewer = minified(&esbuild, &viewer);
    }
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    for (name, script) in [("viewer.js", viewer), ("shaded.js", shaded)] {
        // The script becomes an element of pages.
        let lower = script.to_ascii_lowercase();
        assert!(
            !lower.contains("</script") && !lower.contains("<!--"),
            "{name} ends its own element"
        );
        fs::write(Path::new(&out).join(name), script).expect("OUT_DIR is writable");
    }
}

/// Value of an environment variable; `None` if it is absent or empty.
fn variable(name: &str) -> Option<OsString> {
    println!("cargo::rerun-if-env-changed={name}");
    env::var_os(name).filter(|value| !value.is_empty())
}

fn read(path: &Path) -> String {
    println!("cargo::rerun-if-changed={}", path.display());
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Script of the moving robot, without comments and indentation.
fn assembled() -> String {
    let mut script = String::from("\n\"use strict\";\n(() => {\n");
    for name in VIEWER {
        let path = format!("src/viewer/{name}.js");
        for line in read(Path::new(&path)).lines() {
            // A text over several lines would lose its indentation.
            assert!(
                line.matches('`').count() % 2 == 0,
                "{path}: a text over several lines: {line}"
            );
            let line = line.trim_start();
            if !line.is_empty() && !line.starts_with("//") {
                script.push_str(line);
                script.push('\n');
            }
        }
    }
    script + "})();\n"
}

fn minified(esbuild: &OsString, script: &str) -> String {
    let mut node = Command::new("node")
        .arg(esbuild)
        .args(["--minify", "--target=es2022"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("node starts");
    node.stdin.take().expect("a pipe").write_all(script.as_bytes()).expect("node reads");
    let output = node.wait_with_output().expect("node ends");
    assert!(output.status.success(), "esbuild failed");
    String::from_utf8(output.stdout).expect("esbuild writes UTF-8")
}
