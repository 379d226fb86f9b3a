//! Springs with dampers: straight springs between points of two bodies, springs on degrees of
//! freedom of joints, and bushings between frames of two bodies.

mod bushing;
mod joint_spring;

pub use bushing::{Bushing, BushingSpec, SixBySix};
pub use joint_spring::{JointSpring, JointSpringSpec};

use super::{BodyId, Defect};
use crate::spatial::Vec3;
use std::collections::HashMap;

/// A straight spring with a parallel damper between a point of one body and a point of another. The
/// tension along the line between the points is `stiffness * (length - free_length) - preload +
/// damping * rate of the length`.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Name, unique among springs and bushings.
    pub name: String,
    /// The two connected bodies, which are distinct.
    pub ends: [BodyId; 2],
    /// Positions of the ends, each in its body's frame, m.
    pub points: [Vec3<f64>; 2],
    /// Stiffness, N/m, nonnegative.
    pub stiffness: f64,
    /// Free length, m, nonnegative.
    pub free_length: f64,
    /// Force at the free length, N; positive if it pushes the ends apart.
    pub preload: f64,
    /// Damping, N s/m, nonnegative.
    pub damping: f64,
    /// Least and greatest length that the design allows, m. Lengths outside this range only cause
    /// cautions. `None` if the design sets no limits.
    pub lengths: Option<(f64, f64)>,
}

/// A gas spring, specified by data-sheet values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasSpring {
    /// Force at the extended length, N (`F1` of data sheets), nonnegative.
    pub extension_force: f64,
    /// Ratio of the force at the end of the stroke to the extension force (`x = F2/F1`), at least one.
    pub progression: f64,
    /// Distance between the ends of the extended spring, m, positive.
    pub extended_length: f64,
    /// Stroke, m: positive and less than the extended length.
    pub stroke: f64,
}

/// Specification of a spring; it refers to its bodies by name.
#[must_use = "a specification has no effect until it is passed to a `MechanismBuilder`"]
#[derive(Clone, Debug, PartialEq)]
pub struct SpringSpec {
    name: String,
    ends: [String; 2],
    points: [Vec3<f64>; 2],
    stiffness: f64,
    free_length: f64,
    preload: f64,
    damping: f64,
    gas: Option<GasSpring>,
}

impl SpringSpec {
    /// Creates a spring without stiffness and damping between the origins of the frames of two
    /// bodies, given by name.
    pub fn new(name: impl Into<String>, from: impl Into<String>, to: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ends: [from.into(), to.into()],
            points: [Vec3::zero(); 2],
            stiffness: 0.0,
            free_length: 0.0,
            preload: 0.0,
            damping: 0.0,
            gas: None,
        }
    }

    /// Sets the positions of the ends in the frames of their bodies, m.
    pub fn points(mut self, from: Vec3<f64>, to: Vec3<f64>) -> Self {
        self.points = [from, to];
        self
    }

    /// Sets stiffness, N/m, and free length, m.
    pub fn stiffness(mut self, stiffness: f64, free_length: f64) -> Self {
        (self.stiffness, self.free_length) = (stiffness, free_length);
        self
    }

    /// Sets damping, N s/m.
    pub fn damping(mut self, damping: f64) -> Self {
        self.damping = damping;
        self
    }

    /// Sets the force at the free length, N; positive if it pushes the ends apart.
    pub fn preload(mut self, preload: f64) -> Self {
        self.preload = preload;
        self
    }

    /// Makes this a gas spring: it pushes its ends apart with a force that grows linearly over the stroke, from the
    /// extension force to `progression` times that force. Replaces stiffness, free length and preload.
    pub fn gas(mut self, gas: GasSpring) -> Self {
        let GasSpring { extension_force, progression, extended_length, stroke } = gas;
        self.stiffness = extension_force * (progression - 1.0) / stroke;
        (self.free_length, self.preload) = (extended_length, extension_force);
        self.gas = Some(gas);
        self
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Builds the spring, or returns `None` if one of its bodies is unknown or both are the same
    /// body. Appends all defects to `defects`.
    pub(super) fn resolve(
        self,
        ids: &HashMap<String, BodyId>,
        defects: &mut Vec<Defect>,
    ) -> Option<Spring> {
        if !self.points.iter().all(|point| point.is_finite()) {
            let place = format!("an end of spring `{}`", self.name);
            defects.push(Defect::NotFinite { place });
        }
        if !self.preload.is_finite() {
            let place = format!("`preload` of spring `{}`", self.name);
            defects.push(Defect::NotFinite { place });
        }
        match &self.gas {
            Some(gas) => gas.check(&self.name, defects),
            None => {
                let numbers = [("stiffness", self.stiffness), ("free length", self.free_length)];
                check_not_negative(&self.name, &numbers, defects);
            }
        }
        check_not_negative(&self.name, &[("damping", self.damping)], defects);
        let ends = resolve_ends(&self.name, &self.ends, ids, defects)?;
        Some(Spring {
            name: self.name,
            ends,
            points: self.points,
            stiffness: self.stiffness,
            free_length: self.free_length,
            preload: self.preload,
            damping: self.damping,
            lengths: self.gas.map(|gas| (gas.extended_length - gas.stroke, gas.extended_length)),
        })
    }
}

impl GasSpring {
    fn check(&self, spring: &str, defects: &mut Vec<Defect>) {
        let Self { extension_force, progression, extended_length, stroke } = *self;
        let mut require = |holds: bool, problem: String| {
            if !holds {
                defects.push(Defect::Spring { spring: spring.to_owned(), problem });
            }
        };
        require(
            extension_force >= 0.0 && extension_force.is_finite(),
            format!("its extension force is {extension_force} N, but must be at least 0"),
        );
        require(
            progression >= 1.0 && progression.is_finite(),
            format!(
                "its progression is {progression}, but must be at least 1: it is the force at the \
                 end of the stroke divided by the extension force"
            ),
        );
        require(
            extended_length > 0.0 && extended_length.is_finite(),
            format!("its extended length is {extended_length} m, but must be greater than 0"),
        );
        require(
            stroke > 0.0 && stroke < extended_length,
            format!(
                "its stroke is {stroke} m, but must be greater than 0 and less than its extended length of \
                 {extended_length} m"
            ),
        );
    }
}

/// Appends a defect for each of the spring parameters `numbers` (name and value) that is negative
/// or not finite.
fn check_not_negative(spring: &str, numbers: &[(&'static str, f64)], defects: &mut Vec<Defect>) {
    for &(parameter, value) in numbers {
        if !(value >= 0.0 && value.is_finite()) {
            defects.push(Defect::SpringParameter { spring: spring.to_owned(), parameter, value });
        }
    }
}

/// Finds the two bodies of a spring by name. If a body is unknown or both are the same body,
/// appends a defect and returns `None`.
fn resolve_ends(
    spring: &str,
    names: &[String; 2],
    ids: &HashMap<String, BodyId>,
    defects: &mut Vec<Defect>,
) -> Option<[BodyId; 2]> {
    let mut body = |name: &String| {
        let id = ids.get(name).copied();
        if id.is_none() {
            let (spring, body) = (spring.to_owned(), name.clone());
            defects.push(Defect::UnknownBodyOfSpring { spring, body });
        }
        id
    };
    let (from, to) = (body(&names[0]), body(&names[1]));
    let ends = [from?, to?];
    if ends[0] == ends[1] {
        let (spring, body) = (spring.to_owned(), names[1].clone());
        defects.push(Defect::SpringWithinBody { spring, body });
        return None;
    }
    Some(ends)
}
