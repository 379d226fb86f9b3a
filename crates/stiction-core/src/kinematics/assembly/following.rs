//! Tracking of a motion: prediction from the last configuration, and distinction between jumps of
//! the mechanism and kinks of the prescribed motion.

use super::Assembly;
use super::check::check_targets;
use crate::kinematics::bodies::{Bodies, State};
use crate::kinematics::coordinate::Target;
use crate::kinematics::error::AssemblyError;
use crate::parameters::Parameters;
use crate::spatial::Pose;

/// Bodies closer than this distance to their predicted poses have not jumped; rad or characteristic
/// lengths.
const NEGLIGIBLE: f64 = 1e-6;
/// Maximum number of halvings of a step of the motion.
const HALVINGS: u32 = 12;
/// If a step longer than this fraction of the motion does not converge, it is halved without a
/// search by damped least squares.
const LONG: f64 = 1.0 / 16.0;

impl Assembly {
    /// Moves along a motion from time `from` (the current configuration) to `to`, s, within the
    /// same assembly mode. `motion` writes the targets at a given time. At an instant at which the
    /// rates are not determined, they are continued from earlier instants.
    ///
    /// # Errors
    /// See [`AssemblyError`], which includes a jump that persists at the smallest step. After an
    /// error, loops may be open: move the mechanism to a reachable configuration before further
    /// use.
    pub(crate) fn follow(
        &mut self,
        parameters: &Parameters<f64>,
        from: f64,
        to: f64,
        mut motion: impl FnMut(f64, &mut [Target<f64>]),
    ) -> Result<(), AssemblyError> {
        if !(to - from).is_finite() {
            return Err(AssemblyError::NoTime { from, to });
        }
        self.start.clone_from(&self.state);
        let mut now = from;
        let span = (from, to);
        while let Err(stop) = self.follow_regular(parameters, (now, to), &mut motion) {
            now = stop.next;
            if !self.continue_to(parameters, span, stop.next, &mut motion) {
                // An unreachable end of the motion explains the failure best.
                return Err(self.out_of_reach(parameters, to, &mut motion).unwrap_or(stop.error));
            }
        }
        if self.is_singular(parameters) && !self.rests() {
            // The rates solve the equations, but others do too.
            self.continue_to(parameters, span, to, &mut motion);
        }
        Ok(())
    }

    /// Moves along a motion from the time `from` to `to`, s, by configurations at which loops and
    /// prescribed coordinates determine the rates.
    pub(super) fn follow_regular(
        &mut self,
        parameters: &Parameters<f64>,
        (from, to): (f64, f64),
        motion: &mut impl FnMut(f64, &mut [Target<f64>]),
    ) -> Result<(), Stop> {
        let (mut now, mut step) = (from, to - from);
        let smallest = step * 0.5_f64.powi(HALVINGS as i32);
        // Of several errors, a singular configuration explains the failure better than a jump.
        let mut singular = None;
        self.passed.copy_from_slice(&self.targets);
        while now != to {
            // The last step ends exactly at `to`.
            let last = (to - now).abs() <= step.abs() * (1.0 + 1e-9);
            let next = if last { to } else { now + step };
            let is_long = (next - now).abs() > LONG * (to - from).abs();
            let mut targets = core::mem::take(&mut self.targets);
            motion(next, &mut targets);
            self.targets = targets;
            let outcome = check_targets(
                &self.body_names,
                self.model.constraints.coordinates(),
                &self.targets,
            )
            .and_then(|()| self.step_smoothly(parameters, next - now, !is_long));
            match outcome {
                // Halving the step costs less than a search from a poor prediction.
                Err(_) if is_long && now + 0.5 * (next - now) != now => {
                    self.state.clone_from(&self.before);
                    step = 0.5 * (next - now);
                }
                Ok(()) => {
                    now = next;
                    self.passed.copy_from_slice(&self.targets);
                    step *= 2.0;
                }
                // Far from time zero, half a step may vanish by rounding; stop halving then.
                Err(error) if (0.5 * step).abs() < smallest.abs() || now + 0.5 * step == now => {
                    self.state.clone_from(&self.before);
                    let error = singular.unwrap_or(error);
                    return Err(Stop { next, error });
                }
                Err(error) => {
                    if matches!(error, AssemblyError::Undetermined { .. }) {
                        singular.get_or_insert(error);
                    }
                    self.state.clone_from(&self.before);
                    step = 0.5 * (next - now);
                }
            }
        }
        Ok(())
    }

