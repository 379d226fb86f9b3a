//! Motors that each drive several joints together. If gearings couple these joints, the motor is
//! moved to one of the joints. Otherwise the motor is kept, provided that all motors together
//! determine the effort of each joint.

use super::context::Context;
use super::description::{Description, JointMotor, Motor};
use super::text::gearing;
use crate::diagnostic::quoted;

/// Pivots of the elimination that are smaller than this fraction of the largest matrix entry count
/// as rounding errors.
const DEPENDENT: f64 = 1e-9;

/// Moves every motor of several joints to one joint if gearings couple the joints. Keeps the
/// remaining motors if a model can express them; otherwise removes and reports them.
pub(super) fn settle(context: &Context<'_>, robot: &mut Description) {
    let mut several = Vec::new();
    for motor in std::mem::take(&mut robot.joint_motors) {
        match alone(robot, &motor) {
            Some(alone) => {
                move_to_one(context, robot, &motor, alone);
            }
            None => several.push(motor),
        }
    }
    if determines(robot, &several) {
        for &(joint, _) in several.iter().flat_map(|motor| &motor.terms) {
            robot.joints[joint].dofs[0].actuated = true;
        }
        robot.joint_motors = several;
        return;
    }
    for motor in several {
        let names: Vec<String> =
            motor.terms.iter().map(|(joint, _)| quoted(&robot.joints[*joint].name)).collect();
        let message = format!(
            "the motor {} is left out: it drives several joints, {}, and the file has too few independent \
             motors for these joints",
            quoted(&motor.name),
            names.join(", ")
        );
        context.warn(message, motor.place);
    }
}

/// Finds the single joint to which a motor can be moved. Returns the index of the motor's first
/// joint, and the motor's output coordinate per unit of this joint's coordinate. Returns `None`
/// unless gearings, each of two joints, couple all joints of the motor to the first joint.
fn alone(robot: &Description, motor: &JointMotor) -> Option<(usize, f64)> {
    let first = motor.terms.first()?.0;
    let mut ratios: Vec<Option<f64>> = vec![None; robot.joints.len()];
    ratios[first] = Some(1.0);
    let pairs: Vec<[(usize, f64); 2]> = robot
        .gearings
        .iter()
        .filter_map(|own| gearing::terms(robot, own))
        .filter_map(|terms| match terms.as_slice() {
            &[(a, 0, x), (b, 0, y)] if a != b => Some([(a, x), (b, y)]),
            _ => None,
        })
        .collect();
    let mut changed = true;
    while changed {
        changed = false;
        for &[(a, x), (b, y)] in
            pairs.iter().flat_map(|&[one, two]| [[one, two], [two, one]]).collect::<Vec<_>>().iter()
        {
            if let (Some(ratio), None) = (ratios[a], ratios[b]) {
                // The sum x q_a + y q_b is constant.
                ratios[b] = Some(-x / y * ratio);
                changed = true;
            }
        }
    }
    let sum = motor
        .terms
        .iter()
        .try_fold(0.0, |sum, &(joint, part)| Some(sum + part * ratios[joint]?))?;
    (sum != 0.0).then_some((first, sum))
}

fn move_to_one(
    context: &Context<'_>,
    robot: &mut Description,
    motor: &JointMotor,
    (joint, sum): (usize, f64),
) {
    let own = &mut robot.joints[joint];
    let dof = &mut own.dofs[0];
    dof.actuated = true;
    dof.armature += motor.armature * sum * sum;
    dof.friction += motor.friction * sum.abs();
    dof.damping += motor.damping * sum * sum;
    if motor.terms.len() > 1 {
        let message = format!(
            "the motor {} drives several joints that gearings couple: in the model it drives only joint {}; its \
             effort is the same, but the efforts in the gearings differ",
            quoted(&motor.name),
            quoted(&own.name)
        );
        context.note(message, motor.place.clone());
    }
    robot.motors.push(Motor {
        name: motor.name.clone(),
        joint,
        dof: 0,
        gear: motor.gear * sum,
        effort: motor.effort.map(|effort| effort * sum.abs()),
        rate: None,
        place: motor.place.clone(),
    });
}

/// Tests if the motors that each drive several joints, together with the single-joint motors on the
/// same joints, can give these joints independent efforts: the matrix of coefficients has full
/// rank.
fn determines(robot: &Description, several: &[JointMotor]) -> bool {
    let mut joints: Vec<usize> =
        several.iter().flat_map(|motor| &motor.terms).map(|term| term.0).collect();
    joints.sort_unstable();
    joints.dedup();
    let column = |joint: usize| joints.iter().position(|known| *known == joint);
    let row = |terms: &mut dyn Iterator<Item = (usize, f64)>| {
        let mut row = vec![0.0; joints.len()];
        for (joint, part) in terms {
            if let Some(column) = column(joint) {
                row[column] += part;
            }
        }
        row
    };
    let mut rows: Vec<Vec<f64>> =
        several.iter().map(|motor| row(&mut motor.terms.iter().copied())).collect();
    rows.extend(
        robot
            .motors
            .iter()
            .filter(|motor| motor.dof == 0 && column(motor.joint).is_some())
            .map(|motor| row(&mut std::iter::once((motor.joint, 1.0)))),
    );
    rank(rows) == joints.len()
}

/// Rank of a matrix, by elimination with complete pivoting.
fn rank(mut rows: Vec<Vec<f64>>) -> usize {
    let largest = rows.iter().flatten().fold(0.0_f64, |most, entry| most.max(entry.abs()));
    let mut rank = 0;
    while rank < rows.len() {
        let entries = rows.iter().enumerate().skip(rank).flat_map(|(row, entries)| {
            entries.iter().enumerate().map(move |(column, entry)| (entry.abs(), row, column))
        });
        let Some((size, row, column)) = entries.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if size.is_nan() || size <= DEPENDENT * largest {
            break;
        }
        rows.swap(rank, row);
        let pivot = rows[rank].clone();
        for other in rows.iter_mut().skip(rank + 1) {
            let factor = other[column] / pivot[column];
            other.iter_mut().zip(&pivot).for_each(|(entry, pivot)| *entry -= factor * pivot);
            other[column] = 0.0;
        }
        rank += 1;
    }
    rank
}

#[cfg(test)]
mod tests {
    use super::rank;

    #[test]
    fn rank_of_motors() {
        assert_eq!(rank(vec![vec![1.0, 1.0], vec![1.0, -1.0]]), 2);
        assert_eq!(rank(vec![vec![0.1, 0.3], vec![0.2, 0.6]]), 1);
        assert_eq!(rank(vec![vec![0.0, 2.0]]), 1);
        assert_eq!(rank(Vec::new()), 0);
    }
}
