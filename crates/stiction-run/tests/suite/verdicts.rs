//! Verdicts do not depend on units, scale, base, order or names.

use crate::common::change::{Change, NONE};
use crate::common::*;
use std::collections::BTreeMap;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::Target;
use stiction_core::mobility::Mobility;
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_core::statics::Constraints;
use stiction_format::{ModelFile, gallery};
use stiction_run::check::{Findings, examine};

/// All verdicts on a mechanism at one position.
#[derive(Debug)]
struct Said {
    counts: Vec<usize>,
    gruebler: i64,
    /// Number of motions of each body, and the number of those that are only instantaneous.
    motions: BTreeMap<String, (usize, usize)>,
    /// True for each component of a joint's reaction that is statically determinate.
    determined: BTreeMap<String, [bool; 6]>,
    drives: BTreeMap<String, bool>,
    distances: Vec<f64>,
}

/// Returns the verdicts at four instants of the default motion.
fn said(model: &ModelFile, change: &Change) -> Vec<Said> {
    let mechanism = change.mechanism(&model.mechanism);
    let types: Vec<_> = mechanism.joints().iter().map(|joint| joint.joint_type).collect();
    let motion = model.motion(model.default_motion.as_ref().unwrap()).unwrap();
    let coordinates: Vec<_> =
        motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
    let at = |t: f64| -> Vec<Target<f64>> {
        let scaled = |(target, angle): (Target<f64>, bool)| {
            let s = if angle { 1.0 } else { change.scale };
            let (value, rate) = (target.value * s, target.rate * s);
            Target { value, rate, acceleration: target.acceleration * s }
        };
        motion.at(t).zip(coordinates.iter().map(|c| c.is_angle(&types))).map(scaled).collect()
    };
    let initial_poses: Vec<_> = model
        .initial_poses
        .iter()
        .map(|(body, home)| (*body, Pose { position: home.position * change.scale, ..*home }))
        .collect();
    let (mut before, settings) = (motion.start, Settings::default());
    let mut solver =
        InverseDynamics::new(mechanism, &initial_poses, &coordinates, &at(before), settings)
            .unwrap();
    (0..4)
        .map(|k| {
            // These instants are away from reversals and symmetric positions.
            let time = motion.start + motion.duration * (0.07 + 0.21 * f64::from(k));
            solver.follow(before, time, |t, targets| targets.copy_from_slice(&at(t))).unwrap();
            before = time;
            here(&solver)
        })
        .collect()
}

fn here(solver: &InverseDynamics) -> Said {
    let (mobility, statics) = (Mobility::of(solver), solver.statics());
    let constraints = Constraints::new(&statics);
    let spins = solver.constraints().spins().len();
    let mechanism = solver.mechanism();
    let joint = |index: usize| mechanism.joints()[index].name.clone();
    let leg = constraints.leg_distance(spins);
    Said {
        counts: vec![
            mobility.instantaneous,
            mobility.finite.traced,
            mobility.redundant_constraints,
            constraints.self_stresses().len(),
            constraints.mobility(),
            statics.rank(),
            statics.redundancy(),
            spins,
            usize::from(leg.is_some()),
        ],
        gruebler: mobility.gruebler,
        motions: mobility
            .bodies
            .iter()
            .map(|b| (b.body.clone(), (b.motions.len(), b.first_order_only.len())))
            .collect(),
        determined: statics
            .determined_reactions()
            .into_iter()
            .enumerate()
            .map(|(index, flags)| (joint(index), flags))
            .collect(),
        drives: mechanism
            .actuators()
            .zip(statics.determined_drives())
            .map(|((id, dof), flag)| (format!("{} {dof}", joint(id.0)), flag))
            .collect(),
        distances: vec![
            statics.actuation_distance(spins),
            constraints.distance(mobility.finite.traced),
            leg.unwrap_or(1.0),
        ],
    }
}

/// Asserts that two lists of verdicts agree. `axes` maps each new axis to an old axis; `None` if
/// the axes are not compared.
fn assert_same(what: &str, old: &[Said], new: &[Said], axes: Option<[usize; 3]>) {
    assert_eq!(old.len(), new.len());
    for (old, new) in old.iter().zip(new) {
        assert_eq!((&old.counts, old.gruebler), (&new.counts, new.gruebler), "{what}");
        assert_eq!(old.motions, new.motions, "{what}");
        assert_eq!(old.drives, new.drives, "{what}");
        if let Some(axes) = axes {
            let turn = |flags: &[bool; 6]| -> [bool; 6] {
                std::array::from_fn(|k| flags[axes[k % 3] + 3 * (k / 3)])
            };
            for (joint, flags) in &old.determined {
                assert_eq!(turn(flags), new.determined[joint], "{what} {joint}");
            }
        }
        for (old, new) in old.distances.iter().zip(&new.distances) {
            // Values below the rounding of singular values of order one count as zero.
            assert!((old - new).abs() <= 1e-6 * old.max(*new) + 1e-12, "{what}: {old} {new}");
        }
    }
}

