//! `stiction compare`, and several motions and loads of `stiction inverse`.

use crate::program::Folder;
use crate::program::models::slope;
use serde_json::Value;

/// Figure with the given name in a comparison or an envelope.
fn figure<'a>(value: &'a Value, name: &str) -> &'a Value {
    let figures = value["figures"].as_array().unwrap();
    figures
        .iter()
        .find(|figure| figure["name"] == name)
        .unwrap_or_else(|| panic!("{name}: {value}"))
}

#[test]
fn two_variants_of_a_model() {
    let folder = Folder::new("compare-slope");
    folder.write("slope.toml", &slope(0.7));
    // Without friction, the actuator carries the component of the weight along the slope, 20 N sin
    // 30 deg.
    let options =
        ["compare", "slope.toml", "--set-b", "bodies.block.mass=4 kg", "--friction", "off"];
    let said = folder.stiction(&[&options[..], &["--json", "-o", "out"]].concat());
    let value: Value = serde_json::from_str(said.succeeds()).unwrap();
    let drives = ["A", "B"].map(|side| &value[side]["drives"]["slope"]["with_friction"]);
    let peak = figure(&value["comparison"], "slope effort, peak");
    for (k, drive) in drives.into_iter().enumerate() {
        assert_eq!(peak["values"][k].as_f64().unwrap(), drive["peak"].as_f64().unwrap().abs());
    }
    let [a, b] = [0, 1].map(|k| peak["values"][k].as_f64().unwrap());
    assert_eq!(peak["difference"].as_f64().unwrap(), b - a);
    // Twice the mass, twice the weight.
    assert!((b / a - 2.0).abs() < 1e-12, "{a} {b}");
    for file in ["compare.csv", "compare.json", "drives.svg", "A/inverse.csv", "B/summary.json"] {
        assert!(!folder.read(&format!("out/{file}")).is_empty(), "{file}");
    }
    let said = folder.stiction(&options);
    assert!(said.succeeds().contains("B: slope: with bodies.block.mass=4 kg"));
}

/// The verdicts of a comparison state what differs and which model has a problem, in JSON, on the terminal and in the
/// report.
#[test]
fn comparisons_have_verdicts() {
    let folder = Folder::new("compare-verdicts");
    folder.write("slope.toml", &slope(0.1));
    let verdicts = |more: &[&str]| {
        let options = [&["compare", "slope.toml", "--json", "-o", "out"], more].concat();
        let value: Value = serde_json::from_str(folder.stiction(&options).succeeds()).unwrap();
        let all = value["comparison"]["verdicts"].as_array().unwrap().clone();
        all.into_iter()
            .map(|one| {
                ["class", "statement", "meaning"].map(|key| one[key].as_str().unwrap().to_owned())
            })
            .collect::<Vec<_>>()
    };
    let states = |all: &[[String; 3]], class: &str, words: &str| {
        assert!(
            all.iter().any(|one| one[0] == class && one[1].contains(words)),
            "{words}: {all:#?}"
        );
    };
    let all = verdicts(&["--set-b", "bodies.block.mass=4 kg", "--friction-margin"]);
    states(&all, "good", "Largest relative change of an effort: slope effort, ");
    states(&all, "good", "(+100.0 %)");
    states(&all, "good", "Both runs: Statics determines all reactions and efforts");
    states(&all, "good", "Both runs: Nothing locks with up to ");
    let page = folder.read("out/report.html");
    assert!(page.contains("<b>Both runs: Statics determines all reactions and efforts</b>"));
    let all = verdicts(&["--set-b", "joints.slope.friction.mu=0.2", "--friction", "off"]);
    states(&all, "note", "All figures of the runs are equal up to rounding");

    // Only the second model has a redundant guide, whose share of the friction is unknown.
    let guide = "[joints.guide]\ntype = \"P\"\nfrom = \"ground\"\nto = \"block\"\nat = [0, 1, 0]\nto_at = [0, 1, 0]\n\
                 axis = [\"cos(30 deg)\", 0, \"sin(30 deg)\"]\nfriction = { mu = 0.3 }\n";
    let text = slope(0.1);
    let at = text.find("[motions.up]").unwrap();
    folder.write("two.toml", &format!("{}{guide}{}", &text[..at], &text[at..]));
    let all = verdicts(&["two.toml"]);
    states(&all, "caution", "B: The actuator efforts are not unique");
    states(&all, "good", "A: Statics determines all reactions and efforts");
    let said = folder.stiction(&["compare", "slope.toml", "two.toml"]);
    assert!(
        said.succeeds().contains("\nCAUTION: B: The actuator efforts are not unique"),
        "{}",
        said.out
    );
}

