//! Summary of a run of inverse dynamics.

use super::certainty::MOST_MARGIN;
use super::contributions::Ranking;
use super::efficiency::Efficiency;
use super::motor_summary::MotorSummary;
use super::sample::Sample;
use super::uniqueness::Singular;
use super::verdict::Verdict;
use crate::dofs::{Dof, actuated, dofs_of};
use crate::gearing_load::gearings_json;
use crate::job::{Job, friction_word};
use crate::names::Names;
use crate::ranges::Ranges;
use crate::statistics::{Comparison, Integral, Least, Range, Reactions, Size};
use crate::undetermined::open_components;
use crate::{Sink, SinkError};
use serde_json::{Map, Value, json};
use stiction_core::dynamics::{Bounds, FrictionMode, Weighting};

/// Summary of a run of inverse dynamics, accumulated sample by sample.
#[derive(Clone, Debug)]
pub struct Summary {
    pub(super) names: Names,
    pub(super) drives: Vec<Comparison>,
    /// Index of each actuator's degree of freedom in [`Sample::joints`].
    actuated: Vec<usize>,
    /// Statistics of the coordinate (m or rad), the speed (m/s or rad/s) and the power (W) of each
    /// actuator.
    motions: Vec<(Range, Size, Size)>,
    /// For each actuator, statistics of the width of the interval of possible efforts while joints
    /// are at rest, N or N m.
    pub(super) widest: Vec<Size>,
    /// For each actuator, lower and upper end of the widest interval of possible efforts while
    /// joints are at rest, N or N m.
    pub(super) widest_bounds: Vec<(f64, f64)>,
    /// For each actuator, guaranteed bounds of the effort at the sample with the widest interval of
    /// possible efforts, N or N m.
    widest_outer: Vec<(f64, f64)>,
    /// For each actuator, largest distance by which the guaranteed bounds of the effort exceed the
    /// computed interval of possible efforts, N or N m.
    pub(super) certified_within: Vec<f64>,
    /// Numbers of samples with joints at rest, for each kind of bounds of the effort intervals.
    pub(super) certainty: Certainty,
    pub(super) resting_samples: usize,
    /// Number of samples at which joints are at rest and the intervals of possible efforts are
    /// unknown.
    pub(super) unbounded_samples: usize,
    pub(super) reactions: Reactions,
    pub(super) dissipated: Vec<Integral>,
    pub(super) interface_loads: Vec<Size>,
    pub(super) work: Work,
    pub(super) shares: Ranking,
    pub(super) efficiency: Efficiency,
    pub(super) power_residual: Size,
    pub(super) power_residual_relative: Size,
    pub(super) motors: MotorSummary,
    /// Times of the first and the last sample, s; `None` before the first sample.
    span: Option<(f64, f64)>,
    ranges: Ranges,
    dofs: Vec<Dof>,
    /// Characteristic length of the mechanism, m.
    length: f64,
    pub(super) closure: Size,
    pub(super) actuation: Least,
    pub(super) constraint: Least,
    /// Statistics of the effort of each gearing, and true if this effort is statically determinate
    /// at all samples.
    pub(super) gearings: Vec<(Size, bool)>,
    /// Flags for the reaction of each joint: true for each component that is statically determinate
    /// at all samples. The first three components are the force, the last three the moment.
    pub(super) determined_reactions: Vec<[bool; 6]>,
    pub(super) determined_loads: Vec<bool>,
    pub(super) determined_drives: Vec<bool>,
}

/// Numbers of samples with joints at rest, counted separately for each kind of [`Bounds`] of the
/// effort intervals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Certainty {
    pub(super) exact: usize,
    pub(super) certified: usize,
    pub(super) attained: usize,
}

/// Work along the motion, J.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Work {
    pub(super) drives: Integral,
    pub(super) loads: Integral,
    pub(super) dissipated: Integral,
}

