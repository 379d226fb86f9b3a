//! Rest: intervals, breakaway and self-locking against closed forms and against all ways to hold.

mod common;

use common::*;
use stiction::dynamics::{
    AppliedLoad, Bounds, Breakaway, FrictionMode, InverseDynamics, Rest, Settings, Verdict,
};
use stiction::friction::ContactShape;
use stiction::kinematics::{Coordinate, Target};
use stiction_model::Model;
use stiction_study::breakaway::{Findings, look};

/// A model at the start of its default motion under its default load.
fn at_rest(text: &str) -> Findings {
    let model = model_of("rest", text);
    look(&default_job(&model, FrictionMode::Converged), None).unwrap()
}

fn near(found: f64, expected: f64) {
    // Closed forms and the kernel differ by rounding alone.
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1e-3), "{found} {expected}");
}

const G: f64 = 9.81;

#[test]
fn an_inclined_plane() {
    for (angle, mu, mu_back) in [
        (10.0_f64, 0.1, 0.1),
        (10.0, 0.3, 0.3),
        (35.0, 0.6, 0.8),
        (35.0, 0.8, 0.6),
        (60.0, 0.2, 0.2),
    ] {
        let found = at_rest(&format!(
            r#"
            gravity = [0, 0, "-9.81 m/s^2"]
            [bodies.block]
            mass = "3 kg"
            com = [0, 0, 0]
            inertia = [1, 1, 1]
            [joints.plane]
            type = "P"
            from = "ground"
            to = "block"
            axis = ["cos({angle:?} deg)", 0, "sin({angle:?} deg)"]
            actuated = true
            friction = {{ mu = 0.05, mu_static = {mu:?}, backward = {{ mu_static = {mu_back:?} }} }}
            [motions.sit]
            duration = 0
            plane = "0 m"
            [loads.none]
            [default]
            motion = "sit"
            load = "none"
            "#
        ));
        let (s, c) = angle.to_radians().sin_cos();
        let (along, normal) = (3.0 * G * s, 3.0 * G * c);
        let (low, high) = found.forces.drive_bounds[0];
        // Up the plane friction forward must be overcome, down it friction backward holds.
        near(high, along + mu * normal);
        near(low, along - mu_back * normal);
        assert_eq!(found.forces.bounds, Bounds::Exact);
        let breakaway = found.rest.breakaway[0].unwrap();
        near(breakaway.forward.1, high);
        near(breakaway.backward.1, low);
        // Friction that holds the block acts against sliding down: it is negative.
        let holding = &found.rest.unpowered;
        let locks = mu_back >= s / c;
        assert_eq!(holding.verdict, if locks { Verdict::Holds } else { Verdict::Slips });
        near(holding.needed.1, s / c / mu_back);
        assert_eq!(holding.needed.0, holding.needed.1);
        if locks {
            near(holding.frictions[0][0], -along);
        }
        assert_eq!(found.rest.alone[0], *holding);
    }
}

/// The screw jack of the text books, `W r tan(l + r')` to raise a load and `W r tan(r' - l)` to lower
/// it; it locks itself where `r' >= l`.
#[test]
fn a_screw_jack() {
    for (lead, mu) in [(5.0_f64, 0.05), (5.0, 0.12), (40.0, 0.12), (12.0, 0.2)] {
        let found = at_rest(&format!(
            r#"
            gravity = [0, 0, "-9.81 m/s^2"]
            [bodies.nut]
            mass = "50 kg"
            com = [0, 0, 0]
            inertia = [1, 1, 1]
            [joints.screw]
            type = "H"
            from = "ground"
            to = "nut"
            axis = "z"
            pitch = "{lead:?} mm/rev"
            actuated = true
            friction = {{ mu = {mu:?}, radius = "9 mm", flank_angle = "15 deg" }}
            [motions.sit]
            duration = 0
            screw = "0 deg"
            [loads.none]
            [default]
            motion = "sit"
            load = "none"
            "#
        ));
        let (weight, radius) = (50.0 * G, 0.009);
        let slope = 1e-3 * lead / std::f64::consts::TAU / radius;
        let climb = slope.atan();
        // The flank angle is declared in a section along the axis.
        let flank = (15.0_f64.to_radians().tan() * climb.cos()).atan();
        let friction = (mu / flank.cos()).atan();
        let (low, high) = found.forces.drive_bounds[0];
        near(high, weight * radius * (climb + friction).tan());
        near(low, weight * radius * (climb - friction).tan());
        let holding = &found.rest.unpowered;
        let locks = friction >= climb;
        assert_eq!(holding.verdict, if locks { Verdict::Holds } else { Verdict::Slips });
        // On a screw the normal force depends on the friction; with the demand met, it does not.
        near(holding.needed.1, slope * flank.cos() / mu);
        near(holding.needed.0, slope * flank.cos() / mu);
    }
}

