//! Peculiarities of robot files in published packages, which the programs for these files accept.

use super::tree::{convert, mobility, model, refused, with_files};
use stiction_core::joint::JointType;
use stiction_core::spatial::Vec3;

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
    // Places of errors are correct, also behind the first element.
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

/// An element with a prefix, declared or not, is not part of the robot, whatever its local name is.
#[test]
fn elements_with_a_prefix_are_not_of_the_robot() {
    let tail = "<foo:link name='c'/><foo:joint name='l' type='fixed'><parent link='a'/><child link='c'/></foo:joint>";
    let declared =
        robot(tail, LINK).replacen("<robot name='r'", "<robot name='r' xmlns:foo='x'", 1);
    for text in [robot(tail, LINK), declared] {
        // An attribute with a prefix is ignored, too.
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
    // A negative moment beyond rounding errors is negligible beside the other masses of the robot.
    let small = LINK.replace("='1'", "='1e-12'").replace("ixx='1e-12'", "ixx='-1e-12'");
    let imported = convert("r.urdf", &robot("", &small));
    let said = notes(&imported);
    assert!(said.contains("-1.00e-12 kg m², which is negligible for this robot"), "{said}");
    let said = refused("r.urdf", &with_size("-0.02"));
    assert!(said.contains("r.urdf:5:") && said.contains("physically impossible"), "{said}");
}

#[test]
fn parts_of_a_robot_are_named_as_such() {
    let said = refused("a.xml", "<mujocoinclude><body/></mujocoinclude>");
    assert!(said.contains("a part of an MJCF") && said.contains("<include>"), "{said}");
    let said = refused("a.xml", "<mujoco><default/></mujoco>");
    assert!(said.contains("no moving body"), "{said}");
}

/// Three joints of a planar body are merged to one joint, whose name would be that of the body.
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

/// Ball joints whose second body is nearer to the ground, or is the ground itself.
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

/// A gearing in an extension element leaves one coordinate to be fixed.
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

/// Friction of a joint is assigned by the joint's name after merging, before the joint is renamed
/// because a body has the same name.
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

/// Tables in extension elements refer to joints and bodies by the names in the file, also if the
/// model needs other names.
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

    // A universal joint and a body have the same name.
    let text = "<mujoco><custom><text name='urn:stiction:1/spring/coil' data='joint = \"uni.first\";;stiffness = \"3 N m/rad\";;rest = 0'/>
        <text name='urn:stiction:1/gearing/g' data='joints = { \"uni.first\" = 1, k = 2 }'/></custom><worldbody><body name='uni'>
        <joint name='uni_x' axis='1 0 0'/><joint name='uni_y' axis='0 1 0'/><geom size='.1'/><body name='v'><joint name='k'/>
        <geom size='.1' pos='1 0 0'/></body></body></worldbody></mujoco>";
    let imported = convert("r.xml", text);
    let mechanism = model(&imported).mechanism;
    assert_eq!(mechanism.joints()[0].name, "uni_joint", "{}", imported.text);
    assert!(imported.text.contains("joint = \"uni_joint.first\""), "{}", imported.text);
}

/// Since SDFormat 1.10, a world may have joints and frames of its own.
#[test]
fn joints_of_the_world_connect_models() {
    let inertial = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>";
    let part = format!(
        "<sdf version='1.9'><model name='part'><pose>.1 0 0 0 0 0</pose><link name='a'>{inertial}</link>
        <link name='b'><pose>0 0 .3 0 0 0</pose>{inertial}</link><joint name='j' type='revolute'><parent>a</parent>
        <child>b</child><axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"
    );
    let world = |models: &str, joints: &str| {
        let text = format!("<sdf version='1.10'><world name='w'>{models}\n{joints}</world></sdf>");
        with_files("r.sdf", &text, &[("model://part/model.sdf", &part)], false)
    };
    let include = |name: &str, pose: &str| {
        format!("<include><uri>model://part</uri><name>{name}</name><pose>{pose}</pose></include>")
    };
    let both = include("A", "0 0 0 0 0 0") + &include("B", "0 0 2 0 0 0");
    let imported = world(
        &both,
        "<frame name='top'><pose>0 0 1 0 0 0</pose></frame>
        <joint name='x' type='revolute'><pose relative_to='top'/><parent>A::b</parent><child>B::a</child>
        <axis><xyz expressed_in='__model__'>0 1 0</xyz></axis></joint>
        <joint name='y' type='fixed'><parent>world</parent><child>A</child></joint>",
    );
    let said = notes(&imported);
    assert!(!said.contains("floats"), "{said}");
    let read = model(&imported);
    let joints = read.mechanism.joints();
    let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["x", "y", "A.j", "B.j"]);
    assert_eq!(joints[0].frame_j.position, Vec3::new(0.0, 0.0, 0.7));
    assert_eq!(mobility(&read), 3);
    // A joint of the world can also refer to a single model.
    let one = world(
        &include("A", "0 0 0 0 0 0"),
        "<joint name='y' type='fixed'><parent>world</parent><child>A::a</child></joint>",
    );
    assert_eq!(mobility(&model(&one)), 1, "{}", one.text);
}