#[test]
fn wrong_comparisons_are_refused() {
    let folder = Folder::new("compare-wrong");
    folder.write("slope.toml", &slope(0.7));
    folder.stiction(&["compare", "slope.toml"]).fails(2, &["no difference", "--set-b"]);
    folder.stiction(&["compare", "-"]).fails(2, &["no difference"]);
    folder.stiction(&["compare", "-", "-"]).fails(2, &["standard input can be read only once"]);
    folder.stiction(&["compare", "slope.toml", "slpe"]).fails(2, &["no built-in model"]);
}

#[test]
fn single_runs_and_envelopes_replace_each_other() {
    let folder = Folder::new("envelope-replaced");
    folder.write("slope.toml", &slope(0.7));
    let run = |loads: &[&str]| {
        let mut arguments = vec!["inverse", "slope.toml", "-o", "out"];
        arguments.extend(loads.iter().flat_map(|load| ["--load", load]));
        folder.stiction(&arguments).succeeds();
    };
    let exists = |file: &str| folder.0.join("out").join(file).exists();
    let (several, single) =
        (["envelope.csv", "envelope.json"], ["inverse.csv", "bodies.csv", "summary.json"]);
    // Without a summary, a table is the user's.
    std::fs::create_dir(folder.0.join("out")).unwrap();
    folder.write("out/friction.csv", "mine");
    run(&["none", "block.fx = 1 N"]);
    assert_eq!(folder.read("out/friction.csv"), "mine");
    for _ in 0..2 {
        run(&["none", "block.fx = 1 N"]);
        for file in several {
            assert!(exists(file), "{file}");
        }
        for file in single {
            assert!(!exists(file), "{file}");
        }
        run(&["none"]);
        for file in several {
            assert!(!exists(file), "{file}");
        }
        for file in single {
            assert!(exists(file), "{file}");
        }
        assert!(exists("none/inverse.csv"), "folders remain");
    }
}

