//! Changed values of friction in computations without friction: a note says that they have no effect.

use crate::program::Folder;

/// A pendulum whose parameters affect friction alone, friction through another parameter, and friction and geometry. Its
/// body has the name of the tables of friction.
const PENDULUM: &str = r#"
gravity = [0, -9.81, 0]
[parameters]
coefficient = 0.1
factor = 2
lubricated = "coefficient*factor/2"
radius = "40 mm"
unused = 3
[bodies.friction]
mass = 2
com = [0, "-10*radius", 0]
inertia = [0.01, 0.01, 0.01]
[joints.pivot]
type = "R"
from = "ground"
to = "friction"
axis = "z"
actuated = true
friction = { mu = "lubricated", radius = "radius" }
[motions.swing]
duration = 0.5
pivot = "20 deg*sin(pi*t)"
[loads.none]
[default]
motion = "swing"
load = "none"
"#;

#[test]
fn values_of_friction_without_effect_are_noted() {
    let folder = Folder::new("frictionless");
    folder.write("pendulum.toml", PENDULUM);
    let path = "joints.pivot.friction.mu=0.2";
    let commands: [&[&str]; 4] = [
        &["inverse", "pendulum.toml", "--set"],
        &["forward", "pendulum.toml", "--controller", "pd", "--until", "0.01", "--set"],
        &["linearize", "pendulum.toml", "--set"],
        &["compare", "pendulum.toml", "--set-b"],
    ];
    for command in commands {
        let said = |change: &str, friction: &str| {
            let said = folder.stiction(&[command, &[change, "--friction", friction]].concat());
            assert_eq!(said.code, 0, "{command:?} {change}: {}", said.err);
            said.err
        };
        for change in
            [path, "pivot.friction.mu=0.2", "coefficient=0.2", "factor=3", "parameters.factor=3"]
        {
            let key = change.split('=').next().unwrap();
            let note =
                format!("note: friction is off, so `{key}` has no effect; add --friction on");
            let off = said(change, "off");
            assert_eq!(off.matches(&note).count(), 1, "{command:?} {change}: {off}");
            assert!(!said(change, "on").contains("has no effect"), "{command:?} {change}");
        }
        for change in [
            "radius=50 mm",
            "bodies.friction.mass=3",
            "friction.mass=3",
            "unused=4",
            "default.friction=on",
        ] {
            let off = said(change, "off");
            assert!(!off.contains("has no effect"), "{command:?} {change}: {off}");
        }
    }
    // Static friction is always computed with friction.
    let said = folder.stiction(&["breakaway", "pendulum.toml", "--set", path]);
    assert!(said.code == 0 && !said.err.contains("has no effect"), "{}", said.err);
}

/// The default of this model is without friction; the note names changed and varied keys.
#[test]
fn the_default_of_the_model_counts() {
    let folder = Folder::new("frictionless-default");
    let set = "legs.R.friction.mu=0.2";
    let inverse = ["inverse", "3rps", "--step", "0.5 s", "--set", set];
    let vary = ["--vary", "legs.P.friction.mu = [0.1, 0.2]", "--objective", "peak(leg1.P.effort)"];
    let sweep = [&["sweep"], &inverse[1..], &vary].concat();
    let note = |key: &str| format!("friction is off, so `{key}` has no effect; add --friction on");
    for (command, keys) in [
        (&inverse[..], &["legs.R.friction.mu"][..]),
        (&sweep, &["legs.R.friction.mu", "legs.P.friction.mu"]),
    ] {
        let said = folder.stiction(command);
        assert_eq!(said.code, 0, "{}", said.err);
        assert_eq!(said.err.matches("has no effect").count(), keys.len(), "{}", said.err);
        for key in keys {
            assert!(said.err.contains(&note(key)), "{key}: {}", said.err);
        }
        let quiet = folder.stiction(&[command, &["--friction", "on"]].concat());
        assert!(!quiet.err.contains("has no effect"), "{}", quiet.err);
    }
}
