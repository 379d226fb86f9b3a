//! Recognition of the mechanisms that imported files describe.

use super::tree::{convert, mobility, model, with_files};
use stiction_core::joint::JointType;

fn types(imported: &stiction_format::Imported) -> Vec<(String, JointType)> {
    let model = model(imported);
    let joints = model.mechanism.joints().iter();
    joints.map(|joint| (joint.name.clone(), joint.joint_type)).collect()
}

/// Ball joints of legs are written as hinges of massless bodies, and two point closures form one
/// hinge.
#[test]
fn hinges_of_massless_bodies_are_balls() {
    let text = r#"<mujoco><worldbody>
      <body name="rod"><joint name="hip_x" axis="1 0 0"/><joint name="hip_y" axis="0 1 0"/>
        <joint name="hip_z"/><inertial pos="0 0 1" mass="1" diaginertia="1 1 1"/></body>
      <body name="door" pos="2 0 0"><freejoint name="loose"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>
      </worldbody><equality>
      <connect name="low" body1="door" anchor="0 0 0"/><connect name="high" body1="door" anchor="0 0 2"/>
      </equality></mujoco>"#;
    let understood = convert("m.xml", text);
    let expected = [
        ("hip".to_owned(), JointType::Spherical),
        ("loose".to_owned(), JointType::Free),
        ("low".to_owned(), JointType::Revolute),
    ];
    assert_eq!(types(&understood), expected);
    let literal = with_files("m.xml", text, &[], true);
    assert_eq!(types(&literal).len(), 6);
    assert_eq!(mobility(&model(&understood)), 4);
    assert_eq!(mobility(&model(&literal)), 4);
    let said = |what: &str| understood.notes.iter().any(|note| note.message.contains(what));
    assert!(said("are replaced by a ball joint") && said("replaced by one hinge joint"));
}

/// If the loops of a file are open in its configuration, the nearest closed configuration is found.
#[test]
fn open_loops_are_closed_nearby() {
    let text = r#"<mujoco><compiler angle="radian"/><default><geom type="capsule" size="0.01"/><joint axis="0 -1 0"/></default>
      <worldbody>
      <body name="a"><joint name="q1"/><geom fromto="0 0 0 0 0 0.3"/>
        <body name="b" pos="0 0 0.3"><joint name="q2"/><geom fromto="0 0 0 0.5 0 0"/></body></body>
      <body name="c" pos="0.5 0 0"><joint name="q3"/><geom fromto="0 0 0 0 0 0.32"/></body>
      </worldbody><equality><connect name="tip" site1="s1" site2="s2"/></equality></mujoco>"#
        .replace("0.5 0 0\"/></body></body>", "0.5 0 0\"/><site name=\"s1\" pos=\"0.5 0 0\"/></body></body>")
        .replace("0 0 0.32\"/></body>", "0 0 0.32\"/><site name=\"s2\" pos=\"0 0 0.32\"/></body>");
    let imported = convert("m.xml", &text);
    assert!(imported.text.contains("nearest to zero coordinates"), "{}", imported.text);
    assert!(imported.notes.iter().any(|note| note.message.contains("a nearby position")));
    let model = model(&imported);
    assert_eq!(mobility(&model), 1);
    for joint in model.mechanism.joints() {
        assert!(joint.start.as_ref().is_none_or(|start| start[0].abs() < 0.1), "{}", joint.name);
    }
}

/// Coincident frames, ball joints and universal joints by the YAML convention.
#[test]
fn yaml_files_close_loops_and_change_joints() {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, xyz: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/><origin xyz='{xyz}'/><axis xyz='0 0 1'/><limit effort='1' velocity='1'/></joint>"
        )
    };
    let text = format!(
        "<robot name='r'><link name='base'/>{}{}{}{}{}</robot>",
        ["a", "b", "c", "end"].map(link).concat(),
        joint("mot", "base", "a", "0 0 0"),
        joint("ball", "a", "b", "0 0 1"),
        joint("cross", "base", "c", "1 0 0"),
        joint("stop", "c", "end", "-1 0 1"),
    );
    let yaml = "closed_loop:\n  - [b, stop]\ntype: ['3d']\nname_mot: [mot]\n\
        joint_name: [ball, cross, stop]\njoint_type: [SPHERICAL, CARDAN, FIXED]\n";
    let imported = with_files("r.urdf", &text, &[("r.yaml", yaml)], false);
    let found: Vec<JointType> = types(&imported).into_iter().map(|(_, kind)| kind).collect();
    use JointType::{Fixed, Revolute, Spherical, Universal};
    assert_eq!(found, [Revolute, Spherical, Universal, Fixed, Spherical]);
    let actuators: Vec<_> = model(&imported).mechanism.actuators().collect();
    assert_eq!(actuators.len(), 1);
    let wrong = yaml.replace("[b, stop]", "[b, stopp]");
    let load = |_: &str| Ok(wrong.clone().into_bytes());
    let source = stiction_format::Source::new("r.urdf", &text);
    let errors = stiction_format::import(&source, Default::default(), &load).unwrap_err();
    assert!(errors.to_string().contains("did you mean `stop`?"), "{errors}");
}
