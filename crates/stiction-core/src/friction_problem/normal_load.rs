//! Normal load of a friction interface under the complete wrench of its joint.
//!
//! Equation (F3) of the book's theory.

use crate::friction::{InterfaceShape, Load, NormalLoadMap, OwnFriction, Thread};
use crate::joint::Carrier;
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Wrench};

/// Parameters and body poses at which normal loads are evaluated.
#[derive(Clone, Copy)]
pub(crate) struct Configuration<'a> {
    pub(crate) parameters: &'a Parameters<f64>,
    pub(crate) bodies: &'a Bodies<f64>,
}

impl Configuration<'_> {
    /// Index of the joint of an interface.
    pub(crate) fn joint(&self, interface: usize) -> usize {
        self.parameters.interfaces[interface].joint
    }

    /// Computes the normal load of an interface, N, under its joint's complete wrench or the wrench that a gear
    /// transmits. `own` is the friction of the interface itself, on which the load of a thread depends; the load of a
    /// gear depends on the direction of this friction.
    pub(crate) fn normal_load(
        &self,
        interface: usize,
        wrench: Wrench<f64>,
        own: OwnFriction<f64>,
    ) -> Load<f64> {
        let content = &self.parameters.interfaces[interface];
        let pitch = self.parameters.pitch[content.joint];
        normal_load(&content.load, content, pitch, self.bodies, wrench, own)
    }

    /// Computes an upper bound on the change of an interface's normal load, N, if the wrench at its joint
    /// changes by `wrench`: the load under that change alone, without preload and smoothing. For a
    /// thread, the larger of the bounds for both sliding directions, with the given friction coefficient of
    /// the thread itself.
    pub(crate) fn largest_load_change(
        &self,
        interface: usize,
        wrench: Wrench<f64>,
        coefficient: f64,
    ) -> f64 {
        let content = &self.parameters.interfaces[interface];
        let pitch = self.parameters.pitch[content.joint];
        let map = content.load.seminorm();
        let bound = |direction: f64| {
            let own = OwnFriction { coefficient, constant: 0.0, direction };
            normal_load(&map, content, pitch, self.bodies, wrench, own).value
        };
        match content.shape {
            InterfaceShape::Thread | InterfaceShape::Shaft { .. } => bound(1.0).max(bound(-1.0)),
            _ => bound(1.0),
        }
    }
}

/// Computes the normal load by a load map (that of the interface, or its seminorm) under the joint's
/// complete wrench.
pub(crate) fn normal_load<T: Scalar>(
    map: &NormalLoadMap<T>,
    interface: &InterfaceParameters<T>,
    pitch: T,
    bodies: &Bodies<T>,
    wrench: Wrench<T>,
    own: OwnFriction<T>,
) -> Load<T> {
    let (j, k) = (&bodies.frame_j[interface.joint], &bodies.frame_k[interface.joint]);
    normal_load_between(map, interface, pitch, j, k, wrench, own)
}

/// Computes the normal load from the joint frames `j` and `k`; `wrench` is in the frame in which these are given.
pub(crate) fn normal_load_between<T: Scalar>(
    map: &NormalLoadMap<T>,
    interface: &InterfaceParameters<T>,
    pitch: T,
    j: &Pose<T>,
    k: &Pose<T>,
    wrench: Wrench<T>,
    own: OwnFriction<T>,
) -> Load<T> {
    let axis = match interface.shape {
        InterfaceShape::Pin { axis, carrier: Carrier::Successor, .. } => k.rotation.columns[axis],
        InterfaceShape::Pin { axis, .. } => j.rotation.columns[axis],
        _ => j.rotation.columns[2],
    };
    let load = match interface.shape {
        InterfaceShape::Ball => map.at_point(wrench, j.position),
        InterfaceShape::Plate => map.on_plane(wrench, k.position, axis),
        InterfaceShape::Shaft { dof, joint_type } => {
            let unit = joint_type.dofs()[dof].twist(j, k, pitch);
            map.in_gear(wrench, unit, own.direction)
        }
        _ => map.between(wrench, j.position, k.position, axis),
    };
    if interface.shape == InterfaceShape::Thread {
        return Thread { radius: interface.radius, pitch }.load(map, load, wrench, axis, own);
    }
    load
}