/// Every element and attribute that a reader does not know is reported with its line. Elements and
/// attributes with default values or without significance are not reported.
#[test]
fn nothing_is_left_out_in_silence() {
    let mjcf = "<mujoco><compiler alignfree='true' usethread='false'/><option timestep='1e-3' density='1.2' viscosity='0'
        wind='1 0 0'><flag actuation='disable' contact='disable'/></option>
        <worldbody><body name='a'><joint name='j' axis='0 1 0' margin='.1' actuatorgravcomp='false' armature='2'/>
        <geom size='.1' fluidshape='ellipsoid' rgba='1 0 0 1'/><light/></body></worldbody>
        <tendon><spatial range='0 1'/></tendon><sensor/><contact/>
        <actuator><general joint='j' biastype='affine' gainprm='5' biasprm='0 -5 -1'/></actuator>
        <keyframe><key qpos='0' qvel='1'/></keyframe></mujoco>";
    let imported = convert("r.xml", mjcf);
    let said = notes(&imported);
    for expected in [
        "r.xml:1: `alignfree` of <compiler> is not read",
        "r.xml:1: `density` of <option>",
        "r.xml:2: `wind` of <option>",
        "r.xml:2: `actuation` of <flag>",
        "r.xml:3: `margin` of <joint>",
        "r.xml:4: `fluidshape` of <geom>",
        "r.xml:5: `range` of <spatial>",
        "r.xml:5: <sensor> has no counterpart",
        "r.xml:6: control laws of actuators are left out",
        "r.xml:7: `qvel` of <key>",
    ] {
        assert!(said.contains(expected), "{expected}\n{said}");
    }
    for other in ["viscosity", "usethread", "timestep", "actuatorgravcomp", "rgba", "light"] {
        assert!(!said.contains(other), "{other}\n{said}");
    }
    let link = "<link name='a'><kinematic>true</kinematic><velocity_decay/><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy>
        <izz>1</izz></inertia></inertial><visual name='v'><geometry><box/></geometry></visual></link>";
    let sdf = format!(
        "<sdf version='1.9'><world name='w'><state world_name='w'/><physics type='x'/><model name='m'>{link}
        <joint name='j' type='revolute'><parent>world</parent><child>a</child><axis><xyz>0 0 1</xyz><initial_position>0.5</initial_position>
        <limit><effort>3</effort><stiffness>3</stiffness></limit></axis><physics/></joint>
        <model name='n'>{}</model></model></world></sdf>",
        link.replace("kinematic>true", "kinematic>false").replace("'a'", "'b'")
    );
    let imported = convert("r.sdf", &sdf);
    let said = notes(&imported);
    for expected in [
        "r.sdf:1: <state> has no counterpart",
        "r.sdf:1: <kinematic> has no counterpart",
        "r.sdf:1, 5: <velocity_decay> has no counterpart",
        "r.sdf:4: <stiffness> has no counterpart",
        "r.sdf:4: <physics> has no counterpart",
    ] {
        assert!(said.contains(expected), "{expected}\n{said}");
    }
    // The coordinate is the initial value of the joint.
    assert!(imported.text.contains("\nj = \"28.64788976 deg\"\n"), "{}", imported.text);
    let urdf = robot("", LINK)
        .replace("<axis", "<limit effort='1' velocity='2' jerk='3'/><safety_controller/><axis")
        .replace("<inertial>", "<self_collision_checking/><inertial>");
    let said = notes(&convert("r.urdf", &urdf));
    for expected in
        ["`jerk` of <limit>", "<safety_controller> has", "<self_collision_checking> has"]
    {
        assert!(said.contains(expected), "{expected}\n{said}");
    }
}