impl Summary {
    /// Creates the summary of a job without samples.
    pub fn new(job: &Job<'_>) -> Self {
        let names = Names::new(&job.model.mechanism);
        let (drives, joints, interfaces) =
            (names.drives.len(), names.joints.len(), names.interfaces.len());
        Self {
            names,
            drives: vec![Comparison::default(); drives],
            actuated: actuated(&dofs_of(&job.model.mechanism)),
            motions: vec![Default::default(); drives],
            widest: vec![Size::default(); drives],
            widest_bounds: vec![(0.0, 0.0); drives],
            widest_outer: vec![(0.0, 0.0); drives],
            certified_within: vec![0.0; drives],
            certainty: Certainty::default(),
            resting_samples: 0,
            unbounded_samples: 0,
            reactions: Reactions::new(joints),
            dissipated: vec![Integral::default(); interfaces],
            interface_loads: vec![Size::default(); interfaces],
            work: Work::default(),
            shares: Ranking::new(drives, if job.has_shares() { interfaces } else { 0 }),
            efficiency: Efficiency::new(drives),
            power_residual: Size::default(),
            power_residual_relative: Size::default(),
            motors: MotorSummary::new(job),
            span: None,
            ranges: Ranges::new(&job.model.mechanism),
            dofs: dofs_of(&job.model.mechanism),
            length: job.model.mechanism.characteristic_length(),
            closure: Size::default(),
            actuation: Least::default(),
            constraint: Least::default(),
            gearings: vec![(Size::default(), true); job.model.mechanism.gearings().len()],
            determined_reactions: vec![[true; 6]; joints],
            determined_loads: vec![true; interfaces],
            determined_drives: vec![true; drives],
        }
    }

    /// Returns the duration from the first to the last sample, s.
    pub(super) fn duration(&self) -> f64 {
        self.span.map_or(0.0, |(first, last)| last - first)
    }

    /// Returns the range of the coordinate of each actuator, m or rad.
    pub(super) fn positions(&self) -> impl Iterator<Item = &Range> {
        self.motions.iter().map(|(position, _, _)| position)
    }

    /// Returns the statistics of the power of each actuator, W.
    pub(super) fn powers(&self) -> impl Iterator<Item = &Size> {
        self.motions.iter().map(|(_, _, power)| power)
    }

    /// Returns the names of the joints with statically indeterminate reactions, each with the names
    /// of the indeterminate components.
    pub(super) fn undetermined(&self) -> Vec<(&str, Vec<&'static str>)> {
        self.names
            .joints
            .iter()
            .zip(&self.determined_reactions)
            .filter(|(_, flags)| flags.contains(&false))
            .map(|(name, flags)| (name.as_str(), open_components(flags)))
            .collect()
    }

    /// Returns whether the efforts are unique: they are statically determinate, and no friction
    /// depends on an indeterminate reaction.
    pub(super) fn drives_are_unique(&self, friction: FrictionMode) -> bool {
        let frictions = friction == FrictionMode::Off || !self.determined_loads.contains(&false);
        frictions && !self.determined_drives.contains(&false)
    }

    /// Returns the names of the friction interfaces whose normal load, and therefore friction, is
    /// not unique.
    pub(super) fn frictions_that_are_not_unique(&self) -> impl Iterator<Item = &str> {
        let interfaces = self.names.interfaces.iter().zip(&self.determined_loads);
        interfaces.filter(|(_, determined)| !**determined).map(|((name, _), _)| name.as_str())
    }

