//! Sampled controllers.

use super::job::Job;
use super::motors::Motors;
use crate::error::Error;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction_core::forward::Forward;
use stiction_core::kinematics::{Bodies, Coordinate, State, Target};
use stiction_format::{Control, ControlType, FrictionFeed, ModelFile};

/// Sampled controller with its state.
#[derive(Clone, Debug)]
pub(super) struct Controller<'a> {
    control: &'a Control,
    /// Proportional and derivative gain of each actuator.
    gains: Vec<(f64, f64)>,
    /// Inverse dynamics with the actuators' coordinates prescribed, for computed torque.
    model: Option<InverseDynamics>,
    motors: Motors,
    /// Positions measured at the previous sample.
    before: Option<Vec<f64>>,
}

/// Inputs of a controller at a sample.
pub(super) struct Told<'a> {
    pub(super) time: f64,
    /// Positions and rates of all actuators; angles count full turns.
    pub(super) actual: &'a [(f64, f64)],
    /// Reference motions of the actuators.
    pub(super) wanted: &'a [Target<f64>],
    /// Feed-forward efforts, N or N m.
    pub(super) feed: &'a [f64],
    /// Friction contributions to the efforts of the reference motion.
    pub(super) friction: &'a [f64],
    /// External loads.
    pub(super) loads: &'a [AppliedLoad<f64>],
}

impl<'a> Controller<'a> {
    /// Creates the controller before its first sample; the mechanism starts at `state`.
    pub(super) fn new(
        job: &Job<'a>,
        control: &'a Control,
        forward: &Forward,
        (state, bodies): (&State<f64>, &Bodies<f64>),
    ) -> Result<Self, Error> {
        let wants_gains =
            |c: &stiction_format::Channel| c.proportional.is_none() || c.derivative.is_none();
        let pd = control.control == ControlType::Pd;
        let model = if !pd || control.channels.iter().any(wants_gains) {
            Some(by_actuators(job.model, forward, (state, bodies))?)
        } else {
            None
        };
        let (omega, zeta) = (control.bandwidth, control.damping);
        let mut gains = vec![(omega * omega, 2.0 * zeta * omega); control.channels.len()];
        let mut controller = Self {
            control,
            gains: Vec::new(),
            model,
            motors: Motors::new(&job.model.mechanism),
            before: None,
        };
        if pd {
            let masses = controller.masses()?;
            for ((gains, channel), mass) in gains.iter_mut().zip(&control.channels).zip(masses) {
                gains.0 = channel.proportional.unwrap_or(gains.0 * mass);
                gains.1 = channel.derivative.unwrap_or(gains.1 * mass);
            }
        }
        controller.gains = gains;
        if let Some(model) = &mut controller.model
            && control.friction == FrictionFeed::Measured
        {
            model.settings_mut().friction = FrictionMode::Converged;
        }
        Ok(controller)
    }

    /// Appends the last measured positions, preceded by their number, and the position of the
    /// controller's own model.
    pub(super) fn save(&self, numbers: &mut Vec<f64>) {
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
        let (&count, rest) = numbers.split_first()?;
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

    /// Effective mass of each actuator: the effort for unit acceleration while the other actuators
    /// do not accelerate, kg or kg m^2.
    fn masses(&mut self) -> Result<Vec<f64>, Error> {
        let Some(model) = &mut self.model else {
            return Ok(vec![0.0; self.control.channels.len()]);
        };
        let state = model.state().clone();
        let (bodies, actuators) = (model.bodies().clone(), model.mechanism().actuators());
        let forward = Forward::new(model.mechanism().clone(), &[]);
        let mut targets: Vec<Target<f64>> = actuators
            .map(|(joint, dof)| Target {
                rate: 0.0,
                acceleration: 0.0,
                ..forward.joint_motion(&state, &bodies, joint, dof)
            })
            .collect();
        let mut drives = |targets: &[Target<f64>]| -> Result<Vec<f64>, Error> {
            model.move_to(targets).map_err(Error::Controller)?;
            Ok(model.solve(&[]).map_err(Error::ControllerForces)?.efforts_frictionless.clone())
        };
        let still = drives(&targets)?;
        let mut masses = Vec::with_capacity(still.len());
        for k in 0..still.len() {
            targets[k].acceleration = 1.0;
            masses.push(drives(&targets)?[k] - still[k]);
            targets[k].acceleration = 0.0;
        }
        self.motors.add_inertia(&mut masses);
        Ok(masses)
    }

    /// Computes the efforts held from this sample on, N or N m.
    pub(super) fn sample(&mut self, told: &Told<'_>) -> Result<Vec<f64>, Error> {
        let control = self.control;
        let Told { time, actual, wanted, feed, friction, loads } = told;
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
        let errors: Vec<(f64, f64)> = wanted
            .iter()
            .zip(positions.iter().zip(&rates))
            .map(|(wanted, (position, rate))| (wanted.value - position, wanted.rate - rate))
            .collect();
        let corrections = errors.iter().zip(&self.gains).map(|((e, d), (p, q))| p * e + q * d);
        let mut efforts: Vec<f64> = match (control.control, &mut self.model) {
            (ControlType::ComputedTorque, Some(model)) => {
                let targets: Vec<Target<f64>> = corrections
                    .zip(wanted.iter().zip(positions.iter().zip(&rates)))
                    .map(|(correction, (wanted, (value, rate)))| Target {
                        value: *value,
                        rate: *rate,
                        acceleration: wanted.acceleration + correction,
                    })
                    .collect();
                let at = |error| Error::ControllerAt { time: *time, error: Box::new(error) };
                model.move_to(&targets).map_err(|error| at(Error::Controller(error)))?;
                let forces =
                    model.solve(loads).map_err(|error| at(Error::ControllerForces(error)))?;
                let mut efforts = forces.efforts.clone();
                let friction = control.friction == FrictionFeed::Measured;
                self.motors.add(&mut efforts, &targets, friction);
                efforts
            }
            _ => corrections.collect(),
        };
        for (index, effort) in efforts.iter_mut().enumerate() {
            let limit = control.channels[index].limit;
            let more =
                if control.friction == FrictionFeed::Reference { friction[index] } else { 0.0 };
            *effort = (*effort + feed[index] + more).clamp(-limit, limit);
        }
        self.before = Some(positions);
        Ok(efforts)
    }
}

/// Inverse dynamics of the mechanism at its current pose, prescribed by its actuators; without
/// friction unless the settings change.
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
