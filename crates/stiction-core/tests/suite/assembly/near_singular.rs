//! Assembly near singular configurations, from starts where the loops cannot be closed at first
//! order.

use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::joint::JointType::{Prismatic, Revolute};
use stiction_core::kinematics::{AssemblyError, Coordinate, Gap, Target, locks};
use stiction_core::mechanism::{BodySpec, JointId, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::random::Random;
use stiction_core::spatial::{Pose, Vec3};

use crate::common::{along, v};

/// Creates a planar chain of bars along x between two pivots on the ground with the distance
/// `base`.
fn bars(lengths: &[f64], base: f64) -> Mechanism {
    let mut builder = MechanismBuilder::new("bars");
    let name = |bar: usize| if bar == 0 { "ground".to_owned() } else { format!("b{bar}") };
    for bar in 1..=lengths.len() {
        builder = builder.body(BodySpec::new(name(bar)).mass(1.0));
    }
    for bar in 0..=lengths.len() {
        let end = if bar == 0 { 0.0 } else { lengths[bar - 1] };
        let (next, at) = if bar == lengths.len() { (name(0), base) } else { (name(bar + 1), 0.0) };
        let joint = JointSpec::new(format!("j{bar}"), Revolute, name(bar), next);
        let ends = [end, at].map(|x| Pose::at(v(x, 0.0, 0.0)));
        builder = builder.joint(joint.frames(ends[0], ends[1]));
    }
    builder.build().unwrap()
}

/// Creates a slider-crank with the slider on the x axis; the slider's coordinate is its distance
/// from the crank's pivot.
fn slider_crank(crank: f64, rod: f64) -> Mechanism {
    let x = along(Vec3::zero(), Vec3::unit(0));
    let pin = |name: &str, from: &str, to: &str, at: f64| {
        JointSpec::new(name, Revolute, from, to).frames(Pose::at(v(at, 0.0, 0.0)), Pose::identity())
    };
    let bodies = ["crank", "rod", "slider"].map(|name| BodySpec::new(name).mass(1.0));
    let builder = bodies.into_iter().fold(MechanismBuilder::new("slider"), |b, body| b.body(body));
    builder
        .joint(pin("A", "ground", "crank", 0.0))
        .joint(pin("B", "crank", "rod", crank))
        .joint(pin("C", "rod", "slider", rod))
        .joint(JointSpec::new("P", Prismatic, "ground", "slider").frames(x, x).actuated())
        .build()
        .unwrap()
}

fn at_distance(mechanism: &Mechanism, distance: f64) -> Result<InverseDynamics, AssemblyError> {
    let target = Target { value: distance, rate: 0.0, acceleration: 0.0 };
    let slide = [Coordinate::Joint { joint: JointId(3), dof: 0 }];
    InverseDynamics::new(mechanism.clone(), &[], &slide, &[target], Settings::default())
}

/// The search begins with two bars stretched along the line to the slider. At first order, they
/// cannot shorten their distance. Solutions exist on both sides; a note names the other one.
#[test]
fn stretched_bars_leave_their_line() {
    let mut random = Random::new(4);
    for case in 0..40 {
        let [crank, rod] = [1.0, 2.0].map(|x| x + 0.5 * random.number());
        let by = 10_f64.powi(-3 - case % 9);
        let mechanism = slider_crank(crank, rod);
        let distance = crank + rod - by;
        let solver = at_distance(&mechanism, distance)
            .unwrap_or_else(|error| panic!("{by:e} before the dead centre: {error}"));
        let bar = solver.bodies().pose[1].rotation.columns[0];
        let angle = bar.y.atan2(bar.x).abs();
        // The law of cosines without cancellation.
        let versine =
            (crank + rod - distance) * (rod - crank + distance) / (2.0 * crank * distance);
        let exact = 2.0 * (0.5 * versine).sqrt().asin();
        // Loops are closed to 1e-12; at the angle `s`, this changes the angle by 1e-12 / s.
        let tolerance = 1e-12 / exact;
        assert!((angle - exact).abs() < tolerance, "{by:e}: {angle:e}, expected {exact:e}");
        let notes = solver.assembly_report().notes();
        // Modes closer than the distance at which they count as one require no note.
        if exact > 5e-3 {
            assert!(notes.iter().any(|note| note.contains("assembly mode")), "{by:e}: {notes:?}");
        }
    }
}

/// Beyond the dead centre, the error states the gap, however small it is.
#[test]
fn a_small_gap_is_reported_in_full() {
    let mechanism = slider_crank(1.0, 2.0);
    for by in [1e-3, 1e-6, 1e-8] {
        let Err(AssemblyError::Gap(gap)) = at_distance(&mechanism, 3.0 + by) else {
            panic!("{by:e} beyond the dead centre")
        };
        let text = gap.to_string();
        assert!(text.contains("mm"), "{by:e}: {text}");
        let total = gap.length + gap.missed_length;
        assert!((total / by - 1.0).abs() < 0.1, "{by:e}: {gap:?}");
    }
}

fn gap(mechanism: &Mechanism) -> Gap {
    match locks(mechanism, &[], &[], &[]) {
        Err(AssemblyError::Gap(gap)) => gap,
        other => panic!("{other:?}"),
    }
}

/// Three nearly stretched bars between two pivots, assembled without prescribed coordinates. If the
/// bars are too short, the least gap is reported.
#[test]
fn nearly_stretched_bars_close() {
    let mut random = Random::new(9);
    for case in 0..30 {
        let lengths = [0.1, 0.2, 0.15].map(|x| x * (1.0 + 0.3 * random.number()));
        let reach: f64 = lengths.iter().sum();
        let by = reach * 10_f64.powi(-3 - case % 9);
        let found = locks(&bars(&lengths, reach - by), &[], &[], &[]);
        let found = found.unwrap_or_else(|error| panic!("{by:e} before stretched: {error}"));
        assert_eq!(found.len(), 1, "{by:e}: {found:?}");
        let gap = gap(&bars(&lengths, reach + by));
        assert!((gap.length / by - 1.0).abs() < 1e-3, "{by:e}: {gap:?}");
        assert!(gap.to_string().contains("the loops do not close"), "{gap}");
    }
}