#[test]
fn flags_disable_parts_of_the_mechanics() {
    let text = |flags: &str| {
        format!(
            "<mujoco><option gravity='0 0 -5'><flag {flags}/></option><option timestep='1e-3'/><worldbody><body name='a'>
            <joint name='j' axis='0 1 0' damping='2' stiffness='3' frictionloss='4' range='-10 10'/><geom size='.1' pos='.1 0 0'/>
            </body><body name='b'><joint name='k' axis='0 1 0'/><geom size='.1' pos='0 0 .1'/></body></worldbody>
            <equality><joint joint1='j' joint2='k'/></equality></mujoco>"
        )
    };
    let disabled = text(
        "gravity='disable' equality='disable' damper='disable' spring='disable' limit='disable' frictionloss='disable'",
    );
    let imported = convert("r.xml", &disabled);
    let said = notes(&imported);
    assert!(said.contains("r.xml:1: the file disables `equality`"), "{said}");
    let read = model(&imported);
    assert_eq!(mobility(&read), 2);
    assert_eq!(read.mechanism.gravity(), Vec3::zero());
    for word in ["stiffness", "damping", "range", "friction", "gearings"] {
        assert!(!imported.text.contains(&format!("{word} =")), "{}", imported.text);
    }
    for flags in ["constraint='disable' passive='disable'", "contact='disable'"] {
        let read = model(&convert("r.xml", &text(flags)));
        let is_free = flags.starts_with("constraint");
        assert_eq!(mobility(&read), 1 + usize::from(is_free));
        assert_eq!(read.mechanism.joint_springs().is_empty(), is_free);
        assert_eq!(read.mechanism.gravity(), Vec3::new(0.0, 0.0, -5.0));
    }
}

/// A wrong package folder is reported, also if the meshes are only shown.
#[test]
fn missing_meshes_are_named() {
    let shapes = "<visual><geometry><mesh filename='package://foo/m.dae'/></geometry></visual>
        <visual><geometry><mesh filename='package://foo/n.stl'/></geometry></visual>
        <visual><geometry><mesh filename='here.dae'/></geometry></visual>
        <collision><geometry><mesh filename='package://foo/o.stl'/></geometry></collision></link><link name='b'>";
    let text = robot("", LINK).replace("</link>\n<link name='b'>", shapes);
    let imported = with_files("r.urdf", &text, &[("here.dae", "")], false);
    let said = notes(&imported);
    for name in ["package://foo/m.dae", "package://foo/n.stl", "package://foo/o.stl"] {
        assert!(said.contains(&format!("`{name}`")), "{said}");
    }
    assert!(said.contains("--package-path") && said.contains("only meshes in STL"), "{said}");
    let mjcf = "<mujoco><asset><mesh name='q' file='nope.stl'/></asset><worldbody><body name='a'><joint/>
        <geom type='mesh' mesh='q' group='3'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody></mujoco>";
    let said = notes(&convert("r.xml", mjcf));
    assert!(
        said.contains("r.xml:2: mesh files that cannot be read") && said.contains("`nope.stl`")
    );
}

/// Masses of shapes in SDF.
#[test]
fn masses_of_meshes_in_sdf_are_those_of_the_solid() {
    let text = |shape: &str| {
        format!(
            "<sdf version='1.11'><model name='m'><link name='a'><inertial auto='true'><density>2</density></inertial>
            <collision name='c'><geometry>{shape}</geometry></collision></link><joint name='j' type='revolute'>
            <parent>world</parent><child>a</child><axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"
        )
    };
    let mesh = text("<mesh><uri>model://m/t.obj</uri><scale>2 3 4</scale></mesh>");
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let imported = with_files("r.sdf", &mesh, &[("model://m/t.obj", tetrahedron)], false);
    let mass = model(&imported).mechanism.bodies()[1].mass;
    // Density times the product of the edges divided by 6.
    assert!((mass - 2.0 * 24.0 / 6.0).abs() < 1e-12, "{mass}");
    for (shape, why) in [
        ("<mesh><uri>model://m/t.obj</uri></mesh>", "`model://m/t.obj` is unknown"),
        ("<heightmap/>", "`heightmap` is not computed"),
    ] {
        let said = refused("r.sdf", &text(shape));
        assert!(said.contains(why) && said.contains("r.sdf:2:"), "{said}");
    }
}

