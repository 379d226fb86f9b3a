//! Peculiarities of robot files that published packages contain, and that their programs accept.

use super::tree::{convert, model, refused};
use stiction_core::joint::JointType;

const LINK: &str = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>";

fn notes(imported: &stiction_format::Imported) -> String {
    imported.notes.iter().map(|note| note.line() + "\n").collect()
}

/// Two links on a base, with further text before the end.
fn robot(tail: &str, inertia: &str) -> String {
    format!(
        "<?xml version='1.0'?>\n<!-- <robot> -->\n<robot name='r'><link name='base'/>\n<link name='a'>{LINK}</link>\n\
         <link name='b'>{inertia}</link>\n<joint name='j' type='continuous'><parent link='base'/><child link='a'/>\
         <axis xyz='0 0 1'/></joint>\n<joint name='k' type='fixed'><parent link='a'/><child link='b'/>\
         <mimic joint='j'/></joint>\n{tail}</robot>"
    )
}

#[test]
fn undeclared_prefixes_and_fixed_followers_are_noted() {
    let text = robot("<sensor:camera kind='x' sensor:kind='y'/>\n<other:thing/>", LINK);
    let imported = convert("r.urdf", &text);
    let said = notes(&imported);
    assert!(said.contains("r.urdf:8: <sensor:camera> has no counterpart"), "{said}");
    assert!(said.contains("r.urdf:9: <other:thing> has no counterpart"), "{said}");
    assert!(said.contains("r.urdf:7: a fixed joint cannot follow"), "{said}");
    // Places of errors are those of the file, also behind the first element.
    let wrong = text.replace("<other:thing/>", "<other:thing></robot>");
    let said = refused("r.urdf", &wrong);
    assert!(said.contains("not well-formed XML") && said.contains("r.urdf:9:"), "{said}");
    let many: String = (0..40).map(|k| format!("<p{k}:x/>")).collect();
    let said = refused("r.urdf", &robot(&many, LINK));
    assert!(said.contains("are not declared") && said.contains("r.urdf:8:"), "{said}");
    let most: String = (0..32).map(|k| format!("<p{k}:x/>")).collect();
    let with_comment = robot(&most, LINK).replace("<!-- <robot> -->", "<!--> <robot> -->");
    convert("r.urdf", &with_comment);
}

/// An element with a prefix, declared or not, is none of the robot, whatever the rest of its name is.
#[test]
fn elements_with_a_prefix_are_not_of_the_robot() {
    let tail = "<foo:link name='c'/><foo:joint name='l' type='fixed'><parent link='a'/><child link='c'/></foo:joint>";
    let declared =
        robot(tail, LINK).replacen("<robot name='r'", "<robot name='r' xmlns:foo='x'", 1);
    for text in [robot(tail, LINK), declared] {
        // Nor is an attribute with a prefix.
        let text = text.replacen("type='continuous'", "foo:type='fixed' type='continuous'", 1);
        let imported = convert("r.urdf", &text);
        assert!(notes(&imported).contains("<foo:joint> has no counterpart"));
        let mechanism = model(&imported).mechanism;
        let names: Vec<&str> = mechanism.joints().iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!((names, mechanism.bodies().len()), (vec!["j", "k"], 3));
    }
}

#[test]
fn negative_moments_are_raised_or_refused() {
    let inertia = |xx: &str| LINK.replace("ixx='1'", &format!("ixx='{xx}'"));
    let with_size =
        |xx: &str| robot("", &inertia(xx)).replace("<axis", "<origin xyz='1 0 0'/><axis");
    let imported = convert("r.urdf", &with_size("-3e-9"));
    assert!(notes(&imported).contains("negative principal moment -3.00e-9 kg m²"));
    let mechanism = model(&imported).mechanism;
    let body = &mechanism.bodies()[2];
    assert!(body.principal_moments()[0] >= 0.0 && body.principal_moments()[2] == 1.0);
    // A size that no rounding explains does not matter beside the other masses of the robot.
    let small = LINK.replace("='1'", "='1e-12'").replace("ixx='1e-12'", "ixx='-1e-12'");
    let imported = convert("r.urdf", &robot("", &small));
    let said = notes(&imported);
    assert!(said.contains("-1.00e-12 kg m², which is negligible for this robot"), "{said}");
    let said = refused("r.urdf", &with_size("-0.02"));
    assert!(said.contains("r.urdf:5:") && said.contains("which no body has"), "{said}");
}

#[test]
fn parts_of_a_robot_are_named_as_such() {
    let said = refused("a.xml", "<mujocoinclude><body/></mujocoinclude>");
    assert!(said.contains("a part of an MJCF") && said.contains("<include>"), "{said}");
    let said = refused("a.xml", "<mujoco><default/></mujoco>");
    assert!(said.contains("no moving body"), "{said}");
}

/// Three joints of a planar body have its name in common.
#[test]
fn a_joint_and_its_body_have_different_names() {
    let text = "<mujoco><worldbody><body name='ball'><joint name='ball_x' type='slide' axis='1 0 0'/>
        <joint name='ball_z' type='slide' axis='0 0 1'/><joint name='ball_y' axis='0 1 0'/>
        <geom size='.1'/></body><body name='ball_'><joint name='h'/><geom size='.1'/></body></worldbody></mujoco>";
    let imported = convert("r.xml", text);
    let mechanism = model(&imported).mechanism;
    let planar = &mechanism.joints()[0];
    assert_eq!((planar.joint_type, planar.name.as_str()), (JointType::Planar, "ball_joint"));
}

