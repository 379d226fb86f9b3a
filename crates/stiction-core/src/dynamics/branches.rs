//! Other solutions of friction and reactions, and how far the one that is given goes on.

use super::continuation::{Lock, follow_friction};
use super::inverse::Inverse;
use super::settings::{FrictionMode, Settings};
use super::solver::{InverseDynamics, Parts};
use crate::mechanism::JointId;
use crate::random::Random;
use crate::spatial::Wrench;
use crate::statics::AppliedLoad;

/// How far the coefficients of all contacts may grow, together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionMargin {
    /// The factor at which the solution that is connected with no friction is lost: there friction
    /// locks the mechanism. None if it goes on beyond the factor that was asked for.
    pub locks_at: Option<f64>,
    /// The joint whose load grows without bound there.
    pub joint: Option<JointId>,
}

/// Solutions that are looked for from so many starts.
const STARTS: usize = 32;
/// Steps from each start.
const STEPS: usize = 60;
/// Solutions whose loads differ by less than this part of the largest are one.
const SAME: f64 = 1e-6;
/// Loads this many times those without friction are on the way to infinity.
const UNBOUNDED: f64 = 1e6;

impl InverseDynamics {
    /// Follows the solution from no friction while the coefficients of all contacts grow to `most`
    /// times the given ones. Contacts at rest carry no friction. None where the position is singular,
    /// friction is off or no contact slides: then nothing is known. The forces of the last [`InverseDynamics::solve`] stay.
    pub fn friction_margin(
        &mut self,
        loads: &[AppliedLoad<f64>],
        most: f64,
    ) -> Option<FrictionMargin> {
        let Parts { model, inverse, parameters, kinematics, settings } = self.parts()?;
        if settings.friction == FrictionMode::Off {
            // There is no solution with friction to follow, and nothing is known.
            return None;
        }
        if parameters.interfaces.is_empty() {
            return Some(FrictionMargin { locks_at: None, joint: None });
        }
        if inverse.interfaces().iter().all(|interface| interface.sliding == 0.0) {
            // What rests carries no friction here, so nothing would be followed.
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

    /// Efforts of other solutions of friction and reactions than that of the last
    /// [`InverseDynamics::solve`], as far as Newton's method finds them from many starts: where
    /// [`InverseDynamics::coupling`] is below one there are none, and nothing is looked for. There may
    /// be more than are found.
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
            // From loads of the size that there are, and from larger and larger ones.
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
            probe.press_with(parameters, bodies, &wrenches);
            let mut found = false;
            for _ in 0..STEPS {
                let (change, load) = probe.step(model, parameters, bodies);
                if !load.is_finite() || load > limit {
                    break;
                }
                if settings.is_settled(change, load) {
                    found = probe.is_balanced(model, parameters);
                    break;
                }
            }
            found |= probe.friction_stagnated() && probe.is_balanced(model, parameters);
            if !found {
                continue;
            }
            probe.finish_friction(model.topology(), parameters, bodies);
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
