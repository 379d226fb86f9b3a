//! Directions of slip onset: a ball, plate or sleeve begins to slip along the relative acceleration
//! of its surfaces.

use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::data::Data;
use crate::forward::solve::{Solved, Unsolved};
use crate::kinematics::Bodies;
use nalgebra::{Matrix3, Vector3};

/// Fraction of the largest acceleration below which the relative acceleration of the surfaces
/// counts as round-off.
const ROUND_OFF: f64 = 1e-10;
/// The iteration of the directions has converged if no unit vector changes by this amount or more.
const SETTLED: f64 = 1e-12;
/// Largest number of iterations for the directions.
const PASSES: usize = 40;

impl Forward {
    /// Solves the equations of motion for the modes in `trial`. Iterates the slip onset directions
    /// of the balls and plates in `resting` until each direction agrees with the relative
    /// acceleration of the surfaces. If an interface would slide against its direction, stops and
    /// also returns the index of this interface.
    pub(super) fn solve_directions(
        &self,
        data: &Data,
        trial: &mut [InterfaceMode],
        resting: &[usize],
    ) -> Result<(Solved, Option<usize>), Unsolved> {
        for pass in 0..PASSES {
            let solved = self.solve(data, trial, None, true)?;
            let accelerated = self.accelerated_by(data, &solved);
            let mut turned = 0.0_f64;
            for &interface in resting {
                let (InterfaceMode::AtLimit(direction) | InterfaceMode::Slides(direction)) =
                    trial[interface]
                else {
                    continue;
                };
                let Some(onset) = self.slip_onset(&accelerated, &solved, interface) else {
                    continue;
                };
                let along: f64 = onset.iter().zip(direction).map(|(a, d)| a * d).sum();
                let single = self.parameters.interfaces[interface].shape.has_one_dof();
                if along < 0.0 && (single || pass > 3) {
                    return Ok((solved, Some(interface)));
                }
                if single {
                    continue;
                }
                let next = self.direction(data, &solved, interface, onset);
                turned = turned.max(norm([0, 1, 2].map(|i| next[i] - direction[i])));
                trial[interface] = match trial[interface] {
                    InterfaceMode::Slides(_) => InterfaceMode::Slides(next),
                    _ => InterfaceMode::AtLimit(next),
                };
            }
            if turned < SETTLED || pass + 1 == PASSES {
                return Ok((solved, None));
            }
        }
        let solved = self.solve(data, trial, None, true)?;
        Ok((solved, None))
    }

    /// Computes the direction `d` of slip onset of a ball or plate, for the normal load and the
    /// friction of the other interfaces in `solved`. Let `K` be the decrease of the surface
    /// acceleration per newton of friction, `a` the acceleration without this friction, and `c` the
    /// magnitude of the friction. Then `d = (x + c K)^-1 a`, where `x` is the magnitude of the
    /// acceleration for which `d` has length one.
    fn direction(
        &self,
        data: &Data,
        solved: &Solved,
        interface: usize,
        onset: [f64; 3],
    ) -> [f64; 3] {
        let content = &self.parameters.interfaces[interface];
        let arms = content.arms(self.parameters.pitch[content.joint]);
        let mut lowered = Matrix3::zeros();
        for (column, wrench) in self.unit_frictions(&data.bodies, interface).into_iter().enumerate()
        {
            let response = solved.balance.respond(self, data, &[(content.joint, wrench)], false);
            for row in 0..content.shape.dofs().len() {
                lowered[(row, column)] =
                    -self.surface_rate(&data.bodies, &response.accelerations, interface, row);
            }
        }
        let load = solved.coupled.loads[interface];
        let friction = solved.frictions[interface].at_surface(arms, load);
        let size = norm(friction);
        let free = Vector3::from(onset) + lowered * Vector3::from(friction);
        let along = |x: f64| {
            let matrix = lowered * size + Matrix3::identity() * x;
            matrix.lu().solve(&free).unwrap_or_else(Vector3::zeros)
        };
        // The magnitude of the acceleration lies between zero and its value without friction.
        let (mut low, mut high) = (0.0, free.norm());
        for _ in 0..2000 {
            let middle = if low > 0.0 { (low * high).sqrt() } else { 1e-3 * high };
            if !(middle > low && middle < high) || high < 1e-300 {
                break;
            }
            if along(middle).norm() > 1.0 {
                low = middle
            } else {
                high = middle
            }
            if low > 0.0 && high - low <= 1e-15 * high {
                break;
            }
        }
        let found = along(high);
        let length = found.norm();
        if length > 0.0 { (found / length).into() } else { onset.map(|a| a / norm(onset)) }
    }

    /// Returns a copy of the bodies with the accelerations of a solution.
    pub(super) fn accelerated_by(&self, data: &Data, solved: &Solved) -> Bodies<f64> {
        self.accelerated(&data.bodies, &solved.coupled.response.accelerations)
    }

    /// Returns the relative acceleration of the surfaces of an interface, m/s^2, or `None` if it is
    /// below round-off. `accelerated` are the bodies with the accelerations of the solution.
    pub(super) fn slip_onset(
        &self,
        accelerated: &Bodies<f64>,
        solved: &Solved,
        interface: usize,
    ) -> Option<[f64; 3]> {
        let accelerations = &solved.coupled.response.accelerations;
        let onset = self.surface_acceleration(accelerated, interface);
        (norm(onset) > self.rounding_of_onset(accelerations, interface)).then_some(onset)
    }

    /// Returns the largest relative acceleration of the surfaces of an interface that counts as
    /// round-off, m/s^2.
    pub(in crate::forward) fn rounding_of_onset(
        &self,
        accelerations: &[f64],
        interface: usize,
    ) -> f64 {
        let parameters = &self.parameters;
        let content = &parameters.interfaces[interface];
        let largest = accelerations
            .iter()
            .zip(&self.columns)
            .fold(parameters.gravity.norm() / parameters.length, |m, (a, c)| m.max((a / c).abs()));
        let arm = content.arms(parameters.pitch[content.joint])[0].min(parameters.length);
        ROUND_OFF * largest * arm
    }
}
