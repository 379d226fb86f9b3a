//! Parameters on which the efforts depend linearly, and their list for a mechanism.

use stiction_core::friction::Curve;
use stiction_core::mechanism::{Body, Mechanism};
use stiction_core::parameters::Parameters;
use stiction_core::spatial::{Mat3, Vec3};

/// Kind of a parameter. The indices are those of the bodies, drive trains, friction interfaces or
/// actuators of the mechanism; the index of [`Kind::Term`] is that of the effort term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Mass of a body, kg.
    Mass(usize),
    /// First moment of a body's mass about its origin, along an axis of its frame (body, axis), kg m.
    Moment(usize, usize),
    /// Entry of a body's inertia tensor about the body's origin, in the axes of the body, kg m^2;
    /// the second index refers to [`INERTIA_ENTRIES`].
    Inertia(usize, usize),
    /// Moment of inertia of a drive train's rotor, kg m^2.
    Rotor(usize),
    /// Friction coefficient of an interface: friction per normal load.
    Mu(usize),
    /// Excess of the static friction coefficient of an interface with Stribeck's curve over the
    /// sliding one, as a fraction of the latter: `mu_static/mu - 1`.
    StaticExcess(usize),
    /// Load-independent friction of an interface, as an effort of its joint, N or N m.
    Coulomb(usize),
    /// Viscous friction of an interface, as an effort of its joint per rate, N s/m or N m s/rad.
    Viscous(usize),
    /// Constant friction of an actuated degree of freedom that has no friction interface, N or N m.
    DriveCoulomb(usize),
    /// Viscous friction of an actuated degree of freedom that has no friction interface, N s/m or N m s/rad.
    DriveViscous(usize),
    /// Constant error of a measured effort, N or N m.
    Offset(usize),
    /// Dimensionless factor of an effort term, which is given by a formula.
    Term(usize),
    /// Torque constant of a drive train whose current is measured, N m/A.
    TorqueConstant(usize),
}

impl Kind {
    /// Returns whether the parameter describes friction: a friction coefficient, load-independent
    /// friction, viscous friction, or the excess of static friction.
    pub fn is_friction(self) -> bool {
        match self {
            Self::Mu(_)
            | Self::StaticExcess(_)
            | Self::Coulomb(_)
            | Self::Viscous(_)
            | Self::DriveCoulomb(_)
            | Self::DriveViscous(_) => true,
            Self::Mass(_)
            | Self::Moment(..)
            | Self::Inertia(..)
            | Self::Rotor(_)
            | Self::Offset(_)
            | Self::Term(_)
            | Self::TorqueConstant(_) => false,
        }
    }

    /// Returns the index of the interface whose friction the parameter describes; `None` for other
    /// parameters.
    pub fn interface(self) -> Option<usize> {
        match self {
            Self::Mu(i) | Self::StaticExcess(i) | Self::Coulomb(i) | Self::Viscous(i) => Some(i),
            _ => None,
        }
    }
}

/// Rows and columns of the six entries of an inertia: xx, yy, zz, xy, yz, xz.
pub const INERTIA_ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];

/// Parameter on which the efforts depend linearly. For a friction coefficient, the dependence is
/// linear only at given normal loads.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, such as `leg1.rod.mass` or `leg1.P.mu`.
    pub name: String,
    /// SI unit; empty for dimensionless parameters.
    pub unit: &'static str,
    /// Kind of the parameter, with indices of the mechanism.
    pub kind: Kind,
    /// Value in the model, SI units.
    pub prior: f64,
    /// Typical magnitude, which makes parameters of different units comparable.
    pub scale: f64,
}

impl Parameter {
    /// Returns whether negative values are unphysical.
    pub fn is_nonnegative(&self) -> bool {
        !matches!(self.kind, Kind::Moment(..) | Kind::Inertia(..) | Kind::Offset(_) | Kind::Term(_))
    }