    /// Returns the content of `summary.json`.
    pub fn json(&self, job: &Job<'_>, verdict: &Verdict) -> Value {
        let mut value = json!({
            "program": { "name": "stiction", "version": env!("CARGO_PKG_VERSION") },
            "model": { "name": job.model.name, "title": job.model.title },
            "options": {
                "motion": job.motion_name,
                "load": job.load_name,
                "friction": friction_word(job.friction),
                "start": job.motion.start,
                "duration": job.motion.duration,
                "samples": verdict.samples,
                "interpolation": job.motion.interpolation,
            },
            "cautions": self.cautions(job),
            "units": "SI: s, m, rad, kg, N, N m, J, W",
            "drives": self.drives_json(job),
            "joints": self.reactions.json(&self.names.joints),
            "friction": self.friction_json(),
            "work": {
                "drives": self.work.drives.value,
                "loads": self.work.loads.value,
                "dissipated": self.work.dissipated.value,
            },
            "efficiency": self.has_friction(job).then(|| self.efficiency.json(&self.names)),
            "verdicts": self.verdicts_json(job, verdict),
        });
        // Only models with gearings have this entry.
        if !self.gearings.is_empty() {
            value["gearings"] = gearings_json(&self.names.gearings, &self.gearings);
        }
        // Only models with ranges have this entry.
        if !self.ranges.all.is_empty() {
            value["ranges"] = self.ranges.json();
        }
        // Only models with drive trains have these entries.
        if !self.motors.is_empty() {
            value["actuators"] = self.motors.json(&self.names);
            value["verdicts"]["power_residual_with_motors"] = json!(self.motors.residual());
        }
        value
    }

    /// Lists doubts about the recorded motion, excursions of joints beyond their ranges, and exceeded limits of motors.
    pub(super) fn cautions(&self, job: &Job<'_>) -> Vec<String> {
        let own = self.ranges.cautions().chain(self.motors.cautions());
        job.cautions().into_iter().chain(own).collect()
    }

    /// Lists reasons to interpret the results with care, one short sentence for each: exceeded
    /// ranges and limits, results that are not unique, singular positions in the motion. Cautions
    /// on a recording ([`Motion::cautions`](stiction_format::Motion::cautions)) are not included.
    pub fn doubts(&self, job: &Job<'_>, verdict: &Verdict) -> Vec<String> {
        let mut doubts: Vec<String> =
            self.ranges.cautions().chain(self.motors.cautions()).collect();
        if let Some(singular) = &verdict.singular {
            doubts.push(format!("singular at t = {} s: forces are not unique", singular.time));
        }
        if let Some((from, to)) = verdict.passed_singularities.first() {
            doubts.push(format!("passes a singular position between t = {from} s and {to} s"));
        }
        if !self.drives_are_unique(job.friction) {
            doubts.push("actuator efforts are not unique".to_owned());
        }
        if let Some(others) = &verdict.other_solutions {
            doubts.push(format!("friction has other solutions at t = {} s", others.time));
        }
        doubts
    }

    /// Returns whether friction acts in any joint.
    pub(super) fn has_friction(&self, job: &Job<'_>) -> bool {
        job.friction != FrictionMode::Off && !self.names.interfaces.is_empty()
    }

    fn drives_json(&self, job: &Job<'_>) -> Value {
        let mut drives = Map::new();
        for (k, (name, unit)) in self.names.drives.iter().enumerate() {
            let comparison = &self.drives[k];
            let mut value = json!({
                "unit": unit,
                "with_friction": comparison.with.json(),
                "frictionless": comparison.without.json(),
                "friction_effect": comparison.metrics().json(),
                "widest_interval": self.widest[k].peak,
                "interval_without_limit": self.widest[k].peak.is_infinite(),
                "drive_outer_low": self.widest_outer[k].0,
                "drive_outer_high": self.widest_outer[k].1,
                "interval_certified_within": self.certified_within[k],
                "determined": self.determined_drives[k],
                "position": self.motions[k].0.json(),
                "speed": self.motions[k].1.json(),
                "power": self.motions[k].2.json(),
            });
            if self.has_friction(job) {
                value["friction_contributions"] = self.shares.json(&self.names, k);
            }
            drives.insert(name.clone(), value);
        }
        Value::Object(drives)
    }

    fn friction_json(&self) -> Value {
        let mut interfaces = Map::new();
        let total: f64 = self.dissipated.iter().map(|integral| integral.value).sum();
        for (k, (name, _)) in self.names.interfaces.iter().enumerate() {
            let mut value = json!({
                "load": self.interface_loads[k].json(),
                "dissipated": self.dissipated[k].value,
                "dissipated_part": (total > 0.0).then(|| self.dissipated[k].value / total),
                "determined": self.determined_loads[k],
            });
            // Only friction laws with an internal state have this entry.
            if self.names.steady.contains(name) {
                value["law"] = json!("steady sliding of a law with an internal state");
            }
            interfaces.insert(name.clone(), value);
        }
        Value::Object(interfaces)
    }

