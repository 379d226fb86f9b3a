//! The same robot in three formats, and the specific features of each format.

use super::tree::{Tree, convert, mobility, model, with_files};
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::spatial::Vec3;
use stiction_format::{Imported, ModelFile};

/// A four-bar in the xz plane: crank of 0.1 m at the origin, rocker of 0.12 m at x = 0.3 m, coupler
/// with its own frame at the crank's tip. In two of the formats, a ball joint closes the loop.
const URDF: &str = r#"<?xml version="1.0"?>
<robot name="bars">
  <link name="base"/>
  <link name="crank"><inertial><origin xyz="0.01 0 0.05" rpy="0.3 0 0"/><mass value="0.5"/>
    <inertia ixx="4e-4" iyy="5e-4" izz="2e-4" ixy="0" ixz="0" iyz="1e-5"/></inertial></link>
  <link name="coupler"><inertial><origin xyz="0.15 0 0"/><mass value="0.6"/>
    <inertia ixx="1e-4" iyy="5e-3" izz="5e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="rocker"><inertial><origin xyz="0 0 0.06"/><mass value="0.4"/>
    <inertia ixx="5e-4" iyy="5e-4" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="drive" type="revolute"><parent link="base"/><child link="crank"/>
    <axis xyz="0 -1 0"/><limit lower="-2" upper="2" effort="9" velocity="3"/>
    <dynamics damping="0.02"/></joint>
  <joint name="knee" type="continuous"><parent link="crank"/><child link="coupler"/>
    <origin xyz="0 0 0.1"/><axis xyz="0 -1 0"/></joint>
  <joint name="pivot" type="continuous"><parent link="base"/><child link="rocker"/>
    <origin xyz="0.3 0 0"/><axis xyz="0 -1 0"/></joint>
  <loop_joint name="tip" type="spherical">
    <link1 link="coupler" xyz="0.3 0 0.02" rpy="0 0 0"/><link1 link="rocker" xyz="0 0 0.12" rpy="0 0 0.4"/>
  </loop_joint>
  <transmission name="t"><joint name="drive"/><actuator name="motor">
    <mechanicalReduction>5</mechanicalReduction></actuator></transmission>
</robot>"#;

const MJCF: &str = r#"<mujoco model="bars">
  <compiler angle="degree" eulerseq="XYZ"/>
  <default><joint axis="0 -1 0"/><default class="light"><geom density="0"/></default></default>
  <worldbody>
    <body name="crank">
      <joint name="drive" range="-114.59155902616465 114.59155902616465" damping="0.02"/>
      <inertial pos="0.01 0 0.05" euler="17.188733853924695 0 0" mass="0.5" fullinertia="4e-4 5e-4 2e-4 0 0 1e-5"/>
      <frame pos="0 0 0.06"><frame pos="0 0 0.04">
        <body name="coupler"><joint name="knee"/>
          <inertial pos="0.15 0 0" mass="0.6" diaginertia="1e-4 5e-3 5e-3"/></body>
      </frame></frame>
    </body>
    <body name="rocker" pos="0.3 0 0"><joint name="pivot"/>
      <inertial pos="0 0 0.06" mass="0.4" diaginertia="5e-4 5e-4 1e-5"/></body>
  </worldbody>
  <equality><connect name="tip" body1="coupler" body2="rocker" anchor="0.3 0 0.02"/></equality>
  <actuator><motor name="motor" joint="drive" gear="5" ctrlrange="-1.8 1.8"/></actuator>
</mujoco>"#;

