//! Sparse coupling of friction with joint wrenches at given actuator efforts.
//!
//! At fixed accelerations, the actuators compensate for any friction. The friction in one leg of a
//! parallel robot therefore changes the wrenches in all legs, although at given efforts it would
//! only change those in its own leg. With efforts `t = h + M a + C f`, the difference
//! `t - h - M a - C f` is zero, so that any multiple of it may be added to a component
//! `w + W a + R f` of a joint wrench:
//!
//! ```text
//! (w + r (t - h)) + (W - r M) a + (R - r C) f
//! ```
//!
//! This module finds the actuator and the ratio `r = R_j / C_j` for which most of the row `R - r C`
//! vanishes.
//!
//! Equation (P5) of the book's theory.

use crate::graph::{Graph, Node, Op};
use crate::motions::{UnitAccelerations, run};
use crate::recording::{Counts, RecordingSource};
use crate::samples::Sample;
use crate::wrench::{components, local};
use stiction_core::dynamics::{Response, Sharing};
use stiction_core::friction::InterfaceShape;
use stiction_core::kinematics::Bodies;
use stiction_core::parameters::{InterfaceParameters, Parameters};
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Mat3, Pose, Wrench};

/// Number of samples at which the same entries must vanish.
const SAMPLES: usize = 3;
/// Largest entry, relative to the largest entry of its row before, that counts as zero.
const ZERO: f64 = 1e-9;

/// Actuator whose effort replaces the influence of distant friction on a component of a wrench, and
/// the interface whose friction defines the ratio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Replacement {
    pub(crate) drive: usize,
    pub(crate) interface: usize,
}

/// Form of the wrenches at the friction interfaces as functions of friction and accelerations.
#[derive(Clone, Debug)]
pub(crate) struct WrenchForm {
    /// For each interface, the replacements in the six components of its joint's wrench.
    pub(crate) replacements: Vec<[Option<Replacement>; 6]>,
    /// Rows of one sample.
    rows: Option<Rows>,
    counts: Counts,
}

/// Frame in which the wrench of an interface's joint is expressed.
pub(crate) fn frame<T: Scalar>(interface: &InterfaceParameters<T>, bodies: &Bodies<T>) -> Pose<T> {
    let j = bodies.frame_j[interface.joint];
    match interface.shape {
        // The normal load of a ball does not depend on the axes.
        InterfaceShape::Ball => Pose { rotation: Mat3::identity(), ..j },
        _ => j,
    }
}

/// Changes of the wrench of each interface's joint (rows) per newton of friction of each interface
/// (columns) at fixed accelerations.
pub(crate) fn at_fixed_accelerations<T: Scalar>(
    parameters: &Parameters<T>,
    bodies: &Bodies<T>,
    responses: &[Response<T>],
) -> Vec<Vec<Wrench<T>>> {
    let row = |interface: &InterfaceParameters<T>| {
        let frame = frame(interface, bodies);
        let entry = |response: &Response<T>| local(&frame, response.wrenches[interface.joint]);
        responses.iter().map(entry).collect()
    };
    parameters.interfaces.iter().map(row).collect()
}

/// Rows of one sample.
#[derive(Clone, Debug)]
struct Rows {
    /// For each interface and component of its wrench, the changes per newton of friction of each
    /// interface; for each actuator, those of its effort.
    wrenches: Vec<[Vec<f64>; 6]>,
    efforts: Vec<Vec<f64>>,
    /// The same per unit acceleration of each degree of freedom of the tree.
    accelerated: Vec<[Vec<f64>; 6]>,
    accelerated_efforts: Vec<Vec<f64>>,
}