#[test]
fn the_range_of_a_tendon_with_one_joint_is_that_of_the_joint() {
    let text = "<mujoco><worldbody><body name='a'><joint name='j' range='-90 20'/><geom size='.1'/>
        <body name='b'><joint name='k'/><geom size='.1'/></body></body></worldbody><tendon>
        <fixed name='s' range='-1 2'><joint joint='j' coef='-2'/></fixed>
        <fixed name='t' range='-1 2'><joint joint='j' coef='1'/><joint joint='k' coef='1'/></fixed>
        <fixed name='u' range='5 6'><joint joint='j' coef='1'/></fixed></tendon></mujoco>";
    let imported = convert("r.xml", text);
    let (lower, upper) = model(&imported).mechanism.joints()[0].ranges[0].limits;
    assert!((lower + 1.0).abs() < 1e-12 && (upper - 20_f64.to_radians()).abs() < 1e-12);
    assert!(
        notes(&imported).contains("r.xml:4: `range` of a tendon that couples joints is left out")
    );
}

/// Balls whose second body is nearer to the ground, or the ground itself.
#[test]
fn only_bodies_that_hang_on_a_joint_are_held() {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>\
             </inertial></link>"
        )
    };
    let sdf = format!(
        "<sdf version='1.9'><model name='m'>{}{}<joint name='h' type='revolute'><parent>world</parent><child>a</child>\
         <axis><xyz>0 0 1</xyz></axis></joint><joint name='s' type='ball'><parent>b</parent><child>a</child></joint>\
         </model></sdf>",
        link("a"),
        link("b")
    );
    let imported = convert("r.sdf", &sdf);
    assert!(!imported.text.contains("\"a.rv"), "{}", imported.text);
    assert!(imported.text.contains("\"b.rvx\""), "{}", imported.text);
    model(&imported);
    let ball =
        sdf.replace("<parent>b</parent><child>a</child>", "<parent>b</parent><child>world</child>");
    let imported = convert("r.sdf", &ball);
    assert!(!imported.text.contains("ground.rv"), "{}", imported.text);
    model(&imported);
}

/// A gearing in a table of the extension leaves one coordinate to hold.
#[test]
fn a_gearing_in_a_table_couples_like_a_loop() {
    let link = |name: &str| format!("<link name='{name}'>{LINK}</link>");
    let joint = |name: &str, child: &str, tail: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='base'/><child link='{child}'/><axis xyz='0 0 1'/>{tail}</joint>"
        )
    };
    let text = format!(
        "<robot name='r' xmlns:s='urn:stiction:1'><link name='base'/>{}{}{}{}\
         <s:gearing name='g'>joints = {{ j = 2, k = -1 }}</s:gearing><s:start name='j'>0.5</s:start></robot>",
        link("a"),
        link("b"),
        joint("j", "a", ""),
        joint("k", "b", "<mimic joint='j' multiplier='2'/>"),
    );
    let imported = convert("r.urdf", &text);
    let motion = imported.text.split("[motions.hold]").nth(1).unwrap();
    let held = motion.lines().filter(|line| line.starts_with("j =") || line.starts_with("k ="));
    assert_eq!(held.count(), 1, "{}", imported.text);
    model(&imported);
}

/// The friction of a joint is found by the name that the joint has after merging, before a body's name changes it.
#[test]
fn friction_of_a_renamed_joint_is_kept() {
    let text = "<mujoco><custom><text name='urn:stiction:1/friction/ball' data='mu = 0.1;;radius = 0.005'/></custom><worldbody><body name='ball'>
        <joint name='ball_x' axis='1 0 0'/><joint name='ball_y' axis='0 1 0'/><geom size='.1'/></body></worldbody></mujoco>";
    let imported = convert("r.xml", text);
    assert!(!notes(&imported).contains("there is no joint"), "{}", notes(&imported));
    let mechanism = model(&imported).mechanism;
    let joint = &mechanism.joints()[0];
    assert_eq!((joint.name.as_str(), joint.friction.is_empty()), ("ball_joint", false));
}

/// Tables of extension elements name joints and bodies as the file does, also where the model needs other names.
#[test]
fn tables_follow_renamed_joints_and_bodies() {
    let text = robot(
        "<s:spring xmlns:s='urn:stiction:1' name='coil'>joint = \"the hinge\"\nstiffness = \"3 N m/rad\"\nrest = 0</s:spring>
        <s:actuator xmlns:s='urn:stiction:1' name='m'>joint = \"the hinge\"</s:actuator>
        <s:spring xmlns:s='urn:stiction:1' name='rope'>from = \"ground\"\nat = [0, 0, 0]\nto = \"body a\"\nto_at = [0, 1, 0]
        stiffness = \"1 N/m\"\nfree_length = 0</s:spring>",
        LINK,
    );
    let text = text.replace("'j'", "'the hinge'").replace("'a'", "'body a'");
    let mechanism = model(&convert("r.urdf", &text)).mechanism;
    assert_eq!(mechanism.joints()[0].name, "the_hinge");

    // A universal joint beside a body of its name.
    let text = "<mujoco><custom><text name='urn:stiction:1/spring/coil' data='joint = \"uni.first\";;stiffness = \"3 N m/rad\";;rest = 0'/>
        <text name='urn:stiction:1/gearing/g' data='joints = { \"uni.first\" = 1, k = 2 }'/></custom><worldbody><body name='uni'>
        <joint name='uni_x' axis='1 0 0'/><joint name='uni_y' axis='0 1 0'/><geom size='.1'/><body name='v'><joint name='k'/>
        <geom size='.1' pos='1 0 0'/></body></body></worldbody></mujoco>";
    let imported = convert("r.xml", text);
    let mechanism = model(&imported).mechanism;
    assert_eq!(mechanism.joints()[0].name, "uni_joint", "{}", imported.text);
    assert!(imported.text.contains("joint = \"uni_joint.first\""), "{}", imported.text);
}
