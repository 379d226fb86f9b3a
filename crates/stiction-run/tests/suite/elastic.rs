//! Joint springs, gas springs and bushings of model files: writing and reading again, and reports.

use crate::common::{job, model_of};
use crate::drive_trains::with;
use stiction_core::dynamics::FrictionMode;
use stiction_run::Sink;
use stiction_run::breakaway;
use stiction_run::exchange::{Instant, model_file};
use stiction_run::inverse::{Sample, Summary};

/// Lid of 15 kg with a gas spring that is too short for an opening of 80 deg, a torsion spring and
/// a rubber pad.
const LID: &str = "
gravity = [0, 0, -9.81]
[bodies.lid]
mass = 15
com = [0.4, 0, 0]
inertia = [0.1, 0.8, 0.8]
[joints.hinge]
type = \"R\"
from = \"ground\"
to = \"lid\"
axis = \"-y\"
actuated = true
friction = { radius = \"10 mm\", mu = 0.2 }
[springs.strut]
from = \"ground\"
at = [0.25, 0, -0.1]
to = \"lid\"
to_at = [0.3, 0, 0]
extension_force = \"300 N\"
progression = 1.35
extended_length = \"400 mm\"
stroke = \"250 mm\"
damping = \"120 N s/m\"
[springs.coil]
joint = \"hinge\"
stiffness = \"2 N m/rad\"
rest = \"15 deg\"
preload = \"0.4 N m\"
[springs.link]
from = \"ground\"
to = \"lid\"
at = [0, 0, 0.2]
to_at = [0.1, 0, 0]
stiffness = \"1 N/mm\"
free_length = \"180 mm\"
preload = \"-20 N\"
[bushings.pad]
from = \"ground\"
frame = { position = [0.1, 0, 0], rotation = { axis = \"y\", angle = \"10 deg\" } }
to = \"lid\"
to_frame = { position = [0.1, 0, 0] }
stiffness = [10, 20, 30, \"4 N m/rad\", 5, 6]
damping = [[2, 0, 0, 0, 0.1, 0], [0, 2, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0.1, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]
[loads.none]
";
const OPEN: &str =
    "[motions.m]\nduration = 2\nstep = 0.01\nhinge = \"50 deg - 30 deg*cos(pi*t/2 s)\"\n";

#[test]
fn springs_of_all_kinds_are_written_and_read_back() {
    let known = with(&[LID, OPEN]).mechanism;
    let text = model_file(&known, "", Instant::default()).unwrap();
    let read = model_of("machine", &text).mechanism;
    assert_eq!(read.joint_springs(), known.joint_springs());
    assert_eq!((read.joint_springs().len(), read.springs().len()), (1, 2));
    let by_name = |mechanism: &stiction_core::mechanism::Mechanism| {
        let mut springs = mechanism.springs().to_vec();
        springs.sort_by(|a, b| a.name.cmp(&b.name));
        springs
    };
    for (read, known) in by_name(&read).iter().zip(&by_name(&known)) {
        // The model file contains the progression and the stroke of a gas spring. The stiffness and
        // the shortest length are computed from them, so both are rounded.
        assert!((read.stiffness / known.stiffness - 1.0).abs() < 1e-14, "{read:?}");
        assert_eq!(read.preload, known.preload);
        assert_eq!(read.lengths.map(|l| l.1), known.lengths.map(|l| l.1));
        assert_eq!(
            (read.free_length, read.damping, read.points),
            (known.free_length, known.damping, known.points)
        );
    }
    let (read, known) = (&read.bushings()[0], &known.bushings()[0]);
    assert_eq!((read.stiffness, read.damping), (known.stiffness, known.damping));
    let turned = read.frames[0].rotation.transpose() * known.frames[0].rotation;
    assert!((turned.trace() - 3.0).abs() < 1e-15);
}

/// Tests that the summary reports the time at which the gas spring leaves its stroke. By the law of
/// cosines, its length is then 400 mm.
#[test]
fn the_stroke_of_a_gas_spring_is_watched() {
    let model = with(&[LID, OPEN]);
    let job = job(&model, "m", "none", FrictionMode::Converged);
    let mut summary = Summary::new(&job);
    let verdict = job.run(|sample: &Sample| summary.add(sample), |_, _, _| true).unwrap();
    let summary = summary.json(&job, &verdict);
    let (foot, top): (f64, f64) = (0.25f64.hypot(0.1), 0.3);
    let cosine = (foot * foot + top * top - 0.16) / (2.0 * foot * top);
    let angle = cosine.acos() - (0.1f64).atan2(0.25);
    // The motion is hinge = 50 deg - 30 deg cos(pi t/2).
    let crossed = ((50.0 - angle.to_degrees()) / 30.0).acos() * 2.0 / std::f64::consts::PI;
    let range = &summary["ranges"][0];
    assert_eq!(range["name"], "strut.length");
    let from = range["excursions"][0]["from"].as_f64().unwrap();
    // The report interpolates linearly between samples of 10 ms.
    assert!((from - crossed).abs() < 1e-4, "{from} {crossed}");
    let caution = summary["cautions"][0].as_str().unwrap();
    assert!(
        caution.starts_with("strut.length exceeds its stroke of 150.0 mm to 400.0 mm by "),
        "{caution}"
    );
}

/// Tests that, at rest, the friction of the hinge opposes the sum of the gravity and spring
/// torques.
#[test]
fn breakaway_includes_springs() {
    let closed = "[motions.m]\nduration = 0\nhinge = \"30 deg\"\n";
    let bounds = |text: &str| {
        let model = with(&[text, closed]);
        let job = job(&model, "m", "none", FrictionMode::Converged);
        let found = breakaway::evaluate(&job, None).unwrap().json(&job);
        let drive = &found["drives"]["hinge"];
        [&drive["low"], &drive["high"]]
            .map(|bound| bound.as_f64().unwrap_or_else(|| panic!("{found:#}")))
    };
    let [low, high] = bounds(LID);
    // The coil spring exerts a couple: 1 N m more shifts the interval and does not change the
    // reaction of the hinge.
    let [lower, higher] = bounds(&LID.replace("preload = \"0.4 N m\"", "preload = \"1.4 N m\""));
    assert!((low - lower - 1.0).abs() < 1e-12 && (high - higher - 1.0).abs() < 1e-12);
    assert!(high - low > 0.1);
}