#[test]
fn several_loads_have_an_envelope() {
    let folder = Folder::new("envelope-slope");
    folder.write("slope.toml", &slope(0.7));
    let loads = ["--load", "none", "--load", "block.fz = -7 N"];
    let said = folder
        .stiction(&[&["inverse", "slope.toml"], &loads[..], &["--json", "-o", "out"]].concat());
    let value: Value = serde_json::from_str(said.succeeds()).unwrap();
    let cases = value["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 2);
    assert_eq!([&cases[0]["name"], &cases[1]["name"]], ["none", "load2"]);
    let worst = &figure(&value["envelope"], "slope effort, peak")["worst"];
    let peaks = [0, 1].map(|k| {
        cases[k]["summary"]["drives"]["slope"]["with_friction"]["peak"].as_f64().unwrap().abs()
    });
    assert_eq!(worst["value"].as_f64().unwrap(), peaks[0].max(peaks[1]));
    assert_eq!(worst["run"], "load2");
    for file in ["envelope.csv", "drives.svg", "none/inverse.csv", "load2/summary.json"] {
        assert!(!folder.read(&format!("out/{file}")).is_empty(), "{file}");
    }
    // A list of names is equivalent to repeated options.
    let said = folder.stiction(&["inverse", "slope.toml", "--load", "none,none"]);
    assert!(said.succeeds().contains("envelope of 2 runs"));
}

#[test]
fn errors_name_the_model() {
    let folder = Folder::new("compare-sides");
    folder.write("slope.toml", &slope(0.7));
    let command = |more: &[&str]| folder.stiction(&[&["compare", "slope.toml"], more].concat());
    command(&["--set-b", "bodies.block.mas=1"]).fails(2, &["model B:"]);
    command(&["--set-a", "bodies.block.mas=1"]).fails(2, &["model A:"]);
    let said = command(&["--set-b", "bodies.block.mas=1", "--json"]);
    let value: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(value["error"]["run"], "model B");
}

/// Checks the comparison of a prismatic joint with a motor: its figures, and its limits in percent.
#[test]
fn motors_are_compared() {
    let folder = Folder::new("compare-motors");
    let motor = "[actuators.M]\njoint = \"slope\"\nlead = \"10 mm/rev\"\nrotor_inertia = \"1e-5 kg m^2\"\n\
                 limits = { peak = \"0.1 N m\", rated = \"10 mN m\", speed = \"3000 rpm\" }\n";
    folder.write("slope.toml", &format!("{}{motor}", slope(0.0)));
    let said = folder.stiction(&[
        "compare",
        "slope.toml",
        "--set-b",
        "actuators.M.lead=20 mm/rev",
        "--json",
    ]);
    let value: Value = serde_json::from_str(said.succeeds()).unwrap();
    let values = |name: &str| {
        let own = figure(&value["comparison"], name);
        [0, 1].map(|k| own["values"][k].as_f64().unwrap())
    };
    // Motor torque for 10 N along the slope, computed from the lead.
    let torque = |lead: f64| 10.0 * lead / std::f64::consts::TAU;
    for (found, lead) in values("M motor torque, peak").into_iter().zip([0.01, 0.02]) {
        assert!((found / torque(lead) - 1.0).abs() < 1e-12, "{found}");
    }
    for (found, lead) in values("M of rated rms torque").into_iter().zip([0.01, 0.02]) {
        assert!((found / (100.0 * torque(lead) / 0.01) - 1.0).abs() < 1e-12, "{found}");
    }
    let speeds = values("M motor speed, peak");
    assert!((speeds[0] / speeds[1] - 2.0).abs() < 1e-12);
}

#[test]
fn several_loads_of_a_simulation_have_an_envelope() {
    let folder = Folder::new("forward-envelope");
    folder.write("slope.toml", &slope(0.1));
    let options = ["forward", "slope.toml", "--until", "0.1", "--load", "none"];
    let more = ["--load", "block.fz = -7 N", "--json", "-o", "out"];
    let said = folder.stiction(&[&options[..], &more].concat());
    let value: Value = serde_json::from_str(said.succeeds()).unwrap();
    let cases = value["cases"].as_array().unwrap();
    assert_eq!([&cases[0]["name"], &cases[1]["name"]], ["none", "load2"]);
    let worst = &figure(&value["envelope"], "slope effort, peak")["worst"];
    let peaks = [0, 1].map(|k| {
        let peak = &cases[k]["summary"]["drives"]["slope"]["drive"]["peak"];
        peak.as_f64().unwrap().abs()
    });
    assert_eq!(worst["value"].as_f64().unwrap(), peaks[0].max(peaks[1]));
    for file in ["envelope.csv", "drives.svg", "none/forward.csv", "load2/summary.json"] {
        assert!(!folder.read(&format!("out/{file}")).is_empty(), "{file}");
    }
    // A run with one of the loads alone gives the same table.
    folder.stiction(&[&options[..], &["-o", "alone"]].concat()).succeeds();
    assert_eq!(folder.read("alone/forward.csv"), folder.read("out/none/forward.csv"));
    // Nothing is left to resume once the envelope is complete.
    let again = ["--load", "block.fz = -7 N", "--resume", "-o", "out"];
    folder
        .stiction(&[&options[..], &again].concat())
        .fails(2, &["no run has a checkpoint.json to resume from"]);
}

/// Checks that a run with several loads resumes after an interruption during the second load: the
/// first load is not repeated, the third one is run, and the tables are those of an uninterrupted
/// run.
#[test]
fn several_loads_resume_after_an_interruption() {
    let folder = Folder::new("forward-resume-several");
    folder.write("slope.toml", &slope(0.1));
    let loads = ["--load", "none", "--load", "block.fz = -7 N", "--load", "block.fz = -8 N"];
    let options =
        ["forward", "slope.toml", "--until", "0.1", "--step", "1e-4", "--checkpoint", "0"];
    let options = [&options[..], &loads, &["--json"]].concat();
    folder.stiction(&[&options[..], &["-o", "whole"]].concat()).succeeds();
    let parts = [&options[..], &["-o", "parts"]].concat();
    let exists = |name: &str| folder.0.join("parts").join(name).exists();
    let mut run = folder.begin(&parts, || exists("load2/checkpoint.json"));
    run.kill().unwrap();
    run.wait().unwrap();
    assert!(exists("load2/checkpoint.json") && !exists("envelope.json"));
    folder.stiction(&[&parts[..], &["--resume"]].concat()).succeeds();
    for load in ["none", "load2", "load3"] {
        let table = |run: &str| folder.read(&format!("{run}/{load}/forward.csv"));
        assert_eq!(table("whole"), table("parts"), "{load}");
    }
    assert!(exists("envelope.json") && !exists("none/checkpoint.json"));
}

/// If one of several runs fails, the message names it and the finished runs.
#[test]
fn a_failing_run_is_named() {
    let folder = Folder::new("envelope-fails");
    let four = ["inverse", "five-bar", "--motion", "circle"];
    // The tool leaves its workspace.
    let far = "tool.x = 0.1 m + 2 m/s*t; tool.y = 0.3 m; duration = 1";
    let more = ["--motion", far, "-o", "out"];
    let said = folder.stiction(&[&four[..], &more].concat());
    assert_ne!(said.code, 0);
    assert!(said.err.contains("run `motion2`"), "{}", said.err);
    assert!(said.err.contains("finished before: circle"), "{}", said.err);
    assert!(!folder.read("out/circle/inverse.csv").is_empty());
}
