//! Couplings of joints, and motors of several joints, in all formats.

use super::tree::{convert, mobility, model};
use stiction_core::mechanism::Mechanism;
use stiction_format::{Imported, ModelFile};

const INERTIAL: &str = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>";

/// Text of an SDF link.
fn sdf_link(name: &str) -> String {
    format!(
        "<link name='{name}'><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>"
    )
}

/// Coefficients of a gearing by joint, and its constant, all divided by the coefficient of `first`.
fn gearing(mechanism: &Mechanism, first: &str) -> (Vec<(String, f64)>, f64) {
    let [gearing] = mechanism.gearings() else { panic!("{:?}", mechanism.gearings()) };
    let name = |joint: usize| mechanism.joints()[joint].name.clone();
    let terms: Vec<(String, f64)> =
        gearing.dofs.iter().map(|dof| (name(dof.joint.0), dof.coefficient)).collect();
    let scale = terms.iter().find(|(joint, _)| joint == first).unwrap().1;
    let terms = terms.into_iter().map(|(joint, factor)| (joint, factor / scale)).collect();
    (terms, gearing.offset / scale)
}

fn notes(imported: &Imported) -> String {
    imported.notes.iter().map(|note| note.line()).collect::<Vec<_>>().join("\n")
}

/// A prismatic joint follows a hinge with 20 mm/rad and has the offset 5 mm, in three formats.
#[test]
fn a_mimic_is_a_gearing() {
    let urdf = format!(
        "<robot name='r'><link name='base'/><link name='a'>{INERTIAL}</link><link name='b'>{INERTIAL}</link>
         <joint name='turn' type='continuous'><parent link='base'/><child link='a'/></joint>
         <joint name='push' type='prismatic'><parent link='base'/><child link='b'/>
         <limit lower='-1' upper='1' effort='3' velocity='1'/><mimic joint='turn' multiplier='0.02' offset='0.005'/></joint></robot>"
    );
    // MuJoCo couples deviations from the reference coordinates.
    let mjcf = "<mujoco><compiler angle='radian'/><worldbody>
         <body name='a'><joint name='turn' ref='0.5'/><geom size='0.1'/></body>
         <body name='b'><joint name='push' type='slide' ref='0.01'/><geom size='0.1'/></body></worldbody>
         <equality><joint joint1='push' joint2='turn' polycoef='0.005 0.02 0 0 0'/></equality></mujoco>";
    let sdf = format!(
        "<sdf version='1.11'><model name='m'>{}{}
         <joint name='turn' type='revolute'><parent>world</parent><child>a</child>
         <axis><xyz>0 0 1</xyz><initial_position>0.3</initial_position></axis></joint>
         <joint name='push' type='prismatic'><parent>world</parent><child>b</child><axis><xyz>0 0 1</xyz>
         <mimic joint='turn'><multiplier>0.02</multiplier><offset>0.005</offset><reference>0.1</reference></mimic></axis></joint></model></sdf>",
        sdf_link("a"),
        sdf_link("b")
    );
    let offsets = [0.005, 0.005 + 0.01 - 0.02 * 0.5, 0.005 - 0.02 * 0.1];
    for ((name, text), offset) in
        [("r.urdf", urdf.as_str()), ("r.xml", mjcf), ("r.sdf", &sdf)].into_iter().zip(offsets)
    {
        let imported = convert(name, text);
        let model: ModelFile = model(&imported);
        let (terms, found) = gearing(&model.mechanism, "push");
        let other = terms.iter().find(|(joint, _)| joint == "turn").unwrap().1;
        assert!(
            (other + 0.02).abs() < 1e-16 && (found - offset).abs() < 1e-16,
            "{}",
            imported.text
        );
        assert_eq!(mobility(&model), 1, "{name}");
        assert!(!notes(&imported).contains("left out"), "{name}: {}", notes(&imported));
        // One coordinate fixes the configuration, because the other joint follows.
        assert_eq!(model.motion("hold").unwrap().coordinates.len(), 1, "{}", imported.text);
        // The leading joint keeps its coordinate of the file.
        let stays = match name {
            "r.urdf" => "turn = \"0 deg\"",
            "r.sdf" => "turn = \"17.18873385 deg\"",
            _ => continue,
        };
        assert!(imported.text.contains(stays), "{}", imported.text);
        assert!(!notes(&imported).contains("a nearby position"), "{}", notes(&imported));
    }
}

const JOINTS: &str = "<worldbody><body name='a'><joint name='a'/><geom size='0.1'/></body>
    <body name='b'><joint name='b'/><geom size='0.1'/></body>
    <body name='c'><joint name='c' type='slide'/><geom size='0.1'/></body></worldbody>";