    /// Searches for a configuration at time `to`, s, and returns the error if the mechanism cannot
    /// be assembled there. This prevents an unreachable configuration from being reported as a
    /// jump.
    fn out_of_reach(
        &mut self,
        parameters: &Parameters<f64>,
        to: f64,
        motion: &mut impl FnMut(f64, &mut [Target<f64>]),
    ) -> Option<AssemblyError> {
        let mut targets = core::mem::take(&mut self.targets);
        motion(to, &mut targets);
        self.targets = targets;
        check_targets(&self.body_names, self.model.constraints.coordinates(), &self.targets)
            .and_then(|()| self.search(parameters))
            .err()
    }

    /// Moves along a motion in one step if the motion is smooth enough; otherwise keeps the current
    /// configuration and returns `false`. The step may span many samples. Unlike [`Self::follow`],
    /// this method starts no search, so a failure is cheap.
    ///
    /// # Panics
    /// Panics unless there is one target for each prescribed coordinate.
    #[must_use = "`false` means that the configuration has not changed"]
    pub(crate) fn follow_in_one_step(
        &mut self,
        parameters: &Parameters<f64>,
        step: f64,
        targets: &[Target<f64>],
    ) -> bool {
        if check_targets(&self.body_names, self.model.constraints.coordinates(), targets).is_err() {
            return false;
        }
        self.passed.copy_from_slice(&self.targets);
        self.targets.copy_from_slice(targets);
        let arrived = self.step_smoothly(parameters, step, false).is_ok()
            && (!self.is_singular(parameters) || self.rests());
        if !arrived {
            self.extrapolation.forget();
            self.state.clone_from(&self.before);
            self.targets.copy_from_slice(&self.passed);
            self.differentiate(parameters);
        }
        arrived
    }

    /// Takes one step of the duration `step`, s, along a motion. Fails if the bodies do not move as
    /// their velocities predict. If Newton's method does not converge and `may_search` is set,
    /// searches by damped least squares.
    pub(super) fn step_smoothly(
        &mut self,
        parameters: &Parameters<f64>,
        step: f64,
        may_search: bool,
    ) -> Result<(), AssemblyError> {
        // The changes of the accelerations in the last steps approximate higher derivatives.
        let weights = self.extrapolation.weights(step).filter(|_| self.is_determined());
        let weights = weights.unwrap_or([0.0; 2]);
        let motion = self.state.rates.iter().zip(&self.state.accelerations);
        for (move_by, (v, a)) in self.step.iter_mut().zip(motion) {
            *move_by = step * (v + 0.5 * step * a);
        }
        if weights[0] != 0.0 {
            let changes = [(&self.state, &self.before), (&self.before, &self.before_last)];
            for (weight, (now, before)) in weights.into_iter().zip(changes) {
                let pairs = now.accelerations.iter().zip(&before.accelerations);
                for (move_by, (a, a_before)) in self.step.iter_mut().zip(pairs) {
                    *move_by += weight * (a - a_before);
                }
            }
        }
        let topology = &self.model.topology;
        let is_determined = self.is_determined();
        if is_determined {
            let turning = (&self.state.accelerations[..], &self.state.rates[..]);
            State::add_bracket(topology, &mut self.step, step * step * step / 12.0, turning);
        }
        if self.extrapolation.is_active() {
            core::mem::swap(&mut self.before, &mut self.before_last);
        }
        self.before.clone_from(&self.state);
        if is_determined {
            self.state.advance_far(topology, &self.step);
        } else {
            self.state.advance(topology, &self.step);
        }
        if may_search {
            self.settle(parameters)?;
        } else if !self.newton(parameters) || !self.differentiates_here(parameters) {
            return Err(AssemblyError::Undetermined { open: Vec::new() });
        }

        // Fourth-order prediction from the velocities and accelerations at both ends of the step.
        let ends = self.before.rates.iter().zip(&self.state.rates);
        let bends = self.before.accelerations.iter().zip(&self.state.accelerations);
        for ((move_by, (v0, v1)), (a0, a1)) in self.step.iter_mut().zip(ends).zip(bends) {
            *move_by = 0.5 * step * (v0 + v1) + step * step / 12.0 * (a0 - a1);
        }
        let topology = &self.model.topology;
        let turning = (&self.state.rates[..], &self.before.rates[..]);
        State::add_bracket(topology, &mut self.step, step * step / 12.0, turning);
        self.predicted.clone_from(&self.before);
        self.predicted.advance_far(topology, &self.step);
        if self.is_near_prediction(parameters) {
            self.extrapolation.stepped(step);
            return Ok(());
        }
        let length = parameters.length;
        self.trial.place(&self.model.topology, parameters, &self.before.coordinates);
        let (_, _, moved) = farthest(&self.trial, &self.kinematics.bodies, length);
        self.trial.place(&self.model.topology, parameters, &self.predicted.coordinates);
        let (body, apart, missed) = farthest(&self.trial, &self.kinematics.bodies, length);
        // A smooth motion has a prediction error much smaller than the displacement; a jump does
        // not.
        let follows = missed <= 0.2 * moved + NEGLIGIBLE && missed <= 0.1;
        if !follows && !self.has_a_kink(parameters, step, missed) {
            return Err(AssemblyError::Jump {
                body: self.body_names[body].clone(),
                distance_mm: apart.position.norm() * 1e3,
                angle_deg: apart.rotation.rotation_vector().norm().to_degrees(),
                step,
            });
        }
        Ok(())
    }

