//! Groups of legs are equivalent to bodies and joints that are written individually.

use stiction_core::mechanism::{Mechanism, MechanismBuilder};
use stiction_core::spatial::Vec3;
use stiction_format::{ModelFile, Source, read};

fn model(text: &str) -> ModelFile {
    read(&Source::new("robot.toml", text), &|_| Err(String::new()))
        .unwrap_or_else(|diagnostics| panic!("{diagnostics}"))
}

/// Largest difference of all numbers of two mechanisms; asserts that everything else is equal.
fn difference(a: &Mechanism, b: &Mechanism) -> f64 {
    let mut largest = 0.0f64;
    let mut compare = |a: f64, b: f64| largest = largest.max((a - b).abs());
    assert_eq!(a.bodies(), b.bodies());
    assert_eq!(a.joints().len(), b.joints().len());
    for (a, b) in a.joints().iter().zip(b.joints()) {
        assert_eq!((&a.name, a.joint_type), (&b.name, b.joint_type));
        assert_eq!((a.predecessor, a.successor), (b.predecessor, b.successor));
        assert_eq!((&a.actuated, &a.start, &a.friction), (&b.actuated, &b.start, &b.friction));
        for (a, b) in [(a.frame_j, b.frame_j), (a.frame_k, b.frame_k)] {
            for i in 0..3 {
                compare(a.position.component(i), b.position.component(i));
                for k in 0..3 {
                    compare(a.rotation.at(i, k), b.rotation.at(i, k));
                }
            }
        }
    }
    largest
}

const HEAD: &str = r#"
gravity = [0, 0, -9.81]
[bodies.platform]
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
"#;

/// Compares three legs at different angles, one of them heavier, with bodies and joints written out
/// by hand: all directions in the ground and the platform are rotated by the leg's angle.
#[test]
fn legs_equal_bodies_and_joints_written_by_hand() {
    let legs = model(&format!(
        r#"{HEAD}
[legs]
chain = "R* arm U forearm U"
to = "platform"
foot = ["450 mm", 0, "10 mm"]
tip = [0.15, 0.02, 0.01]
place = [
    {{ angle = "0 deg" }},
    {{ angle = "90 deg", name = "heavy", bodies.arm.mass = "5 kg", joints.R.friction.mu = 0.3 }},
    {{ angle = "-30 deg", foot = [0.5, 0, 0] }},
]
[legs.joints.R]
axis = "y"
start = "10 deg"
friction = {{ mu = 0.1, radius = "5 mm" }}
[legs.joints.U1]
axis = "z"
second_axis = "x"
[legs.joints.U2]
axis = [0, 1, 1]
second_axis = "x"
turn = {{ axis = "x", angle = "20 deg" }}
[legs.bodies.arm]
mass = 2
com = [0, 0, 0.1]
inertia = [1, 1, 1]
"#,
    ));
    let mut by_hand = HEAD.to_owned();
    for (name, mass, mu, angle, foot) in [
        ("leg1", 2, 0.1, "0 deg", "[\"450 mm\", 0, \"10 mm\"]"),
        ("heavy", 5, 0.3, "90 deg", "[0, \"450 mm\", \"10 mm\"]"),
        ("leg3", 2, 0.1, "-30 deg", "[\"0.5*cos(a3)\", \"0.5*sin(a3)\", 0]"),
    ] {
        let turned = |x: f64, y: f64, z: f64| {
            format!(
                "[\"{x}*cos({angle}) - {y}*sin({angle})\", \"{x}*sin({angle}) + {y}*cos({angle})\", {z}]"
            )
        };
        by_hand.push_str(&format!(
            r#"
[bodies."{name}.arm"]
mass = {mass}
com = [0, 0, 0.1]
inertia = [1, 1, 1]
[bodies."{name}.forearm"]
[joints."{name}.R"]
type = "R"
from = "ground"
to = "{name}.arm"
at = {foot}
axis = {y}
x_axis = {x}
turn = {{ axis = "z", angle = "{angle}" }}
actuated = true
start = "10 deg"
friction = {{ mu = {mu}, radius = "5 mm" }}
[joints."{name}.U1"]
type = "U"
from = "{name}.arm"
to = "{name}.forearm"
axis = "z"
second_axis = "x"
[joints."{name}.U2"]
type = "U"
from = "{name}.forearm"
to = "platform"
to_at = {tip}
axis = [0, 1, 1]
second_axis = "x"
turn = {{ xyz = ["20 deg", 0, "-({angle})"] }}
"#,
            x = turned(1.0, 0.0, 0.0),
            y = turned(0.0, 1.0, 0.0),
            tip = turned(0.15, 0.02, 0.01),
        ));
    }
    let by_hand = model(&format!("{by_hand}\n[parameters]\na3 = \"-30 deg\"\n"));
    // The tolerance covers the rounding of a few products of sines and cosines.
    assert!(difference(&legs.mechanism, &by_hand.mechanism) < 1e-15 * 4.0);

    assert_eq!(legs.legs.len(), 3);
    let heavy = &legs.legs[1];
    assert_eq!(heavy.name, "heavy");
    let names: Vec<_> =
        heavy.joints.iter().map(|id| legs.mechanism.joints()[id.0].name.as_str()).collect();
    assert_eq!(names, ["heavy.R", "heavy.U1", "heavy.U2"]);
    let bodies: Vec<_> =
        heavy.bodies.iter().map(|id| legs.mechanism.bodies()[id.0].name.as_str()).collect();
    assert_eq!(bodies, ["heavy.arm", "heavy.forearm"]);
}

