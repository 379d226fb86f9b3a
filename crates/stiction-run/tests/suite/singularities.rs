//! Singular positions along motions: their instants, loads that cannot be carried, and whether
//! another motion avoids them.

use crate::common::*;
use stiction_core::dynamics::FrictionMode;
use stiction_run::check::{Findings, Kind, examine};
use stiction_run::{Follower, Job};

fn found(job: &Job<'_>) -> Findings {
    examine(job, |_, _, _| true).unwrap()
}

/// Tests a slider-crank with an actuated slider. It is singular at its dead centres, where the
/// crank and the rod are collinear. With a prescribed crank angle, the dead centres occur at known
/// instants between samples.
#[test]
fn dead_centres_are_located_between_samples() {
    let text = stiction_format::gallery::get("slider-crank").unwrap();
    let (before, after) = text.split_once("[joints.A]").unwrap();
    let (a, rest) = after.split_once("actuated = true").unwrap();
    let (between, guide) = rest.split_once("[joints.guide]").unwrap();
    let text = format!(
        "{before}[joints.A]{a}{between}[joints.guide]\nactuated = true{guide}\n\
         [motions.off_centre]\nduration = \"1 s\"\nA = \"10 deg + 360 deg*t\"\n"
    );
    let model = model_of("driven-at-the-slider", &text);
    let load = model.loads[0].0.clone();
    let found = found(&job(&model, "off_centre", &load, FrictionMode::Off));
    let crossings = &found.actuation.crossings;
    assert_eq!(crossings.len(), 2, "{crossings:?}");
    for ((time, gained), expected) in crossings.iter().zip([170.0 / 360.0, 350.0 / 360.0]) {
        // The index is V-shaped; the search may stop at 1e-7 from its minimum.
        assert!((time - expected).abs() < 1e-7, "{time} {expected}");
        // With the slider locked, the crank can turn, and no joint carries the moment of its
        // weight.
        assert_eq!(gained.load, "a moment about z", "{gained:?}");
    }
    assert_eq!(found.actuation.singular_samples, 0);
    assert!(found.actuation.least < 1e-7);
    assert_eq!(found.everywhere(Kind::Actuation), Some(false));
    // The passages found by the sign of the determinant are the same.
    assert_eq!(found.passed.len(), 2);
    assert!(found.passed.iter().zip(crossings).all(|((a, b), (t, _))| a < t && t < b));
}

/// Parallelogram of rods in the horizontal plane, whose crank starts at 60 deg.
fn parallelogram(motion: &str) -> stiction_format::ModelFile {
    let bar = |name: &str, length: f64| {
        format!(
            "[bodies.{name}]\nmass = 1\ncom = [{}, 0, 0]\ninertia = [0, 0.1, 0.1]\n",
            length / 2.0
        )
    };
    let joint = |name: &str, from: &str, to: &str, at: f64, to_at: f64, start: f64| {
        format!(
            "[joints.{name}]\ntype = \"R\"\nfrom = \"{from}\"\nto = \"{to}\"\nat = [{at}, 0, 0]\n\
             to_at = [{to_at}, 0, 0]\naxis = \"z\"\nstart = \"{start} deg\"\n"
        )
    };
    let text = [
        "gravity = [0, 0, 0]\n".to_owned(),
        bar("crank", 1.0) + &bar("coupler", 1.2) + &bar("rocker", 1.0),
        joint("A", "ground", "crank", 0.0, 0.0, 60.0) + "actuated = true\n",
        joint("B", "crank", "coupler", 1.0, 0.0, -60.0),
        joint("C", "coupler", "rocker", 1.2, 1.0, 60.0),
        joint("D", "ground", "rocker", 1.2, 0.0, 60.0),
        format!("[motions.over]\nA = \"{motion}\"\n[loads.none]\n"),
    ];
    model_of("parallelogram", &text.concat())
}

/// Tests a parallelogram that passes its flat position: a constraint singularity, at which another
/// motion branch begins.
#[test]
fn a_flat_parallelogram_is_located() {
    let model = parallelogram("60 deg - 79 deg*t");
    let found = found(&job(&model, "over", "none", FrictionMode::Off));
    for nearness in [&found.actuation, &found.constraint] {
        let times: Vec<f64> = nearness.crossings.iter().map(|(time, _)| *time).collect();
        assert_eq!(times.len(), 1, "{nearness:?}");
        assert!((times[0] - 60.0 / 79.0).abs() < 1e-6, "{times:?}");
    }
    assert_eq!(found.everywhere(Kind::Constraint), Some(false));
}