/// A given mass scales the mass and inertia of the shapes, as in libsdformat from version 15.2.
#[test]
fn a_given_mass_is_distributed_over_the_shapes() {
    let text = |inertial: &str, shapes: &str| {
        format!(
            "<sdf version='1.11'><model name='m'><link name='a'>{inertial}\n{shapes}</link>
            <joint name='j' type='revolute'><parent>world</parent><child>a</child></joint></model></sdf>"
        )
    };
    let cubes = "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>
        <collision name='d'><density>4</density><pose>1 0 0 0 0 0</pose>
        <geometry><box><size>1 1 1</size></box></geometry></collision>";
    let inertial = "<inertial auto='true'><mass>3</mass><density>2</density><pose>9 9 9 0 0 0</pose></inertial>";
    let imported = convert("r.sdf", &text(inertial, cubes));
    assert!(
        notes(&imported).contains("r.sdf:1: <pose> of an <inertial auto"),
        "{}",
        notes(&imported)
    );
    let mechanism = model(&imported).mechanism;
    let body = &mechanism.bodies()[1];
    // Half of a cube of 2 kg and one of 4 kg, whose centres are 1 m apart.
    assert!((body.mass - 3.0).abs() < 1e-15 && (body.com.x - 2.0 / 3.0).abs() < 1e-15, "{body:?}");
    for (k, moment) in [(0, 1.0), (1, 1.0 + 8.0 / 6.0)] {
        assert!((body.inertia.at(k, k) - 0.5 * moment).abs() < 1e-15, "{body:?}");
    }
    let said = refused("r.sdf", &text(inertial, ""));
    assert!(said.contains("link `a` has <inertial auto=\"true\"> but no <collision>"), "{said}");
    assert_eq!(said.matches("error").count(), 1, "{said}");
    // Without a mass of the shapes, the distribution of the given mass is unknown.
    let hollow = |density: &str| {
        format!(
            "<collision name='c'><density>{density}</density><geometry><box><size>1 1 1</size></box></geometry></collision>"
        )
    };
    for density in ["0", "-1"] {
        let said = refused("r.sdf", &text(inertial, &hollow(density)));
        let why = format!(
            "the mass of link `a`, 3 kg, cannot be distributed over its collision shapes: their sizes and densities give \
             {density} kg"
        );
        assert!(said.contains(&why) && said.contains("write the numbers in <inertial>"), "{said}");
    }
}

/// Exports to MJCF divide a body at a closure other than a ball joint; when read again, it is one
/// body.
#[test]
fn parts_of_a_divided_body_are_joined() {
    let text = "<mujoco><worldbody><body name='a'><joint name='j' axis='0 1 0'/>
        <inertial pos='.5 0 0' mass='1' diaginertia='.1 .2 .3'/><site name='one' pos='1 0 0'/></body>
        <body name='a@k' pos='1 0 0'><joint name='k' axis='0 1 0'/><inertial pos='-.5 0 0' mass='1' diaginertia='.1 .2 .3'/>
        <site name='two'/></body></worldbody><equality><weld name='k.weld' site1='one' site2='two'/></equality></mujoco>";
    let mechanism = model(&convert("r.xml", text)).mechanism;
    let [_, body] = mechanism.bodies() else { panic!("{} bodies", mechanism.bodies().len()) };
    assert_eq!((body.mass, body.com), (2.0, Vec3::new(0.5, 0.0, 0.0)));
    assert!((body.inertia.at(1, 1) - 0.4).abs() < 1e-15);
    let joints: Vec<&str> = mechanism.joints().iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(joints, ["j", "k"]);
    assert_eq!(mechanism.joints()[1].frame_k.position, Vec3::new(1.0, 0.0, 0.0));
}
