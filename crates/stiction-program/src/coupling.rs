//! A Newton step for the loads of contacts whose frictions change each other's loads.
//!
//! Wrenches are affine in friction forces, and those in loads. The matrix of a step has as many rows as there
//! are contacts. But what happens elsewhere reaches a leg by the few wrenches that it transmits
//! (`transmission`); where these are fewer than the contacts, the step solves for them.
//!
//! Equation (P3) of the book's theory.

use crate::loads::Loads;
use crate::recorded::Recorded;
use crate::small::{Factors, diagonal};
use crate::transmission::Leg;
use crate::wrench::{components, local};
use stiction::dynamics::{Inverse, Response};
use stiction::mechanism::Mechanism;
use stiction::scalar::Scalar;
use stiction::spatial::{Pose, Wrench};

/// A step: the loads after it, and the determinant of its matrix.
pub(crate) struct Step {
    pub(crate) loads: Vec<Recorded>,
    pub(crate) determinant: Recorded,
}

/// What a leg transmits, by the frictions of coupled contacts.
struct Part<'a> {
    leg: &'a Leg,
    frame: Pose<Recorded>,
    /// The first of its amounts among those of all legs.
    first: usize,
    /// For each amount what it is without friction, and what each coupled contact's friction adds.
    powers: Vec<(Recorded, Vec<Recorded>)>,
    /// The wrench of each amount.
    transmitted: Vec<Wrench<Recorded>>,
    /// Its own contacts, by their places among the coupled ones.
    contacts: Vec<usize>,
}

impl Loads<'_> {
    /// A step from these loads, with all contacts' unknowns at once. The matrix is near the identity while
    /// friction is far from locking the mechanism, so pivots are not looked for.
    pub(crate) fn step(&self, presses: &[Recorded]) -> Step {
        let found = self.all_under(&self.forces(presses));
        let factors = Factors::new(&self.matrix(&found), diagonal(presses.len()));
        let change = factors.solve(&Self::misfits(presses, &found));
        let loads = presses.iter().zip(&change).map(|(press, change)| *press - *change).collect();
        Step { loads, determinant: factors.determinant }
    }

    /// The same, leg by leg.
    pub(crate) fn step_by_legs(
        &self,
        mechanism: &Mechanism,
        (inverse, responses): (&Inverse<Recorded>, &[Response<Recorded>]),
        legs: &[Leg],
        presses: &[Recorded],
    ) -> Step {
        let forces = self.forces(presses);
        let coefficients: Vec<Recorded> =
            self.coupled.iter().map(|contact| self.coefficient(*contact)).collect();
        // What each leg transmits, and what it would without friction.
        let mut amounts = Vec::new();
        let mut parts = Vec::new();
        for leg in legs {
            let frame = self.bodies.frame_j[leg.reference];
            let here =
                |wrenches: &[Wrench<Recorded>]| components(local(&frame, wrenches[leg.reference]));
            let ideal = here(inverse.joint_wrenches());
            let own: Vec<[Recorded; 6]> =
                self.coupled.iter().map(|column| here(&responses[*column].wrenches)).collect();
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
                let joint = self.joint(self.coupled[*place]);
                leg.joints.iter().any(|(own, _)| *own == joint)
            };
            let contacts: Vec<usize> = (0..self.coupled.len()).filter(is_own).collect();
            parts.push(Part { leg, frame, first, powers, transmitted, contacts });
        }

        // In each leg the loads' changes as affine functions of what it transmits.
        let mut determinant = Recorded::one();
        let mut answers = vec![Vec::new(); presses.len()];
        let mut range = vec![0..0; presses.len()];
        for part in &parts {
            let own = part.first..part.first + part.transmitted.len();
            let factors = self.within(part, &amounts[own.clone()], presses, &forces, &mut answers);
            determinant *= factors;
            part.contacts.iter().for_each(|&place| range[place] = own.clone());
        }

        // What all legs transmit, so that they agree.
        let count = amounts.len();
        let mut matrix = vec![vec![Recorded::zero(); count]; count];
        let mut right = vec![Recorded::zero(); count];
        for part in &parts {
            for (k, (_, by_contact)) in part.powers.iter().enumerate() {
                let row = part.first + k;
                matrix[row][row] += Recorded::one();
                for (place, one) in by_contact.iter().enumerate() {
                    let slope = *one * coefficients[place];
                    right[row] += slope * answers[place][0];
                    for (k, column) in range[place].clone().enumerate() {
                        let change = slope * answers[place][1 + k];
                        matrix[row][column] -= change;
                    }
                }
            }
        }
        let factors = Factors::new(&matrix, diagonal(count));
        determinant *= factors.determinant;
        let solution = factors.solve(&right);
        let next = |place: usize| {
            let answer = &answers[place];
            let by_amounts = range[place].clone().zip(&answer[1..]);
            by_amounts
                .fold(presses[place] + answer[0], |sum, (k, slope)| sum + solution[k] * *slope)
        };
        Step { loads: (0..presses.len()).map(next).collect(), determinant }
    }

    /// For each contact of a leg the change of its load while the leg transmits the same, and with each amount
    /// that it transmits; returns the determinant of the leg's matrix.
    fn within(
        &self,
        part: &Part<'_>,
        amounts: &[Recorded],
        presses: &[Recorded],
        forces: &[Recorded],
        answers: &mut [Vec<Recorded>],
    ) -> Recorded {
        let Part { leg, frame, powers, transmitted, contacts, .. } = part;
        let mut matrix = Vec::new();
        let mut right: Vec<Vec<Recorded>> = Vec::new();
        for &place in contacts {
            let row = self.coupled[place];
            let joint = self.joint(row);
            let sign = leg.joints.iter().find(|(own, _)| *own == joint).map_or(1.0, |j| j.1);
            let here = frame.inverse() * self.bodies.frame_j[joint];
            let by_amount: Vec<Wrench<Recorded>> = transmitted
                .iter()
                .map(|wrench| local(&here, *wrench) * Recorded::from_f64(sign))
                .collect();
            let mut wrench = self.without[row];
            for ((by_amount, amount), power) in by_amount.iter().zip(amounts).zip(powers) {
                wrench += *by_amount * (*amount - power.0);
            }
            // What friction in the leg does while the leg transmits the same.
            let inside: Vec<Wrench<Recorded>> = contacts
                .iter()
                .map(|&other| {
                    let mut own = self.added[row][other];
                    for (by_amount, power) in by_amount.iter().zip(powers) {
                        own += *by_amount * -power.1[other];
                    }
                    own
                })
                .collect();
            for (own, other) in inside.iter().zip(contacts) {
                wrench += *own * forces[*other];
            }
            let load = self.load(row, wrench);
            let entry = |(own, other): (&Wrench<Recorded>, &usize)| {
                self.slope(row, self.coupled[*other], load.gradient.power(*own))
            };
            matrix.push(inside.iter().zip(contacts).map(entry).collect::<Vec<_>>());
            let mut known = vec![load.value - presses[place]];
            known.extend(by_amount.iter().map(|wrench| load.gradient.power(*wrench)));
            right.push(known);
        }
        let factors = Factors::new(&matrix, diagonal(contacts.len()));
        for k in 0..=transmitted.len() {
            let column: Vec<Recorded> = right.iter().map(|row| row[k]).collect();
            for (place, answer) in contacts.iter().zip(factors.solve(&column)) {
                answers[*place].push(answer);
            }
        }
        factors.determinant
    }
}