/// Tests samples at the flat positions of a parallelogram, where the equations do not determine the
/// rates: the motion continues on its branch, on which the coupler translates. Any tension in the
/// line of all rods is possible there; the least is reported, with which the rods from the ground
/// carry half of the coupler each.
#[test]
fn a_parallelogram_passes_samples_at_its_flat_positions() {
    let model = parallelogram("60 deg - 240 deg*t");
    let omega = 240_f64.to_radians();
    for step in [0.001, 0.01, 0.05, 0.25] {
        let job = Job { step: Some(step), ..job(&model, "over", "none", FrictionMode::Off) };
        let mut flat = 0;
        let check = |sample: &stiction_run::inverse::Sample| {
            if sample.distances.constraint < 1e-8 {
                flat += 1;
                // Centripetal forces of the coupler, and of half a metre of crank and rocker.
                let forces = [1.0, 0.5, 0.5, 1.0].map(|radius| radius * omega * omega);
                for ((force, _), expected) in sample.forces.reactions.iter().zip(forces) {
                    let force = force.norm();
                    assert!((force / expected - 1.0).abs() < 1e-6, "{step}: {force} {expected}");
                }
            }
            Ok(())
        };
        job.run(check, |_, _, _| true).unwrap_or_else(|error| panic!("{step}: {error}"));
        assert_eq!(flat, 2, "{step}");
    }
}

/// Tests rates and accelerations at a flat position of a parallelogram, where they follow from those
/// before: its crank and its rocker move alike, also if the motion accelerates or comes to rest
/// there.
#[test]
fn a_parallelogram_moves_steadily_through_its_flat_positions() {
    for motion in ["60 deg - 240 deg*t", "60 deg - 60 deg*t - 2880 deg*t^3", "60 deg*(1 - 4*t)^2"] {
        for step in [1e-3, 1e-2, 0.05, 0.25] {
            let model = parallelogram(motion);
            let mut follower = Follower::new(&model, &model.motions[0].1, 0.0).unwrap();
            let count = (0.5_f64 / step).round() as usize;
            for sample in 1..=count {
                let time = sample as f64 * step;
                follower.go_to(time).unwrap_or_else(|error| panic!("{motion} {step}: {error}"));
                let bodies = follower.solver.bodies();
                let [crank, coupler, rocker] = [1, 2, 3].map(|body| bodies.twist[body].angular.z);
                let size = crank.abs().max(4.0);
                let off = (crank - rocker).abs().max(coupler.abs()) / size;
                let [a, b, c] = [1, 2, 3].map(|body| bodies.acceleration[body].angular.z);
                let bent = (a - c).abs().max(b.abs()) / (size * size);
                assert!(off < 1e-8 && bent < 1e-5, "{motion} {step} {time}: {off:e} {bent:e}");
            }
        }
    }
}

/// Tests the robot as printed, whose roll is blocked at second order only, by `sqrt(3)/2 k roll^2`.
/// The robot is singular in every pose. Along its printed motion, it has a second singularity that
/// other poses do not have.
#[test]
fn the_printed_robot() {
    let model = model("zhang2018");
    let found = found(&default_job(&model, FrictionMode::Off));
    assert_eq!(found.everywhere(Kind::Actuation), Some(true));
    assert_eq!(found.everywhere(Kind::Constraint), Some(true));
    assert_eq!(found.actuation.singular_samples, found.samples);

    let [play] = found.play() else { panic!("{:?}", found.play()) };
    let k: f64 = 0.15;
    let mechanism = &model.mechanism;
    assert_eq!(mechanism.joints()[play.joint.0].name.split('.').next(), Some("leg1"));
    assert_eq!(mechanism.bodies()[play.motion.body].name, "platform");
    for clearance in [1e-6, 1e-5, 1e-4] {
        let roll = (2.0 * clearance / (3f64.sqrt() * k)).sqrt();
        let error = play.with(clearance) / roll - 1.0;
        // The position closes the loops to 1e-13, and the result has an error of the square root of
        // this value.
        assert!(error.abs() < 1e-6, "{clearance}: {error}");
    }
    assert_eq!(format!("{:.2}", play.with(1e-5).to_degrees()), "0.50");

    let weakness = found.constraint.weakness.as_ref().unwrap();
    assert_eq!(weakness.motion, "rotation about the line leg2.S - leg3.S (along x)");
    let (least, greatest, _) = found.actuation_of_motion.unwrap();
    assert!(least.abs() < 1e-9 && greatest < 1e-9, "theta = 90 deg all along: {greatest}");
    assert!(found.architecture.actuation_of_motion.unwrap() > 0.01, "other poses are governed");
}

