//! Copies the bundled script of the shaded view, if `STICTION_SHADED` names it, to where the crate includes it.

use std::path::Path;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=STICTION_SHADED");
    let script = match env::var_os("STICTION_SHADED").filter(|path| !path.is_empty()) {
        Some(path) => {
            println!("cargo::rerun-if-changed={}", Path::new(&path).display());
            fs::read_to_string(&path).unwrap_or_else(|error| {
                panic!("STICTION_SHADED: {}: {error}", Path::new(&path).display())
            })
        }
        None => String::new(),
    };
    // The script becomes an element of pages.
    let lower = script.to_ascii_lowercase();
    assert!(!lower.contains("</script") && !lower.contains("<!--"), "it ends its own element");
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    fs::write(Path::new(&out).join("shaded.js"), script).expect("OUT_DIR is writable");
}
