//! Variables of a plant that is exported as a functional mock-up unit (FMU).

use super::Plant;
use super::tunable::{Coefficient, Tunable};
use crate::error::Error;
use stiction_core::friction::interfaces_of;
use stiction_core::mechanism::Mechanism;
use stiction_program::emit::fmu::{Causality, Start, Variability, Variable, make_unique};

/// Component of the pose or velocity of a body along world axes; the field of each variant is the
/// index of the component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Position of the origin, m.
    Position(usize),
    /// Orientation as a quaternion, real part first.
    Orientation(usize),
    /// Velocity of the origin, m/s.
    Velocity(usize),
    /// Angular velocity, rad/s.
    AngularVelocity(usize),
}

/// Quantity that a variable of a plant represents. Indices are those of the model's actuators,
/// joint coordinates, bodies and friction interfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Time,
    Effort(usize),
    /// Input force or moment on a body: the index of the body, and the component of the force (0 to
    /// 2) or of the moment (3 to 5).
    Force(usize, usize),
    StartPosition(usize),
    StartRate(usize),
    Parameter(usize),
    Position(usize),
    Rate(usize),
    Acceleration(usize),
    Body(usize, Part),
    /// 1 while the interface sticks, else 0.
    Sticks(usize),
    /// Friction force, N, with a sign if the interface slides along a single direction, else its
    /// magnitude.
    Friction(usize),
    SlidingSpeed(usize),
    NormalLoad(usize),
    /// Number of stick onsets, slip onsets and velocity jumps since the start.
    Events,
    /// Time of the latest stick onset, slip onset or velocity jump, s; the start time before the
    /// first of these events.
    EventTime,
    Kinetic,
    Potential,
    Dissipated,
    EnergyError,
}

/// Variables of a plant and the quantities that they represent, in the order of their value
/// references.
#[derive(Debug, Default)]
pub(super) struct Table {
    pub(super) variables: Vec<Variable>,
    pub(super) quantities: Vec<Quantity>,
    /// For each friction interface, true if it slides along a single direction.
    pub(super) signed: Vec<bool>,
}

impl Table {
    /// Lists the variables of a plant with force inputs on the bodies `forced`.
    pub(super) fn new(plant: &Plant, forced: &[usize]) -> Self {
        let job = plant.setup.plan.job();
        let (names, mechanism) = (plant.setup.plan.names(), &job.model.mechanism);
        let mut table = Self { signed: signed(mechanism), ..Self::default() };
        table.add(Quantity::Time, Variable::time());
        let units = mechanism
            .actuators()
            .map(|(id, dof)| mechanism.joints()[id.0].joint_type.dofs()[dof].units());
        let units: Vec<[&str; 2]> = units
            .map(|(length, effort)| [length, if effort == "N" { "N" } else { "N.m" }])
            .collect();
        for (k, (name, _)) in names.actuators.iter().enumerate() {
            let about = "Effort of the actuator, held between communication points";
            let variable =
                Variable::real(&format!("{name}.effort"), Causality::Input, units[k][1], about);
            table.add(Quantity::Effort(k), started(variable, 0.0));
        }
        for &body in forced {
            for (k, axis) in ["fx", "fy", "fz", "mx", "my", "mz"].into_iter().enumerate() {
                let (what, unit) = if k < 3 { ("Force", "N") } else { ("Moment", "N.m") };
                let about = format!("{what} on the body at its origin, along a world axis");
                let name = format!("{}.{axis}", names.bodies[body]);
                let variable = Variable::real(&name, Causality::Input, unit, &about);
                table.add(Quantity::Force(body, k), started(variable, 0.0));
            }
        }
        for (k, (name, _)) in names.actuators.iter().enumerate() {
            let start = plant.setup.initial[k];
            let mut parameter = |ending: &str, quantity, unit: &str, about: &str, value| {
                let name = format!("start.{name}.{ending}");
                let mut own = Variable::real(&name, Causality::Parameter, unit, about);
                own.variability = Variability::Fixed;
                table.add(quantity, started(own, value));
            };
            let unit = units[k][0];
            let about = "Position of the actuator at the start";
            parameter("position", Quantity::StartPosition(k), unit, about, start.value);
            let about = "Rate of the actuator at the start";
            parameter("speed", Quantity::StartRate(k), &format!("{unit}/s"), about, start.rate);
        }
        for (k, (tunable, name, value)) in plant.setup.tunables.iter().enumerate() {
            let (unit, about) = match tunable {
                Tunable::Friction(_, _, Coefficient::Mu) => {
                    ("1", "Coefficient of sliding friction")
                }
                Tunable::Friction(_, _, Coefficient::MuStatic) => {
                    ("1", "Coefficient of static friction")
                }
                Tunable::Friction(_, _, Coefficient::Viscous) => {
                    ("N.s/m", "Viscous coefficient at the sliding surface")
                }
                Tunable::Mass(_) => {
                    ("kg", "Mass of the body; its moments of inertia do not change")
                }
            };
            let mut own = started(Variable::real(name, Causality::Parameter, unit, about), *value);
            let is_mass = matches!(tunable, Tunable::Mass(_));
            own.range.0 = Some(if is_mass { f64::MIN_POSITIVE } else { 0.0 });
            table.add(Quantity::Parameter(k), own);
        }
        for (k, (name, joint, dof)) in names.coordinates.iter().enumerate() {
            let translates = mechanism.joints()[joint.0].joint_type.dofs()[*dof].translates();
            let unit = if translates { "m" } else { "rad" };
            let mut add = |ending: &str, quantity, causality, per: &str, about: &str| {
                let (name, unit) = (format!("{name}.{ending}"), format!("{unit}{per}"));
                table.add(quantity, Variable::real(&name, causality, &unit, about));
            };
            let about = "Position of the joint; angles count full turns";
            add("position", Quantity::Position(k), Causality::Output, "", about);
            add("speed", Quantity::Rate(k), Causality::Output, "/s", "Rate of the joint");
            let about =
                "Acceleration of the joint, computed with the efforts that act up to this instant";
            add("acceleration", Quantity::Acceleration(k), Causality::Local, "/s2", about);
        }
        for (body, name) in names.bodies.iter().enumerate().skip(1) {
            table.add_body(body, name);
        }
        let shafts = mechanism.shafts_with_friction();
        for (k, name) in names.with_shafts.iter().enumerate() {
            let about = "1 while the friction interface sticks, 0 while it slips";
            let sticks = Variable::integer(&format!("{name}.sticks"), Causality::Output, about);
            table.add(Quantity::Sticks(k), sticks);
            let mut add = |ending: &str, quantity, causality, unit: &str, about: &str| {
                let name = format!("{name}.{ending}");
                table.add(quantity, Variable::real(&name, causality, unit, about));
            };
            // The friction interfaces of motors come after those of the joints.
            let shaft = k.checked_sub(names.interfaces.len()).and_then(|k| shafts.get(k));
            let rotates = shaft.is_some_and(|shaft| shaft.rotates);
            let [force, speed] = if rotates { ["N.m", "rad/s"] } else { ["N", "m/s"] };
            let about = "Friction force at the sliding surface";
            add("friction", Quantity::Friction(k), Causality::Output, force, about);
            let about = "Sliding speed at the surface";
            add("sliding_speed", Quantity::SlidingSpeed(k), Causality::Local, speed, about);
            let about = "Normal load of the friction interface";
            add("normal_load", Quantity::NormalLoad(k), Causality::Local, force, about);
        }
        let about = "Number of stick onsets, slip onsets and jumps of velocities since the start";
        table.add(Quantity::Events, Variable::integer("events.count", Causality::Output, about));
        let about =
            "Time of the last event counted in events.count; before the first one, the start time";
        let mut last = Variable::real("events.time", Causality::Output, "s", about);
        last.variability = Variability::Discrete;
        table.add(Quantity::EventTime, last);
        for (name, quantity, about) in [
            ("kinetic", Quantity::Kinetic, "Kinetic energy"),
            ("potential", Quantity::Potential, "Potential energy of gravity and springs"),
            ("dissipated", Quantity::Dissipated, "Energy dissipated by friction since the start"),
            ("error", Quantity::EnergyError, "Residual of the energy balance since the start"),
        ] {
            let name = format!("energy.{name}");
            table.add(quantity, Variable::real(&name, Causality::Local, "J", about));
        }
        make_unique(&mut table.variables);
        table
    }

