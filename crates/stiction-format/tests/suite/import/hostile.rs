//! No file causes a panic or an endless import, and every error has a place.

use super::tree::convert;
use proptest::prelude::*;
use stiction_format::{Diagnostics, ImportOptions, Imported, Source, import};

/// Imports a text; all files that it names have the same text.
fn attempt(text: &str) -> Result<Imported, Diagnostics> {
    let load = |_: &str| Ok(text.as_bytes().to_vec());
    let mut last = Err(Diagnostics::default());
    for literal in [true, false] {
        let source = Source::new("robot.xml", text);
        last = import(&source, ImportOptions { literal }, &load);
        if let Err(errors) = &last {
            assert!(errors.has_errors());
            assert!(!errors.render(false).is_empty());
        }
    }
    last
}

fn message(text: &str) -> String {
    attempt(text).unwrap_err().render(false)
}

#[test]
fn hostile_files_are_refused_with_reasons() {
    let deep = format!("{}{}", "<body>".repeat(100_000), "</body>".repeat(100_000));
    let laughs = "<!DOCTYPE r [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]><robot name='&b;'/>";
    for (text, reason) in [
        ("", "not well-formed XML"),
        ("<robot", "not well-formed XML"),
        (laughs, "entities"),
        ("<html/>", "is not that of a robot file"),
        ("<robot name='r'/>", "has no links"),
        (&format!("<mujoco><worldbody>{deep}</worldbody></mujoco>"), "nested more than"),
        ("<mujoco><include file='robot.xml'/></mujoco>", "included again"),
        ("<mujoco><worldbody><body pos='nan 0 0'/></worldbody></mujoco>", "not a finite number"),
        ("<mujoco><worldbody><body pos='1e300 0 0'/></worldbody></mujoco>", "greater than"),
        (
            "<mujoco><worldbody><body pos='1 2'/></worldbody></mujoco>",
            "expected 3 numbers, found 2",
        ),
        ("<mujoco><worldbody><body><joint type='x'/></body></worldbody></mujoco>", "unknown type"),
        ("<mujoco><worldbody><composite/></worldbody></mujoco>", "mj_saveLastXML"),
        (
            "<mujoco><worldbody/><equality><connect body1='a' anchor='0 0 0'/></equality></mujoco>",
            "no body `a`",
        ),
        ("<sdf version='1.9'/>", "has no model"),
        (
            "<sdf version='1.9'><model name='m'><include><uri>model://m</uri></include></model></sdf>",
            "",
        ),
        (
            "<sdf version='1.9'><model name='m'><frame name='a'><pose relative_to='b'/></frame>\
             <frame name='b'><pose relative_to='a'/></frame></model></sdf>",
            "relative to itself",
        ),
        (
            "<sdf version='1.9'><model name='m' placement_frame='nope'><link name='a'/></model></sdf>",
            "the placement frame `nope` is not a frame of its model",
        ),
        (
            "<sdf version='1.9'><model name='m'><link name='a'/><joint name='j' type='revolute'/></model></sdf>",
            "has no <parent>",
        ),
        (
            "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='revolute'>\
             <parent link='a'/><child link='c'/></joint></robot>",
            "links have no parent",
        ),
        (
            "<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'><xacro:include filename='x'/></robot>",
            "xacro",
        ),
        ("<robot name='r'><xacro:property name='a' value='1'/></robot>", "xacro robot.urdf.xacro"),
        (
            "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='continuous'>\
             <parent link='a'/><child link='b'/><mimic joint='j'/></joint></robot>",
            "mimics itself",
        ),
        (
            "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><joint name='j' type='fixed'>\
             <parent link='a'/><child link='b'/></joint><joint name='k' type='continuous'>\
             <parent link='b'/><child link='c'/><mimic joint='j'/></joint></robot>",
            "one degree of freedom",
        ),
        (
            "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='revolute'>\
             <parent link='b'/><child link='b'/></joint></robot>",
            "ring",
        ),
        (
            "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='-1'/></inertial></link>\
             <joint name='j' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 0'/></joint></robot>",
            "negative",
        ),
    ] {
        let found = message(text);
        assert!(found.contains(reason), "{reason}:\n{found}");
    }
}

/// Names that the model file does not allow are changed and reported.
#[test]
fn odd_names_are_changed() {
    let text = "<mujoco><worldbody><body name='a b'><joint name='title'/><joint name='%' pos='1 0 0'/>\
        <geom size='1'/><body name='ground'><geom size='1'/></body></body></worldbody></mujoco>";
    let imported = convert("m.xml", text);
    for name in ["[bodies.a_b]", "[joints._title]", "[joints._]", "[bodies._ground]"] {
        assert!(imported.text.contains(name), "{name}\n{}", imported.text);
    }
    assert!(imported.notes.iter().any(|note| note.message.contains("is renamed to a_b")));
}

/// Parts of robot files in any order.
fn part() -> impl Strategy<Value = String> {
    let words = [
        "<mujoco>",
        "</mujoco>",
        "<worldbody>",
        "</worldbody>",
        "<body name='a'>",
        "<body>",
        "</body>",
        "<joint/>",
        "<joint name='j' type='slide' axis='1 0 0'/>",
        "<freejoint/>",
        "<geom size='1'/>",
        "<inertial mass='1' pos='0 0 0' diaginertia='1 1 1'/>",
        "<equality>",
        "</equality>",
        "<connect body1='a' anchor='1 0 0'/>",
        "<weld body1='a'/>",
        "<joint joint1='j'/>",
        "<default class='c'>",
        "</default>",
        "<frame euler='1 2 3'>",
        "</frame>",
        "<robot name='r'>",
        "</robot>",
        "<link name='a'/>",
        "<link name='b'/>",
        "<joint name='j' type='revolute'><parent link='a'/><child link='b'/></joint>",
        "<sdf version='1.5'>",
        "</sdf>",
        "<model name='m'>",
        "</model>",
        "<pose>0 0 1 0 0 0</pose>",
        "<joint name='j' type='revolute2'><parent>world</parent><child>a</child></joint>",
        "<joint name='k' type='ball'><parent>a</parent><child>b</child></joint>",
        "<keyframe><key qpos='1'/></keyframe>",
        "<include><uri>m</uri></include>",
    ];
    proptest::sample::select(words.to_vec()).prop_map(str::to_owned)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn shuffled_files(parts in prop::collection::vec(part(), 0..25), root in 0..3_usize) {
        let (open, close) = [
            ("<mujoco><worldbody>", "</worldbody></mujoco>"),
            ("<robot name='r'>", "</robot>"),
            ("<sdf version='1.9'><model name='m'>", "</model></sdf>"),
        ][root];
        let _ = attempt(&format!("{open}{}{close}", parts.concat()));
    }

    /// Files in which one attribute or text is changed.
    #[test]
    fn damaged_files(at in 0..2000_usize, with in "[-0-9a-z. <>'\"/]{0,6}", length in 0..20_usize) {
        let text = "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/>\
            <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>\
            <joint name='j' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>\
            <limit lower='-1' upper='1' effort='1'/></joint></robot>";
        let at = at % text.len();
        let end = (at + length).min(text.len());
        let _ = attempt(&format!("{}{with}{}", &text[..at], &text[end..]));
    }
}
