//! Protection of inputs and of simulations that can be resumed.

use crate::program::Folder;

const PENDULUM: &str = r#"
gravity = [0, -9.81, 0]
[bodies.bob]
mass = 2
com = [0, -0.4, 0]
inertia = [0.01, 0.01, 0.01]
[joints.pivot]
type = "R"
from = "ground"
to = "bob"
axis = "z"
actuated = true
friction = { mu = 0.1, radius = 0.04 }
[motions.swing]
duration = 0.5
pivot = "20 deg*sin(pi*t)"
"#;

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("pendulum.toml", PENDULUM);
    folder
}

/// No result overwrites an input of the same run.
#[test]
fn inputs_are_not_overwritten() {
    let folder = folder("inputs");
    let recording = "time [s],pivot [rad]\n0,0\n0.1,0.1\n0.2,0.3\n";
    folder.write("motion.csv", recording);
    let forward = ["forward", "pendulum.toml", "--motion", "motion.csv", "-o", "."];
    folder.stiction(&forward).fails(2, &["motion.csv is an input of this run"]);
    let convert =
        ["convert", "pendulum.toml", "--motion", "motion.csv", "--to", "json", "-o", "motion.csv"];
    folder
        .stiction(&convert)
        .fails(2, &["cannot write motion.csv: it is an input of this conversion"]);
    assert_eq!(folder.read("motion.csv"), recording);
    assert_eq!(folder.files(), ["motion.csv", "pendulum.toml"]);
    // A recording of the model, with the name of a table of results.
    folder.write("inverse.csv", recording);
    let named =
        PENDULUM.replace("duration = 0.5\npivot = \"20 deg*sin(pi*t)\"", "file = \"inverse.csv\"");
    folder.write("named.toml", &named);
    folder
        .stiction(&["inverse", "named.toml", "-o", "."])
        .fails(2, &["inverse.csv is an input of this run"]);
    assert_eq!(folder.read("inverse.csv"), recording);
    // A different folder is accepted.
    folder.stiction(&["inverse", "named.toml", "-o", "new"]).succeeds();
}

/// Other results in the folder would damage a simulation that can be resumed.
#[test]
fn interrupted_simulations_are_kept() {
    let folder = folder("interrupted");
    let run = ["forward", "pendulum.toml", "--drives", "none", "--until", "1000", "--step", "1e-3"];
    let run: Vec<&str> = run.into_iter().chain(["--checkpoint", "0.05", "-o", "run"]).collect();
    let mut child = folder.begin(&run, || folder.0.join("run/checkpoint.json").exists());
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = Folder(folder.0.join("run")).files();
    let told = ["run holds an interrupted simulation (checkpoint.json)", "give another folder"];
    folder.stiction(&["inverse", "pendulum.toml", "-o", "run"]).fails(2, &told);
    assert_eq!(Folder(folder.0.join("run")).files(), kept);
    // The program performs only the requested computation, and prints no message about the rest.
    let mut early = run.clone();
    early[5] = "0.001";
    early.push("--resume");
    folder.stiction(&early).fails(2, &["the interrupted run has"]);
    assert_eq!(Folder(folder.0.join("run")).files(), kept);
}

/// A pole of an effort cannot be passed, whether or not a step ends at it.
#[test]
fn poles_are_refused() {
    let folder = folder("poles");
    for (force, at) in [("1 N m/(t/s - 0.2512345)", "0.2512345"), ("1 N m*tan(pi*t/s)", "0.5")] {
        let drives = format!("pivot = {force}").replace("/s", "");
        let run = ["forward", "pendulum.toml", "--drives", &drives, "--until", "0.9"];
        let told = format!("the effort of `pivot` has no finite value at t = {at}");
        folder.stiction(&run).fails(2, &[&told]);
    }
    let load = ["forward", "pendulum.toml", "--load", "bob.fx = 1/(t - 0.25)", "--until", "1"];
    folder.stiction(&load).fails(2, &["the load on `bob` has no finite value at t = 0.25 s"]);
}

/// Jumps and zeros are not poles, for any number of them and any sample times.
#[test]
fn jumps_are_not_poles() {
    let folder = folder("jumps");
    for drive in [
        "0.05 N m*atan2(sin(2*pi*50*t), cos(2*pi*50*t) + 1e-9)",
        "1e-3 N m*sin(2*pi*t)*cos(14000*t)/abs(cos(14000*t))",
        "0.1 N m*(t - 0.0201234)/abs(t - 0.0201234)",
    ] {
        let drives = format!("pivot = {drive}");
        let run = ["forward", "pendulum.toml", "--drives", &drives, "--until", "0.03"];
        folder.stiction(&run).succeeds();
    }
}

/// A parameter may be arbitrarily small, because it can be a factor.
#[test]
fn small_parameters_are_valid() {
    let folder = folder("small");
    let peak = |text: &str| {
        folder.write("small.toml", text);
        folder.stiction(&["inverse", "small.toml"]).succeeds().to_owned()
    };
    let named = format!(
        "[parameters]\neps = 1e-31\n{}",
        PENDULUM.replace("[bodies.bob]\nmass = 2", "[bodies.bob]\nmass = \"eps*2e31*1 kg\"")
    );
    let gravity = "gravity = [0, -9.81, 0]\n";
    let named = format!("{gravity}{}", named.replace(gravity, ""));
    let same = |text: &str| {
        text.lines().filter(|line| !line.contains("loops")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(same(&peak(&named)), same(&peak(PENDULUM)));
}

/// With `--json`, every error is JSON.
#[test]
fn wrong_options_are_reported_as_json() {
    let folder = folder("options");
    for wrong in [&["inverse", "--step="][..], &["inverse", "--nonsense"], &["models", "nope"]] {
        let arguments: Vec<&str> = wrong.iter().copied().chain(["--json"]).collect();
        let said = folder.stiction(&arguments);
        assert_eq!(said.code, 2, "{said:?}");
        let told: serde_json::Value = serde_json::from_str(&said.out).unwrap();
        assert!(told["error"]["message"].as_str().is_some_and(|text| !text.is_empty()), "{told}");
    }
    let twice = folder.stiction(&["inverse", "pendulum.toml", "--step", "0.1", "--step", "0.2"]);
    twice.fails(2, &["cannot be used multiple times"]);
}

/// Two DOFs with the same name would share a column.
#[test]
fn names_of_dofs_are_reserved() {
    let folder = folder("names");
    let second = r#"
[bodies.arm]
[joints.s]
type = "C"
from = "ground"
to = "arm"
axis = "x"
[joints."s.angle"]
type = "R"
from = "arm"
to = "bob"
axis = "z"
"#;
    folder.write("taken.toml", &format!("{PENDULUM}{second}"));
    let told = ["joint `s.angle` has the name of a degree of freedom of joint `s`"];
    folder.stiction(&["inverse", "taken.toml"]).fails(2, &told);
    folder.write("time.toml", &PENDULUM.replace("joints.pivot", "joints.time"));
    folder.stiction(&["inverse", "time.toml"]).fails(2, &["a joint cannot be named `time`"]);
}