/// A collar on a rod with supports at a distance s, pushed along it at the offset e, holds whatever
/// the force where `mu 2 e / s >= 1`.
#[test]
fn a_collar_that_binds() {
    for (offset, mu) in [(0.3_f64, 0.2_f64), (0.2, 0.2), (0.25, 0.2), (0.9, 0.05)] {
        let found = at_rest(&format!(
            r#"
            gravity = [0, 0, 0]
            [bodies.collar]
            [joints.guide]
            type = "P"
            from = "ground"
            to = "collar"
            axis = "z"
            actuated = true
            friction = {{ mu = {mu:?}, bending_span = "100 mm" }}
            [motions.sit]
            duration = 0
            guide = "0 m"
            [loads.push]
            collar = {{ force = [0, 0, "-70 N"], at = ["{offset:?} m", 0, 0] }}
            [default]
            motion = "sit"
            load = "push"
            "#
        ));
        let grip = mu * 2.0 * offset / 0.1;
        let holding = &found.rest.unpowered;
        assert_eq!(holding.verdict, if grip >= 1.0 { Verdict::Holds } else { Verdict::Slips });
        near(holding.needed.1, 1.0 / grip);
        near(holding.needed.0, 1.0 / grip);
    }
}

/// A crank with a weight on its slider. The rod presses the slider against its guide: with the crank
/// up by t and the rod down by p, its push P obeys `P cos p = F + f`, `N = |W + P sin p|`.
#[test]
fn a_slider_crank() {
    for (turn, mu, load) in [(50.0_f64, 0.15, 200.0), (120.0, 0.3, -80.0), (300.0, 0.2, 40.0)] {
        let (sin_t, cos_t) = turn.to_radians().sin_cos();
        let sin_p = 0.1 * sin_t / 0.25;
        let cos_p = (1.0 - sin_p * sin_p).sqrt();
        let (down, slide) = (sin_p.asin().to_degrees(), 0.1 * cos_t + 0.25 * cos_p);
        let text = format!(
            r#"
            gravity = [0, 0, 0]
            [bodies.crank]
            [bodies.rod]
            [bodies.slider]
            [joints.A]
            type = "R"
            from = "ground"
            to = "crank"
            axis = "z"
            actuated = true
            start = "{turn:?} deg"
            [joints.B]
            type = "R"
            from = "crank"
            to = "rod"
            at = ["100 mm", 0, 0]
            axis = "z"
            start = "{:?} deg"
            [joints.C]
            type = "R"
            from = "rod"
            to = "slider"
            at = ["250 mm", 0, 0]
            axis = "z"
            start = "{down:?} deg"
            [joints.guide]
            type = "P"
            from = "ground"
            to = "slider"
            axis = "x"
            start = "{slide:?} m"
            friction = {{ mu = {mu:?} }}
            [motions.sit]
            duration = 0
            A = "{turn:?} deg"
            [loads.push]
            slider = {{ force = ["{:?} N", "-60 N", 0] }}
            [default]
            motion = "sit"
            load = "push"
            "#,
            -turn - down,
            -load,
        );
        let found = at_rest(&text);
        // The push P for friction f = s mu N with the sign n of N's content.
        let mut torques = Vec::new();
        for (s, n) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let push = (load + s * mu * n * 60.0) / (cos_p - s * mu * n * sin_p);
            if n * (60.0 + push * sin_p) >= 0.0 {
                torques.push(-push * 0.1 * (sin_t * cos_p + cos_t * sin_p));
            }
        }
        let low = torques.iter().copied().fold(f64::INFINITY, f64::min);
        let high = torques.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (found_low, found_high) = found.forces.drive_bounds[0];
        near(found_low, low);
        near(found_high, high);
        let (outer_low, outer_high) = found.forces.drive_outer_bounds[0];
        assert!(outer_low <= low && high <= outer_high);
        // Where the push P vanishes, friction alone carries the load.
        let needed = load.abs() / (mu * 60.0);
        let holding = &found.rest.unpowered;
        near(holding.needed.1, needed);
        near(holding.needed.0, needed);
        assert_eq!(holding.verdict, if needed <= 1.0 { Verdict::Holds } else { Verdict::Slips });
    }
}

/// The drives of a mechanism at rest with every contact holding by a part of its greatest friction;
/// none where friction and reactions do not settle.
struct Holder {
    solver: InverseDynamics,
    loads: Vec<AppliedLoad<f64>>,
    targets: Vec<Target<f64>>,
    rest: Rest,
}

