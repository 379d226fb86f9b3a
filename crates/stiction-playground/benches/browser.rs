//! Duration of an answer in WebAssembly relative to the same answer in machine code, on one thread.
//!
//! Requires Node.js, whose engine is that of Chromium, and the module that `cargo xtask playground` builds.

use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;
use std::time::Instant;
use stiction::ModelText;

/// Least number of answers, and seconds of all; the fastest answer counts, since others may use the machine and a browser
/// optimises code while it runs.
const ANSWERS: usize = 5;
const SECONDS: f64 = 1.0;

fn main() {
    let module =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/playground/stiction.wasm");
    if !module.exists() {
        println!("{} is missing: run `cargo xtask playground` first", module.display());
        return;
    }
    println!("| request | machine code, ms | WebAssembly, ms | ratio |");
    println!("| --- | --- | --- | --- |");
    for name in ["3rps", "gough", "five-bar"] {
        for command in ["inverse", "check", "forward"] {
            let text = ModelText::builtin(name).expect("it is in the gallery").as_text().to_owned();
            let request =
                json!({ "command": command, "name": name, "text": text, "until": 0.2 }).to_string();
            let native = native(&request);
            match in_node(&module, &request) {
                Ok(wasm) => println!(
                    "| {command} {name} | {:.1} | {:.1} | {:.2} |",
                    1e3 * native,
                    1e3 * wasm,
                    wasm / native
                ),
                Err(why) => {
                    println!("{why}");
                    return;
                }
            }
        }
    }
}

/// Seconds of the fastest answer in machine code.
fn native(request: &str) -> f64 {
    let once = || {
        let begun = Instant::now();
        let answer = stiction_playground::answer(request, &mut |_, _| {});
        let seconds = begun.elapsed().as_secs_f64();
        let answer: Value = serde_json::from_str(&answer).expect("it is JSON");
        assert!(answer["error"].is_null(), "{}", answer["error"]);
        seconds
    };
    let all = Instant::now();
    let mut fastest = f64::INFINITY;
    for count in 0.. {
        if count >= ANSWERS && all.elapsed().as_secs_f64() > SECONDS {
            break;
        }
        fastest = fastest.min(once());
    }
    fastest
}

/// Seconds of the fastest answer in WebAssembly.
fn in_node(module: &Path, request: &str) -> Result<f64, String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/answers.mjs");
    let run = Command::new("node")
        .arg(script)
        .args([
            module.as_os_str(),
            request.as_ref(),
            ANSWERS.to_string().as_ref(),
            SECONDS.to_string().as_ref(),
        ])
        .output()
        .map_err(|why| format!("node cannot be run: {why}"))?;
    let text = String::from_utf8_lossy(&run.stdout);
    text.trim().parse().map_err(|_| String::from_utf8_lossy(&run.stderr).into_owned())
}