const SDF: &str = r#"<sdf version="1.7"><world name="w"><gravity>0 0 -9.81</gravity><model name="bars">
  <frame name="right" attached_to="base"><pose>0.3 0 0 0 0 0</pose></frame>
  <link name="base"/>
  <link name="crank"><inertial><pose>0.01 0 0.05 0.3 0 0</pose><mass>0.5</mass><inertia>
    <ixx>4e-4</ixx><iyy>5e-4</iyy><izz>2e-4</izz><iyz>1e-5</iyz></inertia></inertial></link>
  <link name="coupler"><pose relative_to="crank">0 0 0.1 0 0 0</pose><inertial><pose>0.15 0 0 0 0 0</pose>
    <mass>0.6</mass><inertia><ixx>1e-4</ixx><iyy>5e-3</iyy><izz>5e-3</izz></inertia></inertial></link>
  <link name="rocker"><pose relative_to="right"/><inertial><pose>0 0 0.06 0 0 0</pose><mass>0.4</mass>
    <inertia><ixx>5e-4</ixx><iyy>5e-4</iyy><izz>1e-5</izz></inertia></inertial></link>
  <joint name="mount" type="fixed"><parent>world</parent><child>base</child></joint>
  <joint name="drive" type="revolute"><parent>base</parent><child>crank</child><axis><xyz>0 -1 0</xyz>
    <limit><lower>-2</lower><upper>2</upper><effort>9</effort></limit><dynamics><damping>0.02</damping></dynamics></axis></joint>
  <joint name="knee" type="revolute"><parent>crank</parent><child>coupler</child><axis><xyz>0 -1 0</xyz></axis></joint>
  <joint name="pivot" type="revolute"><parent>right</parent><child>rocker</child><axis><xyz>0 -1 0</xyz></axis></joint>
  <joint name="tip" type="revolute"><pose relative_to="rocker">0 0 0.12 0 0 0</pose><parent>rocker</parent>
    <child>coupler</child><axis><xyz expressed_in="__model__">0 -1 0</xyz></axis></joint>
</model></world></sdf>"#;

fn joint(mechanism: &Mechanism, name: &str) -> JointId {
    JointId(mechanism.joints().iter().position(|joint| joint.name == name).unwrap())
}

/// Effort of the crank's motor at an angle, with its rate and acceleration.
fn effort(model: &ModelFile, [value, rate, acceleration]: [f64; 3]) -> f64 {
    let mechanism = model.mechanism.clone();
    let coordinate = Coordinate::Joint { joint: joint(&mechanism, "drive"), dof: 0 };
    let target = Target { value, rate, acceleration };
    let settings = Settings { friction: FrictionMode::Off, ..Settings::default() };
    let mut solver =
        InverseDynamics::new(mechanism, &model.initial_poses, &[coordinate], &[target], settings)
            .unwrap();
    solver.solve(&[]).unwrap().efforts[0]
}

