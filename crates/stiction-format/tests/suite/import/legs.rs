//! Repeating legs of a robot file are written once, and the model has the same mechanism as the
//! file.

use super::tree::{convert, model, with_files};
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_format::{Imported, ModelFile};

/// Names of the parts of a leg, and values that differ between legs.
struct Leg<'a> {
    /// Names of two bodies, a hinge, a prismatic joint and a ball joint.
    names: [&'a str; 5],
    angle: f64,
    mass: f64,
}

/// Robot whose legs rotate about tangents of a circle, extend, and carry a plate on ball joints.
fn mjcf(legs: &[Leg<'_>], inside: &str, actuators: &str) -> String {
    let (mut bodies, mut closures, mut motors) = (String::new(), String::new(), String::new());
    for Leg { names: [lower, upper, hinge, slide, ball], angle, mass } in legs {
        let (sin, cos) = angle.to_radians().sin_cos();
        let [x, y] = [0.45 * cos, 0.45 * sin];
        bodies += &format!(
            "<body name='{lower}' euler='0 0 {angle}' pos='{x} {y} 0'><joint name='{hinge}' axis='0 1 0' {inside}/>\n\
             <inertial pos='0 0 .1' mass='{mass}' diaginertia='.02 .02 .01'/>\n\
             <body name='{upper}' pos='0 0 .2'><joint name='{slide}' type='slide' axis='0 0 1' range='-1 1'/>\n\
             <inertial pos='0 0 .1' mass='1' diaginertia='.02 .02 .01'/></body></body>\n"
        );
        closures +=
            &format!("<connect name='{ball}' body1='{upper}' body2='plate' anchor='0 0 .3'/>\n");
        motors += &format!("<motor joint='{slide}' {actuators}/>\n");
    }
    format!(
        "<mujoco model='rps'><worldbody>{bodies}<body name='plate' pos='0 0 .5'><freejoint/>\n\
         <inertial pos='0 0 0' mass='3' diaginertia='.1 .1 .2'/></body></worldbody>\n\
         <equality>{closures}</equality><actuator>{motors}</actuator></mujoco>"
    )
}

const NAMES: [[&str; 5]; 3] = [
    ["leg1_lower", "leg1_upper", "leg1_hinge", "leg1_slide", "leg1_ball"],
    ["leg2_lower", "leg2_upper", "leg2_hinge", "leg2_slide", "leg2_ball"],
    ["leg3_lower", "leg3_upper", "leg3_hinge", "leg3_slide", "leg3_ball"],
];

fn three(names: [[&str; 5]; 3]) -> Vec<Leg<'_>> {
    let each = names.into_iter().zip([0.0, 120.0, 240.0]);
    each.map(|(names, angle)| Leg { names, angle, mass: 2.0 }).collect()
}

/// Compares all numbers with those of the conversion without legs, by name; returns the model with
/// legs.
fn same(imported: &Imported, file: &str, text: &str, files: &[(&str, &str)]) -> ModelFile {
    let (found, long) = (model(imported), model(&with_files(file, text, files, true)));
    assert!(long.legs.is_empty());
    let (a, b) = (&found.mechanism, &long.mechanism);
    assert_eq!((a.bodies().len(), a.joints().len()), (b.bodies().len(), b.joints().len()));
    let near = |a: Vec3<f64>, b: Vec3<f64>| (a + -b).norm() <= 1e-12 * a.norm().max(1.0);
    for body in b.bodies() {
        let own = &a.bodies()[a.body_id(&body.name).unwrap_or_else(|| panic!("{}", body.name)).0];
        assert_eq!((own.mass, own.com, own.inertia), (body.mass, body.com, body.inertia));
    }
    let name =
        |of: &Mechanism, id: stiction_core::mechanism::BodyId| of.bodies()[id.0].name.clone();
    for joint in b.joints() {
        let own = a.joint_id(&joint.name).unwrap_or_else(|| panic!("{}", joint.name));
        let own = &a.joints()[own.0];
        assert_eq!(name(a, own.predecessor), name(b, joint.predecessor));
        assert_eq!(name(a, own.successor), name(b, joint.successor));
        assert_eq!((own.joint_type, &own.actuated), (joint.joint_type, &joint.actuated));
        assert_eq!((&own.friction, &own.ranges), (&joint.friction, &joint.ranges));
        assert!(near(own.frame_j.position, joint.frame_j.position), "{}", joint.name);
        assert!(near(own.frame_k.position, joint.frame_k.position), "{}", joint.name);
        let across = |joint: &stiction_core::mechanism::Joint| -> Mat3<f64> {
            let pose: Pose<f64> = joint.joint_type.pose(&joint.start_or_zero(), joint.pitch);
            joint.frame_j.rotation * pose.rotation * joint.frame_k.rotation.transpose()
        };
        let columns = |joint: &stiction_core::mechanism::Joint| across(joint).columns;
        for (a, b) in columns(own).into_iter().zip(columns(joint)) {
            assert!(near(a, b), "{}", joint.name);
        }
    }
    found
}

