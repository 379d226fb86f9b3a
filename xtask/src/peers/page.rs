//! Generated tables of the book, written between markers in its pages.

use super::build::Tools;
use super::scripts;
use serde_json::Value;
use std::fmt::Write;
use std::fs;

/// Generated part of a page.
struct Part {
    page: &'static str,
    /// Key of the results from which it is generated.
    key: &'static str,
    begin: &'static str,
    tables: fn(&Value) -> String,
}

const END: &str = "<!-- end of cargo xtask peers -->";

const PARTS: [Part; 3] = [
    Part { page: "speed.md", key: "models", begin: "<!-- cargo xtask peers -->", tables },
    Part {
        page: "speed.md",
        key: "simulations",
        begin: "<!-- cargo xtask peers: simulations -->",
        tables: |data| scripts::tables(&data["simulations"]),
    },
    Part {
        page: "growth.md",
        key: "growth",
        begin: "<!-- cargo xtask peers: growth -->",
        tables: |data| scripts::tables(&data["growth"]),
    },
];

/// Replaces the text between the markers of all parts that were measured.
pub(crate) fn write(tools: &Tools<'_>, data: &Value) -> Result<(), String> {
    for part in PARTS.iter().filter(|part| !data[part.key].is_null()) {
        let path = tools.sources.join("../docs/src").join(part.page);
        let fault = |error: std::io::Error| format!("{}: {error}", path.display());
        let page = fs::read_to_string(&path).map_err(fault)?;
        let page = replaced(&page, part.begin, (part.tables)(data).trim_end())
            .ok_or_else(|| format!("docs/src/{} lacks {} or its end", part.page, part.begin))?;
        fs::write(&path, page).map_err(fault)?;
    }
    Ok(())
}

fn replaced(page: &str, begin: &str, tables: &str) -> Option<String> {
    let (before, rest) = page.split_once(begin)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{begin}\n\n{tables}\n\n{END}{after}"))
}

/// Time in microseconds with three digits.
fn microseconds(nanoseconds: &Value) -> String {
    let time = nanoseconds.as_f64().unwrap_or(f64::NAN) / 1e3;
    let decimals = (2 - (time.log10().floor() as i32)).clamp(0, 3) as usize;
    format!("{time:.decimals$}")
}

fn word(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn tables(data: &Value) -> String {
    let mut text = String::new();
    for (model, result) in data["models"].as_object().into_iter().flatten() {
        let _ = write!(
            text,
            "`{model}`, times for one state in µs:\n\n\
             | who, what | median | minimum | difference |\n| --- | --- | --- | --- |\n"
        );
        for (name, median) in result["median_ns"].as_object().into_iter().flatten() {
            let (minimum, difference) = (&result["minimum_ns"][name], &result["difference"][name]);
            let difference = difference.as_f64().unwrap_or(f64::NAN);
            let (median, minimum) = (microseconds(median), microseconds(minimum));
            let _ = writeln!(text, "| {name} | {median} | {minimum} | {difference:.0e} |");
        }
        let _ = write!(text, "\n| ratio, ours / theirs | `{model}` |\n| --- | --- |\n");
        for (name, ratio) in result["ratios"].as_object().into_iter().flatten() {
            let ratio = ratio.as_f64().unwrap_or(f64::NAN);
            let _ = writeln!(text, "| `{name}` | {ratio:.2} |");
        }
        text.push('\n');
    }
    let python = &data["python"];
    let _ = write!(
        text,
        "Times of calls from Python for `{}`, in µs:\n\n\
         | who, what | median | minimum | what it is |\n| --- | --- | --- | --- |\n",
        word(&python["model"])
    );
    for row in python["rows"].as_array().into_iter().flatten() {
        let (median, minimum) = (microseconds(&row["median_ns"]), microseconds(&row["minimum_ns"]));
        let (engine, task, what) = (word(&row["engine"]), word(&row["task"]), word(&row["what"]));
        let _ = writeln!(text, "| {engine} {task} | {median} | {minimum} | {what} |");
    }
    let _ = write!(
        text,
        "\n| ratio of calls from Python | `{}` |\n| --- | --- |\n",
        word(&python["model"])
    );
    for (name, ratio) in data["ratios"].as_object().into_iter().flatten() {
        if name.starts_with("python_") {
            let _ = writeln!(text, "| `{name}` | {:.2} |", ratio.as_f64().unwrap_or(f64::NAN));
        }
    }
    let (machine, versions) = (&data["machine"], &data["versions"]);
    let _ = write!(
        text,
        "\n- Machine: {}, {} cores, {}, {}; {} batches of each; {}, load {}.\n",
        word(&machine["cpu"]),
        machine["cores"],
        word(&machine["caches"]),
        word(&machine["system"]),
        data["batches"],
        if machine["on_one_core"] == true { "all on one core" } else { "not kept on one core" },
        machine["load"],
    );
    let _ = write!(
        text,
        "- Versions: stiction {}, MuJoCo {}, Pinocchio {}, Drake {}, Exudyn {}, Eigen {}, Boost {}, Python {}, numpy {}.\n\
         - Compilers: {}, `{}`; {}, release profile{}.\n",
        word(&versions["stiction"]),
        word(&versions["mujoco"]),
        word(&versions["pin"]),
        word(&versions["drake"]),
        word(&versions["exudyn"]),
        word(&versions["cmeel-eigen"]),
        word(&versions["cmeel-boost"]),
        word(&versions["python"]),
        word(&versions["numpy"]),
        word(&versions["compiler"]),
        word(&versions["flags"]),
        word(&versions["rustc"]),
        match word(&versions["rustflags"]) {
            "" => String::new(),
            flags => format!(" with `{flags}`"),
        },
    );
    text
}

#[cfg(test)]
mod tests {
    use super::{END, PARTS, microseconds, replaced};

    #[test]
    fn replaces_the_text_between_the_marks() {
        let [first, second, _] = PARTS.map(|part| part.begin);
        let page = |text| format!("{first}\n{END}\n{second}{text}{END}\nb\n");
        let new = page("\n\nnew\n\n");
        assert_eq!(replaced(&page("\nold\n"), second, "new"), Some(new));
        assert_eq!(replaced("a page without marks", first, "new"), None);
    }

    #[test]
    fn times_have_three_digits() {
        for (nanoseconds, text) in [(1234.5, "1.23"), (12_345.0, "12.3"), (51_543_830.0, "51544")] {
            assert_eq!(microseconds(&nanoseconds.into()), text);
        }
    }
}