#[test]
fn one_robot_is_the_same_from_three_formats() {
    let imports: [Imported; 3] =
        [convert("bars.urdf", URDF), convert("bars.xml", MJCF), convert("bars.sdf", SDF)];
    let models: Vec<ModelFile> = imports.iter().map(model).collect();
    let motions = [[0.0, 0.0, 0.0], [0.4, 1.5, -3.0], [-0.7, -0.2, 8.0]];
    let expected: Vec<f64> = motions.iter().map(|motion| effort(&models[0], *motion)).collect();
    assert!(expected.iter().all(|effort| effort.abs() > 1e-3), "{expected:?}");
    for (model, import) in models.iter().zip(&imports) {
        assert_eq!(mobility(model), 1);
        let tip = &model.mechanism.joints()[joint(&model.mechanism, "tip").0];
        assert_eq!(tip.joint_type, JointType::Revolute, "{}", import.text);
        for (motion, expected) in motions.iter().zip(&expected) {
            let found = effort(model, *motion);
            // Numbers of order 1, formed in different orders; degrees are rounded once more.
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        // SDF assigns a default inertia to links without one, which is correctly reported as
        // suspicious.
        let doubts: Vec<String> =
            model.warnings.iter().map(|warning| warning.to_json()["message"].to_string()).collect();
        let by_sdf = |doubt: &String| doubt.contains("the inertia of body `base`");
        let expected = usize::from(import.text.contains("links without <inertial>"));
        assert!(
            doubts.len() == expected && doubts.iter().all(by_sdf),
            "{doubts:?}\n{}",
            import.text
        );
    }
    let trains: Vec<f64> =
        models[..2].iter().map(|model| model.mechanism.drive_trains()[0].ratio).collect();
    assert_eq!(trains, [5.0, 5.0]);
    let peaks: Vec<f64> = models
        .iter()
        .map(|model| {
            let train = &model.mechanism.drive_trains()[0];
            train.limits.peak.unwrap() * train.transmission()
        })
        .collect();
    assert!(peaks.iter().all(|peak| (peak - 9.0).abs() < 1e-12), "{peaks:?}");
    for model in &models {
        let drive = &model.mechanism.joints()[joint(&model.mechanism, "drive").0];
        let (least, greatest) = drive.ranges[0].limits;
        assert!((least + 2.0).abs() < 1e-12 && (greatest - 2.0).abs() < 1e-12);
        let interface = &drive.friction[0];
        let damping = interface.law.viscous * interface.radius.unwrap().powi(2);
        assert!((damping - 0.02).abs() < 1e-15);
    }
}

/// A hinge instead of the ball joint changes neither efforts nor statically determined reactions.
#[test]
fn literal_closures_give_the_same_efforts() {
    for (name, text) in [("bars.urdf", URDF), ("bars.xml", MJCF)] {
        let (understood, literal) = (convert(name, text), with_files(name, text, &[], true));
        let (understood, literal) = (model(&understood), model(&literal));
        let tip = joint(&literal.mechanism, "tip").0;
        assert_eq!(literal.mechanism.joints()[tip].joint_type, JointType::Spherical);
        assert_eq!((mobility(&understood), mobility(&literal)), (1, 1));
        for motion in [[0.1, 0.0, 0.0], [-0.5, 2.0, 1.0]] {
            let difference = effort(&understood, motion) - effort(&literal, motion);
            assert!(difference.abs() < 1e-12, "{difference:e}");
        }
    }
}

#[test]
fn mjcf_joints_keyframes_and_classes() {
    let text = r#"<mujoco model="m">
      <compiler angle="radian" inertiafromgeom="auto"/>
      <include file="parts.xml"/>
      <worldbody>
        <body name="a" childclass="heavy" pos="0 0 1">
          <joint name="lift" type="slide" axis="0 0 2" ref="0.1"/>
          <joint name="turn" axis="0 1 0" pos="0.2 0 0" ref="0.5" armature="0.003" frictionloss="0.4"/>
          <geom type="sphere" size="0.1"/>
          <geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.05" mass="2"/>
          <site name="s1" pos="0.1 0 0"/>
          <body name="b" pos="0 0 0.4"><joint name="ball" type="ball"/>
            <geom class="thin" size="0.1 0.2 0.3"/></body>
        </body>
        <site name="s0" pos="0.1 0 0"/>
      </worldbody>
      <tendon><spatial name="spring" stiffness="100" damping="2"><site site="s0"/><site site="s1"/></spatial></tendon>
      <actuator><position joint="turn" kp="10" forcerange="-3 4"/></actuator>
      <keyframe><key name="home" qpos="0.3 0.9 1 0 0 0"/></keyframe>
    </mujoco>"#;
    let parts = r#"<mujocoinclude><default><default class="heavy"><geom density="2000"/>
      <default class="thin"><geom type="box" density="100"/></default></default></default></mujocoinclude>"#;
    let imported = with_files("m.xml", text, &[("parts.xml", parts)], false);
    let model = model(&imported);
    let mechanism = &model.mechanism;
    let body = |name: &str| mechanism.bodies().iter().find(|body| body.name == name).unwrap();
    let sphere = 2000.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-3;
    assert!((body("a").mass - sphere - 2.0).abs() < 1e-12);
    assert!((body("a").com.z - 2.0 * 0.2 / (sphere + 2.0)).abs() < 1e-12);
    assert!((body("b").mass - 100.0 * 8.0 * 0.006).abs() < 1e-12);
    let tree = Tree::new(mechanism, &["lift", "turn"], &[0.1, 0.5]);
    let of = |name: &str| mechanism.bodies().iter().position(|body| body.name == name).unwrap();
    let pose = tree.poses[of("a")];
    // The file is in the configuration of the reference values.
    assert!((pose.position + -Vec3::new(0.0, 0.0, 1.0)).norm() < 1e-15);
    let moved = Tree::new(mechanism, &["lift", "turn"], &[0.3, 0.9]).poses[of("a")];
    let (s, c) = 0.4_f64.sin_cos();
    let expected = Vec3::new(0.2 - 0.2 * c, 0.0, 1.2 + 0.2 * s);
    assert!((moved.position + -expected).norm() < 1e-15, "{:?}", moved.position);
    let start = |name: &str| mechanism.joints()[joint(mechanism, name).0].start.clone().unwrap();
    assert!((start("turn")[0] - 0.9).abs() < 1e-9 && (start("lift")[0] - 0.3).abs() < 1e-9);
    let train = &mechanism.drive_trains()[0];
    assert_eq!((train.rotor_inertia, train.motor_friction.constant), (0.003, 0.4));
    assert_eq!(train.limits.peak, Some(4.0));
    let spring = &mechanism.springs()[0];
    assert_eq!((spring.stiffness, spring.damping), (100.0, 2.0));
    // The spring is relaxed in the file's configuration, between (0.1, 0, 0) and (0.1, 0, 1).
    assert!((spring.free_length - 1.0).abs() < 1e-15);
    let lines: Vec<String> = imported.notes.iter().map(|note| note.line()).collect();
    assert!(lines.iter().any(|line| line.contains("keyframe `home`")), "{lines:#?}");
    assert!(lines.iter().any(|line| line.contains("m.xml:17: control laws")), "{lines:#?}");
}

#[test]
fn sdf_frames_models_and_types() {
    let text = r#"<sdf version="1.8"><model name="m">
      <pose>1 0 0 0 0 1.5707963267948966</pose>
      <link name="base"><inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
      <joint name="hold" type="fixed"><parent>world</parent><child>base</child></joint>
      <model name="arm"><pose relative_to="base">0 2 0 0 0 0</pose>
        <link name="l1"><pose>0 0 0.5 0 0 0</pose><inertial><mass>1</mass></inertial></link>
        <link name="l2"><pose relative_to="l1">0 0 0.5 0 0 0</pose></link>
        <joint name="screw" type="screw"><parent>l1</parent><child>l2</child><axis><xyz>0 0 1</xyz></axis>
          <screw_thread_pitch>0.01</screw_thread_pitch></joint>
      </model>
      <joint name="cardan" type="universal"><parent>base</parent><child>arm::l1</child>
        <axis><xyz>1 0 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis><axis2><xyz>0 1 0</xyz></axis2></joint>
    </model></sdf>"#;
    let imported = convert("m.sdf", text);
    let model = model(&imported);
    let mechanism = &model.mechanism;
    let names: Vec<&str> = mechanism.bodies().iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["ground", "base", "arm.l1", "arm.l2"]);
    let cardan = &mechanism.joints()[joint(mechanism, "cardan").0];
    assert_eq!(cardan.joint_type, JointType::Universal);
    assert_eq!(cardan.ranges.len(), 1);
    let screw = &mechanism.joints()[joint(mechanism, "arm.screw").0];
    assert!((screw.pitch - 0.01 / std::f64::consts::TAU).abs() < 1e-18);
    // The model is rotated: two metres along its y axis are two metres along -x of the world.
    let cross = cardan.frame_j.position;
    let base = &mechanism.joints()[joint(mechanism, "hold").0];
    let point = base.frame_j.apply(base.frame_k.inverse().apply(cross));
    assert!((point + -Vec3::new(-1.0, 0.0, 0.5)).norm() < 1e-15, "{point:?}");
    let lines: Vec<String> = imported.notes.iter().map(|note| note.line()).collect();
    assert!(lines.iter().any(|line| line.contains("without <inertial>")), "{lines:#?}");
}