fn legs(model: &ModelFile) -> Vec<&str> {
    model.legs.iter().map(|leg| leg.name.as_str()).collect()
}

#[test]
fn legs_of_an_mjcf_differ_by_a_rotation() {
    let text = mjcf(&three(NAMES), "damping='0.2'", "");
    let imported = convert("rps.xml", &text);
    let found = same(&imported, "rps.xml", &text, &[]);
    assert_eq!(legs(&found), ["leg1", "leg2", "leg3"]);
    for line in [
        "chain = \"R lower P* upper S\"",
        "angles = [\"0 deg\", \"120 deg\", \"-120 deg\"]",
        "foot = [\"450 mm\", 0, 0]",
        "names = { R = \"{}_hinge\", P = \"{}_slide\", S = \"{}_ball\", lower = \"{}_lower\", upper = \"{}_upper\" }",
        "[legs.bodies.lower]                 # 1, 5, 9",
        "# Closes a loop: <connect> `leg1_ball`.",
    ] {
        assert!(imported.text.lines().any(|own| own == line), "{line}\n{}", imported.text);
    }
    // Motors with the name of their joint are written with the legs.
    let text = mjcf(&three(NAMES), "", "gear='5' forcerange='-9 9'");
    let imported = convert("rps.xml", &text);
    assert_eq!(same(&imported, "rps.xml", &text, &[]).mechanism.drive_trains().len(), 3);
    assert!(!imported.text.contains("[actuators"), "{}", imported.text);
    // Springs have their own names.
    let text = mjcf(&three(NAMES), "stiffness='3'", "");
    let found = same(&convert("rps.xml", &text), "rps.xml", &text, &[]);
    assert_eq!((found.legs.len(), found.mechanism.joint_springs().len()), (3, 3));
}

/// A URDF is a tree: the plate is attached to the first leg, and its frame is not at its centre.
#[test]
fn legs_of_a_urdf_have_their_own_tips() {
    let mut text = "<robot name='rps'><link name='base'/>".to_owned();
    let inertial = "<inertial><mass value='2'/><inertia ixx='.1' iyy='.1' izz='.1' ixy='0' ixz='0' iyz='0'/></inertial>";
    let places = ["left", "right", "rear"].map(|name| {
        let angle = match name {
            "left" => 0.0,
            "right" => 120f64.to_radians(),
            _ => 240f64.to_radians(),
        };
        (name, angle)
    });
    for (name, angle) in places {
        let [x, y] = [0.45 * angle.cos(), 0.45 * angle.sin()];
        text += &format!(
            "<link name='{name}_lower'>{inertial}</link><link name='{name}_upper'>{inertial}</link>\n\
             <joint name='{name}_hinge' type='continuous'><parent link='base'/><child link='{name}_lower'/>\
             <origin xyz='{x} {y} 0' rpy='0 0 {angle}'/><axis xyz='0 1 0'/></joint>\n\
             <joint name='{name}_slide' type='prismatic'><parent link='{name}_lower'/><child link='{name}_upper'/>\
             <origin xyz='0 0 .2'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='9' velocity='1'/></joint>\n\
             <transmission name='{name}'><joint name='{name}_slide'/><actuator name='{name}_slide'/></transmission>\n"
        );
        text += &match name {
            "left" => format!(
                "<link name='plate'>{inertial}</link><joint name='left_ball' type='spherical'>\
                 <parent link='left_upper'/><child link='plate'/><origin xyz='0 0 .3'/></joint>\n"
            ),
            _ => format!(
                "<loop_joint name='{name}_ball' type='spherical'><link1 link='{name}_upper' xyz='0 0 .3' rpy='0 0 0'/>\
                 <link2 link='plate' xyz='{} {y} 0' rpy='0 0 0'/></loop_joint>\n",
                x - 0.45
            ),
        };
    }
    text += "</robot>";
    let imported = convert("rps.urdf", &text);
    let found = same(&imported, "rps.urdf", &text, &[]);
    assert_eq!(legs(&found), ["left", "right", "rear"]);
    assert!(imported.text.contains("angle = \"120 deg\"\ntip = [\"675 mm\""), "{}", imported.text);
}

