//! Export to MuJoCo's XML, interpreted with MuJoCo's conventions.

use crate::common::{default_job, model, model_of};
use roxmltree::{Document, Node};
use std::collections::{BTreeMap, HashMap};
use stiction_core::dynamics::FrictionMode;
use stiction_core::joint::JointType;
use stiction_core::spatial::{Mat3, Pose, Quaternion, Vec3};
use stiction_format::{ImportOptions, LoadCase, ModelFile, Source, gallery, import};
use stiction_run::Job;
use stiction_run::exchange::{Home, Mjcf, Unfit, mjcf};

const ZOO: &str = include_str!("common/zoo.toml");

/// Returns all models of the gallery, and one that has all joint types at all positions of the
/// tree.
fn models() -> impl Iterator<Item = ModelFile> {
    gallery::names().map(model).chain([model_of("zoo", ZOO)])
}

fn home(model: &ModelFile) -> Home<'_> {
    let job = match &model.default_load {
        Some(_) => default_job(model, FrictionMode::Off),
        None => Job { motion: &model.motions[0].1, ..without_load(model) },
    };
    Home::of(&job).unwrap()
}

/// Creates the job of the first motion without a load.
fn without_load(model: &ModelFile) -> Job<'_> {
    static NONE: LoadCase = LoadCase {
        title: String::new(),
        wrenches: Vec::new(),
        laws: Vec::new(),
        payloads: Vec::new(),
    };
    let (name, motion) = &model.motions[0];
    Job { friction: FrictionMode::Off, ..Job::new(model, (name, motion), ("none", &NONE)) }
}

fn numbers(node: &Node<'_, '_>, name: &str) -> Vec<f64> {
    let text = node.attribute(name).unwrap_or_else(|| panic!("no {name} in {node:?}"));
    text.split(' ').map(|number| number.parse().unwrap()).collect()
}

fn vector(node: &Node<'_, '_>, name: &str) -> Vec3<f64> {
    let numbers: [f64; 3] = numbers(node, name).try_into().unwrap();
    Vec3::from(numbers)
}

fn pose(node: &Node<'_, '_>) -> Pose<f64> {
    let quaternion = Quaternion::from_coordinates(&numbers(node, "quat"));
    Pose { position: vector(node, "pos"), rotation: quaternion.rotation() }
}

fn children<'a>(node: &Node<'a, 'a>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    let all: Vec<_> = node.children().filter(|child| child.has_tag_name(tag)).collect();
    all.into_iter()
}

fn name<'a>(node: &Node<'a, 'a>) -> &'a str {
    node.attribute("name").unwrap()
}

/// Poses of MuJoCo's bodies for given coordinates. In each body, the joints act one after the
/// other, with axes and anchors in the preceding pose of the body.
#[derive(Default)]
struct World<'a> {
    poses: HashMap<&'a str, Pose<f64>>,
    sites: HashMap<&'a str, Pose<f64>>,
    /// Body of each joint, and the parent of this body.
    joints: BTreeMap<&'a str, (&'a str, &'a str)>,
    mass: f64,
}

impl<'a> World<'a> {
    fn at(document: &'a Document<'a>, moves: &dyn Fn(&str) -> f64) -> Self {
        let mut world = Self::default();
        let body = document.descendants().find(|node| node.has_tag_name("worldbody")).unwrap();
        world.nest(&body, "world", Pose::identity(), moves);
        world
    }