    /// Returns `true` if the prescribed coordinates determine the configuration, that is, if no
    /// body has a local degree of freedom. The rates of local degrees of freedom are set to zero,
    /// so their angles depend on the steps along the motion, and a better prediction would change
    /// them.
    pub(super) fn is_determined(&self) -> bool {
        self.model.constraints.spins().is_empty()
    }

    /// Returns `true` if the coordinates of the spanning tree are so close to the predicted values
    /// that no body can be farther than [`NEGLIGIBLE`] from its predicted pose.
    fn is_near_prediction(&self, parameters: &Parameters<f64>) -> bool {
        let pairs = self.state.coordinates.iter().zip(&self.predicted.coordinates);
        let apart: f64 = pairs.map(|(a, b)| (a - b).abs()).sum();
        // Bodies turn about the joints between them, and quaternion components are half angles.
        let bodies = &self.kinematics.bodies;
        let places = bodies.frame_j.iter().chain(&bodies.frame_k).chain(&bodies.pose);
        let base = bodies.pose[0].position;
        let reach = places.map(|pose| (pose.position - base).norm()).fold(0.0, f64::max);
        let pitch = parameters.pitch.iter().fold(0.0_f64, |most, pitch| most.max(pitch.abs()));
        let turned = 4.0 * (1.0 + (2.0 * reach + pitch) / parameters.length);
        // The factor 2 is a safety margin on the first-order estimate.
        2.0 * apart * (turned + 1.0 / parameters.length) <= NEGLIGIBLE
    }

    /// Returns `true` if a kink of the prescribed motion explains the prediction error `missed`:
    /// prescribed rates jump, and no body deviates by more than these jumps permit.
    fn has_a_kink(&mut self, parameters: &Parameters<f64>, step: f64, missed: f64) -> bool {
        let kinked = self.passed.iter().zip(&self.targets).any(|(from, to)| {
            let bend = 0.5 * step * (from.acceleration + to.acceleration);
            (to.rate - from.rate - bend).abs() > 0.1 * from.rate.abs().max(to.rate.abs())
        });
        if !kinked || missed > 0.01 {
            return false;
        }
        // Within the step, the rates lie between the rates before and after it.
        let ends = [&self.before.rates, &self.state.rates].map(|rates| {
            let mut end = self.before.clone();
            end.advance(
                &self.model.topology,
                &rates.iter().map(|rate| step * rate).collect::<Vec<f64>>(),
            );
            end
        });
        self.trial.place(&self.model.topology, parameters, &ends[0].coordinates);
        let mut other = self.trial.clone();
        other.place(&self.model.topology, parameters, &ends[1].coordinates);
        let (_, _, range) = farthest(&self.trial, &other, parameters.length);
        missed <= 0.6 * range + 1e-6
    }
}

/// End of a motion before an instant that no step reaches.
pub(super) struct Stop {
    /// Time that the smallest step does not reach, s.
    pub(super) next: f64,
    pub(super) error: AssemblyError,
}

/// Converts an error at an intermediate configuration: attributes undetermined motions to that
/// configuration, not to the prescribed coordinates.
pub(super) fn on_the_way(error: AssemblyError) -> AssemblyError {
    match error {
        AssemblyError::Open { open } => AssemblyError::Undetermined { open },
        other => other,
    }
}

/// Finds the body with the largest difference between two sets of poses. Returns the index of the
/// body, the pose in `b` relative to the pose in `a`, and the size of the difference, with lengths
/// divided by `length`.
fn farthest(a: &Bodies<f64>, b: &Bodies<f64>, length: f64) -> (usize, Pose<f64>, f64) {
    let mut worst = (0, Pose::identity(), 0.0);
    for (body, (a, b)) in a.pose.iter().zip(&b.pose).enumerate() {
        let apart = a.inverse() * *b;
        let size = apart.position.norm() / length + apart.rotation.rotation_vector().norm();
        if size > worst.2 {
            worst = (body, apart, size);
        }
    }
    worst
}
