//! Motions through waypoints: laws, limits, dwells, blends and orientations.

use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::JointId;
use stiction_format::{ModelFile, Motion, Source, gallery, read};

fn model(name: &str) -> ModelFile {
    let source = Source::new(format!("{name}.toml"), gallery::get(name).unwrap());
    read(&source, &|_| Err("no files".to_owned())).unwrap()
}

fn motion(text: &str) -> Result<Motion, String> {
    motion_of("five-bar", text)
}

fn motion_of(name: &str, text: &str) -> Result<Motion, String> {
    model(name)
        .read_motion(&Source::new("motion.toml", text), &|_| Err("no files".to_owned()))
        .map_err(|diagnostics| diagnostics.to_string())
}

/// Durations of a pick-and-place cycle follow from the limits of the tool's path.
#[test]
fn durations_follow_from_limits() {
    let motion = motion(
        r#"
        law = "trapezoid"
        limits.tool = { speed = "1 m/s", acceleration = "10 m/s^2" }
        waypoints = [
            { tool.x = "-80 mm", tool.y = "340 mm", dwell = "50 ms" },
            { tool.x = "80 mm" },
            { tool.y = "380 mm", dwell = "0.1 s" },
        ]"#,
    )
    .unwrap();
    // 160 mm take 1/v + v/a for a unit distance; 40 mm take 2 sqrt(d/a), without constant speed.
    let (first, second) = (0.16 + 0.1, 2.0 * (0.04f64 / 10.0).sqrt());
    assert!((motion.duration - (0.05 + first + second + 0.1)).abs() < 1e-15);
    let at = |t: f64| motion.at(t).collect::<Vec<_>>();
    assert_eq!(at(0.02)[0].value, -0.08);
    let middle = at(0.05 + first / 2.0);
    assert!(middle[0].value.abs() < 1e-15 && (middle[0].rate - 1.0).abs() < 1e-12);
    assert_eq!(middle[1].value, 0.34);
    let up = at(0.05 + first + second / 4.0);
    assert_eq!(up[0].value, 0.08);
    assert!((up[1].acceleration - 10.0).abs() < 1e-9, "{:?}", up[1]);
    let end = at(motion.duration);
    assert_eq!((end[0].value, end[1].value, end[1].rate), (0.08, 0.38, 0.0));
}

/// No limit is exceeded at any instant, and at least one limit is reached in every move.
#[test]
fn limits_hold_for_every_law() {
    for law in ["quintic", "cycloid", "modified-sine", "trapezoid", "s-curve"] {
        let jerk = if law == "trapezoid" { "" } else { ", jerk = \"300 m/s^3\"" };
        let motion = motion(&format!(
            r#"law = "{law}"
            limits.tool = {{ speed = "0.8 m/s", acceleration = "9 m/s^2"{jerk} }}
            waypoints = [{{ tool.x = -0.08, tool.y = 0.34 }}, {{ tool.x = 0.08, tool.y = 0.38 }}]"#,
        ))
        .unwrap();
        let mut most = [0f64; 2];
        for k in 0..=200_000 {
            let both: Vec<_> = motion.at(motion.duration * f64::from(k) / 2e5).collect();
            most[0] = most[0].max(both[0].rate.hypot(both[1].rate));
            most[1] = most[1].max(both[0].acceleration.hypot(both[1].acceleration));
        }
        assert!(most[0] < 0.8 * (1.0 + 1e-12) && most[1] < 9.0 * (1.0 + 1e-12), "{law}: {most:?}");
        // The speed, the acceleration or the jerk limits the fastest move.
        let jerk_bound = matches!(law, "quintic" | "cycloid" | "modified-sine");
        let reached = most[0] > 0.8 * (1.0 - 1e-9) || most[1] > 9.0 * (1.0 - 1e-6);
        assert!(reached || jerk_bound, "{law}: {most:?}");
    }
}

