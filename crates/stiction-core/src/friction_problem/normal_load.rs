//! Normal load of a friction interface under the total wrench of its joint.
//!
//! Equation (F3) of the book's theory.

use crate::friction::{InterfaceShape, Load, NormalLoadMap, OwnFriction, Thread};
use crate::joint::Carrier;
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Wrench};

/// Parameters and body poses for which normal loads are evaluated.
#[derive(Clone, Copy)]
pub(crate) struct Configuration<'a> {
    pub(crate) parameters: &'a Parameters<f64>,
    pub(crate) bodies: &'a Bodies<f64>,
}

impl Configuration<'_> {
    /// Index of the joint to which a friction interface belongs.
    pub(crate) fn joint(&self, interface: usize) -> usize {
        self.parameters.interfaces[interface].joint
    }

    /// Computes the normal load of an interface, N. `wrench` is the total wrench of its joint or,
    /// for a motor shaft, the wrench that the gear transmits. `own` is the friction of the
    /// interface itself: the load of a thread depends on this friction, and the load of a gear
    /// depends on the direction of this friction.
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

    /// Computes an upper bound on the change of an interface's normal load, N, if the wrench at its
    /// joint changes by `wrench`. The bound is the load under `wrench` alone, without preload and
    /// smoothing. For a thread with the friction `coefficient`, and for the shaft of a motor,
    /// returns the larger of the bounds for the two sliding directions.
    pub(crate) fn largest_load_change(
        &self,
        interface: usize,
        wrench: Wrench<f64>,
        coefficient: f64,
    ) -> f64 {
        self.largest_load_changes(interface, coefficient)(wrench)
    }

    /// Returns [`Self::largest_load_change`] as a function of a wrench with any scalar type.
    pub(crate) fn largest_load_changes<T: Scalar>(
        &self,
        interface: usize,
        coefficient: f64,
    ) -> impl Fn(Wrench<T>) -> T + use<T> {
        let content = &self.parameters.interfaces[interface];
        let (shape, radius) = (content.shape, T::from_f64(content.radius));
        let pitch = T::from_f64(self.parameters.pitch[content.joint]);
        let map = content.load.seminorm().lift::<T>();
        let [j, k] = [&self.bodies.frame_j, &self.bodies.frame_k]
            .map(|frames| frames[content.joint].lift::<T>());
        let coefficient = T::from_f64(coefficient);
        move |wrench| larger_of_senses(&map, (shape, radius), pitch, (&j, &k), wrench, coefficient)
    }
}

/// Returns [`Configuration::largest_load_change`] of an interface for any scalar type. `j` and `k`
/// are the frames of its joint.
pub(crate) fn largest_load_change<T: Scalar>(
    interface: &InterfaceParameters<T>,
    pitch: T,
    frames: (&Pose<T>, &Pose<T>),
    wrench: Wrench<T>,
    coefficient: T,
) -> T {
    let surface = (interface.shape, interface.radius);
    larger_of_senses(&interface.load.seminorm(), surface, pitch, frames, wrench, coefficient)
}

/// Returns the load of the seminorm `map` under `wrench`: for a thread or a motor shaft, the larger
/// of the loads for both sliding directions.
#[inline(always)]
fn larger_of_senses<T: Scalar>(
    map: &NormalLoadMap<T>,
    (shape, radius): (InterfaceShape, T),
    pitch: T,
    frames: (&Pose<T>, &Pose<T>),
    wrench: Wrench<T>,
    coefficient: T,
) -> T {
    let bound = |direction: T| {
        let own = OwnFriction { coefficient, constant: T::zero(), direction };
        normal_load_between(map, (shape, radius), pitch, frames, wrench, own).value
    };
    let ahead = bound(T::one());
    match shape {
        InterfaceShape::Thread | InterfaceShape::Shaft { .. } => {
            let back = bound(-T::one());
            (ahead - back).if_positive(ahead, back)
        }
        _ => ahead,
    }
}

/// Computes the normal load under the total wrench of the joint; `map` is the load map of the
/// interface or the seminorm of that map.
pub(crate) fn normal_load<T: Scalar>(
    map: &NormalLoadMap<T>,
    interface: &InterfaceParameters<T>,
    pitch: T,
    bodies: &Bodies<T>,
    wrench: Wrench<T>,
    own: OwnFriction<T>,
) -> Load<T> {
    let (j, k) = (&bodies.frame_j[interface.joint], &bodies.frame_k[interface.joint]);
    normal_load_between(map, (interface.shape, interface.radius), pitch, (j, k), wrench, own)
}

/// Computes the normal load of a surface of the given shape and radius; the joint frames `j` and
/// `k` and the `wrench` are expressed in the same frame. Inlined, so that callers that need only
/// the value do not compute the gradient.
#[inline(always)]
pub(crate) fn normal_load_between<T: Scalar>(
    map: &NormalLoadMap<T>,
    (shape, radius): (InterfaceShape, T),
    pitch: T,
    (j, k): (&Pose<T>, &Pose<T>),
    wrench: Wrench<T>,
    own: OwnFriction<T>,
) -> Load<T> {
    let axis = match shape {
        InterfaceShape::Pin { axis, carrier: Carrier::Successor, .. } => k.rotation.columns[axis],
        InterfaceShape::Pin { axis, .. } => j.rotation.columns[axis],
        _ => j.rotation.columns[2],
    };
    let load = match shape {
        InterfaceShape::Ball => map.at_point(wrench, j.position),
        InterfaceShape::Plate => map.on_plane(wrench, k.position, axis),
        InterfaceShape::Shaft { dof, joint_type } => {
            let unit = joint_type.dofs()[dof].twist(j, k, pitch);
            map.in_gear(wrench, unit, own.direction)
        }
        _ => map.between(wrench, j.position, k.position, axis),
    };
    if shape == InterfaceShape::Thread {
        return Thread { radius, pitch }.load(map, load, wrench, axis, own);
    }
    load
}