/// A tendon that is a sum of joint coordinates, fixed or coupled with another tendon, is a gearing.
/// Nonlinear couplings are reported.
#[test]
fn tendons_and_polynomials() {
    let text = format!(
        "<mujoco>{JOINTS}<tendon><fixed name='s'><joint joint='a' coef='2'/><joint joint='b' coef='-1'/></fixed>
         <fixed name='t'><joint joint='c' coef='4'/></fixed></tendon>
         <equality><tendon name='held' tendon1='s' tendon2='t' polycoef='0.1 0.5 0 0 0'/></equality></mujoco>"
    );
    let (terms, offset) = gearing(&model(&convert("t.xml", &text)).mechanism, "a");
    assert_eq!(terms, [("a".to_owned(), 1.0), ("b".to_owned(), -0.5), ("c".to_owned(), -1.0)]);
    assert_eq!(offset, 0.05);
    let text = format!(
        "<mujoco>{JOINTS}\n<equality>\n<joint joint1='a' joint2='b' polycoef='0 1 0.5 0 0'/>\n<joint joint1='b'/></equality></mujoco>"
    );
    let imported = convert("p.xml", &text);
    assert!(model(&imported).mechanism.gearings().is_empty());
    let notes = notes(&imported);
    assert!(notes.contains("p.xml:5: a coupling with a nonlinear `polycoef`"), "{notes}");
    assert!(notes.contains("p.xml:6: a coupling keeps joint `b` at a constant value"), "{notes}");
}

/// Two motors that drive two joints together are a differential. One motor of two coupled joints
/// becomes a motor of the first joint. One motor of two independent joints is reported.
#[test]
fn motors_of_several_joints() {
    let tendons = "<tendon><fixed name='sum' armature='0.09' frictionloss='0.6' damping='0.18'><joint joint='a' coef='1'/><joint joint='b' coef='1'/></fixed>
         <fixed name='difference'><joint joint='a' coef='1'/><joint joint='b' coef='-1'/></fixed></tendon>";
    let one = "<motor name='m' tendon='sum' gear='3' ctrlrange='-2 2'/>";
    let robot = |more: &str| {
        let text = format!("<mujoco>{JOINTS}{tendons}{more}</mujoco>");
        let imported = convert("m.xml", &text);
        (model(&imported), notes(&imported))
    };
    let (both, _) =
        robot(&format!("<actuator>{one}<motor name='n' tendon='difference'/></actuator>"));
    let [first, second] = both.mechanism.drive_trains() else { panic!("two motors") };
    assert_eq!((first.dofs.len(), second.dofs.len()), (2, 2));
    assert!((first.transmission() - 3.0).abs() < 1e-15);
    assert!((first.rotor_inertia - 0.01).abs() < 1e-16);
    let friction = first.motor_friction;
    assert!((friction.constant - 0.2).abs() < 1e-15 && (friction.viscous - 0.02).abs() < 1e-16);
    assert_eq!(first.limits.peak, Some(2.0));
    assert_eq!(both.mechanism.actuators().count(), 2);
    // Joint b rotates twice as fast as a: the motor rotates by 3 (a + b) = 9 a.
    let coupled = format!(
        "<equality><joint joint1='b' joint2='a' polycoef='0 2 0 0 0'/></equality><actuator>{one}</actuator>"
    );
    let (coupled, said) = robot(&coupled);
    let [train] = coupled.mechanism.drive_trains() else { panic!("one motor") };
    assert!((train.transmission() - 9.0).abs() < 1e-14 && train.only_dof().is_some());
    // The tendon's inertia of 0.09 acts at the coordinate a + b = 3 a.
    assert!((train.reflected_inertia() - 0.81).abs() < 1e-14, "{train:?}");
    assert!(said.contains("that gearings couple"), "{said}");
    let (alone, said) = robot(&format!("<actuator>{one}</actuator>"));
    assert!(alone.mechanism.drive_trains().is_empty());
    assert!(said.contains("too few independent motors"), "{said}");
}

/// A gearbox of SDF couples the hinges between its links and its reference body; a gearbox without
/// these hinges is refused.
#[test]
fn a_gearbox_is_a_gearing() {
    // The second hinge runs from the link to the base, and its axis is reversed: theta_2 = -(-k) = k.
    let text = |reference: &str| {
        format!(
            "<sdf version='1.6'><model name='m'>{}{}{}
             <joint name='w' type='fixed'><parent>world</parent><child>base</child></joint>
             <joint name='j' type='revolute'><parent>base</parent><child>a</child><axis><xyz>0 1 0</xyz></axis></joint>
             <joint name='k' type='revolute'><parent>b</parent><child>base</child><axis><xyz>0 -1 0</xyz></axis></joint>
             <joint name='g' type='gearbox'><parent>a</parent><child>b</child>
             <gearbox_reference_body>{reference}</gearbox_reference_body><gearbox_ratio>5</gearbox_ratio>
             <axis><xyz>0 1 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model></sdf>",
            sdf_link("base"),
            sdf_link("a"),
            sdf_link("b")
        )
    };
    let imported = convert("r.sdf", &text("base"));
    let model: ModelFile = model(&imported);
    let (terms, offset) = gearing(&model.mechanism, "k");
    assert_eq!(offset, 0.0);
    assert_eq!(terms.iter().find(|(joint, _)| joint == "j").unwrap().1, 5.0, "{}", imported.text);
    assert_eq!(mobility(&model), 1);
    let refused = super::tree::refused("r.sdf", &text("a"));
    assert!(refused.contains("connects its <parent> with its reference body"), "{refused}");
}
