//! Names of time columns that other programs write.

/// Returns advice if a column name in a recording or log means the time, but is not `time` or `t`,
/// such as `Time`, `timestamp` and `Time (s)`. `None` for any other name.
pub(crate) fn time_hint(label: &str) -> Option<String> {
    let name = label.split(['(', '[']).next().unwrap_or(label).trim().to_lowercase();
    let known = ["time", "timestamp", "time stamp", "time_stamp", "t", "time_s", "t_s", "seconds"];
    known.contains(&name.as_str()).then(|| {
        "the time column has the name `time`, with the unit in brackets: `time [s]`".to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_time_columns_are_recognised() {
        for name in ["Time", "Time (s)", "timestamp", "TIME [ms]", "T"] {
            assert!(time_hint(name).is_some(), "{name}");
        }
        for name in ["timer", "leg1.P", "", "times"] {
            assert_eq!(time_hint(name), None, "{name}");
        }
    }
}