    fn add(&mut self, quantity: Quantity, variable: Variable) {
        self.variables.push(variable);
        self.quantities.push(quantity);
    }

    fn add_body(&mut self, body: usize, name: &str) {
        let mut add = |endings: &[&str], part: fn(usize) -> Part, unit: &str, about: &str| {
            for (k, ending) in endings.iter().enumerate() {
                let name = format!("{name}.{ending}");
                let variable = Variable::real(&name, Causality::Output, unit, about);
                self.add(Quantity::Body(body, part(k)), variable);
            }
        };
        let about = "Position of the body's origin in the world";
        add(&["x", "y", "z"], Part::Position, "m", about);
        let about =
            "Orientation of the body in the world: unit quaternion with a non-negative real part";
        add(&["qw", "qx", "qy", "qz"], Part::Orientation, "1", about);
        let about = "Velocity of the body's origin, along a world axis";
        add(&["vx", "vy", "vz"], Part::Velocity, "m/s", about);
        let about = "Angular velocity of the body, along a world axis";
        add(&["wx", "wy", "wz"], Part::AngularVelocity, "rad/s", about);
    }

    /// Returns the quantity of the variable with the given value reference.
    ///
    /// # Errors
    /// There is no such variable.
    pub(super) fn quantity(&self, reference: u32) -> Result<Quantity, Error> {
        let found = usize::try_from(reference).ok().and_then(|k| self.quantities.get(k));
        found.copied().ok_or_else(|| {
            let last = self.quantities.len().saturating_sub(1);
            Error::input(format!("there is no variable with the value reference {reference}"))
                .with_help(format!("value references are 0 to {last}, see modelDescription.xml"))
        })
    }
}

fn started(mut variable: Variable, value: f64) -> Variable {
    variable.start = Some(Start::Real(value));
    variable
}

/// For each friction interface, including those of motors: true if it slides along a single
/// direction.
fn signed(mechanism: &Mechanism) -> Vec<bool> {
    let of_joints = mechanism.joints().iter().flat_map(|joint| {
        let interfaces = interfaces_of(joint.joint_type);
        joint.friction.iter().map(|friction| interfaces[friction.place].1.has_one_dof())
    });
    of_joints.chain(mechanism.shafts_with_friction().iter().map(|_| true)).collect()
}