impl Holder {
    /// At an instant of a model's default motion.
    fn new(model: &Model, time: f64) -> Self {
        let job = default_job(model, FrictionMode::Converged);
        let (coordinates, targets): (Vec<Coordinate>, Vec<Target<f64>>) = job
            .motion
            .coordinates
            .iter()
            .map(|(c, course)| (*c, Target { rate: 0.0, acceleration: 0.0, ..course.at(time) }))
            .unzip();
        let loads: Vec<_> = job.load.at(time).collect();
        let mechanism = model.mechanism.clone();
        let settings = Settings::default();
        let mut solver =
            InverseDynamics::new(mechanism, &model.homes, &coordinates, &targets, settings)
                .unwrap();
        let rest = solver.rest(&loads).unwrap();
        Self { solver, loads, targets, rest }
    }

    fn drives(&self, held: &[[f64; 3]]) -> Option<Vec<f64>> {
        self.balance(held).map(|(drives, _)| drives)
    }

    /// Drives and the loads of contacts.
    fn balance(&self, held: &[[f64; 3]]) -> Option<(Vec<f64>, Vec<f64>)> {
        let kernel = self.solver.kernel().unwrap();
        let parameters = self.solver.parameters();
        let settings = Settings::default();
        let mut workspace = kernel.workspace(parameters, self.solver.assembly().state());
        for (contact, held) in held.iter().enumerate() {
            workspace.inverse.set_held(contact, *held);
        }
        kernel.run(parameters, &mut workspace, &self.targets, &self.loads, &settings);
        let inverse = &workspace.inverse;
        let loads = inverse.contacts().iter().map(|contact| contact.load()).collect();
        inverse.friction_settled(&settings).then(|| (inverse.drives().to_vec(), loads))
    }
}

/// SplitMix64, in (-1, 1).
struct Random(u64);

