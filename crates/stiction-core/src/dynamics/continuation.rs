//! Continuation of the solution from zero friction to the given friction coefficients, using the
//! sparse balance.
//!
//! Equation (F8) of the book's theory.

use super::coupling::FrictionCoupling;
use super::inverse::Inverse;
use super::model::Model;
use super::settings::Settings;
use crate::friction_problem::continuation::{Branch, Lock, StepPolicy, fastest_growing, follow};
use crate::friction_problem::newton::UNBOUNDED;
use crate::kinematics::{Bodies, Kinematics};
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;

/// Step sizes of the continuation. Steps are short because a longer step might skip an interval
/// without a solution, or jump to another solution branch.
const STEPS: StepPolicy =
    StepPolicy { first: 0.01, growth: 2.0, longest: 0.02, shortest: 1e-5, most: usize::MAX };

/// Solution branch parametrised by the common factor on all friction coefficients. `inverse`
/// contains the solution at the present factor.
struct BalanceBranch<'a> {
    inverse: &'a mut Inverse<f64>,
    accepted: Inverse<f64>,
    model: &'a Model,
    parameters: &'a Parameters<f64>,
    bodies: &'a Bodies<f64>,
    settings: &'a Settings,
    start: Vec<f64>,
    limit: f64,
}

impl Branch for BalanceBranch<'_> {
    fn correct(&mut self, part: f64) -> bool {
        let Self { inverse, model, parameters, bodies, settings, limit, .. } = self;
        inverse.apply_friction_at(model.topology(), parameters, bodies, settings, part);
        let steps = settings.friction_steps;
        inverse.newton(model, parameters, bodies, settings, (steps, *limit))
            && inverse.orientation() > 0.0
    }

    fn accept(&mut self) {
        self.accepted.clone_from(self.inverse);
    }

    fn reject(&mut self) {
        self.inverse.clone_from(&self.accepted);
    }

    fn fastest_growing(&self) -> usize {
        fastest_growing(&self.start, &loads(&self.accepted))
    }
}

/// Follows the solution branch from zero friction to `until` times the given friction coefficients.
/// On success `inverse` contains the solution with the coefficients multiplied by `until`.
///
/// # Errors
/// Returns the point at which friction locks the mechanism: the determinant of the coupled balance
/// vanishes there, and the forces grow without bound.
pub(super) fn follow_friction(
    inverse: &mut Inverse<f64>,
    model: &Model,
    parameters: &Parameters<f64>,
    kinematics: &mut Kinematics<f64>,
    applied: &[AppliedLoad<f64>],
    settings: &Settings,
    until: f64,
) -> Result<(), Lock> {
    inverse.begin(model, parameters, kinematics, applied, settings);
    let bodies = &kinematics.bodies;
    let bound = FrictionCoupling::default().begin(inverse, model, parameters, bodies);
    let start = loads(inverse);
    let limit = UNBOUNDED * start.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let accepted = inverse.clone();
    let mut branch =
        BalanceBranch { inverse, accepted, model, parameters, bodies, settings, start, limit };
    follow(&mut branch, STEPS.with_bound(bound, until), until)?;
    inverse.finish_friction(model, parameters, bodies);
    inverse.spin_up(model, kinematics);
    Ok(())
}

/// Returns the normal load of each interface, N.
fn loads(inverse: &Inverse<f64>) -> Vec<f64> {
    inverse.interfaces().iter().map(|interface| interface.load()).collect()
}

impl Inverse<f64> {
    /// Runs Newton's method on the balance with linearised friction, starting from the present
    /// normal loads. The method takes at most `steps` steps, and fails if a normal load exceeds
    /// `limit`, N. Returns true if the normal loads converge.
    pub(super) fn newton(
        &mut self,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        settings: &Settings,
        (steps, limit): (usize, f64),
    ) -> bool {
        for _ in 0..steps {
            let (change, largest) = self.step(model, parameters, bodies);
            if largest.is_nan() || largest > limit {
                break;
            }
            if settings.is_settled(change, largest) {
                return true;
            }
        }
        self.friction_stagnated() && self.is_balanced(model, parameters)
    }
}
