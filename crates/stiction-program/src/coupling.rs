//! A Newton step for the loads of contacts whose frictions change each other's loads.
//!
//! Wrenches are affine in friction forces, and those in loads. The matrix of a step has as many rows as there
//! are contacts. But what happens elsewhere reaches a leg by the few wrenches that it transmits
//! (`transmission`); where these are fewer than the contacts, the step solves for them.
//!
//! Equation (P3) of the book's theory.

use crate::recorded::Recorded;
use crate::transmission::{Leg, components, local};
use stiction::dynamics::{ContactState, Inverse, Response};
use stiction::friction::Load;
use stiction::kinematics::Bodies;
use stiction::mechanism::Mechanism;
use stiction::parameters::{ContactParameters, Parameters};
use stiction::scalar::Scalar;
use stiction::spatial::{Mat3, Pose, Vec3, Wrench};

/// All that is known of friction once the frictionless forces are.
pub(crate) struct Coupling<'a> {
    pub(crate) parameters: &'a Parameters<Recorded>,
    pub(crate) bodies: &'a Bodies<Recorded>,
    pub(crate) inverse: &'a Inverse<Recorded>,
    /// For each contact what one newton of its friction does.
    pub(crate) responses: &'a [Response<Recorded>],
    /// The contacts whose loads are unknown.
    pub(crate) coupled: &'a [usize],
}

/// A step: the loads after it, and the determinant of its matrix.
pub(crate) struct Step {
    pub(crate) loads: Vec<Recorded>,
    pub(crate) determinant: Recorded,
}