    /// Returns the index of the body to which the parameter belongs, if it is a mass, a first
    /// moment or an inertia.
    pub fn body(&self) -> Option<usize> {
        match self.kind {
            Kind::Mass(b) | Kind::Moment(b, _) | Kind::Inertia(b, _) => Some(b),
            _ => None,
        }
    }
}

/// Selects the parameters that [`catalogue`] lists.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// True if efforts are measured at the motors, so that they contain rotors and motor friction.
    pub at_motors: bool,
    /// True to include a constant error of every measured effort.
    pub offsets: bool,
    /// Number of effort terms that are given by formulas.
    pub terms: usize,
    /// True to include inertias of bodies and rotors.
    pub inertia: bool,
    /// True to include friction.
    pub friction: bool,
    /// True to include the excess of static friction of interfaces with Stribeck's curve.
    pub static_excess: bool,
    /// Drive trains whose currents are measured and whose torque constants are unknown.
    pub torque_constants: Vec<usize>,
}

impl Choice {
    /// Selects inertia and friction, with efforts measured at the joints.
    pub const ALL: Self = Self {
        at_motors: false,
        offsets: false,
        terms: 0,
        inertia: true,
        friction: true,
        static_excess: false,
        torque_constants: Vec::new(),
    };
}

/// Computes the inertia tensor of a body about the body's origin, in the axes of the body, kg m^2.
pub(crate) fn inertia_about_origin(body: &Body) -> Mat3<f64> {
    let d = body.com;
    let outer = Mat3::from_columns(d * d.x, d * d.y, d * d.z);
    let square = d.dot(d);
    body.inertia + (Mat3::diagonal(Vec3::new(square, square, square)) + outer * -1.0) * body.mass
}

/// Lists the chosen parameters of a mechanism in a fixed order: bodies, rotors, interfaces,
/// actuators, terms, torque constants. Prior and scale of a torque constant are one, because its
/// value is unknown.
pub fn catalogue(mechanism: &Mechanism, choice: &Choice) -> Vec<Parameter> {
    let mut all = Vec::new();
    let length = mechanism.characteristic_length();
    if choice.inertia {
        bodies(mechanism, length, &mut all);
        if choice.at_motors {
            for (index, train) in mechanism.drive_trains().iter().enumerate() {
                if train.dofs.len() == 1 {
                    let prior = train.rotor_inertia;
                    let (name, unit) = (format!("{}.rotor_inertia", train.name), "kg m^2");
                    let scale = if prior > 0.0 { prior } else { 1e-4 };
                    all.push(Parameter { name, unit, kind: Kind::Rotor(index), prior, scale });
                }
            }
        }
    }
    if choice.friction {
        friction(mechanism, choice.static_excess, &mut all);
    }
    let joints = mechanism.joints();
    for (index, (id, dof)) in mechanism.actuators().enumerate() {
        let joint = &joints[id.0];
        let name = joint.actuator_name(dof);
        let linear = joint.joint_type.dofs()[dof].translates();
        if choice.friction && joint.friction.is_empty() {
            // Efforts at the joint do not contain the friction of the motor.
            let train = mechanism
                .drive_trains()
                .iter()
                .find(|train| choice.at_motors && train.only_dof() == Some((id, dof)));
            let motor = train.map(|train| (train.motor_friction, train.transmission()));
            let coulomb = motor.map_or(0.0, |(friction, n)| friction.constant * n.abs());
            let viscous = motor.map_or(0.0, |(friction, n)| friction.viscous * n * n);
            let unit = if linear { "N" } else { "N m" };
            let kind = Kind::DriveCoulomb(index);
            let label = format!("{name}.coulomb");
            all.push(Parameter { name: label, unit, kind, prior: coulomb, scale: scale(coulomb) });
            let unit = if linear { "N s/m" } else { "N m s/rad" };
            let kind = Kind::DriveViscous(index);
            let label = format!("{name}.viscous");
            all.push(Parameter { name: label, unit, kind, prior: viscous, scale: scale(viscous) });
        }
        if choice.offsets {
            let unit = if linear { "N" } else { "N m" };
            let kind = Kind::Offset(index);
            all.push(Parameter {
                name: format!("{name}.offset"),
                unit,
                kind,
                prior: 0.0,
                scale: 1.0,
            });
        }
    }
    for index in 0..choice.terms {
        let name = format!("term{}", index + 1);
        all.push(Parameter { name, unit: "", kind: Kind::Term(index), prior: 1.0, scale: 1.0 });
    }
    for &train in &choice.torque_constants {
        let name = format!("{}.torque_constant", mechanism.drive_trains()[train].name);
        let kind = Kind::TorqueConstant(train);
        all.push(Parameter { name, unit: "N m/A", kind, prior: 1.0, scale: 1.0 });
    }
    all
}

