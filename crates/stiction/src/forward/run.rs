//! Results of a simulation with access by name.

use crate::error::Error;
use crate::inverse::{BodyPose, Reaction};
use crate::names::Names;
use std::sync::Arc;
use stiction_core::forward::{EventKind, InterfaceMode};
use stiction_run::SpacePoint;
use stiction_run::forward::{Ending, Outcome};

/// Motion of a joint coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMotion {
    /// Position, m or rad; angles count full turns.
    pub position: f64,
    /// Rate, m/s or rad/s.
    pub rate: f64,
    /// Acceleration, m/s² or rad/s².
    pub acceleration: f64,
}

/// Friction in one friction interface of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Sliding velocity in each direction of the interface, m/s.
    pub velocity: [f64; 3],
    /// Friction force in each direction of the interface, N.
    pub force: [f64; 3],
    /// Normal load, N.
    pub load: f64,
    /// Static friction limit, N.
    pub limit: f64,
    /// Dissipated power, W.
    pub power: f64,
    /// `true` while the interface sticks.
    pub sticks: bool,
}

/// Velocity of a body in the world, along world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyVelocity {
    /// Velocity of the body's origin, m/s.
    pub linear: [f64; 3],
    /// Angular velocity, rad/s.
    pub angular: [f64; 3],
}

/// State and forces at one instant, by name, in SI units and along world axes.
#[derive(Clone, Debug)]
pub struct Sample {
    names: Arc<Names>,
    /// Time, s.
    pub time: f64,
    joints: Vec<JointMotion>,
    efforts: Vec<f64>,
    reactions: Vec<Reaction>,
    gearings: Vec<f64>,
    interfaces: Vec<Interface>,
    poses: Vec<BodyPose>,
    velocities: Vec<BodyVelocity>,
    pub(crate) space: Vec<SpacePoint>,
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Potential energy of gravity and springs, J. The potential energy of gravity is zero at the
    /// height of the solver's reference point, the mean of the ground's joint origins.
    pub potential_energy: f64,
    works: Vec<f64>,
    /// Work of all loads since the start, J.
    pub load_work: f64,
    dissipated: Vec<f64>,
    /// Energy dissipated by dampers of springs since the start, J.
    pub damper_dissipation: f64,
    /// Error of the energy balance since the start, J, caused by numerical integration and
    /// rounding.
    pub energy_error: f64,
    /// Largest loop-closure error, m; angles are multiplied by the characteristic length.
    pub closure_error: f64,
}

impl Sample {
    pub(crate) fn new(names: Arc<Names>, sample: &stiction_run::forward::Sample<'_>) -> Self {
        let now = sample.instant;
        let determined = now.redundant == 0;
        let joints = sample.joints.iter().map(|motion| JointMotion {
            position: motion.value,
            rate: motion.rate,
            acceleration: motion.acceleration,
        });
        let reactions = now.reactions().into_iter().map(|(force, moment)| Reaction {
            force: force.to_array(),
            moment: moment.to_array(),
            determined,
        });
        let interfaces = now.interfaces.iter().zip(&now.account.interfaces);
        let interfaces = interfaces.map(|(state, power)| Interface {
            velocity: state.velocity,
            force: state.friction,
            load: state.load,
            limit: state.limit,
            power: *power,
            sticks: matches!(state.interface, InterfaceMode::Sticks | InterfaceMode::AtLimit(_)),
        });
        let origin = sample.forward.parameters().origin;
        // A simulation may append motor shafts to the bodies of the mechanism; they are left out
        // here.
        let bodies = sample.forward.mechanism().bodies().len();
        let poses = now.bodies.pose.iter().take(bodies).map(|pose| BodyPose::new(*pose, origin));
        let twists = now.bodies.pose.iter().zip(&now.bodies.twist).take(bodies);
        let velocities = twists.map(|(pose, twist)| BodyVelocity {
            linear: twist.velocity_at(pose.position).to_array(),
            angular: twist.angular.to_array(),
        });
        Self {
            time: now.time,
            joints: joints.collect(),
            efforts: now.drives.clone(),
            reactions: reactions.collect(),
            gearings: now.gearings.clone(),
            interfaces: interfaces.collect(),
            poses: poses.collect(),
            velocities: velocities.collect(),
            space: sample.in_space().collect(),
            kinetic_energy: now.account.kinetic,
            potential_energy: now.account.potential,
            works: sample.energies.drives.clone(),
            load_work: sample.energies.loads,
            dissipated: sample.energies.interfaces.clone(),
            damper_dissipation: sample.energies.dampers,
            energy_error: sample.energy_error,
            closure_error: sample.closure,
            names,
        }
    }

    /// Motion of a joint coordinate: the name of a joint, followed by that of the degree of freedom if the joint has
    /// several.
    ///
    /// # Errors
    /// No joint coordinate has that name.
    pub fn joint(&self, coordinate: &str) -> Result<JointMotion, Error> {
        Ok(self.joints[self.names.coordinate(coordinate)?])
    }

    /// Position of a joint coordinate, m or rad.
    ///
    /// # Errors
    /// No joint coordinate has that name.
    pub fn position(&self, coordinate: &str) -> Result<f64, Error> {
        Ok(self.joint(coordinate)?.position)
    }

    /// Rate of a joint coordinate, m/s or rad/s.
    ///
    /// # Errors
    /// No joint coordinate has that name.
    pub fn rate(&self, coordinate: &str) -> Result<f64, Error> {
        Ok(self.joint(coordinate)?.rate)
    }