/// A leg that differs is written separately; the other legs are combined.
#[test]
fn a_different_leg_is_not_merged() {
    for mass in [2.5, 2.0 * (1.0 + 1e-9)] {
        let mut own = three(NAMES);
        own[1].mass = mass;
        let text = mjcf(&own, "", "");
        let imported = convert("rps.xml", &text);
        let found = same(&imported, "rps.xml", &text, &[]);
        assert_eq!(legs(&found), ["leg1", "leg3"], "{}", imported.text);
        assert!(imported.text.contains("[bodies.leg2_lower]"));
        let text = mjcf(&own[..2], "", "");
        let found = same(&convert("rps.xml", &text), "rps.xml", &text, &[]);
        assert!(found.legs.is_empty());
    }
    // An angle that differs by more than rounding is kept.
    let mut own = three(NAMES);
    own[1].angle = 120.000001;
    let text = mjcf(&own, "", "");
    same(&convert("rps.xml", &text), "rps.xml", &text, &[]);
}

#[test]
fn names_of_legs_are_those_of_the_file() {
    for (names, expected) in [
        // Names of the same form as in model files need no patterns.
        (
            [
                ["a.lower", "a.upper", "a.R", "a.P", "a.S"],
                ["b.lower", "b.upper", "b.R", "b.P", "b.S"],
                ["c.lower", "c.upper", "c.R", "c.P", "c.S"],
            ],
            vec!["a", "b", "c"],
        ),
        // The number of the leg follows the name of the part, and parts have numbers.
        (
            [
                ["link1_1", "link2_1", "q1_1", "q2_1", "q3_1"],
                ["link1_2", "link2_2", "q1_2", "q2_2", "q3_2"],
                ["link1_3", "link2_3", "q1_3", "q2_3", "q3_3"],
            ],
            vec!["1", "2", "3"],
        ),
        // The number of the leg is in the middle of names, and bodies are named like joint types.
        (
            [
                ["R leftX", "P leftX", "joint_left_a", "joint_left_b", "joint_left_c"],
                ["R rightX", "P rightX", "joint_right_a", "joint_right_b", "joint_right_c"],
                ["R rearX", "P rearX", "joint_rear_a", "joint_rear_b", "joint_rear_c"],
            ],
            vec!["left", "right", "rear"],
        ),
        // Names with reserved words, quotes and braces are renamed first.
        (
            [
                ["start\"1", "{}1", "{}é1", "ö\\1", "x::1"],
                ["start\"2", "{}2", "{}é2", "ö\\2", "x::2"],
                ["start\"3", "{}3", "{}é3", "ö\\3", "x::3"],
            ],
            vec!["1", "2", "3"],
        ),
        // The names of the parts of a leg have no word in common.
        (
            [
                ["b1", "b2", "j1", "j2", "j3"],
                ["b3", "b4", "j4", "j5", "j6"],
                ["b5", "b6", "j7", "j8", "j9"],
            ],
            vec![],
        ),
    ] {
        let text = mjcf(&three(names), "", "").replace("\"", "&quot;");
        let found = same(&convert("rps.xml", &text), "rps.xml", &text, &[]);
        assert_eq!(legs(&found), expected, "{}", convert("rps.xml", &text).text);
    }
}
