//! Distribution of joint efforts among motors: several motors on one joint, and motors that drive
//! several joints together.
//!
//! Equations (G10) and (G11) of the book's theory.

use super::DriveTrain;
use super::motor::times;
use crate::mechanism::{Defect, Joint, JointId};
use nalgebra::DMatrix;

/// Linear map from the motions and efforts of a mechanism's actuated degrees of freedom to the
/// motion and the effort at the output of one motor's gear.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotorMap {
    /// Terms of the map, one for each actuator on which the motion or the effort of the gear's
    /// output depends.
    pub terms: Vec<MotorTerm>,
}

/// Term of a [`MotorMap`]: an actuated degree of freedom, with its factors for the motion and the
/// effort at the output of the motor's gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorTerm {
    /// Index of the actuator, in the order of [`Mechanism::actuators`](crate::mechanism::Mechanism::actuators).
    pub actuator: usize,
    /// Derivative of the output coordinate of the motor's gear with respect to the coordinate of
    /// the degree of freedom. The gear exerts its effort, multiplied by this factor, on the degree
    /// of freedom.
    pub part: f64,
    /// Effort at the output of this motor's gear per unit total effort of all motors on the degree
    /// of freedom.
    pub share: f64,
}

impl MotorMap {
    /// Computes the rate or acceleration of the gear's output coordinate; `of` returns the rate or
    /// acceleration of the actuator with the given index.
    pub fn output(&self, of: impl Fn(usize) -> f64) -> f64 {
        self.terms.iter().map(|term| term.part * of(term.actuator)).sum()
    }

    /// Computes an upper bound on the magnitude of the gear's output coordinate, or of its rate;
    /// `of` returns the magnitude for the actuator with the given index.
    pub fn most(&self, of: impl Fn(usize) -> f64) -> f64 {
        self.terms.iter().map(|term| term.part.abs() * of(term.actuator)).sum()
    }

    /// Returns the effort at the output of the gear per unit effort of the given actuator, or zero
    /// if the map has no term for this actuator.
    pub(crate) fn share_of(&self, actuator: usize) -> f64 {
        let term = self.terms.iter().find(|term| term.actuator == actuator);
        term.map_or(0.0, |term| term.share)
    }

    /// Computes the effort at the output of the gear from the efforts of all actuators.
    pub fn effort(&self, efforts: &[f64]) -> f64 {
        self.terms.iter().map(|term| term.share * efforts[term.actuator]).sum()
    }

    /// Computes the interval of the effort at the output of the gear from the effort intervals of
    /// all actuators. The ends of the result are guaranteed bounds. They are attained if the effort
    /// depends on one actuator only. Otherwise, the friction forces may be unable to bring the
    /// efforts of several actuators to the required ends of their intervals at once.
    pub fn effort_bounds(&self, bounds: &[(f64, f64)]) -> (f64, f64) {
        let each = self.terms.iter().map(|term| {
            let (low, high) = bounds[term.actuator];
            let (a, b) = (times(low, term.share), times(high, term.share));
            (a.min(b), a.max(b))
        });
        each.fold((0.0, 0.0), |(low, high), (a, b)| (low + a, high + b))
    }
}

/// Group of drive trains that drive common degrees of freedom, directly or through other drive
/// trains of the group.
pub(in crate::mechanism) struct Group {
    /// Indices of the group's drive trains, in ascending order.
    pub(in crate::mechanism) trains: Vec<usize>,
    /// Degrees of freedom driven by the group: joint, and index of the degree of freedom in the
    /// joint.
    pub(super) dofs: Vec<(JointId, usize)>,
}

