//! Defects that the builder finds in the description of a mechanism.

use super::RangeOf;
use core::fmt;
use core::ops::Deref;
use thiserror::Error;

/// All defects of a mechanism description, in the order of their detection. The list contains at
/// least one defect.
///
/// Dereferences to a slice of [`Defect`]s. The error text has one line for each defect.
#[derive(Clone, Debug, PartialEq)]
pub struct Defects(Vec<Defect>);

impl Defects {
    /// Wraps a list of defects; returns `None` for an empty list.
    pub(super) fn new(defects: Vec<Defect>) -> Option<Self> {
        (!defects.is_empty()).then_some(Self(defects))
    }
}

impl Deref for Defects {
    type Target = [Defect];

    fn deref(&self) -> &[Defect] {
        &self.0
    }
}

impl IntoIterator for Defects {
    type Item = Defect;
    type IntoIter = std::vec::IntoIter<Defect>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a Defects {
    type Item = &'a Defect;
    type IntoIter = core::slice::Iter<'a, Defect>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl fmt::Display for Defects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, defect) in self.0.iter().enumerate() {
            write!(f, "{}{defect}", if k == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl core::error::Error for Defects {}

/// One defect of a mechanism description. [`super::MechanismBuilder::build`] reports all defects
/// together.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Defect {
    /// The mechanism has no body besides the ground.
    #[error("the mechanism has no moving body")]
    NoBodies,
    /// Two bodies, joints, springs, actuators or gearings have the same name.
    #[error("there are two {what} named `{name}`")]
    DuplicateName {
        /// Plural name of the kind of part: `bodies`, `joints`, `springs`, `actuators` or
        /// `gearings`.
        what: &'static str,
        /// The duplicate name.
        name: String,
    },
    /// A joint has the name of another joint's degree of freedom.
    #[error(
        "joint `{joint}` has the name of a degree of freedom of joint `{other}`: rename it, \
         because their columns in results would coincide"
    )]
    NameOfFreedom {
        /// Name of the joint.
        joint: String,
        /// Name of the joint to which the degree of freedom belongs.
        other: String,
    },
    /// The name of a joint is a reserved column name of the results.
    #[error("a joint cannot be named `{name}`: results have columns of that name")]
    NameTaken {
        /// The reserved name.
        name: String,
    },
    /// A body has the name of the ground.
    #[error("a body cannot be named `{}`: this is the name of the fixed body", super::GROUND_NAME)]
    GroundTaken,
    /// A joint refers to a body that does not exist.
    #[error("joint `{joint}` connects body `{body}`, which does not exist")]
    UnknownBody {
        /// Name of the joint.
        joint: String,
        /// Name of the missing body.
        body: String,
    },
    /// Both sides of a joint are the same body.
    #[error("joint `{joint}` connects body `{body}` with itself")]
    SameBody {
        /// Name of the joint.
        joint: String,
        /// Name of the body.
        body: String,
    },
    /// A body is not connected with the ground by any chain of joints.
    #[error(
        "body `{body}` is not connected with the ground by any chain of joints (a `free` joint \
         connects a body that floats)"
    )]
    Disconnected {
        /// Name of the body.
        body: String,
    },
    /// A value is NaN or infinite.
    #[error("{place} is not a finite number")]
    NotFinite {
        /// Description of the value and of the part to which it belongs.
        place: String,
    },
    /// The mass of a body is negative.
    #[error("body `{body}` has a mass of {mass} kg, but a mass must be at least 0")]
    NegativeMass {
        /// Name of the body.
        body: String,
        /// Mass, kg.
        mass: f64,
    },
    /// The inertia tensor of a body is not symmetric.
    #[error("the inertia of body `{body}` is not symmetric")]
    AsymmetricInertia {
        /// Name of the body.
        body: String,
    },
    /// The inertia tensor of a body has a negative principal moment.
    #[error("the inertia of body `{body}` has the negative principal moment {moment} kg m^2")]
    NegativeInertia {
        /// Name of the body.
        body: String,
        /// The smallest principal moment, kg m^2.
        moment: f64,
    },
    /// A helical joint has no pitch, or a joint of another type has one.
    #[error("joint `{joint}`: a helical joint needs a pitch other than 0, other joints have none")]
    Pitch {
        /// Name of the joint.
        joint: String,
    },
    /// A degree of freedom does not exist or cannot be actuated.
    #[error("joint `{joint}` has no degree of freedom {dof} that an actuator could drive")]
    NotActuable {
        /// Name of the joint.
        joint: String,
        /// Index of the degree of freedom.
        dof: usize,
    },
    /// The list of start coordinates has the wrong length.
    #[error("joint `{joint}` has {found} start coordinates, but needs {expected}")]
    StartLength {
        /// Name of the joint.
        joint: String,
        /// Number of start coordinates in the description.
        found: usize,
        /// Number of coordinates of the joint.
        expected: usize,
    },
    /// Friction is declared at an interface that joints of this type do not have.
    #[error("joint `{joint}`: friction of {joint_type} joints is not modelled")]
    NoContact {
        /// Name of the joint.
        joint: String,
        /// Symbol of the joint type.
        joint_type: &'static str,
    },
    /// Friction is declared twice for the same interface.
    #[error("joint `{joint}` declares friction twice at one interface")]
    DuplicateContact {
        /// Name of the joint.
        joint: String,
    },
    /// A friction parameter is out of its admissible range.
    #[error(
        "joint `{joint}`: the friction's {parameter} is {value}{}, but must be {range}",
        unit(parameter)
    )]
    FrictionParameter {
        /// Name of the joint.
        joint: String,
        /// Name of the parameter.
        parameter: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Description of the admissible range.
        range: &'static str,
    },
    /// Friction parameters do not fit the interface or contradict each other.
    #[error("joint `{joint}`: {problem}")]
    Friction {
        /// Name of the joint.
        joint: String,
        /// Description of the problem.
        problem: &'static str,
    },
    /// A radius is missing for a rotating interface, or given for an interface that only slides.
    #[error("joint `{joint}`: {problem}")]
    Radius {
        /// Name of the joint.
        joint: String,
        /// Description of the problem.
        problem: &'static str,
    },
    /// A compliance is out of its range, or given in a direction in which the joint moves.
    #[error("joint `{joint}`: the {part} compliance {problem}")]
    Compliance {
        /// Name of the joint.
        joint: String,
        /// Name of the compliance: `radial`, `axial`, `bending` or `torsional`.
        part: &'static str,
        /// Description of the problem.
        problem: &'static str,
    },
    /// The limits of a joint's range are not finite and ascending, or the joint does not have the
    /// quantity that the range limits.
    #[error("joint `{joint}`: the range {problem}")]
    Range {
        /// Name of the joint.
        joint: String,
        /// Quantity that the range limits.
        of: RangeOf,
        /// Description of the problem.
        problem: &'static str,
    },
    /// A spring refers to a body that does not exist.
    #[error("spring `{spring}` is fixed to body `{body}`, which does not exist")]
    UnknownBodyOfSpring {
        /// Name of the spring.
        spring: String,
        /// Name of the missing body.
        body: String,
    },
    /// Both ends of a spring are on the same body.
    #[error("both ends of spring `{spring}` are on body `{body}`, where it has no effect")]
    SpringWithinBody {
        /// Name of the spring.
        spring: String,
        /// Name of the body.
        body: String,
    },
    /// A parameter of a spring is negative or not finite.
    #[error("spring `{spring}`: its {parameter} is {value}, but must be at least 0")]
    SpringParameter {
        /// Name of the spring.
        spring: String,
        /// Name of the parameter.
        parameter: &'static str,
        /// Value of the parameter.
        value: f64,
    },
    /// A spring acts on a joint that does not exist.
    #[error("spring `{spring}` acts on joint `{joint}`, which does not exist")]
    UnknownJointOfSpring {
        /// Name of the spring.
        spring: String,
        /// Name of the missing joint.
        joint: String,
    },
    /// A spring or bushing does not fit its joint, or its values contradict each other.
    #[error("spring `{spring}`: {problem}")]
    Spring {
        /// Name of the spring or bushing.
        spring: String,
        /// Description of the problem.
        problem: String,
    },
    /// A drive train refers to a joint that does not exist.
    #[error("actuator `{actuator}` drives joint `{joint}`, which does not exist")]
    UnknownJointOfActuator {
        /// Name of the drive train.
        actuator: String,
        /// Name of the missing joint.
        joint: String,
    },
    /// The body that carries a rotor does not exist.
    #[error("the rotor of actuator `{actuator}` is carried by body `{body}`, which does not exist")]
    UnknownBodyOfActuator {
        /// Name of the drive train.
        actuator: String,
        /// Name of the missing body.
        body: String,
    },
    /// The values of a drive train do not fit its joints, contradict each other, or contradict the
    /// values of other drive trains.
    #[error("actuator `{actuator}`: {problem}")]
    Actuator {
        /// Name of the drive train.
        actuator: String,
        /// Description of the problem.
        problem: String,
    },
    /// A gearing refers to a joint that does not exist.
    #[error("gearing `{gearing}` connects joint `{joint}`, which does not exist")]
    UnknownJointOfGearing {
        /// Name of the gearing.
        gearing: String,
        /// Name of the missing joint.
        joint: String,
    },
    /// A gearing does not fit its joints.
    #[error("gearing `{gearing}`: {problem}")]
    Gearing {
        /// Name of the gearing.
        gearing: String,
        /// Description of the problem.
        problem: String,
    },
    /// A parameter of a drive train is out of its range.
    #[error("actuator `{actuator}`: `{parameter}` is {value}, but must be {range}")]
    ActuatorParameter {
        /// Name of the drive train.
        actuator: String,
        /// Key of the parameter in the model file.
        parameter: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Description of the admissible range.
        range: &'static str,
    },
    /// The characteristic length is not a positive finite number.
    #[error("the characteristic length is {0} m, but must be greater than 0")]
    CharacteristicLength(
        /// The declared value, m.
        f64,
    ),
    /// The characteristic length differs so much from the size of the mechanism that round-off
    /// would determine the ranks of matrices.
    #[error(
        "the characteristic length is {length:e} m, but must be between {least:.1e} and \
         {most:.1e} m, because joints and centres of mass are some {own:.1e} m apart"
    )]
    CharacteristicLengthFar {
        /// The declared value, m.
        length: f64,
        /// Default characteristic length of this mechanism, m.
        own: f64,
        /// Smallest admissible value, m.
        least: f64,
        /// Largest admissible value, m.
        most: f64,
    },
}

/// Returns the unit of a friction parameter, preceded by a space, for use after its value in
/// messages. Returns an empty string for dimensionless parameters and for parameters per unit of
/// load.
fn unit(parameter: &str) -> &'static str {
    match parameter {
        "radius" | "bending span" | "torsion arm" => " m",
        "position of the gland" | "position of the piston" => " m",
        "preload" | "smoothing" => " N",
        "viscous coefficient" => " N s/m",
        "Stribeck velocity" | "regularisation velocity" => " m/s",
        _ => "",
    }
}