    fn nest(
        &mut self,
        node: &Node<'a, 'a>,
        parent: &'a str,
        parent_pose: Pose<f64>,
        moves: &dyn Fn(&str) -> f64,
    ) {
        for body in children(node, "body") {
            let mut here = parent_pose * pose(&body);
            let freejoints = children(&body, "freejoint").inspect(|_| assert_eq!(parent, "world"));
            for joint in children(&body, "joint").chain(freejoints) {
                let of = (name(&body), parent);
                assert!(self.joints.insert(name(&joint), of).is_none(), "two of a name");
                let moved = moves(name(&joint));
                match joint.attribute("type") {
                    Some("slide") => {
                        let axis = vector(&joint, "axis");
                        here = here * Pose::at(axis * moved);
                    }
                    Some("hinge") => {
                        let (axis, anchor) = (vector(&joint, "axis"), vector(&joint, "pos"));
                        let turn = Mat3::rotation(axis, moved);
                        let position = anchor - turn * anchor;
                        here = here * Pose { rotation: turn, position };
                    }
                    // Coordinates of balls and free bodies are not changed.
                    _ => {}
                }
            }
            let inertial = children(&body, "inertial").next().unwrap();
            self.mass += numbers(&inertial, "mass")[0];
            for site in children(&body, "site") {
                let there = here * pose(&site);
                assert!(self.sites.insert(name(&site), there).is_none(), "two of a name");
            }
            assert!(self.poses.insert(name(&body), here).is_none(), "two of a name");
            self.nest(&body, name(&body), here, moves);
        }
    }
}

fn apart(a: Pose<f64>, b: Pose<f64>) -> f64 {
    let turn = (a.rotation.transpose() * b.rotation).rotation_vector();
    (a.position - b.position).norm() + turn.norm()
}

#[test]
fn every_model_is_a_tree_and_equalities() {
    for model in models() {
        let home = home(&model);
        let Mjcf { text, notes } = mjcf(&home).unwrap();
        assert_eq!(
            mjcf(&home).unwrap(),
            Mjcf { text: text.clone(), notes },
            "it is the same again"
        );
        let document = Document::parse(&text).unwrap();
        let world = World::at(&document, &|_| 0.0);
        let (mechanism, name_of) = (&model.mechanism, &model.name);

        // Bodies, including all parts of split bodies, have their assembled poses.
        for (body, pose) in mechanism.bodies().iter().zip(&home.poses) {
            let further = format!("{}@", body.name);
            let is_part = |name: &str| name == body.name || name.starts_with(&further);
            let parts: Vec<_> = world.poses.iter().filter(|(name, _)| is_part(name)).collect();
            assert!(parts.iter().any(|(name, _)| **name == body.name), "{name_of}");
            for (_, found) in parts {
                assert!(apart(*found, *pose) < 1e-12, "{name_of}: {}", body.name);
            }
        }
        let mass: f64 = mechanism.bodies().iter().map(|body| body.mass).sum();
        assert!((world.mass - mass).abs() < 1e-14 * mass, "{name_of}");

        // Equality constraints are satisfied: at balls, two points coincide; at all others,
        // position and orientation.
        let equality = document.descendants().find(|node| node.has_tag_name("equality"));
        let equalities: Vec<Node<'_, '_>> = equality
            .iter()
            .flat_map(|node| node.children().filter(|child| child.is_element()))
            .collect();
        let mut threads = 0;
        for node in &equalities {
            let site = |attribute: &str| world.sites[node.attribute(attribute).unwrap()];
            match node.tag_name().name() {
                "connect" => {
                    let (a, b) = (site("site1"), site("site2"));
                    assert!((a.position - b.position).norm() < 4e-12, "{name_of}");
                }
                "weld" => assert!(apart(site("site1"), site("site2")) < 4e-12, "{name_of}"),
                "joint" => threads += 1,
                other => panic!("{other}"),
            }
        }
        let further = world.poses.keys().filter(|name| name.contains('@')).count();
        // Every joint of the model either nests a body or closes a loop with a part of a body,
        // except for balls; a joint without constraints may do neither.
        let types = |wanted| mechanism.joints().iter().filter(move |j| j.joint_type == wanted);
        let bodies = mechanism.bodies().len() - 1;
        let closing = mechanism.joints().len() - bodies;
        let free = types(JointType::Free).count();
        let nested_free = world.joints.keys().filter(|name| {
            types(JointType::Free).any(|j| j.name == **name || format!("{}.x", j.name) == **name)
        });
        let dropped = free - nested_free.count();
        assert_eq!(equalities.len() - threads, closing - dropped, "{name_of}");
        assert_eq!(threads, types(JointType::Helical).count(), "{name_of}");
        assert_eq!(world.poses.len(), 1 + bodies + further, "{name_of}");
    }
}

