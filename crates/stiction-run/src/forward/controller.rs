//! Controllers of the actuators, evaluated at regular samples or in continuous time.

use super::acting_inputs::prescribed;
use super::job::Job;
use super::motors::Motors;
use super::sampled_loop::{SampledLoop, Tuning, largest_bandwidth};
use crate::error::Error;
use crate::names::Names;
use nalgebra::{DMatrix, DVector};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction_core::forward::Forward;
use stiction_core::kinematics::{AssemblyError, Bodies, Coordinate, State, Target};
use stiction_format::{Control, ControlType, FrictionFeed, ModelFile};

/// Gains and effort limit of the controller of one actuator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gains {
    proportional: f64,
    derivative: f64,
    /// Integral gain; zero without integral action.
    pub(super) integral: f64,
    /// Time constant with which the integral part tracks the limited effort (anti-windup), s; infinite if the effort
    /// has no limit.
    tracking: f64,
    /// Largest magnitude of the effort, N or N m; infinite if there is no limit.
    pub(super) limit: f64,
}

impl Gains {
    /// Returns the sum of the proportional, derivative and integral parts for the given errors of
    /// position and rate. The sum is an effort, N or N m, before its limit; for computed torque it
    /// is an acceleration, m/s^2 or rad/s^2.
    pub(super) fn effort(&self, (error, rate_error): (f64, f64), integral: f64) -> f64 {
        self.proportional * error + integral + self.derivative * rate_error
    }

    /// Returns the time derivative of the integral part, N/s or N m/s, with anti-windup by
    /// back-calculation. `demand` is the effort before the limit, and `effort` the effort after the
    /// limit.
    pub(super) fn integral_rate(&self, error: f64, demand: f64, effort: f64) -> f64 {
        self.integral * error + (effort - demand) / self.tracking
    }

    /// Returns the characteristic magnitude of the integral part, N or N m, which scales the
    /// absolute tolerance of the time integration.
    pub(super) fn scale(&self) -> f64 {
        if self.limit.is_finite() { self.limit } else { self.proportional.max(self.integral) }
    }
}

/// Controller of all actuators, with the state that it keeps from sample to sample.
#[derive(Clone, Debug)]
pub(super) struct Controller<'a> {
    control: &'a Control,
    /// Controller gains and effort limit of each actuator.
    pub(super) gains: Vec<Gains>,
    /// Integral part of the effort of each actuator at the last sample, N or N m. Zeros for a
    /// controller in continuous time, because the simulation then integrates these parts.
    integrals: Vec<f64>,
    /// Inverse dynamics for computed torque and for effective masses, with prescribed coordinates
    /// of the actuators. `None` if the controller requires neither.
    model: Option<InverseDynamics>,
    motors: Motors,
    /// Names of the locked actuators.
    locked: String,
    /// Positions of all actuators at the previous sample, m or rad; `None` before the first sample.
    before: Option<Vec<f64>>,
    /// Stability of the loop at the start.
    pub(super) tuning: Tuning,
}

/// Measurements, references and feed-forward efforts that a controller receives at a sample.
pub(super) struct ControllerInput<'a> {
    pub(super) time: f64,
    /// Position, m or rad, and rate, m/s or rad/s, of each actuator. Angles are not wrapped to one
    /// turn.
    pub(super) actual: &'a [(f64, f64)],
    /// Reference position, rate and acceleration of each actuator.
    pub(super) reference: &'a [Target<f64>],
    /// Feed-forward effort of each actuator, N or N m.
    pub(super) feed: &'a [f64],
    /// Friction contribution to the effort of each actuator along the reference motion, N or N m.
    pub(super) friction: &'a [f64],
    /// External loads on the bodies at the sample.
    pub(super) loads: &'a [AppliedLoad<f64>],
}