impl RecordingSource<'_> {
    /// Finds the form in which most entries vanish at all samples.
    pub(crate) fn wrench_form(&self, samples: &[Sample]) -> WrenchForm {
        let rows: Vec<Rows> =
            samples.iter().take(SAMPLES).map(|sample| self.friction_rows(sample)).collect();
        let counts = self.counts(0);
        let of = |interface: usize, component: usize| {
            let rows = rows.iter().map(|r| (&*r.wrenches[interface][component], &r.efforts));
            sparsest_replacement(&rows.collect::<Vec<_>>())
        };
        let replacements: Vec<[Option<Replacement>; 6]> = (0..counts.interfaces)
            .map(|interface| core::array::from_fn(|component| of(interface, component)))
            .collect();
        WrenchForm { replacements, rows: rows.into_iter().next(), counts }
    }

    fn friction_rows(&self, sample: &Sample) -> Rows {
        let Sample { state, targets, loads, .. } = sample;
        let (model, parameters) = (self.model, self.solver.parameters());
        let like = self.solver.state();
        let ran = run(model, parameters, like, &state.coordinates, (targets, loads), 0);
        let bodies = &ran.kinematics.bodies;
        let responses = Sharing::new(model).responses(model, parameters, bodies, &ran.inverse);
        let wrenches = at_fixed_accelerations(parameters, bodies, &responses);
        let row = |wrenches: &Vec<Wrench<f64>>| {
            core::array::from_fn(|k| wrenches.iter().map(|w| components(*w)[k]).collect())
        };
        let units =
            UnitAccelerations::new(model, parameters, like, &state.coordinates, targets).forces;
        let accelerated: Vec<Vec<Wrench<f64>>> = parameters
            .interfaces
            .iter()
            .map(|interface| {
                let frame = frame(interface, bodies);
                units.iter().map(|unit| local(&frame, unit.wrenches[interface.joint])).collect()
            })
            .collect();
        let drives = 0..self.counts(0).drives;
        Rows {
            wrenches: wrenches.iter().map(row).collect(),
            efforts: drives
                .clone()
                .map(|drive| responses.iter().map(|r| r.efforts[drive]).collect())
                .collect(),
            accelerated: accelerated.iter().map(row).collect(),
            accelerated_efforts: drives
                .map(|drive| units.iter().map(|unit| unit.drives[drive]).collect())
                .collect(),
        }
    }
}

impl Rows {
    /// Number of accelerations of the tree on which a component of a wrench depends after the
    /// replacement `to`.
    fn remaining_accelerations(
        &self,
        interface: usize,
        component: usize,
        to: Option<Replacement>,
    ) -> usize {
        let row = &self.accelerated[interface][component];
        let rest: Vec<f64> = match to {
            None => row.clone(),
            Some(to) => {
                let wrenches = &self.wrenches[interface][component];
                let ratio = wrenches[to.interface] / self.efforts[to.drive][to.interface];
                let efforts = self.accelerated_efforts[to.drive].iter();
                row.iter().zip(efforts).map(|(x, effort)| x - ratio * effort).collect()
            }
        };
        let largest = row.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        rest.iter().filter(|x| x.abs() > ZERO * largest).count()
    }
}

/// Replacement that makes most entries of a row vanish, in all samples of the row and of the rows
/// of the efforts. `None` if most entries remain, or if only one would vanish, because the
/// replacement adds entries for accelerations.
fn sparsest_replacement(samples: &[(&[f64], &Vec<Vec<f64>>)]) -> Option<Replacement> {
    let (row, efforts) = samples.first()?;
    let bounds: Vec<f64> = samples
        .iter()
        .map(|(row, _)| ZERO * row.iter().fold(0.0_f64, |max, x| max.max(x.abs())))
        .collect();
    let is_entry = |column: usize| {
        samples.iter().zip(&bounds).any(|((row, _), bound)| row[column].abs() > *bound)
    };
    let entries: Vec<usize> = (0..row.len()).filter(|column| is_entry(*column)).collect();
    let remaining = |to: &Replacement| {
        let stays = |column: &usize| {
            samples.iter().zip(&bounds).any(|((row, efforts), bound)| {
                let effort = &efforts[to.drive];
                let ratio = row[to.interface] / effort[to.interface];
                let rest = row[*column] - ratio * effort[*column];
                // A ratio that is not finite leads to NaN.
                rest.is_nan() || rest.abs() > *bound
            })
        };
        (0..row.len()).filter(stays).count()
    };
    let all = (0..efforts.len())
        .flat_map(|drive| entries.iter().map(move |&interface| Replacement { drive, interface }));
    let (count, to) = all.map(|to| (remaining(&to), to)).min_by_key(|(count, _)| *count)?;
    (2 * count < entries.len() && count + 2 <= entries.len()).then_some(to)
}