/// Tests that joint coordinates have the same meaning as in the model: for any values, the frames
/// of each joint agree with the formulas of the kernel.
#[test]
fn joints_move_as_ours() {
    let mut tried = std::collections::BTreeSet::new();
    for model in models() {
        let home = home(&model);
        let text = mjcf(&home).unwrap().text;
        let document = Document::parse(&text).unwrap();
        // Each joint has a fixed large displacement; the two coordinates of a thread move together.
        let amount = |name: &str| {
            let sum: u32 =
                name.bytes().enumerate().map(|(k, b)| (k as u32 + 3) * u32::from(b)).sum();
            f64::from(sum % 97) / 97.0 - 0.4
        };
        let pitches: HashMap<String, (String, f64)> = document
            .descendants()
            .filter(|node| node.has_attribute("polycoef"))
            .map(|node| {
                let read = |attribute| node.attribute(attribute).unwrap().to_owned();
                (read("joint1"), (read("joint2"), numbers(&node, "polycoef")[1]))
            })
            .collect();
        let moves = |name: &str| match pitches.get(name) {
            Some((angle, pitch)) => pitch * amount(angle),
            None => amount(name),
        };
        let world = World::at(&document, &moves);
        for (index, joint) in model.mechanism.joints().iter().enumerate() {
            let dofs = joint.joint_type.dofs();
            let names: Vec<String> = match dofs.len() {
                1 => vec![joint.name.clone()],
                _ => dofs.iter().map(|f| format!("{}.{}", joint.name, f.name)).collect(),
            };
            let Some(&(child, parent)) = names.first().and_then(|n| world.joints.get(&**n)) else {
                continue;
            };
            let origin = |name: &str| name.split('@').next().unwrap().to_owned();
            let [from, to] = [joint.predecessor, joint.successor]
                .map(|body| model.mechanism.bodies()[body.0].name.clone());
            let reversed = origin(child) == from;
            assert_eq!(
                [origin(parent), origin(child)],
                if reversed { [to, from] } else { [from, to] }
            );
            let (before, after) = (world.poses[parent], world.poses[child]);
            let (in_from, in_to) = if reversed { (after, before) } else { (before, after) };
            let found = (in_from * joint.frame_j).inverse() * (in_to * joint.frame_k);
            let mut q: Vec<f64> = Vec::new();
            for (name, value) in names.iter().zip(&home.coordinates[index]) {
                q.push(value.unwrap_or(0.0) + amount(name));
            }
            let expected = match joint.joint_type {
                // The rotation has not moved; the positions are those in J.
                JointType::Free => Pose {
                    position: Vec3::new(q[0], q[1], q[2]),
                    rotation: home.across[index].rotation,
                },
                joint_type => joint_type.pose(&q, joint.pitch),
            };
            assert!(apart(found, expected) < 1e-12, "{}: {}", model.name, joint.name);
            tried.insert((joint.joint_type.symbol(), reversed, child.contains('@')));
        }
    }
    // All types with coordinates occur, most of them in all four variants.
    for symbol in ["R", "P", "H", "C", "U", "E"] {
        for reversed in [false, true] {
            assert!(
                tried.iter().any(|&(s, r, _)| (s, r) == (symbol, reversed)),
                "no {symbol}, reversed: {reversed}; there are {tried:?}"
            );
        }
        assert!(
            tried.iter().any(|&(s, _, further)| s == symbol && further),
            "no {symbol} closes a loop; there are {tried:?}"
        );
    }
}

