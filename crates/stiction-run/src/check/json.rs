//! JSON output of the results of a check.

use super::{Findings, Kind, Nearness, Range, Weakness};
use crate::Job;
use serde_json::{Value, json};
use stiction_core::mobility::GenericRank;

/// Joint clearance for which the resulting play is reported, m.
pub(super) const CLEARANCE: f64 = 1e-5;

impl Findings {
    /// Returns all results as a JSON object.
    pub fn json(&self, job: &Job<'_>) -> Value {
        let joint_name = |joint: usize| job.model.mechanism.joints()[joint].name.as_str();
        let bodies = self.mobility.bodies.iter().map(|body| {
            json!({
                "body": body.body,
                "motions": body.motions,
                "first_order_only": body.first_order_only,
            })
        });
        let stresses = self.self_stresses.iter().map(|stress| {
            let joints = stress.iter().map(|load| {
                json!({
                    "joint": joint_name(load.joint.0),
                    "force": load.force.to_array(),
                    "moment": load.moment.to_array(),
                })
            });
            Value::Array(joints.collect())
        });
        let undetermined = self.undetermined.iter().flat_map(|(joint, components)| {
            components.iter().map(move |component| format!("{joint}.{component}"))
        });
        let play = self.play().iter().map(|play| {
            json!({
                "body": job.model.mechanism.bodies()[play.motion.body].name,
                "joint": joint_name(play.joint.0),
                "clearance": CLEARANCE,
                "amount": play.with(CLEARANCE),
                "unit": if play.motion.turns { "rad" } else { "m" },
            })
        });
        let ranges = |ranges: &[Range]| Value::Array(ranges.iter().map(Range::json).collect());
        let mut singularities = json!({
            "leg": null,
            "passed": self.passed,
            "characteristic_length": job.model.mechanism.characteristic_length(),
        });
        for (kind, nearness) in self.singularities() {
            singularities[kind.word()] = self.nearness_json(kind, nearness);
        }
        let generic = |rank: &GenericRank| {
            json!({
                "open": rank.open,
                "smallest_kept": rank.kept,
                "largest_dropped": rank.dropped,
                "decided": rank.decided,
            })
        };
        json!({
            "model": job.model.name,
            "motion": job.motion_name,
            "samples": self.samples,
            "assembly": self.assembly.json(),
            "mobility": {
                "gruebler": self.mobility.gruebler,
                "instantaneous": self.mobility.instantaneous,
                "finite": self.mobility.finite.decided(),
                "finite_range": self.mobility.finite.range(),
                "finite_motion": self.mobility.finite_motion.as_ref().map(|motion| json!({
                    "body": motion.body,
                    "moved": motion.moved,
                    "turned": motion.turned,
                    "closure": motion.closure,
                })),
                "finite_traced": self.mobility.finite.traced,
                "branches_meet": self.mobility.branches_meet,
                "local_dofs": self.idle_spins,
                "smallest_kept": self.mobility.gap.0,
                "largest_dropped": self.mobility.gap.1,
                "bodies": bodies.collect::<Vec<_>>(),
                "play": play.collect::<Vec<_>>(),
            },
            "redundant_constraints": self.mobility.redundant_constraints,
            "self_stresses": stresses.collect::<Vec<_>>(),
            "undetermined_reactions": undetermined.collect::<Vec<_>>(),
            "drives_unique": self.drives_unique,
            "singularities": singularities,
            "in_general": {
                "positions": self.architecture.positions,
                "reach": self.architecture.reach,
                "constraints": generic(&self.architecture.constraints),
                "constraints_and_actuators": generic(&self.architecture.actuated),
            },
            "actuation_of_motion": self.actuation_of_motion.map(|(least, greatest, time)| {
                json!({
                    "least": least,
                    "time": time,
                    "greatest": greatest,
                    "greatest_elsewhere": self.architecture.actuation_of_motion,
                })
            }),
            "mass": self.sizes.json(),
            "travel": ranges(&self.sizes.joints),
            "legs": ranges(&self.sizes.legs),
            "reach": self.sizes.reach_json(),
            "warnings": self.warnings,
            "cautions": self.cautions,
            "ranges": self.ranges.json(),
        })
    }

    fn nearness_json(&self, kind: Kind, nearness: &Nearness) -> Value {
        let weakness = |weakness: &Weakness| {
            json!({
                "body": weakness.body,
                "motion": weakness.motion,
                "load": weakness.load,
                "left": weakness.left,
            })
        };
        let crossings = nearness.crossings.iter().map(|(time, gained)| {
            let mut crossing = weakness(gained);
            crossing["time"] = json!(time);
            crossing
        });
        json!({
            "distance": nearness.least,
            "time": nearness.time,
            "singular_samples": nearness.singular_samples,
            "weakest": nearness.weakness.as_ref().map(weakness),
            "crossings": crossings.collect::<Vec<_>>(),
            "not_searched": nearness.not_searched,
            "everywhere": self.everywhere(kind),
        })
    }
}