/// With all joints at zero and no `turn`, the last body is parallel to the ground, whatever the
/// leg's angle, and the joint frames follow from `foot` and `tip`.
#[test]
fn the_end_of_a_leg_is_parallel_to_the_ground() {
    for chain in ["S", "fixed", "R link S"] {
        let text = format!(
            "{HEAD}
[legs]
chain = \"{chain}\"
to = \"platform\"
about = [1, 2, 3]
angles = [\"77 deg\"]
foot = [1, 0, 0]
tip = [0, 0, 0]
{}",
            if chain.contains('R') { "[legs.joints.R]\naxis = [3, 1, 0]\n" } else { "" }
        );
        let model = model(&text);
        let pose = model
            .mechanism
            .joints()
            .iter()
            .fold(stiction_core::spatial::Pose::identity(), |pose, joint| {
                pose * joint.frame_j * joint.frame_k.inverse()
            });
        let turn = pose.rotation.rotation_vector().norm();
        assert!(turn < 1e-15, "{chain}: {turn}");
    }
}

/// The numbering continues across groups; `home` of a leg's body refers to the rotated frame.
#[test]
fn numbering_continues_across_groups() {
    let text = format!(
        "{HEAD}
[[legs]]
chain = \"S rod S\"
to = \"platform\"
angles = [0, 1]
foot = [1, 0, 0]
tip = [1, 0, 0]
[legs.bodies.rod]
home = {{ position = [1, 0, 0.5] }}
[[legs]]
chain = \"S rod S\"
to = \"platform\"
angles = [2]
foot = [1, 0, 0]
tip = [1, 0, 0]
"
    );
    let model = model(&text);
    let names: Vec<_> = model.legs.iter().map(|leg| leg.name.as_str()).collect();
    assert_eq!(names, ["leg1", "leg2", "leg3"]);
    assert!(model.mechanism.joint_id("leg3.S2").is_some());
    let (body, home) = model.initial_poses[1];
    assert_eq!(model.mechanism.bodies()[body.0].name, "leg2.rod");
    let expected = Vec3::new(1f64.cos(), 1f64.sin(), 0.5);
    assert!((home.position - expected).norm() < 1e-15);
}

/// The order of tables in the file determines only the order of bodies and joints.
#[test]
fn a_file_equals_the_builder() {
    use stiction_core::joint::JointType;
    use stiction_core::mechanism::{BodySpec, JointSpec};
    let model = model(
        r#"
name = "crank"
gravity = [0, "-9.81 m/s^2", 0]
characteristic_length = "0.3 m"
[joints.zeta]
type = "R"
from = "ground"
to = "b"
axis = "z"
actuated = true
[bodies.b]
mass = "1 kg"
com = [0.1, 0, 0]
inertia = { zz = 2e-3, yy = 1e-3, xx = 1e-3, xy = -1e-4 }
[bodies.a]
[joints.alpha]
type = "H"
from = "b"
to = "a"
axis = "z"
pitch = "5 mm/rev"
"#,
    );
    let tensor = |xx: f64, yy: f64, zz: f64, xy: f64| {
        stiction_core::spatial::Mat3::from_columns(
            Vec3::new(xx, xy, 0.0),
            Vec3::new(xy, yy, 0.0),
            Vec3::new(0.0, 0.0, zz),
        )
    };
    let expected = MechanismBuilder::new("crank")
        .gravity(Vec3::new(0.0, -9.81, 0.0))
        .characteristic_length(0.3)
        .body(
            BodySpec::new("b")
                .mass(1.0)
                .com(Vec3::new(0.1, 0.0, 0.0))
                .inertia(tensor(1e-3, 1e-3, 2e-3, -1e-4)),
        )
        .body(BodySpec::new("a"))
        .joint(JointSpec::new("zeta", JointType::Revolute, "ground", "b").actuated())
        .joint(
            JointSpec::new("alpha", JointType::Helical, "b", "a")
                .pitch(0.005 / std::f64::consts::TAU),
        )
        .build()
        .unwrap();
    assert_eq!(model.mechanism, expected);
}

/// The three ways to write a chain give the same robot except for the names of the bodies.
#[test]
fn a_chain_can_list_only_joints() {
    let legs = |chain: &str, [first, second]: [&str; 2]| {
        model(&format!(
            r#"{HEAD}
[legs]
{chain}
to = "platform"
angles = ["0 deg", "120 deg", "240 deg"]
foot = [0.4, 0, 0]
tip = [0.2, 0, 0]
[legs.joints.R]
axis = "y"
friction = {{ mu = 0.1, radius = "5 mm" }}
[legs.joints.P]
axis = "z"
start = 0.5
[legs.bodies.{first}]
mass = 2
com = [0, 0, 0.1]
inertia = [1, 1, 1]
[legs.bodies.{second}]
mass = 1
com = [0, 0, -0.1]
inertia = [1, 1, 1]
"#
        ))
    };
    let named = legs("chain = \"R cylinder P* rod S\"", ["cylinder", "rod"]);
    let apart = legs("chain = \"R P* S\"\nbetween = [\"cylinder\", \"rod\"]", ["cylinder", "rod"]);
    assert_eq!(named.mechanism, apart.mechanism);

    let short = legs("chain = \"R P* S\"", ["link1", "link2"]);
    assert_eq!(short.mechanism.bodies()[2].name, "leg1.link1");
    assert_eq!(short.mechanism.bodies()[7].name, "leg3.link2");
    assert_eq!(short.legs[1].bodies.len(), 2);
    for (a, b) in named.mechanism.bodies().iter().zip(short.mechanism.bodies()) {
        assert_eq!((a.mass, a.com, a.inertia), (b.mass, b.com, b.inertia));
    }
    assert_eq!(named.mechanism.joints(), short.mechanism.joints());
}

/// Individual values of one leg do not change other legs.
#[test]
fn one_leg_can_differ() {
    let legs = |places: &str| {
        model(&format!(
            r#"{HEAD}
[legs]
chain = "R P* S"
to = "platform"
foot = [0.4, 0, 0]
tip = [0.2, 0, 0]
place = [{places}]
[legs.joints.R]
axis = "y"
start = "10 deg"
friction = {{ mu = 0.1, radius = "5 mm", viscous = "0.02 N s/m" }}
[legs.joints.P]
axis = "z"
start = "0.5 m"
friction = {{ mu = 0.1 }}
[legs.bodies.link1]
mass = "2 kg"
com = [0, 0, 0.1]
inertia = [0.1, 0.2, 0.3]
"#
        ))
    };
    let equal = legs("{ angle = 0 }, { angle = \"120 deg\" }, { angle = \"240 deg\" }");
    let one = legs(
        r#"
    { angle = 0 },
    { angle = "120 deg", bodies.link1 = { mass = "5 kg", inertia = { xx = 1, yy = 1, zz = 1 } }, joints = { R = { friction.mu = 0.3, start = "20 deg" }, P.start = "0.6 m" } },
    { angle = "240 deg" },
"#,
    );
    let (a, b) = (&equal.mechanism, &one.mechanism);
    for (a, b) in a.bodies().iter().zip(b.bodies()) {
        if a.name == "leg2.link1" {
            assert_eq!((a.mass, b.mass), (2.0, 5.0));
            // A tensor is replaced as a whole; all other values remain.
            assert_eq!((b.inertia.at(0, 0), b.inertia.at(2, 2), b.com), (1.0, 1.0, a.com));
        } else {
            assert_eq!(a, b);
        }
    }
    for (a, b) in a.joints().iter().zip(b.joints()) {
        let law = |joint: &stiction_core::mechanism::Joint| format!("{:?}", joint.friction);
        match a.name.as_str() {
            "leg2.R" => {
                assert_ne!(a.start, b.start);
                // All other friction keys are those of the group.
                assert_eq!(law(b), law(a).replace("0.1", "0.3"));
            }
            "leg2.P" => {
                assert_ne!(a.start, b.start);
                assert_eq!(law(a), law(b));
            }
            _ => assert_eq!(a, b),
        }
    }
}

/// Springs of legs: names of parts in the chain, points on the end bodies that are rotated with the
/// leg, and individual values of one leg.
#[test]
fn springs_of_legs_are_those_written_by_hand() {
    let robot = |springs: &str, more: &str| {
        model(&format!(
            "{HEAD}\n[legs]\nchain = \"R* arm S\"\nto = \"platform\"\nfoot = [0.5, 0, 0]\ntip = [0.2, 0, 0]\n\
             place = [{{ angle = 0 }}, {{ angle = \"90 deg\"{springs} }}]\n\
             joints.R = {{ axis = \"y\", start = 0 }}\nbodies.arm = {{ mass = 1, com = [0, 0, 0.1], inertia = [1, 1, 1] }}\n{more}"
        ))
    };
    let short = robot(
        ", springs.pull.stiffness = 300",
        "[legs.springs.pull]\nfrom = \"ground\"\nat = [0.4, 0.1, 0]\nto = \"arm\"\nto_at = [0.1, 0, 0.2]\n\
         stiffness = 200\nfree_length = 0.1\n[legs.springs.twist]\njoint = \"R\"\nstiffness = 2\nrest = 0.3",
    );
    let springs = short.mechanism.springs();
    let names: Vec<&str> = springs.iter().map(|spring| spring.name.as_str()).collect();
    assert_eq!(names, ["leg1.pull", "leg2.pull"]);
    assert_eq!([springs[0].stiffness, springs[1].stiffness], [200.0, 300.0]);
    for (spring, at) in springs.iter().zip([[0.4, 0.1, 0.0], [-0.1, 0.4, 0.0]]) {
        assert!((spring.points[0] + -Vec3::from(at)).norm() < 1e-16, "{:?}", spring.points);
        // A body of the leg has its own frame, so the point is not rotated.
        assert_eq!(spring.points[1], Vec3::new(0.1, 0.0, 0.2));
        let body = &short.mechanism.bodies()[spring.ends[1].0].name;
        assert_eq!(*body, format!("{}.arm", &spring.name[..4]));
    }
    let on_joints = short.mechanism.joint_springs();
    let joints: Vec<&str> = on_joints
        .iter()
        .map(|spring| short.mechanism.joints()[spring.joint.0].name.as_str())
        .collect();
    assert_eq!(joints, ["leg1.R", "leg2.R"]);
    assert!(on_joints.iter().all(|spring| (spring.stiffness, spring.rest) == (2.0, 0.3)));
    let wrong = format!(
        "{HEAD}\n[legs]\nchain = \"R* arm S\"\nto = \"platform\"\nfoot = [0.5, 0, 0]\ntip = [0.2, 0, 0]\nangles = [0, 2]\n\
         joints.R = {{ axis = \"y\" }}\nbodies.arm = {{ mass = 1, com = [0, 0, 0.1], inertia = [1, 1, 1] }}\n\
         [legs.springs.pull]\njoint = \"Q\"\nstiffness = 2\nrest = 0"
    );
    let said = read(&Source::new("robot.toml", wrong), &|_| Err(String::new())).unwrap_err();
    assert!(said.to_string().contains("`Q`"), "{said}");
}

/// With `names`, parts can have names other than the leg's name, a dot and the name in the chain.
#[test]
fn parts_of_legs_can_have_other_names() {
    let text = |names: &str| {
        format!(
            "{HEAD}
[legs]
chain = \"R* arm P rod S\"
to = \"platform\"
{names}
place = [{{ name = \"left\" }}, {{ angle = \"180 deg\" }}]
foot = [1, 0, 0]
tip = [1, 0, 0]
[legs.joints.R]
axis = \"y\"
[legs.joints.P]
axis = \"z\"
[legs.springs.P]
joint = \"P\"
stiffness = \"1 N/m\"
rest = 0
[legs.actuators.R]
ratio = 2
rotor_axis = {{ body = \"arm\", axis = \"z\" }}
"
        )
    };
    let named = model(&text(r#"names = { R = "hip_{}", arm = "{}-arm", P = "{}" }"#));
    let plain = model(&text(""));
    let names = |model: &ModelFile| -> Vec<String> {
        model.mechanism.joints().iter().map(|joint| joint.name.clone()).collect()
    };
    assert_eq!(names(&plain), ["left.R", "left.P", "left.S", "leg2.R", "leg2.P", "leg2.S"]);
    assert_eq!(names(&named), ["hip_left", "left", "left.S", "hip_leg2", "leg2", "leg2.S"]);
    let bodies: Vec<_> = named.mechanism.bodies().iter().map(|body| body.name.as_str()).collect();
    assert_eq!(bodies, ["ground", "platform", "left-arm", "left.rod", "leg2-arm", "leg2.rod"]);
    assert_eq!(named.mechanism.drive_trains()[1].name, "hip_leg2");
    assert_eq!(named.mechanism.joint_springs()[0].name, "left.P");
    assert!(difference_of_frames(&named.mechanism, &plain.mechanism) == 0.0);
    for (names, message) in [
        (r#"names = { R = "hip" }"#, "must contain {} exactly once"),
        (r#"names = { R = "{}{}" }"#, "must contain {} exactly once"),
        (r#"names = { Q = "{}_q" }"#, "has no joint or body `Q`"),
        (r#"names = { R = "{} a" }"#, "cannot be the name of a joint"),
        (r#"names = { R = "{}.S" }"#, "left.S"),
        (r#"names = { R = 1 }"#, "a quoted name"),
        (r#"names = ["a"]"#, "a table of names"),
    ] {
        let source = Source::new("robot.toml", text(names));
        let errors = read(&source, &|_| Err(String::new())).unwrap_err().to_string();
        assert!(errors.contains(message), "{names}: {errors}");
    }
}

/// Largest difference of the joint frames, in order.
fn difference_of_frames(a: &Mechanism, b: &Mechanism) -> f64 {
    let joints = a.joints().iter().zip(b.joints());
    let frames = joints.flat_map(|(a, b)| [(a.frame_j, b.frame_j), (a.frame_k, b.frame_k)]);
    let size = |(a, b): (stiction_core::spatial::Pose<f64>, stiction_core::spatial::Pose<f64>)| {
        (a.inverse() * b).position.norm() + (a.inverse() * b).rotation.rotation_vector().norm()
    };
    frames.map(size).fold(0.0, f64::max)
}