/// Tests that the reference position of the file and its keyframe are the home position.
#[test]
fn the_key_is_the_home() {
    for model in models() {
        let text = mjcf(&home(&model)).unwrap().text;
        let document = Document::parse(&text).unwrap();
        let mut expected = Vec::new();
        let free = |node: &Node<'_, '_>| node.has_tag_name("freejoint");
        let joints = document.descendants().filter(|node| {
            free(node) || (node.has_tag_name("joint") && node.has_attribute("type"))
        });
        for joint in joints {
            if free(&joint) {
                let body = joint.parent().unwrap();
                expected.extend(numbers(&body, "pos"));
                expected.extend(numbers(&body, "quat"));
            } else if joint.attribute("type") == Some("ball") {
                expected.extend([1.0, 0.0, 0.0, 0.0]);
            } else {
                expected.extend(numbers(&joint, "ref"));
            }
        }
        let key = document.descendants().find(|node| node.has_tag_name("key")).unwrap();
        assert_eq!(numbers(&key, "qpos"), expected, "{}", model.name);
    }
}

/// Tests that viscous friction without coefficients of friction becomes damping of equal power.
#[test]
fn viscous_friction_is_damping() {
    let model = model_of("zoo", ZOO);
    let Mjcf { text, notes } = mjcf(&home(&model)).unwrap();
    let document = Document::parse(&text).unwrap();
    let damping: BTreeMap<&str, f64> = document
        .descendants()
        .filter(|node| node.has_tag_name("joint") && node.has_attribute("damping"))
        .map(|node| (name(&node), numbers(&node, "damping")[0]))
        .collect();
    let advance = 0.1 / std::f64::consts::TAU;
    let expected = [
        ("A.H", 4.0 * (0.008 * 0.008 + advance * advance)),
        ("C.C.angle", 5.0 * 0.02 * 0.02),
        ("C.C.slide", 7.0),
        ("C.E.angle", 6.0 * 0.05 * 0.05),
        ("C.E.x", 6.0),
        ("C.E.y", 6.0),
    ];
    assert_eq!(damping.len(), expected.len(), "{damping:?}");
    for (name, expected) in expected {
        // A unit conversion and a few products round.
        assert!((damping[name] - expected).abs() < 1e-14 * expected, "{name}: {}", damping[name]);
    }
    // Two balls close loops.
    assert!(notes[0].starts_with("friction at 2 of 6 friction interfaces"), "{notes:?}");
    // The export omits the coefficient of friction but keeps the viscous part.
    let translational = crate::common::model("3upu");
    let Mjcf { text, notes } = mjcf(&home(&translational)).unwrap();
    let document = Document::parse(&text).unwrap();
    let guide = document.descendants().find(|node| node.attribute("name") == Some("leg1.P"));
    assert_eq!(numbers(&guide.unwrap(), "damping"), [40.0]);
    assert!(notes[0].starts_with("friction at 15 of 15 friction interfaces"), "{notes:?}");
}

