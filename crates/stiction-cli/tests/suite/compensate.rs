//! The command `stiction compensate`.

use crate::program::{Folder, json};

#[test]
fn controllers_are_compared() {
    let folder = Folder::new("compensate");
    let base = ["compensate", "slider-crank", "--controller"];
    let laws = "computed-torque,computed-torque+coulomb,computed-torque+friction";
    let said = folder.stiction(&[&base[..], &[laws, "-o", "out"]].concat());
    let text = said.succeeds();
    assert!(
        text.contains("times smaller than") && text.contains("computed-torque+coulomb"),
        "{text}"
    );
    assert_eq!(
        Folder(folder.0.join("out")).files(),
        ["compensate-space.csv", "compensate.csv", "compensate.json", "report.html"]
    );
    let figures = json(&folder.read("out/compensate.json"));
    assert_eq!(figures["controllers"].as_array().map(Vec::len), Some(3));
    assert!(figures["improvement"].as_f64() > Some(5.0));
    let page = folder.read("out/report.html");
    // Scripts may name NaN.
    let texts = page.split("<script").enumerate().map(|(k, part)| match k {
        0 => part,
        _ => part.split_once("</script>").map_or("", |(_, rest)| rest),
    });
    let texts: String = texts.collect();
    assert!(texts.contains("computed-torque+coulomb") && !texts.contains("NaN"), "{texts}");
    let several = ["--transition", "sign,fade,5%", "--report", "off", "-o", "several"];
    let said = folder.stiction(&[&base[..], &[laws], &several].concat());
    let text = said.succeeds();
    assert!(text.contains("tanh 5%") && text.lines().all(|line| line.len() <= 100), "{text}");
    let files = ["compensate-space.csv", "compensate.csv", "compensate.json"];
    assert_eq!(Folder(folder.0.join("several")).files(), files);
    let all = json(&folder.read("several/compensate.json"));
    assert_eq!(all["controllers"].as_array().map(Vec::len), Some(1 + 3 + 3));
    // Constant friction jumps where the legs reverse; the tanh transition spreads the jump over
    // several samples.
    let legs = ["compensate", "3rps", "--controller", "computed-torque+coulomb", "--json"];
    let said = folder.stiction(&[&legs[..], &["--transition", "sign,5%"]].concat());
    let all = json(said.succeeds());
    let own = |at: usize| all["controllers"][at].clone();
    let change = |at: usize| own(at)["peak_effort_change"][0].as_f64().unwrap();
    assert!(own(1)["transition"] == "tanh 5%" && change(1) < 0.3 * change(0), "{all}");
    let disturbed = ["--resolution", "0.1 mrad", "--noise", "1e-5", "--delay", "1 ms", "--json"];
    let said = folder.stiction(&[&base[..], &[laws], &disturbed].concat());
    let worse = json(said.succeeds());
    assert!(worse["improvement"].as_f64() < figures["improvement"].as_f64());
    assert_eq!(worse["delay"].as_f64(), Some(0.001));
}

/// On the default robot, with friction coefficients known to 10 % and exact sensors, compensation
/// by the friction of the model reduces the rms error of each actuator at least by a factor of five
/// compared with computed torque alone.
#[test]
fn compensation_of_the_default_robot_is_effective() {
    let folder = Folder::new("compensate-default");
    for seed in ["1", "2", "3"] {
        let laws = "computed-torque,computed-torque+friction";
        let options = ["--controller", laws, "--known-to", "10 %", "--seed", seed, "--json"];
        let said = folder.stiction(&[&["compensate"], &options[..]].concat());
        let found = json(said.succeeds());
        for actuator in 0..3 {
            let rms = |law: usize| found["controllers"][law]["rms_error"][actuator].as_f64();
            let (without, with) = (rms(0).unwrap(), rms(1).unwrap());
            assert!(without > 5.0 * with, "seed {seed}, actuator {actuator}: {without} {with}");
        }
    }
}

#[test]
fn impossible_comparisons_are_refused() {
    let folder = Folder::new("compensate-wrong");
    let refused = |arguments: &[&str], texts: &[&str]| {
        folder.stiction(&[&["compensate"], arguments].concat()).fails(2, texts);
    };
    refused(&["zhang2018"], &["cannot generate code for `zhang2018`", "stiction check"]);
    refused(&["four-bar", "--controller", "pid"], &["no controller `pid`", "`pd`"]);
    refused(&["four-bar", "--transition", "tanh"], &["--transition", "`5%`"]);
    refused(&["four-bar", "--noise", "3 s"], &["expected a length or an angle, found a time"]);
    refused(&["four-bar", "--known-to", "x"], &["expected a fraction or a percentage"]);
    refused(&["four-bar", "--period", "-1"], &["period of the controller", "--period"]);
}

#[test]
fn a_failure_after_the_result_is_part_of_the_one_json_text() {
    let folder = Folder::new("compensate-json");
    // A folder with the name of a table.
    std::fs::create_dir_all(folder.0.join("out/compensate.csv")).unwrap();
    let laws = ["compensate", "slider-crank", "--controller", "pd,computed-torque"];
    let said = folder.stiction(&[&laws[..], &["--json", "-o", "out"]].concat());
    assert_ne!(said.code, 0);
    let result = json(&said.out);
    assert!(result["error"]["message"].is_string() && result["controllers"].is_array(), "{result}");
}