fn scale(prior: f64) -> f64 {
    if prior > 0.0 { prior } else { 1.0 }
}

fn bodies(mechanism: &Mechanism, length: f64, all: &mut Vec<Parameter>) {
    let total: f64 = mechanism.bodies().iter().map(|body| body.mass).sum();
    for (index, body) in mechanism.bodies().iter().enumerate().skip(1) {
        if body.mass <= 0.0 {
            // A massless body represents the carrier of a joint and has no parameters.
            continue;
        }
        let mass = body.mass.max(1e-3 * total);
        let mut push = |suffix: String, unit, kind, prior, scale| {
            all.push(Parameter {
                name: format!("{}.{suffix}", body.name),
                unit,
                kind,
                prior,
                scale,
            });
        };
        push("mass".into(), "kg", Kind::Mass(index), body.mass, mass);
        for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
            let prior = body.mass * body.com.component(axis);
            push(format!("m{letter}"), "kg m", Kind::Moment(index, axis), prior, mass * length);
        }
        let inertia = inertia_about_origin(body);
        for (entry, &(row, column)) in INERTIA_ENTRIES.iter().enumerate() {
            let letters = ["xx", "yy", "zz", "xy", "yz", "xz"];
            let kind = Kind::Inertia(index, entry);
            let prior = inertia.at(row, column);
            push(format!("i{}", letters[entry]), "kg m^2", kind, prior, mass * length * length);
        }
    }
}

fn friction(mechanism: &Mechanism, has_excess: bool, all: &mut Vec<Parameter>) {
    let parameters: Parameters<f64> = Parameters::new(mechanism);
    let names = mechanism.joints().iter().flat_map(|joint| joint.interface_names());
    for (index, (interface, name)) in parameters.interfaces.iter().zip(names).enumerate() {
        let joint = &mechanism.joints()[interface.joint];
        let linear = joint.joint_type.dofs()[interface.shape.dofs()][0].translates();
        let arm = interface.arms(joint.pitch)[0].abs();
        let law = &interface.law;
        let mut push = |suffix: &str, unit, kind, prior: f64| {
            let name = format!("{name}.{suffix}");
            all.push(Parameter { name, unit, kind, prior, scale: scale(prior) });
        };
        if law.mu > 0.0 {
            push("mu", "", Kind::Mu(index), law.mu);
            if let (true, Curve::Stribeck { mu_static, .. }, None, None) =
                (has_excess, &law.curve, &interface.backward, law.regularisation)
            {
                let excess = (mu_static / law.mu - 1.0).max(0.0);
                push("static_excess", "", Kind::StaticExcess(index), excess);
            }
        }
        let unit = if linear { "N" } else { "N m" };
        push("coulomb", unit, Kind::Coulomb(index), law.mu * interface.load.preload * arm);
        let unit = if linear { "N s/m" } else { "N m s/rad" };
        push("viscous", unit, Kind::Viscous(index), law.viscous * arm * arm);
    }
}