/// Tests that the parts of a split body add up to its mass and inertia, that motors are in the
/// order of the model, and that springs end at their points.
#[test]
fn parts_motors_and_springs() {
    let model = model_of("zoo", ZOO);
    let text = mjcf(&home(&model)).unwrap().text;
    let document = Document::parse(&text).unwrap();
    let parts = document.descendants().filter(|node| {
        node.has_tag_name("body") && name(node).split('@').next() == Some("platform")
    });
    let (mut count, mut sum) = (0, [0.0; 7]);
    for part in parts {
        let inertial = children(&part, "inertial").next().unwrap();
        assert_eq!(vector(&inertial, "pos"), Vec3::new(0.01, -0.02, 0.03));
        let own = [numbers(&inertial, "mass"), numbers(&inertial, "fullinertia")].concat();
        sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        count += 1;
    }
    assert!(count > 2, "it closes several loops");
    let whole = [8.0, 0.2, 0.25, 0.3, 0.01, -0.02, 0.03];
    for (sum, whole) in sum.into_iter().zip(whole) {
        assert!((sum - whole).abs() < 1e-15 * 8.0, "{sum} {whole}");
    }
    let motors: Vec<_> = document
        .descendants()
        .filter(|node| node.has_tag_name("motor"))
        .map(|node| (name(&node), node.attribute("joint").unwrap()))
        .collect();
    let expected =
        ["D.P", "E.P", "G.R2", "I.C.angle", "I.C.slide", "I.E.x", "I.E.y", "I.E.angle", "J.H"];
    assert_eq!(motors, expected.map(|name| (name, name)));
    let tether = document.descendants().find(|node| node.attribute("name") == Some("tether"));
    let tether = tether.unwrap();
    assert_eq!(numbers(&tether, "stiffness"), [200.0]);
    assert_eq!(numbers(&tether, "springlength"), [0.3]);
    assert_eq!(numbers(&tether, "damping"), [5.0]);
    let world = World::at(&document, &|_| 0.0);
    let ends = children(&tether, "site").map(|site| site.attribute("site").unwrap());
    let ends: Vec<Vec3<f64>> = ends.map(|end| world.sites[end].position).collect();
    let home = home(&model);
    let expected = [
        home.poses[0].apply(Vec3::new(0.1, 0.2, 0.3)),
        home.poses[1].apply(Vec3::new(0.01, 0.02, 0.03)),
    ];
    for (end, expected) in ends.into_iter().zip(expected) {
        assert!((end - expected).norm() < 1e-14);
    }
}

/// Tests that the export opens a loop at a ball, if the loop has one.
#[test]
fn loops_are_opened_at_balls() {
    for name in ["3rps", "gough", "delta", "6sps", "zhang2018"] {
        let model = model(name);
        let text = mjcf(&home(&model)).unwrap().text;
        assert!(text.contains("<connect ") && !text.contains("<weld "), "{name}");
    }
}

/// Tests that moments of inertia that MuJoCo would reject are increased, with a note.
#[test]
fn planar_inertias_are_those_of_laminas() {
    let model = model("andrews");
    let Mjcf { text, notes } = mjcf(&home(&model)).unwrap();
    assert!(notes.iter().any(|note| note.contains("K1, K2, K3, K4, K5, K6, K7 are increased")));
    let document = Document::parse(&text).unwrap();
    let crank = document.descendants().find(|node| node.attribute("name") == Some("K1"));
    let inertial = children(&crank.unwrap(), "inertial").next().unwrap();
    let [xx, yy, zz, xy, xz, yz] = numbers(&inertial, "fullinertia").try_into().unwrap();
    // About the joint axis, the moment of inertia is that of the benchmark. About the other axes,
    // it is half as large, plus a margin for rounding.
    assert_eq!((zz, xy, xz, yz), (2.194e-6, 0.0, 0.0, 0.0));
    for across in [xx, yy] {
        assert!(across > zz / 2.0 && across < zz / 2.0 * (1.0 + 1e-8), "{across}");
    }
}

/// A slider-crank whose coupler has no mass.
const MASSLESS: &str = r#"
gravity = [0, -9.81, 0]

[bodies.crank]
mass = 1
com = [0.1, 0, 0]
inertia = [0.01, 0.01, 0.01]

[bodies.rod]

[bodies.block]
mass = 1
com = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]

[joints.A]
type = "R"
from = "ground"
to = "crank"
axis = "z"
actuated = true

[joints.B]
type = "R"
from = "crank"
to = "rod"
at = [0.2, 0, 0]
axis = "z"

[joints.C]
type = "R"
from = "rod"
to = "block"
at = [0.5, 0, 0]
axis = "z"

[joints.slide]
type = "P"
from = "ground"
to = "block"
axis = "x"
start = 0.6

[motions.turn]
A = "50 deg + 2 rad/s*t"
"#;