impl Group {
    pub(in crate::mechanism) fn all(trains: &[DriveTrain]) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        for (k, train) in trains.iter().enumerate() {
            let mut merged = Self { trains: vec![k], dofs: Vec::new() };
            merged.dofs.extend(train.dofs.iter().map(|driven| (driven.joint, driven.dof)));
            let touches = |group: &Self| group.dofs.iter().any(|&(j, d)| train.moves(j, d));
            let (touching, others): (Vec<Self>, Vec<Self>) = groups.into_iter().partition(touches);
            groups = others;
            for group in touching {
                merged.trains.extend(group.trains);
                merged.dofs.extend(group.dofs);
            }
            merged.trains.sort_unstable();
            merged.dofs.sort_unstable();
            merged.dofs.dedup();
            groups.push(merged);
        }
        groups.sort_by_key(|group| group.trains[0]);
        groups
    }

    /// Computes the derivatives of the output coordinates of the group's gears (rows) with respect
    /// to the coordinates of the group's degrees of freedom (columns).
    pub(super) fn parts(&self, trains: &[DriveTrain]) -> DMatrix<f64> {
        let mut parts = DMatrix::zeros(self.trains.len(), self.dofs.len());
        for (row, &train) in self.trains.iter().enumerate() {
            for (joint, dof, part) in trains[train].output_parts() {
                if let Some(column) = self.dofs.iter().position(|&at| at == (joint, dof)) {
                    parts[(row, column)] = part;
                }
            }
        }
        parts
    }

    /// Computes the efforts of the motors (rows) per unit effort of each degree of freedom
    /// (columns). If several motor efforts produce the same joint efforts, selects those with the
    /// smallest sum of `effort^2 / share`, where `share` is the declared share of each motor.
    /// Returns `None` if the motors do not determine the motion of all degrees of freedom.
    pub(super) fn shares(&self, trains: &[DriveTrain]) -> Option<DMatrix<f64>> {
        // Singular values below this fraction of the largest one count as round-off.
        const DEPENDENT: f64 = 1e-9;
        if self.dofs.len() == 1 {
            let each = self.trains.iter().map(|&train| trains[train].share);
            return Some(DMatrix::from_iterator(self.trains.len(), 1, each));
        }
        let parts = self.parts(trains);
        // Scale rows by the square roots of the shares, and columns to unit norm, because the
        // columns have different units.
        let mut scaled = parts.clone();
        for (mut row, &train) in scaled.row_iter_mut().zip(&self.trains) {
            row *= trains[train].share.max(0.0).sqrt();
        }
        let sizes: Vec<f64> = scaled.column_iter().map(|column| column.norm()).collect();
        if sizes.iter().any(|size| !size.is_normal()) {
            return None;
        }
        for (mut column, size) in scaled.column_iter_mut().zip(&sizes) {
            column /= *size;
        }
        // With the pseudoinverse P of the scaled matrix, the motor efforts are diag(root) P^T
        // diag(1 / size) tau: `root` are the square roots of the shares, `size` the norms of the
        // columns, and `tau` the joint efforts.
        let svd = scaled.clone().svd(true, true);
        let most = svd.singular_values.max();
        let least = svd.singular_values.min();
        if self.trains.len() < self.dofs.len() || least <= DEPENDENT * most {
            return None;
        }
        let mut shares = svd.pseudo_inverse(0.0).ok()?.transpose();
        for (mut row, &train) in shares.row_iter_mut().zip(&self.trains) {
            row *= trains[train].share.max(0.0).sqrt();
        }
        for (mut column, size) in shares.column_iter_mut().zip(&sizes) {
            column /= *size;
        }
        // If there are as many motors as degrees of freedom, the result is an inverse matrix and
        // does not depend on the shares. The direct inverse is exact for small integers.
        if self.trains.len() == self.dofs.len() {
            shares = parts.transpose().try_inverse().unwrap_or(shares);
        }
        Some(shares)
    }
}

/// Computes the [`MotorMap`] of each drive train; `actuators` are the actuated degrees of freedom
/// of the mechanism.
pub(in crate::mechanism) fn motor_maps(
    trains: &[DriveTrain],
    actuators: &[(JointId, usize)],
) -> Vec<MotorMap> {
    let mut maps = vec![MotorMap::default(); trains.len()];
    for group in Group::all(trains) {
        let parts = group.parts(trains);
        let shares = group.shares(trains).unwrap_or_else(|| parts.map(|_| 0.0));
        for (row, &train) in group.trains.iter().enumerate() {
            let terms = group.dofs.iter().enumerate().filter_map(|(column, dof)| {
                let actuator = actuators.iter().position(|known| known == dof)?;
                let (part, share) = (parts[(row, column)], shares[(row, column)]);
                (part != 0.0 || share != 0.0).then_some(MotorTerm { actuator, part, share })
            });
            maps[train].terms = terms.collect();
        }
    }
    maps
}

/// Checks that motors can drive their joints independently, and appends all defects to `defects`.
/// Shares of motors on one degree of freedom must sum to one; motors that drive several joints
/// together must determine the motion of each joint.
pub(in crate::mechanism) fn check_shares(
    trains: &[DriveTrain],
    joints: &[Joint],
    defects: &mut Vec<Defect>,
) {
    for group in Group::all(trains) {
        let names = |of: &mut dyn Iterator<Item = String>| of.collect::<Vec<_>>().join(", ");
        let motors =
            names(&mut group.trains.iter().map(|&train| format!("`{}`", trains[train].name)));
        let moved = names(
            &mut group
                .dofs
                .iter()
                .map(|&(joint, dof)| format!("`{}`", joints[joint.0].dof_name(dof))),
        );
        let actuator = || group.trains.last().map_or_else(String::new, |k| trains[*k].name.clone());
        if group.dofs.len() == 1 {
            let sum: f64 = group.trains.iter().map(|&train| trains[train].share).sum();
            if (sum - 1.0).abs() > 1e-9 {
                let problem = format!(
                    "the shares of {motors} in the effort of {moved} sum to {sum}, but must sum to \
                     1: give each motor a `share`"
                );
                defects.push(Defect::Actuator { actuator: actuator(), problem });
            }
            continue;
        }
        if group.shares(trains).is_some() {
            continue;
        }
        let problem = if group.trains.len() < group.dofs.len() {
            format!(
                "{motors} cannot drive {} joints ({moved}) independently: add motors, or model the \
                 shaft of the motor as a revolute joint and connect it with the joints by a \
                 `gearing`",
                group.dofs.len(),
            )
        } else {
            format!(
                "{motors} cannot move {moved} independently: choose linearly independent \
                 coefficients, and a `share` above 0 for each motor"
            )
        };
        defects.push(Defect::Actuator { actuator: actuator(), problem });
    }
}