#[test]
fn a_blend_rounds_the_corner() {
    let text = |blend: &str| {
        format!(
            r#"waypoints = [
                {{ tool.x = 0, tool.y = 0.34 }},
                {{ tool.x = 0.05, duration = 0.2, blend = {blend} }},
                {{ tool.y = 0.36, duration = 0.2 }},
            ]"#
        )
    };
    let blended = motion(&text("0.08")).unwrap();
    assert!((blended.duration - 0.32).abs() < 1e-15);
    // From the beginning of the second move on, both coordinates move.
    let corner: Vec<_> = blended.at(0.16).collect();
    assert!(corner[0].rate > 0.0 && corner[0].value < 0.05 && corner[1].value > 0.34);
    let end: Vec<_> = blended.at(0.32).collect();
    assert_eq!((end[0].value, end[1].value), (0.05, 0.36));
    assert!(motion(&text("0.15")).unwrap_err().contains("half of the shorter"));
    assert_eq!(motion(&text("0")).unwrap().duration, 0.4);
}

/// Between two orientations, the body rotates about a fixed axis: by half the angle at half the
/// way.
#[test]
fn orientations_are_interpolated_on_the_rotation_group() {
    let motion = motion_of(
        "gough",
        r#"waypoints = [
            { platform.rotation = { axis = "x", angle = "20 deg" } },
            { platform.rotation = { zyx = ["30 deg", "10 deg", "-15 deg"] }, duration = 1 },
        ]"#,
    )
    .unwrap();
    let rotation = |t: f64| {
        let r: Vec<f64> = motion.at(t).map(|target| target.value).collect();
        nalgebra::Rotation3::from_scaled_axis(nalgebra::Vector3::new(r[0], r[1], r[2]))
    };
    let (from, half, to) = (rotation(0.0), rotation(0.5), rotation(1.0));
    let expected = from.slerp(&to, 0.5);
    assert!((half.matrix() - expected.matrix()).norm() < 1e-14);
    let zyx = nalgebra::Rotation3::from_euler_angles(
        (-15f64).to_radians(),
        10f64.to_radians(),
        30f64.to_radians(),
    );
    assert!((to.matrix() - zyx.matrix()).norm() < 1e-14);
    let h = 1e-5;
    for axis in 0..3 {
        let [low, at, high] = [0.3 - h, 0.3, 0.3 + h].map(|t| motion.at(t).nth(axis).unwrap());
        assert!(((high.value - low.value) / (2.0 * h) - at.rate).abs() < 1e-8);
        assert!(((high.rate - low.rate) / (2.0 * h) - at.acceleration).abs() < 1e-7);
    }
}