impl<'a> Controller<'a> {
    /// Creates the controller before its first sample. `state` and `bodies` describe the mechanism
    /// at the start of the simulation.
    pub(super) fn new(
        job: &Job<'a>,
        control: &'a Control,
        forward: &Forward,
        (state, bodies): (&State<f64>, &Bodies<f64>),
    ) -> Result<Self, Error> {
        let wants_gains =
            |c: &stiction_format::Channel| c.proportional.is_none() || c.derivative.is_none();
        let pd = control.control != ControlType::ComputedTorque;
        // Prescribed actuators are not moved by the controller.
        let count = control.channels.len();
        let taken = prescribed(job);
        let mut free: Vec<usize> = (0..count).filter(|k| !taken.contains(k)).collect();
        let uses_defaults = free.iter().any(|k| wants_gains(&control.channels[*k]));
        let needs_model = !pd || uses_defaults;
        let motors = Motors::new(&job.known_model().mechanism);
        let names = Names::new(forward.mechanism()).drives;
        let locked = job.locked.iter().map(|k| format!("`{}`", names[*k].0));
        let locked = locked.collect::<Vec<_>>().join(", ");
        // With given gains, the model is only needed to examine their stability, and may fail.
        let prepare = || {
            let mut model = by_actuators(job.known_model(), forward, (state, bodies))?;
            // Computed torque makes each actuator a unit mass.
            let masses = match pd {
                true => mass_matrix(&mut model, &motors)?,
                false => DMatrix::identity(count, count),
            };
            Ok((model, masses))
        };
        let (model, masses) = match prepare() {
            Ok((model, masses)) => (needs_model.then_some(model), Some(masses)),
            Err(error) if needs_model => return Err(of_locks(error, &locked)),
            Err(_) => (None, None),
        };
        if let Some(masses) = &masses {
            free.retain(|k| masses[(*k, *k)] > 0.0);
        }
        let coupled = masses.as_ref().map(|all| all.select_rows(&free).select_columns(&free));
        let zeta = control.damping;
        let mut tuning = Tuning::default();
        let omega = control.bandwidth.unwrap_or_else(|| {
            let largest = coupled
                .as_ref()
                .map_or(f64::INFINITY, |coupled| largest_bandwidth(coupled, zeta, control.period));
            if largest < Control::USUAL_BANDWIDTH && uses_defaults {
                tuning.lowered = Some(largest);
            }
            largest.min(Control::USUAL_BANDWIDTH)
        });
        let usual = |limit: f64| Gains {
            proportional: omega * omega,
            derivative: 2.0 * zeta * omega,
            integral: 0.0,
            tracking: f64::INFINITY,
            limit,
        };
        let mut gains: Vec<Gains> =
            control.channels.iter().map(|channel| usual(channel.limit)).collect();
        if pd {
            for (k, (gains, channel)) in gains.iter_mut().zip(&control.channels).enumerate() {
                // Without a model, both gains are given.
                let mass = masses.as_ref().map_or(0.0, |masses| masses[(k, k)]);
                let given = channel.proportional;
                gains.proportional = given.unwrap_or(gains.proportional * mass);
                gains.derivative = channel.derivative.unwrap_or(gains.derivative * mass);
                gains.integral = channel.integral.unwrap_or(0.0);
                if gains.integral > 0.0 && gains.limit.is_finite() {
                    let usual = gains.proportional / gains.integral;
                    gains.tracking = channel.tracking.unwrap_or(usual);
                }
            }
        }
        tuning.growth = coupled.and_then(|masses| {
            let of = |gain: fn(&Gains) -> f64| {
                DVector::from_iterator(free.len(), free.iter().map(|k| gain(&gains[*k])))
            };
            let control_loop = SampledLoop {
                masses,
                proportional: of(|gains| gains.proportional),
                derivative: of(|gains| gains.derivative),
                integral: of(|gains| gains.integral),
                period: control.period,
                differences: control.differences,
            };
            control_loop.growth()
        });
        let integrals = vec![0.0; count];
        let mut controller =
            Self { control, gains, integrals, model, motors, locked, before: None, tuning };
        if let Some(model) = &mut controller.model
            && control.friction == FrictionFeed::Measured
        {
            model.settings_mut().friction = FrictionMode::Converged;
        }
        Ok(controller)
    }

