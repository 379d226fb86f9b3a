//! Efforts of gearings in summaries.

use crate::names::width;
use crate::statistics::Size;
use serde_json::{Value, json};
use std::fmt::{self, Write};
use stiction_draw::numbers::number;

/// Returns the entry of `summary.json` with the peak and the root mean square of the effort of each
/// gearing, by name.
pub(crate) fn gearings_json(names: &[(String, &'static str)], loads: &[(Size, bool)]) -> Value {
    let entry = |((name, unit), (size, determined)): (&(String, &str), &(Size, bool))| {
        let mut entry = size.json();
        entry["unit"] = json!(unit);
        entry["determined"] = json!(determined);
        (name.clone(), entry)
    };
    Value::Object(names.iter().zip(loads).map(entry).collect())
}

/// Writes the peak and the root mean square of the effort of each gearing as text.
pub(crate) fn write_gearings(
    out: &mut impl Write,
    names: &[(String, &'static str)],
    loads: &[(Size, bool)],
) -> fmt::Result {
    let wide = width(names.iter().map(|(name, _)| name.as_str()), 13);
    writeln!(out, "{:wide$}  {:>13} {:>11} {:>13}", "gearing", "effort", "at", "rms")?;
    for ((name, unit), (size, determined)) in names.iter().zip(loads) {
        let line = format!(
            "{name:wide$}  {:>9} {unit:3} {:>9} s {:>9} {unit:3}{}",
            number(size.peak),
            number(size.peak_time),
            number(size.rms()),
            if *determined { "" } else { "  not unique" },
        );
        writeln!(out, "{}", line.trim_end())?;
    }
    Ok(())
}