    /// Force (N) or torque (N m) of an actuator.
    ///
    /// # Errors
    /// No actuator has that name.
    pub fn effort(&self, actuator: &str) -> Result<f64, Error> {
        Ok(self.efforts[self.names.actuator(actuator)?])
    }

    /// Work of an actuator since the start, J.
    ///
    /// # Errors
    /// No actuator has that name.
    pub fn work(&self, actuator: &str) -> Result<f64, Error> {
        Ok(self.works[self.names.actuator(actuator)?])
    }

    /// Effort of a rigid gearing, N m, or N if its equation is a sum of lengths. The gearing exerts, on each of its
    /// joints, this effort times the coefficient of the joint.
    ///
    /// # Errors
    /// No gearing has that name.
    pub fn gearing_effort(&self, gearing: &str) -> Result<f64, Error> {
        Ok(self.gearings[self.names.gearing(gearing)?])
    }

    /// Force and moment that the predecessor of a joint exerts on the successor.
    ///
    /// # Errors
    /// No joint has that name.
    pub fn reaction(&self, joint: &str) -> Result<Reaction, Error> {
        Ok(self.reactions[self.names.joint(joint)?])
    }

    /// Friction in a friction interface.
    ///
    /// # Errors
    /// No friction interface has that name.
    pub fn friction(&self, interface: &str) -> Result<Interface, Error> {
        Ok(self.interfaces[self.names.interface_or_shaft(interface)?])
    }

    /// Energy dissipated in a friction interface since the start, J.
    ///
    /// # Errors
    /// No friction interface has that name.
    pub fn dissipated(&self, interface: &str) -> Result<f64, Error> {
        Ok(self.dissipated[self.names.interface_or_shaft(interface)?])
    }

    /// Pose of a body in the world.
    ///
    /// # Errors
    /// No body has that name.
    pub fn pose(&self, body: &str) -> Result<BodyPose, Error> {
        Ok(self.poses[self.names.body(body)?])
    }

    /// Velocity of a body in the world.
    ///
    /// # Errors
    /// No body has that name.
    pub fn velocity(&self, body: &str) -> Result<BodyVelocity, Error> {
        Ok(self.velocities[self.names.body(body)?])
    }

    /// Energy dissipated by all friction interfaces since the start, J.
    pub fn friction_dissipation(&self) -> f64 {
        self.dissipated.iter().sum()
    }

    /// Motions of all scalar joint coordinates, in the order of the model.
    pub(crate) fn all_joints(&self) -> &[JointMotion] {
        &self.joints
    }

    /// Friction of all interfaces; those of motors are last.
    pub(crate) fn all_interfaces(&self) -> &[Interface] {
        &self.interfaces
    }

    /// Poses and velocities of all bodies; the first body is the ground.
    pub(crate) fn all_bodies(&self) -> (&[BodyPose], &[BodyVelocity]) {
        (&self.poses, &self.velocities)
    }

    /// Sum of kinetic and potential energy, J.
    pub fn mechanical_energy(&self) -> f64 {
        self.kinetic_energy + self.potential_energy
    }
}

/// Event of a simulation, for example that a friction interface begins to stick or slip, that the
/// integration scheme changes, or that the robot passes a singular position.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// Name of the friction interface or joint; empty if the event concerns the whole mechanism.
    pub at: String,
    /// Kind of event, with its numbers.
    pub kind: EventKind,
}

/// Converts events of the solver: replaces the indices of friction interfaces and joints by names.
pub(crate) fn named(names: &Names, events: &[stiction_core::forward::Event]) -> Vec<Event> {
    let name = |event: &stiction_core::forward::Event| match &event.kind {
        EventKind::Sticks { interface, .. } | EventKind::Slides { interface, .. } => {
            names.with_shafts.get(*interface).cloned()
        }
        EventKind::NotUnique { joint, .. } | EventKind::Jump { joint, .. } => {
            names.joints.get(joint.0).cloned()
        }
        _ => None,
    };
    let each = events.iter().map(|event| Event {
        time: event.time,
        at: name(event).unwrap_or_default(),
        kind: event.kind.clone(),
    });
    each.collect()
}

/// Results of a simulation: all samples and events, and the reason if it ended early.
#[derive(Debug)]
pub struct Run {
    samples: Vec<Sample>,
    events: Vec<Event>,
    ended: Result<(), Error>,
}

impl Run {
    pub(super) fn new(samples: Vec<Sample>, outcome: Outcome, names: &Names) -> Self {
        let events = named(names, &outcome.events);
        let ended = match outcome.ending {
            Ending::Failed(error) => Err((*error).into()),
            _ => Ok(()),
        };
        Self { samples, events, ended }
    }

    /// All samples, in the order of time.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// The last sample.
    ///
    /// # Errors
    /// The simulation has no sample; the error states the reason.
    pub fn last(&self) -> Result<&Sample, Error> {
        self.samples.last().ok_or_else(|| match &self.ended {
            Err(error) => Error::no_answer(error.message()),
            Ok(()) => Error::no_answer("the simulation has no sample"),
        })
    }

    /// All events, in the order of time.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Outcome of the simulation: `Ok` if it reached its end time or a stop condition, else the reason why it did
    /// not.
    pub fn ended(&self) -> Result<(), &Error> {
        self.ended.as_ref().copied()
    }
}
