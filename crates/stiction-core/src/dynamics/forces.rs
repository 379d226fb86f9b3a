//! Results of inverse dynamics at one instant.

use super::dense_fallback::DenseForces;
use super::interfaces::InterfaceState;
use super::inverse::Inverse;
use super::model::Model;
use super::power::Power;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::{Vec3, Wrench};

/// Largest accepted relative power residual of the computed forces. Round-off is about 1e-15, but
/// grows near singular configurations.
pub(super) const BALANCED: f64 = 1e-9;

/// Forces at one friction interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceForce {
    /// Sliding velocity at the surface, m/s. For a ball or plate, the magnitude of the sliding
    /// velocity.
    pub velocity: f64,
    /// True if the interface slides.
    pub slides: bool,
    /// Normal force at the friction surface, N.
    pub load: f64,
    /// Friction force with the sign of the sliding velocity, N. Zero at rest, where static friction
    /// is not a single force but a set of forces.
    pub friction: f64,
    /// Largest friction force for this normal force and speed, N.
    pub limit: f64,
    /// Dissipated power, W.
    pub power: f64,
}

/// Reliability of the effort intervals under static friction, see [`Forces::effort_bounds`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounds {
    /// The effort intervals are exact: both ends are attained, and no admissible effort lies
    /// outside.
    Exact,
    /// The outer bounds are guaranteed, but may not be attained.
    Certified,
    /// Both ends of each effort interval are attained. No outer bounds exist, because friction and
    /// reactions are coupled too strongly.
    Attained,
    /// No effort intervals were computed.
    Unknown,
}

/// All forces at one instant.
#[derive(Debug, PartialEq)]
pub struct Forces {
    /// Effort of each actuator, N or N m, in the order of
    /// [`Mechanism::actuators`](crate::mechanism::Mechanism::actuators).
    pub efforts: Vec<f64>,
    /// Effort of each actuator without friction, N or N m, in the order of `efforts`.
    pub efforts_frictionless: Vec<f64>,
    /// Smallest and largest effort of each actuator, N or N m, over all admissible static friction
    /// forces of the interfaces at rest. Both equal the effort if all interfaces slide.
    pub effort_bounds: Vec<(f64, f64)>,
    /// Guaranteed outer bounds of `effort_bounds`; infinite if `bounds` is [`Bounds::Attained`].
    pub effort_outer_bounds: Vec<(f64, f64)>,
    /// Reliability of `effort_bounds`.
    pub bounds: Bounds,
    /// Reaction of each joint: the force that the predecessor exerts on the successor, N, and the
    /// moment about the origin of the joint, N m, in world axes. The reaction includes constraint,
    /// actuator and friction forces.
    pub reactions: Vec<(Vec3<f64>, Vec3<f64>)>,
    /// Effort of each gearing, N m; N if the gearing sums lengths. The order is that of
    /// [`Mechanism::gearings`](crate::mechanism::Mechanism::gearings). On each of its degrees of
    /// freedom, a gearing exerts its effort times the coefficient of this degree of freedom.
    pub gearings: Vec<f64>,
    /// Forces at the friction interfaces, in the order of
    /// [`Parameters::interfaces`](crate::parameters::Parameters::interfaces).
    pub interfaces: Vec<InterfaceForce>,
    /// Power balance of these forces.
    pub power: Power,
}

impl Clone for Forces {
    fn clone(&self) -> Self {
        let mut copy = Self::new([0; 3], 0);
        copy.clone_from(self);
        copy
    }

    /// Copies `other` into the existing buffers, so that results of many samples do not allocate.
    fn clone_from(&mut self, other: &Self) {
        let Self {
            efforts,
            efforts_frictionless,
            effort_bounds,
            effort_outer_bounds,
            bounds,
            reactions,
            gearings,
            interfaces,
            power,
        } = other;
        self.efforts.clone_from(efforts);
        self.efforts_frictionless.clone_from(efforts_frictionless);
        self.effort_bounds.clone_from(effort_bounds);
        self.effort_outer_bounds.clone_from(effort_outer_bounds);
        self.bounds = *bounds;
        self.reactions.clone_from(reactions);
        self.gearings.clone_from(gearings);
        self.interfaces.clone_from(interfaces);
        self.power = *power;
    }
}

impl InterfaceForce {
    /// Forces at an interface, all zero.
    const NONE: Self =
        Self { velocity: 0.0, slides: false, load: 0.0, friction: 0.0, limit: 0.0, power: 0.0 };

    fn of(state: &InterfaceState<f64>, has_friction: bool) -> Self {
        let slides = state.sliding > 0.0;
        let limit = if has_friction { state.friction() } else { 0.0 };
        let friction = if slides { limit.copysign(state.velocity) } else { 0.0 };
        Self {
            velocity: state.velocity,
            slides,
            load: state.load(),
            friction,
            limit,
            power: friction * state.velocity,
        }
    }
}