#[test]
fn defects_are_explained() {
    for (text, says) in [
        ("waypoints = 3", "a list of at least two tables"),
        ("waypoints = [{ tool.x = 0 }]", "a list of at least two tables"),
        ("waypoints = [{ tool.x = 0 }]", "found only one"),
        ("waypoints = []", "found none"),
        ("waypoints = [{ tool.x = 0 }, 3]", "a table of coordinates"),
        ("waypoints = [{ tool.x = 0 }, { tool.x = 1 }]", "the duration of the move"),
        ("waypoints = [{ tool.x = 0 }, { tool.y = 1, at = 1 }]", "does not give `tool.y`"),
        ("waypoints = [{ tool.x = 0, at = 0 }, { tool.x = 1, at = 1 }]", "cannot have `at`"),
        ("waypoints = [{ tool.x = 0 }, { tool.x = 1, at = -1 }]", "must take more than 0 s"),
        (
            "waypoints = [{ tool.x = 0 }, { tool.x = 1, duration = 1 }]\nduration = 2",
            "cannot have `duration`",
        ),
        ("law = \"quintic\"\ntool.x = 1", "needs `waypoints`"),
        (
            "tool.y = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1, at = 1 }]",
            "both waypoints and expressions",
        ),
        (
            "limits.tool.speed = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1, duration = 0.5 }]",
            "its limits require at least 1.875 s",
        ),
        (
            "limits.tool.speed = 1\nlaw = \"trapezoid\"\nwaypoints = [{ tool.x = 0 }, { tool.x = 1 }]",
            "needs a limit of the acceleration",
        ),
        (
            "limits.left_motor.speed = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1 }]",
            "leave one degree of freedom undetermined",
        ),
        (
            "limits.tool.acceleration = 9\nwaypoints = [{ tool.x = 0, tool.y = 0.3 }, { tool.x = 0.1, blend = 0.09 }, { tool.x = 0 }]",
            "of `tool` reaches",
        ),
        (
            "waypoints = [{ tool.rotation = { axis = \"z\", angle = 0 } }, { tool.rotation = { axis = \"z\", angle = 1 }, at = 1, blend = 0.1 }, { tool.rotation = { axis = \"z\", angle = 1.5 }, at = 2 }]",
            "`blend` is not possible between waypoints with a `rotation`",
        ),
        (
            "limits.left_moter.speed = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1 }]",
            "`left_moter` is not a coordinate of the waypoints",
        ),
        ("limits.speed = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1 }]", "needs the name"),
        (
            "law = \"trapezoid\"\nlimits.tool = { acceleration = 9, jerk = 3 }\nwaypoints = [{ tool.x = 0 }, { tool.x = 1 }]",
            "jerk cannot be limited",
        ),
        (
            "limits.left_motor.speed = 1\nwaypoints = [{ tool.x = 0, tool.y = 0.3 }, { tool.x = 3 }]",
            "cannot be evaluated",
        ),
        (
            "law = \"s-curve\"\nlimits.tool = { acceleration = 9, jerk = 300 }\nwaypoints = [{ tool.x = 0, tool.y = 0.3 }, { tool.x = 0.1, blend = 0.02 }, { tool.y = 0.35 }]",
            "in the blend the jerk of `tool` reaches 1.414 times",
        ),
        (
            "waypoints = [{ tool.x = 0 }, { tool.x = 1, law = \"sin\", at = 1 }]",
            "`sin` is not understood",
        ),
        ("waypoints = [{ toool.x = 0 }, { tool.x = 1, at = 1 }]", "did you mean `tool`"),
        (
            "waypoints = [{ tool.rotation = { axis = \"z\", angle = 0 } },
                { tool.rotation = { axis = \"z\", angle = 2 }, at = 1 },
                { tool.rotation = { axis = \"z\", angle = 3.5 }, at = 2 }]",
            "half a turn",
        ),
    ] {
        let message = motion(text).unwrap_err();
        assert!(message.contains(says), "{text}: {message}");
    }
}

/// An arm with a revolute and a prismatic joint, whose tool moves in a plane.
const POLAR: &str = "
gravity = [0, 0, -9.81]
[bodies.arm]
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
[bodies.tool]
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
[joints.turn]
type = \"R\"
from = \"ground\"
to = \"arm\"
axis = \"z\"
actuated = true
[joints.reach]
type = \"P\"
from = \"arm\"
to = \"tool\"
axis = \"y\"
actuated = true
start = 0.3
";

fn polar(text: &str) -> Result<Motion, String> {
    let source = Source::new("polar.toml", POLAR);
    let model = read(&source, &|_| Err("no files".to_owned())).unwrap();
    model
        .read_motion(&Source::new("motion.toml", text), &|_| Err("no files".to_owned()))
        .map_err(|diagnostics| diagnostics.to_string())
}

/// A tool passes the pivot at a distance of 0.3 m on a straight line of 0.4 m. At its middle, the
/// line is perpendicular to the arm, and the arm rotates fastest: at 1.875 times the mean speed of
/// a quintic, over 0.3 m.
#[test]
fn joint_limits_of_a_straight_line() {
    let motion = polar(
        "limits.turn.speed = \"2 rad/s\"\nwaypoints = [{ tool.x = -0.2, tool.y = 0.3 }, { tool.x = 0.2 }]",
    )
    .unwrap();
    let expected = 1.875 * 0.4 / 0.3 / 2.0;
    assert!((motion.duration - expected).abs() < 1e-9 * expected, "{}", motion.duration);
}

/// On a radial line, the length of the arm is the distance of the tool, so the limits of the joint
/// and of the tool give the same move for every law.
#[test]
fn joint_limits_along_a_radius() {
    for law in ["quintic", "cycloid", "modified-sine", "trapezoid", "s-curve"] {
        for (speed, acceleration, jerk) in [(0.5, 3.0, 40.0), (5.0, 3.0, 40.0), (0.5, 30.0, 4.0)] {
            let duration = |name: &str| {
                let jerk = match law {
                    "trapezoid" => String::new(),
                    _ => format!(", jerk = {jerk}"),
                };
                let text = format!(
                    "law = \"{law}\"\nlimits.{name} = {{ speed = {speed}, acceleration = {acceleration}{jerk} }}\n\
                     waypoints = [{{ tool.x = 0, tool.y = 0.3 }}, {{ tool.y = 0.9 }}]",
                );
                polar(&text).unwrap().duration
            };
            let (straight, joint) = (duration("tool"), duration("reach"));
            // The search for the phases ends near the shortest move, never below it.
            let near = if matches!(law, "trapezoid" | "s-curve") { 1e-4 } else { 1e-9 };
            let excess = joint / straight - 1.0;
            assert!(excess > -1e-9 && excess < near, "{law} {speed}: {excess}");
        }
    }
}

/// Motion of a gallery robot's degrees of freedom along prescribed coordinates.
struct Along<'a> {
    solver: InverseDynamics,
    motion: &'a Motion,
    dofs: &'a [(JointId, usize)],
    now: f64,
}

impl<'a> Along<'a> {
    fn new(name: &str, motion: &'a Motion, dofs: &'a [(JointId, usize)]) -> Self {
        let model = model(name);
        let coordinates: Vec<Coordinate> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let start: Vec<Target<f64>> = motion.at(0.0).collect();
        let (mechanism, settings) = (model.mechanism.clone(), Settings::default());
        let poses = &model.initial_poses;
        let solver =
            InverseDynamics::new(mechanism, poses, &coordinates, &start, settings).unwrap();
        Self { solver, motion, dofs, now: 0.0 }
    }

    fn at(&mut self, time: f64) -> Vec<Target<f64>> {
        let motion = self.motion;
        let at = |t: f64, out: &mut [Target<f64>]| {
            out.iter_mut().zip(motion.at(t)).for_each(|(out, target)| *out = target);
        };
        self.solver.follow(self.now, time, at).unwrap();
        self.now = time;
        self.dofs.iter().map(|(joint, dof)| self.solver.joint_motion(*joint, *dof)).collect()
    }
}

/// Greatest rate, acceleration and jerk of degrees of freedom of a hexapod along a motion.
fn greatest(motion: &Motion, dofs: &[(JointId, usize)], count: u32) -> [f64; 3] {
    let mut along = Along::new("gough", motion, dofs);
    let step = motion.duration / f64::from(count);
    let mut most = [0.0_f64; 3];
    let mut before: Vec<f64> = Vec::new();
    for k in 0..=count {
        let now = along.at(step * f64::from(k));
        for (leg, target) in now.iter().enumerate() {
            most[0] = most[0].max(target.rate.abs());
            most[1] = most[1].max(target.acceleration.abs());
            if let Some(last) = before.get(leg) {
                most[2] = most[2].max((target.acceleration - last).abs() / step);
            }
        }
        before = now.iter().map(|target| target.acceleration).collect();
    }
    most
}

/// Greatest rate or acceleration, by golden-section search around the greatest sample of each
/// degree of freedom.
fn greatest_between(motion: &Motion, dofs: &[(JointId, usize)], of_rate: bool) -> f64 {
    const SAMPLES: u32 = 2_000;
    let mut most = 0.0_f64;
    for dof in dofs {
        let mut along = Along::new("gough", motion, std::slice::from_ref(dof));
        let mut value = |time: f64| {
            let target = along.at(time)[0];
            if of_rate { target.rate.abs() } else { target.acceleration.abs() }
        };
        let step = motion.duration / f64::from(SAMPLES);
        let samples: Vec<f64> = (0..=SAMPLES).map(|k| value(step * f64::from(k))).collect();
        let greatest = samples.iter().copied().fold(0.0, f64::max);
        most = most.max(greatest);
        let place = samples.iter().position(|sample| *sample == greatest).unwrap() as f64;
        let (mut low, mut high) =
            ((place - 1.0).max(0.0) * step, ((place + 1.0) * step).min(motion.duration));
        for _ in 0..45 {
            let third = 0.381_966_011_25 * (high - low);
            let (a, b) = (value(low + third), value(high - third));
            most = most.max(a).max(b);
            if a > b { high -= third } else { low += third }
        }
    }
    most
}

/// Waypoints of the platform of a hexapod.
const WAYS: &str = "waypoints = [{ platform.x = 0, platform.y = 0, platform.z = 0.75,\n\
     platform.rotation = { axis = \"x\", angle = 0 } },\n\
     { platform.x = 0.1, platform.rotation = { axis = [1, 2, 0], angle = \"20 deg\" } },\n\
     { platform.z = 0.6 }]";

/// Moves of a hexapod with limits of its legs: no limit is exceeded at any instant, and one limit
/// is reached in each move.
#[test]
fn legs_of_a_hexapod_keep_their_limits() {
    let model = model("gough");
    let limits = [0.6, 7.0, 250.0];
    for law in ["quintic", "cycloid", "modified-sine", "trapezoid", "s-curve"] {
        let jerk = if law == "trapezoid" { "" } else { ", jerk = 250" };
        let text = format!(
            "law = \"{law}\"\nlimits.actuators = {{ speed = 0.6, acceleration = 7{jerk} }}\n{WAYS}",
        );
        let motion = motion_of("gough", &text).unwrap();
        let legs: Vec<_> = model.mechanism.actuators().collect();
        let most = greatest(&motion, &legs, 20_000);
        let ratios: Vec<f64> = most.iter().zip(limits).map(|(a, b)| a / b).collect();
        assert!(ratios[0] < 1.0 + 1e-9 && ratios[1] < 1.0 + 1e-9, "{law}: {ratios:?}");
        let jumps = law == "trapezoid";
        // Differences of accelerations that are accurate to about 1e-12 of 7 m/s^2.
        assert!(jumps || ratios[2] < 1.0 + 1e-6, "{law}: {ratios:?}");
        let last = if jumps { 2 } else { 3 };
        let reached = ratios[..last].iter().fold(0.0_f64, |most, ratio| most.max(*ratio));
        assert!(reached > 1.0 - 1e-4, "{law}: {ratios:?}");
    }
}

/// Rates and accelerations of passive joints can be greatest anywhere, also near the ends of
/// pieces.
#[test]
fn passive_joints_of_a_hexapod_keep_their_limits() {
    let model = model("gough");
    for leg in 1..=6 {
        let joint = model.mechanism.joint_id(&format!("leg{leg}.U")).unwrap();
        for (dof, name) in ["first", "second"].into_iter().enumerate() {
            let text = format!(
                "law = \"quintic\"\nlimits.leg{leg}.U.{name} = {{ speed = 0.5, acceleration = 4 }}\n{WAYS}",
            );
            let motion = motion_of("gough", &text).unwrap();
            let most = greatest(&motion, &[(joint, dof)], 4_000);
            let ratios = [most[0] / 0.5, most[1] / 4.0];
            assert!(
                ratios.iter().all(|ratio| *ratio < 1.0 + 1e-9),
                "leg{leg}.U.{name}: {ratios:?}"
            );
            // The greatest of 4000 samples.
            assert!(ratios[0].max(ratios[1]) > 1.0 - 1e-5, "leg{leg}.U.{name}: {ratios:?}");
        }
    }
}

/// Limits of the path of a body that follows from prescribed joints: the tip of an arm of 0.4 m
/// that rotates by 1.2 rad has a limited speed; its acceleration also has a radial component.
#[test]
fn paths_of_bodies_that_follow_from_joints() {
    const ARM: &str = "gravity = [0, 0, 0]\n[bodies.arm]\n[joints.turn]\ntype = \"R\"\nfrom = \"ground\"\nto = \"arm\"\n\
        axis = \"z\"\nactuated = true\n[bodies.tip]\n[joints.end]\ntype = \"fixed\"\nfrom = \"arm\"\nto = \"tip\"\n\
        at = [0.4, 0, 0]\n";
    let model = read(&Source::new("arm.toml", ARM), &|_| Err("no files".to_owned())).unwrap();
    let motion = |limits: &str| {
        let text = format!(
            "law = \"quintic\"\nlimits.tip = {limits}\nwaypoints = [{{ turn = 0 }}, {{ turn = 1.2 }}]"
        );
        model
            .read_motion(&Source::new("motion.toml", text), &|_| Err("no files".to_owned()))
            .unwrap()
    };
    // A quintic's greatest speed is 15/8 of the mean speed.
    let found = motion("{ speed = 0.3 }").duration;
    let expected = 1.875 * 0.4 * 1.2 / 0.3;
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    let own = motion("{ acceleration = 2 }");
    let most = (0..=100_000).map(|k| {
        let target = own.at(own.duration * f64::from(k) / 1e5).next().unwrap();
        0.4 * (target.rate * target.rate).hypot(target.acceleration)
    });
    let most = most.fold(0.0_f64, f64::max);
    assert!((most / 2.0 - 1.0).abs() < 1e-9, "{most}");
}

/// Limits of legs are reached by every law: the greatest speed and acceleration, found between
/// samples by a search, equal the limits to 1e-9. The acceleration of a trapezoid jumps, so that a
/// search finds its greatest value on one side only.
#[test]
fn legs_of_a_hexapod_reach_their_limits() {
    let model = model("gough");
    let legs: Vec<_> = model.mechanism.actuators().collect();
    for law in ["quintic", "cycloid", "modified-sine", "trapezoid", "s-curve"] {
        for of_rate in [true, false] {
            // The other limits are far away; trapezoid and s-curve require them.
            let limits = match (law, of_rate) {
                ("trapezoid", true) => "speed = 0.2, acceleration = 50",
                ("s-curve", true) => "speed = 0.2, acceleration = 50, jerk = 9000",
                ("s-curve", false) => "acceleration = 4, jerk = 9000",
                (_, true) => "speed = 0.2",
                (_, false) => "acceleration = 4",
            };
            let limit = if of_rate { 0.2 } else { 4.0 };
            let text = format!("law = \"{law}\"\nlimits.actuators = {{ {limits} }}\n{WAYS}");
            let motion = motion_of("gough", &text).unwrap();
            let ratio = greatest_between(&motion, &legs, of_rate) / limit;
            assert!((ratio - 1.0).abs() < 1e-9, "{law}, {limits}: {ratio}");
        }
    }
}

/// A blend during which the sum of two moves exceeds a limit is refused. The message states the
/// longest possible blend, if there is one.
#[test]
fn a_blend_that_is_too_long_names_the_longest() {
    let text = |law: &str, limits: &str, blend: &str| {
        format!(
            "law = \"{law}\"\nlimits.{limits}\nwaypoints = [{{ tool.x = -0.08, tool.y = 0.34 }},\n\
             {{ tool.y = 0.38, blend = {blend} }}, {{ tool.x = 0.08 }}]"
        )
    };
    for limits in ["tool = { acceleration = 20 }", "actuators = { acceleration = 90 }"] {
        let message = motion(&text("cycloid", limits, "0.03")).unwrap_err();
        let (_, rest) = message.split_once("the longest blend within the limits takes ").unwrap();
        let longest = rest.split(' ').next().unwrap();
        assert!(longest.parse::<f64>().unwrap() < 0.03, "{message}");
        motion(&text("cycloid", limits, longest)).unwrap();
        let longer = format!("{}", 1.02 * longest.parse::<f64>().unwrap());
        assert!(motion(&text("cycloid", limits, &longer)).is_err(), "{limits}: {longest}");
    }
    let limits = "tool = { acceleration = 20, jerk = 900 }";
    let message = motion(&text("s-curve", limits, "0.01")).unwrap_err();
    assert!(message.contains("no blend is short enough"), "{message}");
    assert!(message.contains("their greatest jerk at this waypoint"), "{message}");
}