impl Coupling<'_> {
    fn contact(&self, contact: usize) -> (&ContactParameters<Recorded>, &ContactState<Recorded>) {
        (&self.parameters.contacts[contact], &self.inverse.contacts()[contact])
    }

    /// The friction force under a load.
    pub(crate) fn force(&self, contact: usize, load: Recorded) -> Recorded {
        let (coefficient, constant) = self.contact(contact).1.resistance();
        coefficient * load + constant
    }

    /// The change of a joint's wrench with a contact's friction, in the joint's frame.
    fn response(&self, joint: usize, contact: usize) -> Wrench<Recorded> {
        // Components in the joint's frame: many a load needs but two of them.
        local(&self.bodies.frame_j[joint], self.responses[contact].wrenches[joint])
    }

    fn load(&self, contact: usize, wrench: Wrench<Recorded>) -> Load<Recorded> {
        let (parameters, state) = self.contact(contact);
        let joint = parameters.joint;
        let here = Pose { rotation: Mat3::identity(), position: Vec3::zero() };
        let across = self.bodies.frame_j[joint].inverse() * self.bodies.frame_k[joint];
        state.load_in(parameters, self.parameters.pitch[joint], &here, &across, wrench)
    }

    /// The load on any contact under these frictions of the coupled ones.
    pub(crate) fn load_under(&self, contact: usize, forces: &[Recorded]) -> Load<Recorded> {
        let joint = self.contact(contact).0.joint;
        let mut wrench = local(&self.bodies.frame_j[joint], self.inverse.joint_wrenches()[joint]);
        for (column, force) in self.coupled.iter().zip(forces) {
            wrench += self.response(joint, *column) * *force;
        }
        self.load(contact, wrench)
    }

    /// How a contact's load changes with the friction of another.
    pub(crate) fn influence(&self, load: &Load<Recorded>, on: usize, of: usize) -> Recorded {
        load.gradient.power(self.response(self.contact(on).0.joint, of))
    }

    /// A step from these loads, with all contacts' unknowns at once.
    pub(crate) fn step(&self, loads: &[Recorded]) -> Step {
        let forces = self.forces(loads);
        let mut matrix = Vec::new();
        let mut misfit = Vec::new();
        for (&row, load) in self.coupled.iter().zip(loads) {
            let found = self.load_under(row, &forces);
            misfit.push(vec![*load - found.value]);
            let entry = |&column: &usize| {
                let (coefficient, _) = self.contact(column).1.resistance();
                identity(row, column) - self.influence(&found, row, column) * coefficient
            };
            matrix.push(self.coupled.iter().map(entry).collect::<Vec<_>>());
        }
        let determinant = solve(&mut matrix, &mut misfit);
        let next = loads.iter().zip(&misfit).map(|(load, change)| *load - change[0]);
        Step { loads: next.collect(), determinant }
    }

    fn forces(&self, loads: &[Recorded]) -> Vec<Recorded> {
        self.coupled.iter().zip(loads).map(|(contact, load)| self.force(*contact, *load)).collect()
    }

    /// The same, leg by leg.
    pub(crate) fn step_by_legs(
        &self,
        mechanism: &Mechanism,
        legs: &[Leg],
        loads: &[Recorded],
    ) -> Step {
        let forces = self.forces(loads);
        // What each leg transmits, and what it would without friction.
        let mut amounts = Vec::new();
        let mut parts = Vec::new();
        for leg in legs {
            let frame = self.bodies.frame_j[leg.reference];
            let ideal = components(local(&frame, self.inverse.joint_wrenches()[leg.reference]));
            let own: Vec<[Recorded; 6]> = self
                .coupled
                .iter()
                .map(|column| components(self.response(leg.reference, *column)))
                .collect();
            let first = amounts.len();
            let mut powers = Vec::new();
            for &free in &leg.free {
                let by_contact: Vec<Recorded> = own.iter().map(|wrench| wrench[free]).collect();
                let sum = by_contact
                    .iter()
                    .zip(&forces)
                    .fold(ideal[free], |sum, (one, force)| sum + *one * *force);
                amounts.push(sum);
                powers.push((ideal[free], by_contact));
            }
            let transmitted = leg.transmitted(mechanism, self.parameters, self.bodies);
            let is_own = |place: &usize| {
                let joint = self.contact(self.coupled[*place]).0.joint;
                leg.joints.iter().any(|(own, _)| *own == joint)
            };
            let contacts: Vec<usize> = (0..self.coupled.len()).filter(is_own).collect();
            parts.push((leg, frame, first, powers, transmitted, contacts));
        }

        // In each leg the loads' changes as affine functions of what it transmits.
        let count = amounts.len();
        let mut determinant = Recorded::one();
        let mut answers = vec![Vec::new(); loads.len()];
        let mut range = vec![0..0; loads.len()];
        for (leg, frame, first, powers, transmitted, contacts) in &parts {
            let mut matrix = Vec::new();
            let mut right = Vec::new();
            for &place in contacts {
                let row = self.coupled[place];
                let joint = self.contact(row).0.joint;
                let sign = leg.joints.iter().find(|(own, _)| *own == joint).map_or(1.0, |j| j.1);
                let here = frame.inverse() * self.bodies.frame_j[joint];
                let by_amount: Vec<Wrench<Recorded>> = transmitted
                    .iter()
                    .map(|wrench| local(&here, *wrench) * Recorded::from_f64(sign))
                    .collect();
                let mut wrench =
                    local(&self.bodies.frame_j[joint], self.inverse.joint_wrenches()[joint]);
                for (k, by_amount) in by_amount.iter().enumerate() {
                    wrench += *by_amount * (amounts[first + k] - powers[k].0);
                }
                // What friction in the leg does while the leg transmits the same.
                let inside: Vec<Wrench<Recorded>> = contacts
                    .iter()
                    .map(|&other| {
                        let mut own = self.response(joint, self.coupled[other]);
                        for (k, by_amount) in by_amount.iter().enumerate() {
                            own += *by_amount * -powers[k].1[other];
                        }
                        own
                    })
                    .collect();
                for (own, other) in inside.iter().zip(contacts) {
                    wrench += *own * forces[*other];
                }
                let load = self.load(row, wrench);
                let entry = |(own, other): (&Wrench<Recorded>, &usize)| {
                    let column = self.coupled[*other];
                    let (coefficient, _) = self.contact(column).1.resistance();
                    identity(row, column) - load.gradient.power(*own) * coefficient
                };
                matrix.push(inside.iter().zip(contacts).map(entry).collect::<Vec<_>>());
                let mut known = vec![load.value - loads[place]];
                known.extend(by_amount.iter().map(|wrench| load.gradient.power(*wrench)));
                right.push(known);
            }
            determinant *= solve(&mut matrix, &mut right);
            for (&place, answer) in contacts.iter().zip(right) {
                answers[place] = answer;
                range[place] = *first..*first + transmitted.len();
            }
        }

        // What all legs transmit, so that they agree.
        let mut matrix = vec![vec![Recorded::zero(); count]; count];
        let mut right = vec![vec![Recorded::zero()]; count];
        for (_, _, first, powers, ..) in &parts {
            for (k, (_, by_contact)) in powers.iter().enumerate() {
                let row = first + k;
                matrix[row][row] += Recorded::one();
                for (place, one) in by_contact.iter().enumerate() {
                    let (coefficient, _) = self.contact(self.coupled[place]).1.resistance();
                    let slope = *one * coefficient;
                    right[row][0] += slope * answers[place][0];
                    for (k, column) in range[place].clone().enumerate() {
                        let change = slope * answers[place][1 + k];
                        matrix[row][column] -= change;
                    }
                }
            }
        }
        determinant *= solve(&mut matrix, &mut right);
        let next = |place: usize| {
            let answer = &answers[place];
            let by_amounts = range[place].clone().zip(&answer[1..]);
            by_amounts.fold(loads[place] + answer[0], |sum, (k, slope)| sum + right[k][0] * *slope)
        };
        Step { loads: (0..loads.len()).map(next).collect(), determinant }
    }
}

fn identity(row: usize, column: usize) -> Recorded {
    Recorded::from_f64(if row == column { 1.0 } else { 0.0 })
}

/// Solves in place for several right-hand sides, without looking for pivots: the matrix is near the identity
/// while friction is far from locking the mechanism. Returns the product of the pivots.
fn solve(matrix: &mut [Vec<Recorded>], right: &mut [Vec<Recorded>]) -> Recorded {
    let count = right.len();
    let mut determinant = Recorded::one();
    let mut over = Vec::with_capacity(count);
    for pivot in 0..count {
        determinant *= matrix[pivot][pivot];
        over.push(matrix[pivot][pivot].recip());
        for row in pivot + 1..count {
            let factor = matrix[row][pivot] * over[pivot];
            for column in pivot + 1..count {
                let change = factor * matrix[pivot][column];
                matrix[row][column] -= change;
            }
            for k in 0..right[row].len() {
                let change = factor * right[pivot][k];
                right[row][k] -= change;
            }
        }
    }
    for row in (0..count).rev() {
        for k in 0..right[row].len() {
            for column in row + 1..count {
                let change = matrix[row][column] * right[column][k];
                right[row][k] -= change;
            }
            right[row][k] *= over[row];
        }
    }
    determinant
}