    /// Appends the state of the controller to `numbers`: the integral parts, the number of
    /// positions measured at the previous sample, these positions, and the configuration of the
    /// inverse dynamics.
    pub(super) fn save(&self, numbers: &mut Vec<f64>) {
        numbers.extend(&self.integrals);
        let before = self.before.as_deref().unwrap_or_default();
        numbers.push(before.len() as f64);
        numbers.extend(before);
        if let Some(model) = &self.model {
            numbers.extend(model.save());
        }
    }

    /// Restores the state written by [`Self::save`]; `None` if the numbers belong to another
    /// controller.
    pub(super) fn restore(&mut self, numbers: &[f64]) -> Option<()> {
        let (integrals, rest) = numbers.split_at_checked(self.integrals.len())?;
        self.integrals.copy_from_slice(integrals);
        let (&count, rest) = rest.split_first()?;
        let (before, position) = rest.split_at_checked(count as usize)?;
        if !before.is_empty() && before.len() != self.gains.len() {
            return None;
        }
        self.before = (!before.is_empty()).then(|| before.to_vec());
        match &mut self.model {
            Some(model) => model.restore(position),
            None => position.is_empty().then_some(()),
        }
    }

    /// Computes the efforts of all actuators, N or N m, which act from this sample until the next
    /// one.
    pub(super) fn sample(&mut self, input: &ControllerInput<'_>) -> Result<Vec<f64>, Error> {
        let control = self.control;
        let ControllerInput { time, actual, reference, feed, friction, loads } = input;
        let mut positions = Vec::with_capacity(actual.len());
        let mut rates = Vec::with_capacity(actual.len());
        for (index, (value, rate)) in actual.iter().enumerate() {
            let step = control.channels[index].resolution;
            let value = if step > 0.0 { (value / step).round() * step } else { *value };
            rates.push(match &self.before {
                Some(before) if control.differences => (value - before[index]) / control.period,
                None if control.differences => 0.0,
                _ => *rate,
            });
            positions.push(value);
        }
        let errors: Vec<(f64, f64)> = reference
            .iter()
            .zip(positions.iter().zip(&rates))
            .map(|(reference, (position, rate))| {
                (reference.value - position, reference.rate - rate)
            })
            .collect();
        let each = errors.iter().zip(&self.gains).zip(&self.integrals);
        let corrections = each.map(|((errors, gains), integral)| gains.effort(*errors, *integral));
        let mut efforts: Vec<f64> = match (control.control, &mut self.model) {
            (ControlType::ComputedTorque, Some(model)) => {
                let targets: Vec<Target<f64>> = corrections
                    .zip(reference.iter().zip(positions.iter().zip(&rates)))
                    .map(|(correction, (reference, (value, rate)))| Target {
                        value: *value,
                        rate: *rate,
                        acceleration: reference.acceleration + correction,
                    })
                    .collect();
                let at = |error| Error::ControllerAt { time: *time, error: Box::new(error) };
                let locked = &self.locked;
                let ahead = if self.before.is_some() { control.period } else { 0.0 };
                model
                    .move_ahead(ahead, &targets)
                    .map_err(|error| at(of_locks(Error::Controller(error), locked)))?;
                let forces =
                    model.solve(loads).map_err(|error| at(Error::ControllerForces(error)))?;
                let mut efforts = forces.efforts.clone();
                let friction = control.friction == FrictionFeed::Measured;
                self.motors.add(*time, &mut efforts, (&targets, model.bodies()), friction)?;
                efforts
            }
            _ => corrections.collect(),
        };
        for (index, effort) in efforts.iter_mut().enumerate() {
            let gains = &self.gains[index];
            let more =
                if control.friction == FrictionFeed::Reference { friction[index] } else { 0.0 };
            let demand = *effort + feed[index] + more;
            *effort = demand.clamp(-gains.limit, gains.limit);
            if gains.integral > 0.0 {
                // With a time constant below the sampling period, the anti-windup term would
                // overshoot.
                let tracking = gains.tracking.max(control.period);
                let gains = Gains { tracking, ..*gains };
                let rate = gains.integral_rate(errors[index].0, demand, *effort);
                self.integrals[index] += control.period * rate;
            }
        }
        self.before = Some(positions);
        Ok(efforts)
    }
}

