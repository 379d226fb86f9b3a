//! Messages about infeasible inputs: large and small mechanisms, loops open by lengths and by
//! angles.

use crate::program::Folder;

/// A valid linkage, and a loop of slides of which one is rotated relative to the others.
const TWISTED: &str = r#"
gravity = [0, 0, 0]
[bodies.crank]
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
[bodies.rod]
[bodies.rocker]
[bodies.block]
[bodies.slide]
[joints]
a = { type = "R", from = "ground", to = "crank", axis = "z", actuated = true, start = ["60 deg"] }
b = { type = "R", from = "crank", to = "rod", at = [0.2, 0, 0], axis = "z", start = ["-40 deg"] }
c = { type = "R", from = "rod", to = "rocker", at = [0.3, 0, 0], axis = "z", start = ["-100 deg"] }
d = { type = "R", from = "ground", to = "rocker", at = [0.4, 0, 0], to_at = [0.25, 0, 0], axis = "z" }
p1 = { type = "P", from = "ground", to = "block", axis = "x", actuated = true }
p2 = { type = "P", from = "block", to = "slide", axis = "y" }
p3 = { type = "P", from = "ground", to = "slide", axis = "x", turn = { axis = "z", angle = "30 deg" } }
[motions.go]
duration = "0.1 s"
a = "60 deg + 40 deg/s*t"
p1 = "0.1 m/s*t"
"#;

/// The message names a loop that is open by an angle, although another loop has a smaller gap.
#[test]
fn loops_open_by_an_angle_are_named() {
    let folder = Folder::new("twisted");
    folder.write("model.toml", TWISTED);
    let said = folder.stiction(&["inverse", "model.toml"]);
    said.fails(1, &["joint `p", "stays open by", " deg"]);
}

/// The weight of a pendulum of 1 ug without an actuator is unbalanced: a moment of 1e-13 N m is
/// significant here.
#[test]
fn small_amounts_are_reported() {
    let folder = Folder::new("small");
    let model = r#"
        gravity = [0, -10, 0]
        [bodies.bob]
        mass = 1e-9
        com = [1e-4, 0, 0]
        inertia = [0, 1e-18, 1e-18]
        [joints.pivot]
        type = "R"
        from = "ground"
        to = "bob"
        axis = "z"
        [motions.sit]
        duration = 0
        pivot = 0
    "#;
    folder.write("model.toml", model);
    let said = folder.stiction(&["inverse", "model.toml"]);
    said.fails(1, &["a moment of 1.00000e-12 N m remains unbalanced"]);
}

/// A planar mechanism with three equal legs, in the horizontal plane. `motion` is the table of its
/// motion, and `foot` the radius of the feet of the legs.
fn three_legs(motion: &str, foot: &str) -> String {
    format!(
        r#"
        gravity = [0, 0, "-9.81 m/s^2"]
        [bodies.platform]
        mass = "2 kg"
        com = [0, 0, 0]
        inertia = {{ zz = "0.01 kg m^2" }}
        home = {{ position = [0, 0, 0] }}
        [legs]
        chain = "R* crank R rod R"
        to = "platform"
        angles = ["90 deg", "210 deg", "330 deg"]
        foot = [{foot}, 0, 0]
        tip = ["100 mm", 0, 0]
        [legs.joints]
        R1 = {{ axis = "z", start = "120 deg" }}
        R2 = {{ axis = "z", at = ["220 mm", 0, 0], start = "100 deg" }}
        R3 = {{ axis = "z", at = ["220 mm", 0, 0] }}
        [legs.bodies]
        crank = {{ mass = "0.6 kg", com = ["110 mm", 0, 0], inertia = {{ zz = "2.5e-3 kg m^2" }} }}
        rod = {{ mass = "0.6 kg", com = ["110 mm", 0, 0], inertia = {{ zz = "2.5e-3 kg m^2" }} }}
        {motion}
        "#
    )
}

const ALONG_X: &str =
    "[motions.x]\nduration = \"2 s\"\nplatform = { x = \"150 mm*t\", y = 0, rz = 0 }";

#[test]
fn open_loops_of_the_size_of_the_mechanism_hint_at_units() {
    let folder = Folder::new("units");
    folder.write("legs.toml", &three_legs(ALONG_X, "\"400\""));
    let said = folder.stiction(&["inverse", "legs.toml"]);
    said.fails(1, &["stays open by 399.", "help: check the lengths and their units", "400 mm"]);
    // Out of reach by a little.
    folder.write("legs.toml", &three_legs(ALONG_X, "\"400 mm\""));
    let said = folder.stiction(&["inverse", "legs.toml"]);
    said.fails(
        1,
        &["error: at t = 1.03 s: the loops do not close", "keep the motion within reach"],
    );
}

#[test]
fn references_out_of_reach_are_named() {
    let folder = Folder::new("reference");
    folder.write("legs.toml", &three_legs(ALONG_X, "\"400 mm\""));
    let said = folder.stiction(&["forward", "legs.toml"]);
    said.fails(
        1,
        &["the mechanism cannot follow the reference motion: ", "that the controller follows"],
    );
}

#[test]
fn views_without_a_motion_ask_for_one() {
    let folder = Folder::new("motionless");
    folder.write("legs.toml", &three_legs("", "\"400 mm\""));
    let said = folder.stiction(&["view", "legs.toml", "-o", "out"]);
    said.fails(2, &["no motion is given", "--motion", "[motions.NAME]"]);
}

/// Every position in the horizontal plane is an equilibrium; rounding errors of the stiffness are
/// no motions.
#[test]
fn neutral_motions_have_no_frequency() {
    let folder = Folder::new("neutral");
    folder.write("legs.toml", &three_legs(ALONG_X, "\"400 mm\""));
    let said = folder.stiction(&["equilibrium", "legs.toml"]);
    let text = said.succeeds();
    assert_eq!(text.matches("neutral (zero frequency)").count(), 3, "{text}");
    assert!(!text.contains("oscillates") && !text.contains("grows"), "{text}");
}
