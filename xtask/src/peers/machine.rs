//! Description of the machine without its host name.

use super::build::Programs;
use crate::runs;
use serde_json::{Value, json};
use std::fs;
use std::process::Command;
use std::thread::available_parallelism;

/// Index of the last core, if programs can be pinned to it.
pub(crate) fn last_core() -> Option<usize> {
    let core = available_parallelism().ok()?.get() - 1;
    let mut command = Command::new("taskset");
    command.args(["--cpu-list", &core.to_string(), "true"]);
    runs(&mut command).then_some(core)
}

pub(crate) fn machine(programs: &Programs) -> Value {
    json!({
        "cpu": cpu(),
        "cores": available_parallelism().map_or(0, |n| n.get()),
        "caches": caches(),
        "system": format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        "on_one_core": programs.core.is_some(),
        "load": load(),
    })
}

/// Model of the processor as reported by Linux or macOS.
fn cpu() -> String {
    if let Ok(text) = fs::read_to_string("/proc/cpuinfo") {
        let field = |name: &str| {
            let line = text.lines().find(|line| line.starts_with(name))?;
            line.split_once(':').map(|(_, value)| value.trim().to_string())
        };
        if let Some(model) = field("model name") {
            let numbers = [("family", "cpu family"), ("model", "model\t")];
            let numbers = numbers.map(|(word, name)| field(name).map(|n| format!("{word} {n}")));
            let numbers: Vec<String> = numbers.into_iter().flatten().collect();
            return format!("{model} ({})", numbers.join(", "));
        }
    }
    let answer = Command::new("sysctl").args(["-n", "machdep.cpu.brand_string"]).output();
    answer.map_or_else(|_| "unknown".into(), |a| String::from_utf8_lossy(&a.stdout).trim().into())
}

/// Caches of a core as reported by Linux.
fn caches() -> String {
    let folder = "/sys/devices/system/cpu/cpu0/cache";
    let read = |i: usize, name: &str| fs::read_to_string(format!("{folder}/index{i}/{name}"));
    let cache = |i: usize| {
        let (level, kind, size) = (read(i, "level").ok()?, read(i, "type").ok()?, read(i, "size"));
        let kind = match kind.trim() {
            "Data" => "d",
            "Instruction" => "i",
            _ => "",
        };
        Some(format!("L{}{kind} {}", level.trim(), size.ok()?.trim()))
    };
    (0..8).map_while(cache).collect::<Vec<_>>().join(", ")
}

/// Load average over the last minute, to which this comparison contributes one.
fn load() -> Value {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().and_then(|word| word.parse::<f64>().ok()).into()
}