/// Models nested in a merged model are placed in the frame of that model, not in that of the model around it.
#[test]
fn models_nested_in_a_merged_model_are_placed_in_it() {
    let part = "<sdf version='1.9'><model name='part' placement_frame='tip'><pose>5 6 7 0 0 0</pose>
        <link name='a'/><frame name='tip'><pose>1 0 0 0 0 0</pose></frame>
        <model name='m'><pose>0 2 0 0 0 0</pose><link name='b'/></model>
        <model name='n'><pose relative_to='__model__'>0 3 0 0 0 0</pose><link name='c'/></model></model></sdf>";
    let joint = |name: &str, kind: &str, from: &str, to: &str| {
        format!(
            "<joint name='{name}' type='{kind}'><parent>{from}</parent><child>{to}</child></joint>"
        )
    };
    let text = format!(
        "<sdf version='1.9'><model name='top'><pose>0 0 10 0 0 0</pose><include merge='true'><uri>part.sdf</uri>
        <pose degrees='true'>0 0 1 0 0 90</pose></include>{}{}{}</model></sdf>",
        joint("j", "revolute", "world", "a"),
        joint("k", "fixed", "a", "m::b"),
        joint("l", "fixed", "a", "n::c")
    );
    let imported = with_files("top.sdf", &text, &[("part.sdf", part)], true);
    let mechanism = model(&imported).mechanism;
    let tree = Tree::new(&mechanism, &["j"], &[0.0]);
    // The pose of the include is that of the frame `tip`.
    for (name, expected) in
        [("a", [0.0, -1.0, 11.0]), ("b", [-2.0, -1.0, 11.0]), ("c", [-3.0, -1.0, 11.0])]
    {
        let body = mechanism.bodies().iter().position(|body| body.name.ends_with(name)).unwrap();
        let error = (tree.poses[body].position + -Vec3::from(expected)).norm();
        assert!(error < 1e-14, "{name}: {:?}", tree.poses[body].position);
    }
}