/// Attributes contradictory accelerations of the controller's model to the locked actuators, if there
/// are any.
fn of_locks(error: Error, locked: &str) -> Error {
    match error {
        Error::Controller(error @ AssemblyError::Contradiction { .. }) if !locked.is_empty() => {
            Error::ControllerLocked { locked: locked.to_owned(), error }
        }
        other => other,
    }
}

/// Returns the mass matrix of the actuators, kg or kg m^2. Its column `k` contains the efforts per
/// unit acceleration of actuator `k` while the other actuators do not accelerate. `model` prescribes
/// the coordinates of the actuators.
fn mass_matrix(model: &mut InverseDynamics, motors: &Motors) -> Result<DMatrix<f64>, Error> {
    let state = model.state().clone();
    let (bodies, actuators) = (model.bodies().clone(), model.mechanism().actuators());
    // The state refers to the spanning tree of the model without friction. With friction, the
    // spanning tree may also contain motor shafts.
    let mechanism = model.mechanism().without_friction();
    let forward = Forward::new(mechanism, &[]);
    let mut targets: Vec<Target<f64>> = actuators
        .map(|(joint, dof)| Target {
            rate: 0.0,
            acceleration: 0.0,
            ..forward.joint_motion(&state, &bodies, joint, dof)
        })
        .collect();
    let mut efforts = |targets: &[Target<f64>]| -> Result<DVector<f64>, Error> {
        model.move_to(targets).map_err(Error::Controller)?;
        let forces = model.solve(&[]).map_err(Error::ControllerForces)?;
        Ok(DVector::from_column_slice(&forces.efforts_frictionless))
    };
    let still = efforts(&targets)?;
    let mut masses = DMatrix::zeros(targets.len(), targets.len());
    for k in 0..targets.len() {
        targets[k].acceleration = 1.0;
        masses.set_column(k, &(efforts(&targets)? - &still));
        targets[k].acceleration = 0.0;
    }
    motors.add_inertia(&mut masses);
    Ok(masses)
}

/// Creates a solver of inverse dynamics for the mechanism in the configuration given by `state` and
/// `bodies`. The coordinates of the actuators are prescribed. Friction is switched off in the
/// settings of the solver.
pub(super) fn by_actuators(
    model: &ModelFile,
    forward: &Forward,
    (state, bodies): (&State<f64>, &Bodies<f64>),
) -> Result<InverseDynamics, Error> {
    let mechanism = model.mechanism.starting_at(bodies.joint_poses());
    let ground = forward.parameters().ground.inverse();
    let initial_poses: Vec<_> = model
        .mechanism
        .bodies()
        .iter()
        .enumerate()
        .skip(1)
        .map(|(index, _)| (stiction_core::mechanism::BodyId(index), ground * bodies.pose[index]))
        .collect();
    let coordinates: Vec<Coordinate> =
        mechanism.actuators().map(|(joint, dof)| Coordinate::Joint { joint, dof }).collect();
    let targets: Vec<Target<f64>> = mechanism
        .actuators()
        .map(|(joint, dof)| forward.joint_motion(state, bodies, joint, dof))
        .collect();
    let settings = Settings { friction: FrictionMode::Off, ..Settings::default() };
    InverseDynamics::new(mechanism, &initial_poses, &coordinates, &targets, settings)
        .map_err(Error::Controller)
}
