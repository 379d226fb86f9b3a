//! Directions in which contacts begin to slide: those of balls and plates are those of their acceleration.

use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::situation::Situation;
use crate::forward::solve::{Solved, Unsolved};
use crate::kinematics::Bodies;
use nalgebra::{Matrix3, Vector3};

/// Accelerations below this part of the largest are none.
const STILL: f64 = 1e-10;
/// Directions are found when they turn by less than this.
const TURNED: f64 = 1e-12;
/// Passes for that.
const TURNS: usize = 40;

impl Forward {
    /// Solves with the directions of all that begins to slide; those of balls and plates turn until they
    /// are those of the acceleration. Also a contact that would slide back.
    pub(super) fn turn(
        &self,
        situation: &Situation,
        trial: &mut [InterfaceMode],
        resting: &[usize],
    ) -> Result<(Solved, Option<usize>), Unsolved> {
        for pass in 0..TURNS {
            let solved = self.solve(situation, trial, None, true)?;
            let accelerated = self.accelerated_by(situation, &solved);
            let mut turned = 0.0_f64;
            for &interface in resting {
                let (InterfaceMode::AtLimit(direction) | InterfaceMode::Slides(direction)) =
                    trial[interface]
                else {
                    continue;
                };
                let Some(begins) = self.begins(&accelerated, &solved, interface) else { continue };
                let along: f64 = begins.iter().zip(direction).map(|(a, d)| a * d).sum();
                let single = self.parameters.interfaces[interface].shape.has_one_dof();
                if along < 0.0 && (single || pass > 3) {
                    return Ok((solved, Some(interface)));
                }
                if single {
                    continue;
                }
                let next = self.direction(situation, &solved, interface, begins);
                turned = turned.max(norm([0, 1, 2].map(|i| next[i] - direction[i])));
                trial[interface] = match trial[interface] {
                    InterfaceMode::Slides(_) => InterfaceMode::Slides(next),
                    _ => InterfaceMode::AtLimit(next),
                };
            }
            if turned < TURNED || pass + 1 == TURNS {
                return Ok((solved, None));
            }
        }
        let solved = self.solve(situation, trial, None, true)?;
        Ok((solved, None))
    }

    /// The direction in which a ball or plate begins to slide, other contacts and its load as they are.
    /// With `K`, what one newton of friction takes from the surface's acceleration, that without
    /// friction `a`, and friction of size `c`, it is `d = (x + c K)^-1 a` with the acceleration `x` that
    /// makes it of length one.
    fn direction(
        &self,
        situation: &Situation,
        solved: &Solved,
        interface: usize,
        begins: [f64; 3],
    ) -> [f64; 3] {
        let content = &self.parameters.interfaces[interface];
        let arms = content.arms(self.parameters.pitch[content.joint]);
        let scene = self.scene(situation);
        let mut taken = Matrix3::zeros();
        for (column, wrench) in
            self.unit_frictions(&situation.bodies, interface).into_iter().enumerate()
        {
            let response = solved.balance.respond(&scene, &[(content.joint, wrench)], false);
            for row in 0..3 {
                taken[(row, column)] =
                    -self.surface_rate(&situation.bodies, &response.accelerations, interface, row);
            }
        }
        let load = solved.coupled.loads[interface];
        let rub = &solved.affine_frictions[interface];
        let friction: [f64; 3] =
            [0, 1, 2].map(|i| (rub.known[i] + rub.per_load[i] * load) / arms[i]);
        let size = norm(friction);
        let free = Vector3::from(begins) + taken * Vector3::from(friction);
        let along = |x: f64| {
            let matrix = taken * size + Matrix3::identity() * x;
            matrix.lu().solve(&free).unwrap_or_else(Vector3::zeros)
        };
        // Between none and all of the acceleration without friction.
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
        if length > 0.0 { (found / length).into() } else { begins.map(|b| b / norm(begins)) }
    }

    /// The bodies as they accelerate in a solved choice.
    pub(super) fn accelerated_by(&self, situation: &Situation, solved: &Solved) -> Bodies<f64> {
        self.accelerated(&situation.bodies, &solved.coupled.response.accelerations)
    }

    /// The acceleration of a contact's surface, m/s^2, where it is more than rounding; `accelerated` are the bodies as
    /// they accelerate in this solution.
    pub(super) fn begins(
        &self,
        accelerated: &Bodies<f64>,
        solved: &Solved,
        interface: usize,
    ) -> Option<[f64; 3]> {
        let accelerations = &solved.coupled.response.accelerations;
        let begins = self.surface_acceleration(accelerated, interface);
        (norm(begins) > self.rounding_of_beginnings(accelerations, interface)).then_some(begins)
    }

    /// Accelerations of a contact's surface up to this, m/s^2, are rounding.
    pub(in crate::forward) fn rounding_of_beginnings(
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
        STILL * largest * arm
    }
}