#[test]
fn bodies_without_mass_are_reported() {
    // A spring is fixed to the rod, so the rod has to be a body of the file.
    let held = MASSLESS.replace("[joints.A]", "[springs.S]\nfrom = \"ground\"\nat = [0, 1, 0]\nto = \"rod\"\nto_at = [0.1, 0, 0]\nstiffness = 1\nfree_length = 1\n\n[joints.A]");
    let model = model_of("massless", &held);
    let error = mjcf(&home(&model)).unwrap_err();
    assert_eq!(error, Unfit::Massless { body: "rod".into() });
    // If a joint that closes a loop connects two bodies without mass, neither of them can be split.
    let ring = MASSLESS
        .replace("[bodies.block]\nmass = 1\ncom = [0, 0, 0]", "[bodies.block]")
        .replace("[0.01, 0.01, 0.01]\n\n[joints.A]", "[0, 0, 0]\n\n[joints.A]")
        .replace("mass = 1\ncom = [0.1, 0, 0]\ninertia = [0.01, 0.01, 0.01]\n", "");
    let model = model_of("ring", &ring);
    let error = mjcf(&home(&model)).unwrap_err();
    assert_eq!(error, Unfit::CannotClose { joint: "slide".into() });
    // A body without mass is accepted if it is fixed to a body with mass.
    let fixed = MASSLESS
        .replace("to = \"rod\"\nat = [0.2, 0, 0]\naxis = \"z\"", "to = \"rod\"\nat = [0.2, 0, 0]")
        .replace("[joints.B]\ntype = \"R\"", "[joints.B]\ntype = \"fixed\"");
    let fixed = fixed
        .replace("type = \"P\"", "type = \"E\"")
        .replace("axis = \"x\"\nstart = 0.6", "axis = \"z\"")
        + "slide.angle = 0\n";
    let model = model_of("fixed", &fixed);
    let text = mjcf(&Home::of(&without_load(&model)).unwrap()).unwrap().text;
    assert!(text.contains("<body name=\"rod\""));
}

/// Tests that another motion starts at another position.
#[test]
fn the_motion_selects_the_position() {
    let model = model("four-bar");
    for angle in [60.0, 100.0_f64] {
        let text = format!("A = {angle} deg; duration = 0");
        let motion = Source::new("--motion", text);
        let motion = model.parse_motion(&motion, &|_| Err(String::new())).unwrap();
        let job = Job { motion: &motion, ..without_load(&model) };
        let text = mjcf(&Home::of(&job).unwrap()).unwrap().text;
        let document = Document::parse(&text).unwrap();
        let key = document.descendants().find(|node| node.has_tag_name("key")).unwrap();
        assert!((numbers(&key, "qpos")[0] - angle.to_radians()).abs() < 1e-15);
    }
}

/// Several joints of one MJCF body, which the import divides by massless bodies.
#[test]
fn joints_of_one_body_stay_joints_of_one_body() {
    let text = "<mujoco><worldbody><body name='b' pos='0 0.1 0.2'><inertial mass='2' pos='0 0 0' diaginertia='1 2 2'/>
        <joint name='k' axis='0 1 1' pos='0.1 0 0'/><joint name='l' type='slide' axis='1 0 1'/>
        <joint name='m' axis='1 0 0' pos='0 0.1 0'/></body></worldbody>
        <actuator><motor joint='k'/><motor joint='l'/><motor joint='m'/></actuator></mujoco>";
    let none = |_: &str| Err(String::new());
    let source = Source::new("b.xml", text);
    let imported = import(&source, ImportOptions::default(), &none).unwrap().text;
    let model = model_of("b", &imported);
    let again = mjcf(&home(&model)).unwrap().text;
    let joints = again.split_once("<body name=\"b\"").unwrap().1.matches("<joint").count();
    assert_eq!((again.matches("<body").count(), joints), (2, 3), "{again}");
}
