//! The command `stiction breakaway`.

use crate::program::Folder;
use crate::program::models::slope;
use serde_json::Value;

#[test]
fn terminal_and_json_agree() {
    let folder = Folder::new("breakaway-slope");
    folder.write("slope.toml", &slope(0.7));
    let said = folder.stiction(&["breakaway", "slope.toml", "--at", "1.5"]);
    let out = said.succeeds();
    // 20 N at 30 degrees: 10 N, and 0.7 times 17.32 N of friction.
    for part in ["at t = 1.500 s", "10.00", "-2.124", "22.12", "12.12", "exact", "self-locking"] {
        assert!(out.contains(part), "{part}: {out}");
    }
    // 0.7 / tan 30 deg
    assert!(out.contains("divided by 1.212"), "{out}");

    let said = folder.stiction(&["breakaway", "slope.toml", "--json", "--load", "block.fz = -7 N"]);
    let value: Value = serde_json::from_str(said.succeeds()).unwrap();
    let drive = &value["drives"]["slope"];
    assert!((drive["frictionless"].as_f64().unwrap() - 13.5).abs() < 1e-12, "{drive}");
    assert_eq!(value["unpowered"]["verdict"], "holds");
    assert_eq!(value["options"]["time"], 0.0);

    folder.write("slope.toml", &slope(0.2));
    let said = folder.stiction(&["breakaway", "slope.toml"]);
    let out = said.succeeds();
    assert!(
        out.contains("not self-locking") && out.contains("static coefficients 2.887 times"),
        "{out}"
    );
}

#[test]
fn infeasible_inputs_are_reported() {
    let folder = Folder::new("breakaway-wrong");
    folder.write("slope.toml", &slope(0.7));
    for time in ["2.5", "-1", "nan"] {
        let said = folder.stiction(&["breakaway", "slope.toml", "--at", time]);
        said.fails(2, &["the motion lasts from 0 s to 2 s", "--at"]);
    }
    folder.stiction(&["breakaway", "nothing"]).fails(2, &["no built-in model"]);
    folder.stiction(&["breakaway", "zhang2018"]).fails(1, &["no finite actuator effort"]);
}
