//! Quantities with respect to which actuator forces are differentiated.

use stiction_core::kinematics::Target;
use stiction_core::mechanism::{BodyId, JointId};
use stiction_core::parameters::Parameters;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::Vec3;

/// Variable of a state of motion, or parameter of a mechanism, with respect to which actuator
/// forces are differentiated. Derivatives have the unit of actuator forces (N, N m) per unit of the
/// quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Value of a prescribed coordinate, by its index among the prescribed coordinates, rad or m.
    /// All other positions follow from the loop closure; rates and accelerations of all prescribed
    /// coordinates do not change.
    Value(usize),
    /// Rate of a prescribed coordinate, rad/s or m/s.
    Rate(usize),
    /// Acceleration of a prescribed coordinate, rad/s^2 or m/s^2.
    Acceleration(usize),
    /// Mass of a body, kg. The inertia of the body about its centre of mass does not change.
    Mass(BodyId),
    /// Position of a body's centre of mass along x, y or z (0, 1, 2) of its frame, m.
    CentreOfMass(BodyId, usize),
    /// Moment of inertia of a body about an axis through its centre of mass, parallel to x, y or z
    /// (0, 1, 2) of the body's frame, kg m^2.
    Inertia(BodyId, usize),
    /// Position of a joint's frame J in its predecessor, along x, y or z (0, 1, 2) of the
    /// predecessor's frame, m. Prescribed coordinates do not change, and the loops are closed
    /// again.
    PlaceInPredecessor(JointId, usize),
    /// Position of a joint's frame K in its successor, along x, y or z (0, 1, 2) of the successor's
    /// frame, m. Prescribed coordinates do not change, and the loops are closed again.
    PlaceInSuccessor(JointId, usize),
    /// Coefficient of sliding friction, dimensionless, by the index of the interface in
    /// [`Parameters::interfaces`].
    Mu(usize),
    /// Viscous coefficient of a friction interface at its surface, N s/m.
    Viscous(usize),
    /// Radius of a rotating friction interface, m.
    Radius(usize),
}

impl Quantity {
    /// Returns the parameter of the mechanism that the quantity denotes; `None` if the quantity is
    /// not a parameter or does not exist.
    pub(crate) fn of_mechanism<T: Scalar>(self, parameters: &mut Parameters<T>) -> Option<&mut T> {
        match self {
            Self::Value(_) | Self::Rate(_) | Self::Acceleration(_) => None,
            Self::Mass(body) => parameters.mass.get_mut(body.0),
            Self::CentreOfMass(body, axis) => component(parameters.com.get_mut(body.0)?, axis),
            Self::Inertia(body, axis) => {
                let inertia = parameters.inertia.get_mut(body.0)?;
                component(inertia.columns.get_mut(axis)?, axis)
            }
            Self::PlaceInPredecessor(joint, axis) => {
                component(&mut parameters.frame_j.get_mut(joint.0)?.position, axis)
            }
            Self::PlaceInSuccessor(joint, axis) => {
                component(&mut parameters.frame_k.get_mut(joint.0)?.position, axis)
            }
            Self::Mu(interface) => Some(&mut parameters.interfaces.get_mut(interface)?.law.mu),
            Self::Viscous(interface) => {
                Some(&mut parameters.interfaces.get_mut(interface)?.law.viscous)
            }
            Self::Radius(interface) => Some(&mut parameters.interfaces.get_mut(interface)?.radius),
        }
    }

    /// Returns the prescribed value, rate or acceleration that the quantity denotes; `None` if the
    /// quantity belongs to the mechanism or does not exist.
    pub(crate) fn of_motion<T>(self, targets: &mut [Target<T>]) -> Option<&mut T> {
        match self {
            Self::Value(k) => targets.get_mut(k).map(|target| &mut target.value),
            Self::Rate(k) => targets.get_mut(k).map(|target| &mut target.rate),
            Self::Acceleration(k) => targets.get_mut(k).map(|target| &mut target.acceleration),
            _ => None,
        }
    }
}

fn component<T>(vector: &mut Vec3<T>, axis: usize) -> Option<&mut T> {
    match axis {
        0 => Some(&mut vector.x),
        1 => Some(&mut vector.y),
        2 => Some(&mut vector.z),
        _ => None,
    }
}