impl Forces {
    /// Creates the forces of a mechanism, all zero.
    pub(super) fn new([actuators, joints, gearings]: [usize; 3], interfaces: usize) -> Self {
        Self {
            efforts: vec![0.0; actuators],
            efforts_frictionless: vec![0.0; actuators],
            effort_bounds: vec![(0.0, 0.0); actuators],
            effort_outer_bounds: vec![(0.0, 0.0); actuators],
            bounds: Bounds::Exact,
            reactions: vec![(Vec3::zero(), Vec3::zero()); joints],
            gearings: vec![0.0; gearings],
            interfaces: vec![InterfaceForce::NONE; interfaces],
            power: Power::NONE,
        }
    }

    /// Copies the results of the sparse computation, except the power balance.
    pub(super) fn read(
        &mut self,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        inverse: &Inverse<f64>,
    ) {
        let gearings = inverse.gearing_efforts(model, parameters);
        self.gearings.iter_mut().zip(gearings).for_each(|(to, from)| *to = from);
        self.efforts.copy_from_slice(inverse.efforts());
        self.efforts_frictionless.copy_from_slice(inverse.efforts_frictionless());
        self.read_joints(bodies, inverse.joint_wrenches());
        self.read_interfaces(inverse.interfaces(), inverse.has_friction());
    }

    /// Copies the results of the dense fallback, except the power balance.
    pub(super) fn take(&mut self, bodies: &Bodies<f64>, solution: &DenseForces, friction: bool) {
        self.efforts.copy_from_slice(&solution.efforts);
        self.efforts_frictionless.copy_from_slice(&solution.efforts_frictionless);
        self.gearings.copy_from_slice(&solution.gearings);
        self.close_bounds();
        self.read_joints(bodies, &solution.wrenches);
        self.read_interfaces(&solution.interfaces.states, friction);
        if self.interfaces.iter().any(|interface| !interface.slides && interface.limit != 0.0) {
            self.bounds = Bounds::Unknown;
            self.effort_outer_bounds.fill((f64::NEG_INFINITY, f64::INFINITY));
        }
    }

    /// Returns the relative power residual: the residual divided by [`Power::turnover`] plus a
    /// small power that exceeds round-off at rest. The result is infinite if a force is not finite.
    /// `length` is the characteristic length, m.
    pub fn imbalance(&self, length: f64) -> f64 {
        let numbers = self.efforts.iter().chain(&self.efforts_frictionless).copied();
        let reactions = self.reactions.iter().map(|(force, moment)| {
            force.norm_squared().sqrt() + moment.norm_squared().sqrt() / length
        });
        let (mut largest, mut finite) = (0.0_f64, self.power.turnover.is_finite());
        for reaction in reactions.clone() {
            largest = largest.max(reaction);
        }
        for number in numbers.chain(reactions).chain(self.interfaces.iter().map(|c| c.limit)) {
            finite &= number.is_finite();
        }
        if !finite {
            return f64::INFINITY;
        }
        // At rest, rates and powers are round-off. The scale therefore includes the power of the
        // largest reaction at 1e-5 rad/s.
        let at_rest = 1e-5 * largest * length;
        self.power.residual().abs() / (self.power.turnover + at_rest).max(f64::MIN_POSITIVE)
    }

    /// Sets both ends of each effort interval to the effort, for a motion in which all interfaces
    /// slide.
    pub(super) fn close_bounds(&mut self) {
        for (bounds, &drive) in self.effort_bounds.iter_mut().zip(&self.efforts) {
            *bounds = (drive, drive);
        }
        self.effort_outer_bounds.copy_from_slice(&self.effort_bounds);
        self.bounds = Bounds::Exact;
    }

    /// Sets the outer bounds of the efforts. `changes` contains bounds of the change of each effort
    /// due to static friction; `None` if no outer bounds exist.
    pub(super) fn certify_bounds(&mut self, changes: Option<Vec<(f64, f64)>>) {
        let finite =
            self.effort_bounds.iter().all(|(low, high)| low.is_finite() && high.is_finite());
        let Some(changes) = changes.filter(|_| finite) else {
            self.bounds = Bounds::Attained;
            self.effort_outer_bounds.fill((f64::NEG_INFINITY, f64::INFINITY));
            return;
        };
        let mut exact = true;
        for (k, (down, up)) in changes.into_iter().enumerate() {
            let (low, high) = self.effort_bounds[k];
            let outer = (low.min(self.efforts[k] + down), high.max(self.efforts[k] + up));
            let same = 1e-9 * (low.abs() + high.abs());
            exact &= low - outer.0 <= same && outer.1 - high <= same;
            self.effort_outer_bounds[k] = outer;
        }
        self.bounds = if exact { Bounds::Exact } else { Bounds::Certified };
        if exact {
            self.effort_outer_bounds.copy_from_slice(&self.effort_bounds);
        }
    }

    fn read_joints(&mut self, bodies: &Bodies<f64>, wrenches: &[Wrench<f64>]) {
        let pairs = wrenches.iter().zip(&bodies.frame_j);
        for (reaction, (wrench, frame)) in self.reactions.iter_mut().zip(pairs) {
            *reaction = (wrench.force, wrench.moment_about(frame.position));
        }
    }

    fn read_interfaces(&mut self, states: &[InterfaceState<f64>], has_friction: bool) {
        for (force, state) in self.interfaces.iter_mut().zip(states) {
            *force = InterfaceForce::of(state, has_friction);
        }
    }
}