    fn verdicts_json(&self, job: &Job<'_>, verdict: &Verdict) -> Value {
        let undetermined: Map<String, Value> = self
            .undetermined()
            .into_iter()
            .map(|(name, open)| (name.to_owned(), json!(open)))
            .collect();
        json!({
            "drives_unique": self.drives_are_unique(job.friction),
            "mobility": verdict.mobility,
            "local_dofs": verdict.idle_spins,
            "redundancy": verdict.redundancy,
            "undetermined_reactions": undetermined,
            "weighting": weighting_words(job, verdict),
            "samples_at_rest": self.resting_samples,
            "samples_without_intervals": self.unbounded_samples,
            "intervals": {
                "exact": self.certainty.exact,
                "certified": self.certainty.certified,
                "attained": self.certainty.attained,
            },
            "rest_speed": verdict.rest_speed,
            "closure": self.closure.peak,
            "power_residual": self.power_residual.peak.abs(),
            "power_residual_relative": self.power_residual_relative.peak.abs(),
            "friction_coupling": verdict.coupling,
            "friction_is_unique": verdict.coupling.is_some_and(|coupling| coupling < 1.0),
            "friction_unique_up_to": verdict
                .coupling
                .filter(|coupling| *coupling > 0.0)
                .map(|coupling| 1.0 / coupling),
            "other_solutions": verdict.other_solutions.as_ref().map(|others| {
                json!({ "samples": others.samples, "time": others.time, "drives": others.drives })
            }),
            "friction_margin": verdict.friction_margin.as_ref().map(|margin| {
                json!({
                    "factor": margin.factor,
                    "most": MOST_MARGIN,
                    "time": margin.time,
                    "joint": margin.joint,
                })
            }),
            "passed_singularities": verdict.passed_singularities,
            "singular": verdict.singular.as_ref().map(|singular| self.singular_json(singular)),
            "distance_actuation": self.actuation.json(),
            "distance_constraint": self.constraint.json(),
            "characteristic_length": job.model.mechanism.characteristic_length(),
        })
    }
}