#[test]
fn units_and_order_of_the_file() {
    for name in gallery::names() {
        let text = gallery::get(name).unwrap();
        let expected = said(&model(name), &NONE);
        for (other, what) in [(in_other_units(text), "units"), (in_reverse(text), "order")] {
            assert_ne!(other, text);
            let found = said(&model_of(name, &other), &NONE);
            assert_same(&format!("{name} {what}"), &expected, &found, Some([0, 1, 2]));
        }
    }
}

#[test]
fn scale() {
    for name in gallery::names() {
        let model = model(name);
        let expected = said(&model, &NONE);
        for scale in [1e-3, 0.03, 7.0, 1e3] {
            let found = said(&model, &Change { scale, ..NONE });
            assert_same(&format!("{name} times {scale}"), &expected, &found, Some([0, 1, 2]));
        }
    }
}

#[test]
fn base() {
    let position = Vec3::new(-7.0, 30.0, 2.0);
    // The base is rotated by quarter turns about z and x. The array contains the old axes (up to
    // signs) of the new x, y, z.
    let quarter = |axis: usize| Mat3::about_axis(axis, (1.0, 0.0));
    let bases = [
        (quarter(2), Some([1, 0, 2])),
        (quarter(0), Some([0, 2, 1])),
        (quarter(2) * quarter(0), Some([2, 0, 1])),
        (Mat3::rotation(Vec3::new(1.0, -2.0, 0.5), 2.1), None),
    ];
    for name in gallery::names() {
        let model = model(name);
        let expected = said(&model, &NONE);
        for (rotation, axes) in bases {
            let base = Some(Pose { rotation, position });
            let found = said(&model, &Change { base, ..NONE });
            assert_same(&format!("{name} {rotation:?}"), &expected, &found, axes);
        }
    }
}

/// Compares the complete report; only names may differ.
#[test]
fn names() {
    for name in gallery::names() {
        let model = model(name);
        let change = Change { rename: true, ..NONE };
        let mut renamed = model.clone();
        renamed.mechanism = change.mechanism(&model.mechanism);
        let report = |model: &ModelFile| -> Findings {
            let mut job = default_job(model, FrictionMode::Off);
            job.step = Some(job.motion.duration / 4.0);
            examine(&job, |_, _, _| true).unwrap()
        };
        let (old, mut new) = (report(&model), report(&renamed));
        // Texts contain names of bodies and joints; the new report contains the new names.
        let old_name = |name: &mut String| {
            let known = renamed.mechanism.body_id(name).unwrap();
            name.clone_from(&model.mechanism.bodies()[known.0].name);
        };
        let old_words = |words: &mut String| {
            for (k, joint) in renamed.mechanism.joints().iter().enumerate() {
                let whole = format!("{} ", joint.name);
                *words = words.replace(&whole, &format!("{} ", model.mechanism.joints()[k].name));
            }
        };
        let kinds = [Some(&mut new.actuation), Some(&mut new.constraint), new.leg.as_mut()];
        for nearness in kinds.into_iter().flatten() {
            let crossings = nearness.crossings.iter_mut().map(|(_, weakness)| weakness);
            for weakness in nearness.weakness.iter_mut().chain(crossings) {
                old_name(&mut weakness.body);
                old_words(&mut weakness.motion);
            }
        }
        let counts = |found: &Findings| {
            let mobility = &found.mobility;
            let Mobility { gruebler, instantaneous, finite, redundant_constraints, .. } = *mobility;
            let counts = (gruebler, instantaneous, finite, redundant_constraints);
            (counts, found.self_stresses.clone(), found.drives_unique, found.passed.clone())
        };
        assert_eq!(counts(&old), counts(&new), "{name}");
        assert_eq!((old.actuation, old.constraint), (new.actuation, new.constraint), "{name}");
        assert_eq!(old.leg, new.leg, "{name}");
        let by_new_names = old.undetermined.iter().map(|(joint, components)| {
            let index = model.mechanism.joint_id(joint).unwrap().0;
            (change.name('j', index, joint), components.clone())
        });
        assert_eq!(by_new_names.collect::<Vec<_>>(), new.undetermined, "{name}");
    }
}