impl Random {
    fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Two actuators: all ways to put the frictions of a five-bar's pins at a limit or at nothing.
#[test]
fn a_five_bar_against_all_ways_to_hold_it() {
    let model = model("five-bar");
    let holder = Holder::new(&model, 0.37);
    let contacts = holder.solver.parameters().contacts.len();
    assert!(contacts >= 5);
    let forces = holder.solver.forces();
    let mut reached = vec![(f64::INFINITY, f64::NEG_INFINITY); 2];
    for number in 0..3_usize.pow(contacts as u32) {
        let digit = |k: usize| (number / 3_usize.pow(k as u32) % 3) as f64 - 1.0;
        let held: Vec<[f64; 3]> = (0..contacts).map(|k| [digit(k), 0.0, 0.0]).collect();
        for (reached, drive) in reached.iter_mut().zip(holder.drives(&held).unwrap()) {
            *reached = (reached.0.min(drive), reached.1.max(drive));
        }
    }
    for (k, (low, high)) in reached.into_iter().enumerate() {
        near(forces.drive_bounds[k].0, low);
        near(forces.drive_bounds[k].1, high);
        let (outer_low, outer_high) = forces.drive_outer_bounds[k];
        assert!(outer_low <= low && high <= outer_high);
        // Certified bounds that say nothing would be no help.
        assert!(
            outer_high - outer_low < 1.2 * (high - low),
            "{outer_low} {low} {high} {outer_high}"
        );
    }
}

/// Admissible static frictions at random: none leads beyond the intervals.
#[test]
fn balls_and_pins_of_a_robot_against_random_ways_to_hold_it() {
    let model = model("3rps");
    let holder = Holder::new(&model, 0.3);
    let contacts = &holder.solver.parameters().contacts;
    let forces = holder.solver.forces();
    let mut random = Random(7);
    let mut widest = [0.0_f64; 3];
    for round in 0..2000 {
        let held: Vec<[f64; 3]> = contacts
            .iter()
            .map(|contact| {
                let mut held = [0.0, 0.0, 0.0].map(|_: f64| random.signed());
                if contact.shape != ContactShape::Ball {
                    held = [held[0], 0.0, 0.0];
                }
                // Half of them at their limits, the others within.
                let size = held.iter().map(|x| x * x).sum::<f64>().sqrt();
                let over = if round % 2 == 0 { 1.0 / size } else { 1.0 / size.max(1.0) };
                held.map(|x| x * over)
            })
            .collect();
        for (k, drive) in holder.drives(&held).unwrap().into_iter().enumerate() {
            let (low, high) = forces.drive_bounds[k];
            let rounding = 1e-9 * (high - low);
            assert!((low - rounding..=high + rounding).contains(&drive), "{low} {drive} {high}");
            let centre = forces.drives[k];
            widest[k] = widest[k].max(((drive - centre) / (high - centre)).abs());
        }
    }
    // Random signs of many contacts seldom agree, but come some way.
    assert!(widest.iter().all(|w| *w > 0.4), "{widest:?}");
    for ((low, high), (outer_low, outer_high)) in
        forces.drive_bounds.iter().zip(&forces.drive_outer_bounds)
    {
        assert!(outer_low <= low && high <= outer_high);
    }
}

/// Statics say which static friction raises a drive most, kinematics which motion impends. Friction
/// takes power from the motion, so both are the same, but for loads: to first order in the
/// coefficients the ends of the interval are the breakaway efforts. Where contacts slide to and fro
/// only, and none slowly (pins of planar mechanisms), the loads change no direction, and they agree.
#[test]
fn breakaway_is_at_the_ends_of_the_interval() {
    let mut compared = 0;
    for name in regular() {
        let model = model(name);
        let Ok(found) = look(&default_job(&model, FrictionMode::Converged), Some(0.0)) else {
            continue;
        };
        for (k, breakaway) in found.rest.breakaway.iter().enumerate() {
            let (Some(breakaway), (low, high)) = (breakaway, found.forces.drive_bounds[k]) else {
                continue;
            };
            let rounding = 1e-9 * (low.abs() + high.abs());
            let (back, forth) = (breakaway.backward.1, breakaway.forward.1);
            assert!(low - rounding <= back && forth <= high + rounding, "{name} {breakaway:?}");
            let planar = ["five-bar", "four-bar", "slider-crank", "3rrr"].contains(&name);
            let gap = (back - low).max(high - forth);
            assert!(!planar || gap <= rounding, "{name} {breakaway:?} {low} {high}");
            compared += usize::from(high - low > 1e-6);
        }
    }
    assert!(compared > 10, "{compared}");
}

/// A guide and a plate that load each other strongly: where motion begins friction is within its limits, so what
/// is attained reaches as far.
#[test]
fn motion_begins_within_the_interval() {
    const STRONG: &str = r#"
gravity = [5.92, 9.7, -5.62]
[base]
rotation = { xzy = ["81 deg", "43 deg", "94 deg"] }

[bodies.b0]
com = [-0.062, -0.11, 0.12]
[bodies.b1]
mass = 2.99
com = [-0.021, -0.111, -0.077]
inertia = [0.15, 0.173, 0.14]
[bodies.b2]
[bodies.b3]

[joints.j0]
type = "H"
from = "b0"
to = "ground"
at = [0.366, 0.2943, -0.0668]
to_at = [0.022, 0.11, -0.311]
axis = [0.7, -0.024, -0.51]
turn = { yzx = [-2.23, -0.124, -1.7] }
pitch = 0.017
actuated = true
[joints.guide]
type = "P"
from = "b0"
to = "b1"
at = [0.26, 0.3, 0.043]
axis = [-0.23, 0.8525, -0.64]
turn = { xzx = [0.65, 2.465, -3.0] }
start = 0.075
friction = { mu = 0.14, torsion_arm = 0.1301 }
[joints.j4]
type = "E"
from = "b1"
to = "b2"
at = [0.4, -0.133, -0.361]
to_at = [0.73, -0.0584, -0.169]
axis = [0, 0, -1]
x_axis = [-2.1, 0.14, 0]
actuated = ["angle"]
friction = { mu = 0.1, radius = 0.004, bending_span = 0.22 }
[joints.j3]
type = "P"
from = "b3"
to = "b2"
axis = [-0.385, -0.082, -0.369]
actuated = true
[joints.j2]
type = "S"
from = "b2"
to = "ground"
at = [-0.16, -0.2, -0.018]
to_at = [0.4, -0.3335, -0.0656]

[springs.s0]
from = "b1"
to = "b0"
at = [0.02, 0.36, -0.015]
to_at = [0.2256, -0.201, -0.45]
stiffness = 58
free_length = 0.431

[motions.go]
duration = 0
j0 = -0.18
j4.x = 0.04
j3 = 0.23

[loads.press]
b1 = { force = [12.9, -56, -72.3], moment = [-2.12, 2.66, 0.006], at = [0.26, 0.25, 0.07] }
b3 = { force = [3.1, -78, 39.6], moment = [4.68, 1.1, -7.89], at = [0.3, 0.29, 0.15] }
[default]
motion = "go"
load = "press"
"#;
    let model = model_of("strong", STRONG);
    let found = look(&default_job(&model, FrictionMode::Converged), None).unwrap();
    assert_eq!(found.forces.bounds, Bounds::Attained);
    let mut some = 0;
    for (breakaway, (low, high)) in found.rest.breakaway.iter().zip(&found.forces.drive_bounds) {
        let Some(Breakaway { forward, backward }) = breakaway else { continue };
        for effort in [forward.0, forward.1, backward.0, backward.1] {
            assert!((*low..=*high).contains(&effort), "{low} {effort} {high}");
            some += 1;
        }
    }
    assert_eq!(some, 12);
}

/// Two actuators, no drive: the frictions that are said to hold a five-bar, put into the kernel by
/// their parts of the limits, leave nothing to its drives.
#[test]
fn frictions_that_hold_do_hold() {
    let text = stiction_model::gallery::get("five-bar").unwrap();
    let (mut held, mut slipped) = (0, 0);
    for mu in [0.1, 1.0, 3.0, 6.0, 10.0] {
        let text = text.replace("0.08", &format!("{mu:?}")).replace("0.002", &format!("{mu:?}"));
        let holder = Holder::new(&model_of("five-bar", &text), 0.37);
        let holding = &holder.rest.unpowered;
        assert!(holding.needed.0 <= holding.needed.1, "{mu}: {:?}", holding.needed);
        if holding.verdict != Verdict::Holds {
            assert!(holding.frictions.is_empty() && holding.needed.1 > 1.0);
            slipped += usize::from(holding.verdict == Verdict::Slips);
            continue;
        }
        // Of the loads under these frictions only the kernel knows: they are found in turn.
        let mut loads: Vec<f64> = holder.solver.forces().contacts.iter().map(|c| c.load).collect();
        let mut left = f64::INFINITY;
        for _ in 0..1000 {
            let part = |(friction, load): (&Vec<f64>, &f64)| [friction[0] / (mu * load), 0.0, 0.0];
            let parts: Vec<[f64; 3]> = holding.frictions.iter().zip(&loads).map(part).collect();
            let Some((drives, found)) = holder.balance(&parts) else { break };
            left = drives.iter().fold(0.0, |max: f64, drive| max.max(drive.abs()));
            loads = loads.iter().zip(found).map(|(old, new)| 0.5 * (old + new)).collect();
            if left < 1e-9 {
                assert!(parts.iter().all(|part| part[0].abs() <= 1.0 + 1e-9), "{mu}: {parts:?}");
                break;
            }
        }
        assert!(left < 1e-9, "{mu}: {left}");
        held += 1;
    }
    assert!(held > 0 && slipped > 0, "{held} {slipped}");
}

/// The breakaway effort of a leg is what slow motion of that leg takes, the other legs standing.
#[test]
fn breakaway_is_the_limit_of_slow_motion() {
    let model = model("3rps");
    let holder = Holder::new(&model, 0.3);
    let legs: Vec<_> = model.mechanism.actuators().collect();
    let coordinates: Vec<Coordinate> =
        legs.iter().map(|&(joint, freedom)| Coordinate::Joint { joint, freedom }).collect();
    for (k, breakaway) in holder.rest.breakaway.iter().enumerate() {
        let breakaway = breakaway.unwrap();
        for (rate, expected) in [(1e-8, breakaway.forward), (-1e-8, breakaway.backward)] {
            let targets: Vec<Target<f64>> = legs
                .iter()
                .enumerate()
                .map(|(leg, &(joint, freedom))| Target {
                    value: holder.solver.joint_coordinates(joint)[freedom],
                    rate: if leg == k { rate } else { 0.0 },
                    acceleration: 0.0,
                })
                .collect();
            let (mechanism, homes) = (model.mechanism.clone(), &model.homes);
            let settings = Settings { rest_speed: 1e-14, ..Settings::default() };
            let mut solver =
                InverseDynamics::new(mechanism, homes, &coordinates, &targets, settings).unwrap();
            let forces = solver.solve(&holder.loads).unwrap();
            let same = holder.solver.forces().drives_frictionless.iter();
            for (a, b) in same.zip(&forces.drives_frictionless) {
                assert!((a - b).abs() < 1e-9 * a.abs(), "another position: {a} {b}");
            }
            // Legs that stand have guides at rest, with no friction or any: the effort is between.
            let (least, greatest) = (expected.0.min(expected.1), expected.0.max(expected.1));
            let (low, high) = forces.drive_bounds[k];
            // Viscous friction at 1e-8 m/s, and what slow contacts of the standing legs leave.
            let near = 1e-6;
            assert!(
                (low - least).abs() < near && (high - greatest).abs() < near,
                "{k} {rate}: {low} {high} {expected:?}"
            );
        }
    }
}