#[test]
fn singular_architectures_are_distinguished() {
    for name in stiction_format::gallery::names() {
        let model = model(name);
        let found = found(&default_job(&model, FrictionMode::Off));
        let expected = match name {
            "zhang2018" => [true, true],
            "griffis-duffy" => [true, false],
            _ => [false, false],
        };
        let kinds = [Kind::Actuation, Kind::Constraint];
        assert_eq!(kinds.map(|kind| found.everywhere(kind)), expected.map(Some), "{name}");
        let [a, c] = [&found.architecture.actuated, &found.architecture.constraints];
        for rank in [a, c] {
            // Singular values that vanish are zero up to rounding or, if a motion is blocked at
            // second order, up to the square root of the rounding error.
            assert!(rank.kept.unwrap() > 1e-4, "{name}");
            assert!(rank.dropped.is_none_or(|dropped| dropped < 1e-6), "{name}");
        }
        // The search for architecture singularities has moved the mechanism far from its pose.
        assert!(found.architecture.reach > 0.3, "{name}: {}", found.architecture.reach);
    }
}

/// Tests that, at a singular pose that carries its load, the forces are finite and unique up to the
/// self-stress -2 : 1 : 1.
#[test]
fn a_load_in_the_range_of_a_singular_pose() {
    let text = stiction_format::gallery::get("zhang2018").unwrap().to_owned()
        + "\n[motions.home]\nduration = 0\nplatform.x = 0\nplatform.y = \"k/sqrt(3)\"\n\
           platform.z = \"515 mm\"\nplatform.rx = 0\nplatform.ry = 0\nplatform.rz = 0\n";
    let model = model_of("home", &text);
    let run = Run::of(&job(&model, "home", "none", FrictionMode::Off)).unwrap();
    let singular = run.verdict.singular.unwrap();
    assert_eq!((singular.samples, singular.body.as_str()), (1, "platform"));
    assert_eq!(singular.load, "a moment about y");
    let [direction] = singular.null_directions.as_slice() else { panic!("one direction") };
    assert_eq!(direction.drives, [0.0; 3], "actuator efforts are unique");
    let at = |name: &str| {
        let found = direction.joints.iter();
        found.into_iter().find(|l| model.mechanism.joints()[l.joint.0].name == name).unwrap().force
    };
    let [one, two, three] = ["leg1.S", "leg2.S", "leg3.S"].map(|name| at(name).y);
    assert!((one + 2.0 * two).abs() < 1e-12 && (two - three).abs() < 1e-12, "{one} {two} {three}");
    // At other poses there is no such message.
    let regular = crate::common::model("3rps");
    assert_eq!(Run::of(&default_job(&regular, FrictionMode::Off)).unwrap().verdict.singular, None);
}

/// An arm with two fingers has no legs, and so has a four-bar linkage with a link on its coupler:
/// bodies of open chains can always move while the other bodies are fixed.
#[test]
fn open_branches_are_no_legs() {
    let body = |name: &str| {
        format!("[bodies.{name}]\nmass = 1\ncom = [0.1, 0, 0]\ninertia = [0.1, 0.1, 0.1]\n")
    };
    let joint = |name: &str, from: &str, to: &str, at: f64| {
        format!(
            "[joints.{name}]\ntype = \"R\"\nfrom = \"{from}\"\nto = \"{to}\"\nat = [{at}, 0, 0]\n\
             axis = \"z\"\nactuated = true\n"
        )
    };
    let names = ["arm", "left", "right"];
    let mut text = "gravity = [0, -9.81, 0]\n".to_owned() + &names.map(body).concat();
    text += &joint("A", "ground", "arm", 0.0);
    text += &[joint("L", "arm", "left", 0.5), joint("R", "arm", "right", 0.6)].concat();
    text += "[motions.hold]\nduration = 0\nA = 0\nL = 0.2\nR = 0.3\n[loads.none]\n";
    let model = model_of("arm", &text);
    assert!(found(&job(&model, "hold", "none", FrictionMode::Off)).leg.is_none());

    let text = stiction_format::gallery::get("four-bar").unwrap();
    let (text, _) = text.split_once("[motions").unwrap();
    let text = format!(
        "{text}{}{}[motions.hold]\nduration = 0\nA = 1\nlink = 0\n[loads.none]\n",
        body("bob"),
        joint("link", "coupler", "bob", 0.1)
    );
    let model = model_of("four-bar with a link", &text);
    assert!(found(&job(&model, "hold", "none", FrictionMode::Off)).leg.is_none());
}
