//! Errors and remarks about the content of robot files: each states the value and a way out.

use super::tree::{convert, refused, with_files};
use stiction_format::{ImportOptions, Imported, Source, import};

/// Two links on hinges; `inertial` is the content of the second link, `more` that of the robot.
fn arm(inertial: &str, limit: &str, more: &str) -> String {
    let whole = "<mass value='2'/><inertia ixx='.02' iyy='.03' izz='.02' ixy='0' ixz='0' iyz='0'/>";
    format!(
        "<robot name='r'><link name='base'/><link name='a'><inertial>{whole}</inertial></link>
        <link name='b'><inertial><origin xyz='0 0 .1'/>{}</inertial></link>
        <joint name='j' type='revolute'><parent link='base'/><child link='a'/><axis xyz='0 1 0'/>{}</joint>
        <joint name='k' type='revolute'><parent link='a'/><child link='b'/><origin xyz='0 0 .4' rpy='.1 .2 .3'/>
        <axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='5' velocity='2'/></joint>{more}</robot>",
        if inertial.is_empty() { whole } else { inertial },
        if limit.is_empty() { "<limit lower='-3' upper='3' effort='9' velocity='3'/>" } else { limit },
    )
}

/// Remarks that every command shows as warnings.
fn warnings(imported: &Imported) -> String {
    let warnings = imported.notes.iter().filter_map(|note| note.warning());
    warnings.map(|warning| format!("{} {:?}\n", warning.message, warning.place)).collect()
}

#[test]
fn missing_inertias_of_urdf_are_warnings_with_places() {
    for (inertial, expected) in [
        ("<mass value='2'/>", "the inertia of link `b` is missing and counts as 0 kg m^2"),
        (
            "<mass value='2'/><inertia ixx='.02' iyy='.03' izz='.02' ixy='0' ixz='0'/>",
            "`iyz` of the inertia of link `b` is missing and counts as 0 kg m^2",
        ),
        (
            "<inertia ixx='.02' iyy='.03' izz='.02' ixy='0' ixz='0' iyz='0'/>",
            "the mass of link `b` is missing and counts as 0 kg",
        ),
    ] {
        let imported = convert("r.urdf", &arm(inertial, "", ""));
        let note = imported.notes.iter().find(|note| note.message.starts_with(expected));
        let note = note.unwrap_or_else(|| panic!("{expected}: {:?}", imported.notes));
        assert!(note.line().starts_with("r.urdf:2: ") && note.message.contains(": write "));
        assert!(note.affects_results);
    }
    assert_eq!(warnings(&convert("r.urdf", &arm("", "", ""))), "");
}

#[test]
fn a_reduction_of_zero_is_an_error() {
    let transmission = |value: &str| {
        format!(
            "<transmission name='t'><joint name='k'/><actuator name='m'><mechanicalReduction>{value}\
             </mechanicalReduction></actuator></transmission>"
        )
    };
    let said = refused("r.urdf", &arm("", "", &transmission("0")));
    assert!(said.contains("the mechanicalReduction of transmission `t` is 0"), "{said}");
    assert!(said.contains("r.urdf:5:") && said.contains("help: write the speed"), "{said}");
    assert!(convert("r.urdf", &arm("", "", &transmission("-4"))).text.contains("ratio = -4"));
}

#[test]
fn wrong_numbers_are_shown_with_a_way_out() {
    let sdf = |mass: &str| {
        format!(
            "<sdf version='1.9'><model name='m'><link name='a'><inertial>\n<mass>{mass}</mass></inertial></link></model></sdf>"
        )
    };
    let said = refused("m.sdf", &sdf("2,5"));
    assert!(said.contains("expected 1 number, found 2: `2,5`"), "{said}");
    assert!(said.contains("help: write the decimal point as a point"), "{said}");
    let said = refused("m.sdf", &sdf("-2"));
    assert!(said.contains("the mass of link `a` is negative: -2 kg"), "{said}");
    assert!(said.contains("m.sdf:2:"), "{said}");
    let said = refused("r.urdf", &arm("", "<limit lower='-inf' upper='3'/>", ""));
    assert!(said.contains("help: write a number that is finite; for a missing limit"), "{said}");
    let said = refused("r.urdf", &arm("<mass value='2kg'/>", "", ""));
    assert!(said.contains("help: write 2 without a unit"), "{said}");
}

