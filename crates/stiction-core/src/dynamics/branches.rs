//! Search for solutions of the friction problem beyond the computed one, and the friction margin to
//! jamming.

use super::continuation::follow_friction;
use super::inverse::Inverse;
use super::settings::{FrictionMode, Settings};
use super::solver::{InverseDynamics, Parts};
use crate::friction_problem::continuation::Lock;
use crate::mechanism::JointId;
use crate::random::Random;
use crate::spatial::Wrench;
use crate::statics::AppliedLoad;

/// Friction margin to jamming: the largest common factor by which all friction coefficients can be
/// multiplied before friction locks the mechanism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionMargin {
    /// Factor at which friction locks the mechanism: the solution branch connected to the
    /// frictionless solution ends there. `None` if this branch exists up to the largest requested
    /// factor.
    pub locks_at: Option<f64>,
    /// Joint whose normal load grows without bound as the factor approaches `locks_at`. `None` if
    /// `locks_at` is `None`.
    pub joint: Option<JointId>,
}

/// Number of random starts in the search for other solutions.
const STARTS: usize = 32;
/// Largest number of Newton steps from each random start in the search for other solutions.
const STEPS: usize = 60;
/// Two solutions count as equal if their actuator efforts differ by less than this fraction.
const SAME: f64 = 1e-6;
/// Normal loads count as unbounded if they exceed the largest frictionless normal load by this
/// factor.
const UNBOUNDED: f64 = 1e6;

impl InverseDynamics {
    /// Computes the friction margin, up to the factor `most`. Interfaces at rest are regarded as
    /// frictionless. Returns `None` if the configuration is singular, if friction is off, or if
    /// there are interfaces but none of them slides. Does not change the forces of the last
    /// [`InverseDynamics::solve`].
    pub fn friction_margin(
        &mut self,
        loads: &[AppliedLoad<f64>],
        most: f64,
    ) -> Option<FrictionMargin> {
        if self.has_program() {
            // A program does not compute the matrix of the balance.
            self.by_kernel(loads);
        }
        let Parts { model, inverse, parameters, kinematics, settings } = self.parts()?;
        if settings.friction == FrictionMode::Off {
            return None;
        }
        if parameters.interfaces.is_empty() {
            return Some(FrictionMargin { locks_at: None, joint: None });
        }
        if inverse.interfaces().iter().all(|interface| interface.sliding == 0.0) {
            return None;
        }
        let settings = Settings { friction: FrictionMode::Converged, ..*settings };
        let mut probe = inverse.clone();
        let followed =
            follow_friction(&mut probe, model, parameters, kinematics, loads, &settings, most);
        Some(match followed {
            Ok(()) => FrictionMargin { locks_at: None, joint: None },
            Err(Lock { part, interface }) => FrictionMargin {
                locks_at: Some(part),
                joint: Some(JointId(parameters.interfaces[interface].joint)),
            },
        })
    }

    /// Searches for solutions of the friction problem that differ from the result of the last
    /// [`InverseDynamics::solve`], by Newton's method from many random starts. Returns the actuator
    /// efforts of each solution found; the list may be incomplete. Returns an empty list if
    /// [`InverseDynamics::coupling`] is `None`, or if it is below one, because the solution is then
    /// unique.
    pub fn other_solutions(&mut self, loads: &[AppliedLoad<f64>]) -> Vec<Vec<f64>> {
        if self.coupling().is_none_or(|coupling| coupling < 1.0) {
            return Vec::new();
        }
        let efforts = self.forces().efforts.clone();
        let Some(Parts { model, inverse, parameters, kinematics, settings }) = self.parts() else {
            return Vec::new();
        };
        let mut probe = inverse.clone();
        probe.begin(model, parameters, kinematics, loads, settings);
        let without = probe.joint_wrenches().to_vec();
        let largest = |inverse: &Inverse<f64>| {
            inverse.interfaces().iter().map(|c| c.load()).fold(f64::MIN_POSITIVE, f64::max)
        };
        let limit = UNBOUNDED * largest(&probe);
        let force = without.iter().map(|w| w.force.norm()).fold(0.0, f64::max);
        let mut random = Random::new(1);
        let mut known = vec![efforts];
        for start in 0..STARTS {
            // The first starts have wrenches of the size of the frictionless wrenches, later starts
            // have larger ones.
            let size = force * 4f64.powi(start as i32 / 8);
            let wrenches: Vec<Wrench<f64>> = without
                .iter()
                .map(|wrench| {
                    let shift = random.vector() * size;
                    let moment = random.vector() * (size * parameters.length);
                    Wrench { force: wrench.force + shift, moment: wrench.moment + moment }
                })
                .collect();
            probe.begin(model, parameters, kinematics, loads, settings);
            let bodies = &kinematics.bodies;
            probe.restart_from(parameters, bodies, &wrenches);
            let found = probe.newton(model, parameters, bodies, settings, (STEPS, limit))
                && probe.is_balanced(model, parameters);
            if !found {
                continue;
            }
            probe.finish_friction(model, parameters, bodies);
            let efforts = probe.efforts().to_vec();
            let scale = efforts.iter().map(|d| d.abs()).fold(f64::MIN_POSITIVE, f64::max);
            let differs = |other: &Vec<f64>| {
                other.iter().zip(&efforts).any(|(a, b)| (a - b).abs() > SAME * scale)
            };
            if known.iter().all(differs) {
                known.push(efforts);
            }
        }
        known.split_off(1)
    }
}