impl WrenchForm {
    /// Returns `true` if wrenches depend on few accelerations of the tree, and therefore are
    /// functions of these; `false` if they are functions of the accelerations of the prescribed
    /// coordinates.
    pub(crate) fn is_by_tree(&self) -> bool {
        let Counts { interfaces, dofs, targets, .. } = self.counts;
        let of = |interface: usize, component: usize| {
            let to = self.replacements[interface][component];
            self.rows
                .as_ref()
                .map_or(0, |rows| rows.remaining_accelerations(interface, component, to))
        };
        let entries: usize = (0..interfaces)
            .map(|interface| (0..6).map(|component| of(interface, component)).sum::<usize>())
            .sum();
        // The accelerations of the tree must be computed, too.
        entries + dofs * targets < 6 * interfaces * targets
    }

    /// Removes those replacements whose ratio is not a value that occurs elsewhere in the merged
    /// graph, but a division by an effort, which may vanish. `ratios` lists the ratio and the
    /// divisor of each replacement. Returns `false` if no replacement is removed.
    pub(crate) fn remove_divisions(&mut self, merged: &Graph, ratios: &[Node]) -> bool {
        let unsigned = |node: Node| match merged.ops()[node as usize] {
            Op::Neg(node) => node,
            _ => node,
        };
        let divides = |node: Node, divisor: Node| {
            let op = merged.ops()[node as usize];
            matches!(op, Op::Div(_, by) if unsigned(by) == unsigned(divisor))
        };
        let mut is_removed = false;
        let all = self.replacements.iter_mut().flatten().filter(|to| to.is_some());
        for (replacement, pair) in all.zip(ratios.chunks(2)) {
            let &[ratio, divisor] = pair else { break };
            let ratio = unsigned(ratio);
            let mut operands = merged.ops()[ratio as usize].operands();
            if divides(ratio, divisor) || operands.any(|node| divides(node, divisor)) {
                *replacement = None;
                is_removed = true;
            }
        }
        is_removed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a wrench component and of two efforts for six interfaces. The component depends on
    /// the friction of its own leg (the first two interfaces) and on the second effort.
    fn sample(scale: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
        let efforts = vec![
            vec![0.3, -0.2, 1.1, 0.7, -0.4, 0.9],
            vec![0.5, 0.8, -0.6, scale, 0.2 * scale, -1.3],
        ];
        let ratio = 0.25 + scale;
        let mut row: Vec<f64> = efforts[1].iter().map(|effort| ratio * effort).collect();
        row[0] += 2.0;
        row[1] -= scale;
        (row, efforts)
    }

    #[test]
    fn the_effort_with_the_sparsest_rest_is_found() {
        let samples: Vec<_> = [0.4, 1.7, -0.8].map(sample).to_vec();
        let rows: Vec<(&[f64], &Vec<Vec<f64>>)> =
            samples.iter().map(|(row, efforts)| (&**row, efforts)).collect();
        assert_eq!(sparsest_replacement(&rows), Some(Replacement { drive: 1, interface: 2 }));
    }

    #[test]
    fn rows_without_a_common_ratio_are_left_alone() {
        let row = [1.0, 2.0, -1.0, 0.5, 3.0];
        let efforts = vec![vec![1.0, -1.0, 0.3, 0.8, 0.9], vec![0.0; 5]];
        assert_eq!(sparsest_replacement(&[(&row, &efforts)]), None);
        assert_eq!(sparsest_replacement(&[(&[0.0; 5], &efforts)]), None);
        assert_eq!(sparsest_replacement(&[]), None);
        // A replacement would remove the only entry, but add some for accelerations.
        assert_eq!(sparsest_replacement(&[(&[0.0, 0.0, 3.0, 0.0, 0.0], &efforts)]), None);
    }
}