/// The time does not double with each level of nested models with placement frames.
#[test]
fn placement_frames_may_be_nested() {
    const DEPTH: usize = 40;
    let below = |level: usize| -> String {
        (level + 1..DEPTH).map(|level| format!("m{level}::")).collect()
    };
    let mut text = "<link name='a'/><frame name='tip'><pose>1 0 0 0 0 0</pose></frame>".to_owned();
    for level in (0..DEPTH).rev() {
        if level == 0 {
            text += &format!(
                "<joint name='j' type='revolute'><parent>world</parent><child>{}a</child></joint>",
                below(level)
            );
        }
        let frame = below(level) + "tip";
        text = format!("<model name='m{level}' placement_frame='{frame}'>{text}</model>");
    }
    let imported = convert("m.sdf", &format!("<sdf version='1.11'>{text}</sdf>"));
    let mechanism = model(&imported).mechanism;
    // All models place the same frame at the origin.
    let tree = Tree::new(&mechanism, &["j"], &[0.0]);
    let error = (tree.poses[1].position + Vec3::new(1.0, 0.0, 0.0)).norm();
    assert!(error < 1e-12, "{:?}", tree.poses[1].position);
}

#[test]
fn what_floats_is_said() {
    let text = "<sdf version='1.11'><model name='m'><link name='a'><pose>0 0 1 0 0 0</pose></link></model></sdf>";
    let imported = convert("m.sdf", text);
    let model = model(&imported);
    assert_eq!(model.mechanism.joints()[0].joint_type, JointType::Free);
    assert_eq!(mobility(&model), 6);
    assert!(imported.notes.iter().any(|note| note.message.contains("it floats")));
}

/// Notes list omitted content, and worlds with scenery are accepted.
#[test]
fn what_is_left_out_is_listed() {
    let mjcf = "<mujoco><worldbody><body name='a' gravcomp='1'>
        <joint name='j' axis='0 1 0' stiffness='5' springdamper='0.2 1' actuatorfrcrange='-3 3'/>
        <geom type='box' size='.1 .02 .02' pos='.1 0 0'/></body></worldbody>
        <actuator><motor joint='j' forcerange='-1 3'/></actuator></mujoco>";
    let imported = convert("r.xml", mjcf);
    let notes: Vec<String> = imported.notes.iter().map(|note| note.line()).collect();
    for word in ["gravcomp", "springdamper", "actuatorfrcrange", "`forcerange` is not symmetric"] {
        assert!(notes.iter().any(|note| note.contains(word)), "{word}: {notes:?}");
    }
    // A spring without a reference is relaxed at zero.
    let _: ModelFile = model(&imported);
    assert!(imported.text.contains("rest = 0\n"), "{}", imported.text);

    let link = "<link name='a'><inertial><pose>0.1 0 0 0 0 0</pose><mass>1</mass>
        <inertia><ixx>0.01</ixx><iyy>0.02</iyy><izz>0.015</izz></inertia></inertial></link>";
    let sdf = format!(
        "<sdf version='1.6'><world name='w'><include><uri>model://sun</uri></include>
         <include><uri>model://ground_plane</uri></include><model name='m'>{link}
         <joint name='j' type='revolute'><parent>world</parent><child>a</child><axis><xyz>0 1 0</xyz></axis></joint>
         </model></world></sdf>"
    );
    let imported = convert("r.sdf", &sdf);
    let notes: Vec<String> = imported.notes.iter().map(|note| note.line()).collect();
    for name in ["sun", "ground_plane"] {
        assert!(notes.iter().any(|note| note.contains(name)), "{name}: {notes:?}");
    }
    assert!(imported.text.contains("[joints.j]"), "{}", imported.text);
}
