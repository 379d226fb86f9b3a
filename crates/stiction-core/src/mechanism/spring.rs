//! Springs with dampers between points of two bodies.

use super::{BodyId, Defect};
use crate::spatial::Vec3;
use std::collections::HashMap;

/// A straight spring with a parallel damper between a point of one body and a point of another.
/// Tension along the line between the points: `stiffness * (length - free_length) + damping * rate
/// of the length`.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Name, unique among springs.
    pub name: String,
    /// Bodies of the two ends, distinct from each other.
    pub ends: [BodyId; 2],
    /// Positions of the ends, each in its body's frame, m.
    pub points: [Vec3<f64>; 2],
    /// Stiffness, N/m, not negative.
    pub stiffness: f64,
    /// Free length, m, not negative.
    pub free_length: f64,
    /// Damping, N s/m, not negative.
    pub damping: f64,
}

/// Specification of a spring; bodies by name.
#[must_use = "it has no effect unless a mechanism is built with it"]
#[derive(Clone, Debug, PartialEq)]
pub struct SpringSpec {
    name: String,
    ends: [String; 2],
    points: [Vec3<f64>; 2],
    stiffness: f64,
    free_length: f64,
    damping: f64,
}

impl SpringSpec {
    /// A spring without stiffness and damping between the origins of two bodies.
    pub fn new(name: impl Into<String>, from: impl Into<String>, to: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ends: [from.into(), to.into()],
            points: [Vec3::zero(); 2],
            stiffness: 0.0,
            free_length: 0.0,
            damping: 0.0,
        }
    }

    /// Sets the ends in the frames of their bodies, m.
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

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Builds the spring, unless its bodies are unknown; other defects go to `defects`.
    pub(super) fn resolve(
        self,
        ids: &HashMap<String, BodyId>,
        defects: &mut Vec<Defect>,
    ) -> Option<Spring> {
        let spring = || self.name.clone();
        if !self.points.iter().all(|point| point.is_finite()) {
            let place = format!("an end of spring `{}`", self.name);
            defects.push(Defect::NotFinite { place });
        }
        let parameters = [
            ("stiffness", self.stiffness),
            ("free length", self.free_length),
            ("damping", self.damping),
        ];
        for (parameter, value) in parameters {
            if !(value >= 0.0 && value.is_finite()) {
                defects.push(Defect::SpringParameter { spring: spring(), parameter, value });
            }
        }
        let mut body = |name: &String| {
            let id = ids.get(name).copied();
            if id.is_none() {
                let body = name.clone();
                defects.push(Defect::UnknownBodyOfSpring { spring: spring(), body });
            }
            id
        };
        let (from, to) = (body(&self.ends[0]), body(&self.ends[1]));
        let ends = [from?, to?];
        if ends[0] == ends[1] {
            let [_, body] = self.ends;
            defects.push(Defect::SpringWithinBody { spring: self.name, body });
            return None;
        }
        Some(Spring {
            name: self.name,
            ends,
            points: self.points,
            stiffness: self.stiffness,
            free_length: self.free_length,
            damping: self.damping,
        })
    }
}
