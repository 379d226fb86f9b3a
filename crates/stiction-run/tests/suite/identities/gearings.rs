//! Rigid gearings between actuated joints of random mechanisms.

use crate::common::model_of;
use crate::identities::harness::{Verdict, try_everywhere};
use crate::identities::solve::{TOLERANCE, agree, solve};
use crate::identities::specimen::Specimen;
use crate::mechanisms::random::{Case, Class};
use stiction_core::dynamics::{AppliedLoad, Forces};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::Mechanism;
use stiction_format::{Source, read};
use toml::{Table, Value};

/// Returns the mechanism with a gearing of two joints in place of the actuator of the second joint;
/// `None` if the joints form a loop.
fn geared(specimen: &Specimen, joints: [&str; 2], ratio: f64, offset: f64) -> Option<Mechanism> {
    let mut file: Table = specimen.file().parse().unwrap();
    for key in ["motions", "loads", "default"] {
        file.remove(key);
    }
    let own = file.get_mut("joints").unwrap().get_mut(joints[1]).unwrap().as_table_mut().unwrap();
    own.insert("actuated".to_owned(), Value::Boolean(false));
    let coefficients = [(joints[0], 1.0), (joints[1], ratio)];
    let coefficients = coefficients.map(|(name, c)| (name.to_owned(), Value::Float(c)));
    let gearing = [
        ("joints".to_owned(), Value::Table(coefficients.into_iter().collect())),
        ("offset".to_owned(), Value::Float(offset)),
    ];
    let gearing = Value::Table(gearing.into_iter().collect());
    let gearings = [("pair".to_owned(), gearing)].into_iter().collect();
    file.insert("gearings".to_owned(), Value::Table(gearings));
    let text = file.to_string();
    match read(&Source::new("geared.toml", text.clone()), &|_| Err("no files".into())) {
        Err(error) if error.to_string().contains("every joint of a loop") => None,
        _ => Some(model_of("geared", &text).mechanism),
    }
}

/// Tests that a gearing that is compatible with the motion can replace the actuator of one of its
/// joints. The gearing exerts the same effort there, and the actuator of the other joint
/// additionally carries the reaction of the gearing. All joint reactions and friction forces are
/// unchanged.
#[test]
fn gearings_replace_actuators() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        if specimen.class == Class::RedundantlyActuated {
            return Err(Verdict::Apart("efforts are not unique"));
        }
        let case = specimen.case();
        let joints = case.mechanism.joints();
        // The gearing connects actuated joints with one degree of freedom whose coordinates are
        // prescribed.
        let both = case.coordinates.iter().enumerate().filter_map(|(k, coordinate)| {
            let Coordinate::Joint { joint, .. } = *coordinate else { return None };
            (joints[joint.0].actuated == [true]).then_some((k, joint))
        });
        let both: Vec<_> = both.collect();
        let [(first, a), (second, b), ..] = both[..] else {
            return Err(Verdict::Apart("fewer than two actuated coordinates"));
        };
        let (x, y) = (case.targets[first], case.targets[second]);
        let ratio = -x.rate / y.rate;
        if !(0.1..10.0).contains(&ratio.abs()) {
            return Err(Verdict::Apart("one of them hardly moves"));
        }
        let mut free = specimen.case();
        free.targets[second] = Target { acceleration: -x.acceleration / ratio, ..y };
        let expected = solve(&free)?;
        let largest = expected.numbers().largest;
        let names = [a, b].map(|joint| joints[joint.0].name.as_str());
        let offset = x.value + ratio * y.value;
        let Some(mechanism) = geared(specimen, names, ratio, offset) else {
            return Err(Verdict::Apart("geared joints form a loop"));
        };
        // The joints of a model file are in another order.
        let id = |joint: usize| mechanism.joint_id(&joints[joint].name).unwrap();
        let others = free.coordinates.iter().zip(&free.targets).enumerate();
        let others = others.filter(|(k, _)| *k != second).map(|(_, (coordinate, target))| {
            let Coordinate::Joint { joint, dof } = *coordinate else { unreachable!("joints only") };
            (Coordinate::Joint { joint: id(joint.0), dof }, *target)
        });
        let (coordinates, targets) = others.unzip();
        let bodies = specimen.case().mechanism;
        let loads = free.loads.iter().map(|load| {
            let body = mechanism.body_id(&bodies.bodies()[load.body.0].name).unwrap();
            AppliedLoad { body, ..*load }
        });
        let case = Case {
            coordinates,
            targets,
            loads: loads.collect(),
            class: specimen.class,
            mechanism: mechanism.clone(),
        };
        let found = solve(&case)?;
        let actuators: Vec<_> = free.mechanism.actuators().collect();
        let of = |joint| actuators.iter().position(|(known, _)| *known == joint).unwrap();
        let lambda = expected.forces.efforts[of(b)] / ratio;
        let mut efforts = Vec::new();
        for (joint, dof) in found.solver.mechanism().actuators() {
            let name = &mechanism.joints()[joint.0].name;
            let own = free.mechanism.joint_id(name).unwrap();
            let actuator = actuators.iter().position(|known| *known == (own, dof)).unwrap();
            let taken = if own == a { lambda } else { 0.0 };
            efforts.push(expected.forces.efforts[actuator] - taken);
        }
        let force = |forces: &Forces, joint: usize| forces.reactions[joint].0.norm();
        let all = 0..joints.len();
        let reactions: Vec<f64> = all.clone().map(|k| force(&expected.forces, k)).collect();
        let again: Vec<f64> = all.map(|k| force(&found.forces, id(k).0)).collect();
        // A ratio other than one magnifies rounding.
        let tolerance = 10.0 * TOLERANCE;
        let power = &found.forces.power;
        let balanced = power.residual().abs() < 1e-10 * power.turnover;
        Ok(agree("gearing", &[lambda], &found.forces.gearings, largest, tolerance)
            .and(|| agree("drive", &efforts, &found.forces.efforts, largest, tolerance))
            .and(|| agree("force", &reactions, &again, largest, tolerance))
            .and(|| match balanced {
                true => Verdict::Holds,
                false => Verdict::Broken(format!("power {power:?}")),
            }))
    }
    try_everywhere("gearings replace actuators", 0.2, identity);
}