impl Sink<Sample> for Summary {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let (time, forces) = (sample.time, &sample.forces);
        self.span = Some((self.span.map_or(time, |(first, _)| first), time));
        for (k, comparison) in self.drives.iter_mut().enumerate() {
            comparison.add(time, forces.efforts[k], forces.efforts_frictionless[k]);
            let (low, high) = forces.effort_bounds[k];
            let outer = forces.effort_outer_bounds[k];
            self.widest[k].add(time, high - low);
            if self.widest[k].peak_time == time {
                self.widest_bounds[k] = (low, high);
                self.widest_outer[k] = outer;
            }
            let motion = &sample.joints[self.actuated[k]];
            let (position, speed, power) = &mut self.motions[k];
            position.add(motion.value);
            speed.add(time, motion.rate);
            power.add(time, forces.efforts[k] * motion.rate);
            if forces.bounds == Bounds::Certified {
                let beyond = (low - outer.0).max(outer.1 - high);
                self.certified_within[k] = self.certified_within[k].max(beyond);
            }
        }
        if forces.interfaces.iter().any(|c| !c.slides && c.limit > 0.0) {
            let certainty = &mut self.certainty;
            match forces.bounds {
                Bounds::Exact => certainty.exact += 1,
                Bounds::Certified => certainty.certified += 1,
                Bounds::Attained => certainty.attained += 1,
                Bounds::Unknown => {}
            }
        }
        self.unbounded_samples += usize::from(forces.bounds == Bounds::Unknown);
        self.resting_samples +=
            usize::from(forces.interfaces.iter().any(|c| !c.slides && c.limit > 0.0));
        self.reactions.add(time, forces.reactions.iter().map(|(f, m)| (f.norm(), m.norm())));
        for (k, interface) in forces.interfaces.iter().enumerate() {
            self.dissipated[k].add(time, interface.power);
            self.interface_loads[k].add(time, interface.load);
        }
        self.shares.add(time, &sample.shares);
        self.efficiency.add(time, forces, &sample.backward);
        let power = &forces.power;
        self.work.drives.add(time, power.actuators);
        self.work.loads.add(time, power.loads);
        self.work.dissipated.add(time, power.dissipated);
        self.power_residual.add(time, power.residual());
        self.power_residual_relative.add(time, forces.imbalance(self.length));
        self.motors.add(time, &sample.motors, forces);
        let bodies = &sample.bodies;
        self.ranges.add(
            time,
            |of| of.value(bodies),
            |joint, index| {
                let place =
                    self.dofs.iter().position(|dof| (dof.joint, dof.index) == (joint, index));
                let motion = sample.joints.get(place?)?;
                Some((motion.value, Some(motion.rate)))
            },
        );
        self.closure.add(time, sample.closure);
        self.actuation.add(time, sample.distances.actuation);
        self.constraint.add(time, sample.distances.constraint);
        for (all, now) in self.determined_reactions.iter_mut().zip(&sample.determined_reactions) {
            all.iter_mut().zip(now).for_each(|(all, now)| *all &= now);
        }
        let gearings = forces.gearings.iter().zip(&sample.determined_gearings);
        for ((size, all), (effort, now)) in self.gearings.iter_mut().zip(gearings) {
            size.add(time, *effort);
            *all &= now;
        }
        for (all, now) in self.determined_loads.iter_mut().zip(&sample.determined_loads) {
            *all &= now;
        }
        for (all, now) in self.determined_drives.iter_mut().zip(&sample.determined_drives) {
            *all &= now;
        }
        Ok(())
    }
}

impl Summary {
    fn singular_json(&self, singular: &Singular) -> Value {
        let directions = singular.null_directions.iter().map(|direction| {
            let drives = self.names.drives.iter().zip(&direction.drives);
            let drives: Map<String, Value> =
                drives.map(|((name, _), drive)| (name.clone(), json!(drive))).collect();
            let joints = direction.joints.iter().map(|load| {
                json!({
                    "joint": self.names.joints[load.joint.0],
                    "force": load.force.to_array(),
                    "moment": load.moment.to_array(),
                })
            });
            json!({ "drives": drives, "reactions": joints.collect::<Vec<_>>() })
        });
        json!({
            "time": singular.time,
            "samples": singular.samples,
            "body": singular.body,
            "motion": singular.motion,
            "load": singular.load,
            "null_directions": directions.collect::<Vec<_>>(),
        })
    }
}

/// Describes the weighting that selects one of several possible solutions for efforts or reactions;
/// `None` if the solution is unique.
pub(super) fn weighting_words(job: &Job<'_>, verdict: &Verdict) -> Option<String> {
    let mechanism = &job.model.mechanism;
    let length = mechanism.characteristic_length();
    let gives = mechanism.joints().iter().any(|joint| joint.compliance.is_some());
    let reactions = format!(
        "the least sum over all joints of |force|^2 + |moment|^2/L^2, moments about the joint's origin, \
         L = {:.4} mm",
        length * 1e3
    );
    let drives = format!(
        "the least sum of squared efforts{}, those of rotary actuators divided by L = {:.4} mm",
        if mechanism.drive_trains().is_empty() { "" } else { " at the joints (not of the motors)" },
        length * 1e3
    );
    let energy =
        "the least elastic energy of the joints with their declared compliances".to_owned();
    match verdict.weighting {
        _ if verdict.redundancy == 0 => None,
        Some(Weighting::LeastReactions) => Some(reactions),
        Some(Weighting::LeastEnergy) => Some(energy),
        Some(Weighting::LeastEfforts) => Some(drives),
        Some(Weighting::Determined) => None,
        None if gives => Some(format!("{drives}, then by {energy}, and then by {reactions}")),
        None => Some(format!("{drives}, and then by {reactions}")),
    }
}