#[test]
fn open_loops_are_stated_once() {
    let closure = "<loop_joint name='l' type='revolute'><link1 link='b' xyz='0 0 .1' rpy='0 0 0'/>
        <link2 link='base' xyz='0 0 .5' rpy='0 0 0'/></loop_joint>";
    let imported = convert("r.urdf", &arm("", "", closure));
    let said = warnings(&imported);
    assert_eq!(said.matches("the loops do not close").count(), 1, "{said}");
}

#[test]
fn remarks_that_affect_results_are_warnings() {
    let mjcf = |body: &str, joint: &str| {
        format!(
            "<mujoco><worldbody><body name='b' {body}><joint name='j' {joint}/><geom size='1'/></body></worldbody></mujoco>"
        )
    };
    for (body, joint, expected) in [
        ("", "armature='0.1'", "the armature of a joint without a motor"),
        ("gravcomp='1'", "", "gravity compensation (gravcomp)"),
        ("", "stiffness='1 2'", "only the linear part of `stiffness`"),
        ("", "springdamper='1 1'", "springdamper"),
        ("", "type='ball' armature='0.1'", "`armature` of a ball joint"),
    ] {
        let said = warnings(&convert("m.xml", &mjcf(body, joint)));
        assert!(said.starts_with(expected) && said.contains("m.xml"), "{expected}: {said}");
    }
    // The range of a ball is a property that inverse dynamics does not use.
    assert_eq!(warnings(&convert("m.xml", &mjcf("", "type='ball' range='0 1'"))), "");
}

#[test]
fn yaml_files_that_are_read_unasked_are_explained() {
    let text = arm("", "", "");
    let read = |name: &'static str, yaml: &'static str| {
        let load = move |wanted: &str| match wanted == name {
            true => Ok(yaml.as_bytes().to_vec()),
            false => Err("there is no such file".to_owned()),
        };
        import(&Source::new("arm.urdf", &text), ImportOptions::default(), &load)
    };
    let foreign = "closed_loop: [['x.from', 'x.to']]\ntype: ['3d']\n";
    let said = read("robot.yaml", foreign).unwrap_err().to_string();
    let unwrapped = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(unwrapped.contains("robot.yaml is read because it is in the folder"), "{said}");
    assert!(unwrapped.contains("write an empty file arm.yaml"), "{said}");
    // The file of the same name belongs to the robot.
    let said = read("arm.yaml", foreign).unwrap_err().to_string();
    assert!(said.contains("there is no joint or link `x.from`"), "{said}");
    assert!(!said.contains("is read because"), "{said}");
    let both = [("arm.yaml", ""), ("robot.yaml", foreign)];
    assert!(!with_files("arm.urdf", &text, &both, false).text.contains("closure"));
}

#[test]
fn unknown_keys_of_yaml_files_are_reported() {
    let notes = |yaml: &str| {
        let imported = with_files("arm.urdf", &arm("", "", ""), &[("arm.yaml", yaml)], false);
        imported.notes.iter().map(|note| format!("{}\n", note.line())).collect::<String>()
    };
    assert!(notes("foo: bar\n").contains("the YAML file `arm.yaml` is not read: it has none of"));
    let said = notes("name_mot: [k]\nclosed_lop: []\n");
    assert!(said.contains("arm.yaml:2: the unknown key `closed_lop` is left out"), "{said}");
    assert!(said.contains("did you mean `closed_loop`?"), "{said}");
    // Types of joints alone are read, too.
    let imported = with_files(
        "arm.urdf",
        &arm("", "", ""),
        &[("arm.yaml", "joint_name: [k]\njoint_type: [FIXED]\n")],
        false,
    );
    assert!(imported.text.contains("type = \"fixed\""), "{}", imported.text);
}

#[test]
fn errors_in_extension_elements_have_places_in_the_robot_file() {
    let text = "<mujoco>\n<custom><text name='urn:stiction:1/friction/j' data='mu = -0.1;;radius = 0.01'/></custom>\n\
        <worldbody><body name='b'>\n<joint name='j'/><geom size='1'/></body></worldbody></mujoco>";
    let said = refused("m.xml", text);
    assert!(said.contains("m.xml:4:") && said.contains("friction = { mu = -0.1"), "{said}");
    assert!(!said.contains("as a model file"), "{said}");
}
