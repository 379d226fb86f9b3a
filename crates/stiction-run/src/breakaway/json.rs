//! JSON output of the static-friction results for a mechanism at rest.

use super::Findings;
use crate::Job;
use crate::names::Names;
use serde_json::{Map, Value, json};
use stiction_core::dynamics::{Bounds, Breakaway, Holding, Verdict};

impl Findings {
    /// Returns all results as a JSON object, in which infinite numbers become `null`.
    pub fn json(&self, job: &Job<'_>) -> Value {
        let names = Names::new(&job.model.mechanism);
        let mut drives = Map::new();
        for (k, (name, unit)) in names.drives.iter().enumerate() {
            let (low, high) = self.forces.effort_bounds[k];
            let (outer_low, outer_high) = self.forces.effort_outer_bounds[k];
            let value = json!({
                "unit": unit,
                "frictionless": self.forces.efforts_frictionless[k],
                "low": low,
                "high": high,
                "outer_low": outer_low,
                "outer_high": outer_high,
                "breakaway": self.rest.breakaway[k].as_ref().map(breakaway_json),
                "alone_unpowered": self.holding_json(&names, &self.rest.alone[k]),
            });
            drives.insert(name.clone(), value);
        }
        let undetermined = self.undetermined_loads.iter().map(|&k| &names.interfaces[k].0);
        let mut value = json!({
            "program": { "name": "stiction", "version": env!("CARGO_PKG_VERSION") },
            "model": { "name": job.model.name, "title": job.model.title },
            "options": {
                "motion": job.motion_name,
                "load": job.load_name,
                "time": self.time,
            },
            "units": "SI: s, m, rad, kg, N, N m, J, W",
            "drives": drives,
            "intervals": bounds_word(self.forces.bounds),
            "unpowered": self.holding_json(&names, &self.rest.unpowered),
            "undetermined_loads": undetermined.collect::<Vec<_>>(),
            "redundant_actuators": self.redundant_actuators,
        });
        // Only models with drive trains have these entries.
        let trains = job.model.mechanism.drive_trains();
        if !trains.is_empty() {
            let motors = trains.iter().zip(&self.motors).map(|(train, (motor, power_off))| {
                let (low, high) = motor.torque_bounds;
                let value = json!({
                    "unit": "N m",
                    "motor_torque": motor.torque,
                    "low": low,
                    "high": high,
                    "power_off": power_off.json(),
                });
                (train.name.clone(), value)
            });
            value["actuators"] = Value::Object(motors.collect());
            value["unpowered"]["scope"] =
                json!("friction of the joints, with motors and gears disconnected");
        }
        value
    }

    fn holding_json(&self, names: &Names, holding: &Holding) -> Value {
        let (not_enough, enough) = holding.needed;
        let frictions: Map<String, Value> = names
            .interfaces
            .iter()
            .zip(&holding.frictions)
            .map(|((name, _), friction)| (name.clone(), json!(friction)))
            .collect();
        json!({
            "verdict": match holding.verdict {
                Verdict::Holds => "holds",
                Verdict::Slips => "slips",
                Verdict::Undecided => "undecided",
            },
            "coefficients_needed": { "more_than": not_enough, "enough": enough },
            "frictions": frictions,
        })
    }
}

fn breakaway_json(breakaway: &Breakaway) -> Value {
    let way = |(first, last): (f64, f64)| json!({ "may_begin": first, "begins": last, "locked": last.is_infinite() });
    json!({ "forward": way(breakaway.forward), "backward": way(breakaway.backward) })
}

fn bounds_word(bounds: Bounds) -> &'static str {
    match bounds {
        Bounds::Exact => "exact",
        Bounds::Certified => "certified",
        Bounds::Attained => "attained",
        Bounds::Unknown => "unknown",
    }
}
