//! Summary of a simulation: peaks and root mean squares, energy balance, events and verdicts.

use super::events::{DescribedEvent, describe_all, method_name, methods};
use super::job::Job;
use super::outcome::{Ending, Outcome};
use super::rows::{Layout, Rows};
use crate::gearing_load::gearings_json;
use crate::motor_load::MotorLoad;
use crate::ranges::Ranges;
use crate::statistics::{Reactions, Size};
use crate::{Sink, SinkError};
use serde_json::{Map, Value, json};
use stiction_core::forward::{Event, EventKind, Settings};

/// Summary of a simulation, accumulated row by row.
#[derive(Clone, Debug)]
pub struct Summary {
    pub(super) layout: Layout,
    pub(super) first: Option<Rows>,
    pub(super) last: Rows,
    pub(super) samples: usize,
    pub(super) drives: Vec<Size>,
    /// Peak and root mean square of the tracking error of each actuator, m or rad.
    pub(super) errors: Vec<Size>,
    /// Load on the motor of each drive train.
    pub(super) motors: Vec<MotorLoad>,
    pub(super) reactions: Reactions,
    /// Peak and root mean square of the effort of each gearing. The flag is true if the effort is
    /// statically determinate at all samples.
    pub(super) gearings: Vec<(Size, bool)>,
    pub(super) loads: Vec<Size>,
    pub(super) closure: Size,
    pub(super) energy_error: Size,
    /// Kinetic energy plus the magnitude of the potential energy, J. The peak determines the size
    /// of rounding errors in the energy balance.
    energies: Size,
    ranges: Ranges,
}

/// Largest acceptable relative energy error of event-driven integration, as a multiple of the
/// tolerance of a step. The errors of thousands of events accumulate, and singular positions
/// amplify rounding errors.
const LOST: f64 = 1e5;
/// Largest acceptable relative energy error of time stepping, as a multiple of the tolerance of a
/// step. Time stepping is of first order at dense transitions and with bristle or regularised laws, so its energy
/// error exceeds the tolerance of a step by far.
const LOST_IN_STEPS: f64 = 3e4;
/// Largest relative energy error that any tolerance explains.
const LOST_AT_MOST: f64 = 0.01;

/// Sticking time and number of stick onsets of a friction interface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sticking {
    /// Total time during which the interface sticks, s.
    pub(super) time: f64,
    /// Number of stick onsets of the interface.
    pub(super) stops: usize,
}

impl Summary {
    /// Creates the summary of a job before its first sample.
    pub fn new(job: &Job<'_>) -> Self {
        let layout = Layout::new(job);
        let (drives, joints, interfaces) =
            (layout.names.drives.len(), layout.names.joints.len(), layout.names.interfaces.len());
        let gearings = layout.names.gearings.len();
        Self {
            motors: vec![MotorLoad::default(); layout.motors.trains().count()],
            layout,
            first: None,
            last: Rows::default(),
            samples: 0,
            drives: vec![Size::default(); drives],
            errors: vec![Size::default(); drives],
            reactions: Reactions::new(joints),
            gearings: vec![(Size::default(), true); gearings],
            loads: vec![Size::default(); interfaces],
            closure: Size::default(),
            energy_error: Size::default(),
            energies: Size::default(),
            ranges: Ranges::new(&job.model.mechanism),
        }
    }

    /// Returns the sticking time and the stick onsets of each friction interface until the last
    /// sample.
    pub(super) fn sticking(&self, events: &[Event]) -> Vec<Sticking> {
        let Some(first) = &self.first else { return Vec::new() };
        let mut since: Vec<Option<f64>> = first
            .friction
            .chunks_exact(6)
            .map(|row| (row[5] == 1.0).then_some(first.time))
            .collect();
        let mut all = vec![Sticking::default(); since.len()];
        for event in events {
            match event.kind {
                EventKind::Sticks { interface, .. } => {
                    all[interface].stops += 1;
                    since[interface].get_or_insert(event.time);
                }
                EventKind::Slides { interface, .. } => {
                    if let Some(begun) = since[interface].take() {
                        all[interface].time += event.time - begun;
                    }
                }
                _ => {}
            }
        }
        for (sticking, since) in all.iter_mut().zip(since) {
            sticking.time += since.map_or(0.0, |begun| (self.last.time - begun).max(0.0));
        }
        all
    }

    /// Returns the times of the first and the last sample, s.
    pub(super) fn span(&self) -> (f64, f64) {
        (self.first.as_ref().map_or(0.0, |first| first.time), self.last.time)
    }

    /// Returns one value for each friction interface: true if the interface sticks at the first
    /// sample.
    pub fn at_rest_first(&self) -> Vec<bool> {
        let first = self.first.iter().flat_map(|rows| rows.friction.chunks_exact(6));
        first.map(|row| row[5] == 1.0).collect()
    }

    /// Returns the terms of the energy balance at the last sample.
    pub(super) fn account(&self) -> Account<'_> {
        let (drives, interfaces) = (self.drives.len(), self.loads.len());
        let last = self.last.energy.as_slice();
        let start = |k: usize| self.first.as_ref().map_or(0.0, |first| first.energy[k]);
        let at = |k: usize| last.get(k).copied().unwrap_or(0.0);
        let changes = usize::from(self.layout.has_payload_changes);
        let first = 4 + 2 * changes + drives;
        Account {
            kinetic: (start(0), at(0)),
            potential: (start(1), at(1)),
            drives: last.get(2..2 + drives).unwrap_or(&[]),
            loads: at(2 + drives),
            dampers: at(3 + drives),
            payloads: self.layout.has_payload_changes.then(|| (at(4 + drives), at(5 + drives))),
            interfaces: last.get(first..first + interfaces).unwrap_or(&[]),
            turnover: at(first + 1 + interfaces),
        }
    }

    /// Returns the content of `summary.json`.
    pub fn json(&self, job: &Job<'_>, outcome: &Outcome) -> Value {
        let names = &self.layout.names;
        let account = self.account();
        let sticking = self.sticking(&outcome.events);
        let mut drives = Map::new();
        for (k, (name, unit)) in names.drives.iter().enumerate() {
            let dof = &self.layout.dofs[self.layout.dof_of_actuator[k]];
            let at_end = self.last.forward.as_slice();
            let motion = (!at_end.is_empty())
                .then(|| self.layout.motion_in(at_end, self.layout.dof_of_actuator[k]));
            drives.insert(
                name.clone(),
                json!({
                    "unit": unit,
                    "drive": self.drives[k].json(),
                    "work": account.drives.get(k),
                    "error": self.layout.reference[k].then(|| self.errors[k].json()),
                    "error_unit": self.layout.reference[k].then(|| dof.units()[0]),
                    "position_at_end": motion.map(|m| m[0]),
                    "rate_at_end": motion.map(|m| m[1]),
                }),
            );
        }
        let trains = self.layout.motors.trains().zip(&self.motors);
        let actuators: Map<String, Value> = trains
            .map(|(train, load)| (train.name.clone(), Value::Object(load.json(train))))
            .collect();
        let mut friction = Map::new();
        for (k, (name, _)) in names.interfaces.iter().enumerate() {
            friction.insert(
                name.clone(),
                json!({
                    "load": self.loads[k].json(),
                    "dissipated": account.interfaces.get(k),
                    "sticks": sticking.get(k).map(|s| s.time),
                    "stops": sticking.get(k).map(|s| s.stops),
                }),
            );
        }
        let (ended, why) = match &outcome.ending {
            Ending::Reached => ("reached", None),
            Ending::Stopped(condition) => ("stopped", Some(condition.clone())),
            Ending::Interrupted => ("interrupted", None),
            Ending::Failed(error) => ("failed", Some(error.to_string())),
        };
        let [by_events, in_steps] = methods(&outcome.events, self.span());
        let turnover = account.turnover;
        let error = self.energy_error.peak.abs();
        // Time stepping does not examine uniqueness.
        let is_examined = in_steps == 0.0 || !job.friction;
        let is_unique = |other: &dyn Fn(&EventKind) -> bool| -> Option<bool> {
            let is_other = outcome.events.iter().any(|event| other(&event.kind));
            (is_other || is_examined).then_some(!is_other)
        };
        let shares = |event: &Event| matches!(event.kind, EventKind::SharesNotUnique { .. });
        let slides = |event: &Event| matches!(event.kind, EventKind::Slides { .. });
        // A slip onset depends on the rule that distributes static friction, if this is not unique.
        let mut after_shares = outcome.events.iter().skip_while(|event| !shares(event));
        let by_rule = after_shares.any(slides);
        let is_motion_unique = is_unique(&|kind| matches!(kind, EventKind::NotUnique { .. }));
        let is_motion_unique = is_motion_unique.filter(|unique| !unique || !by_rule);
        let others: Vec<Value> =
            outcome.events.iter().filter_map(|event| self.others(event)).collect();
        let mut value = json!({
            "program": { "name": "stiction", "version": env!("CARGO_PKG_VERSION") },
            "model": { "name": job.model.name, "title": job.model.title },
            "options": {
                "motion": job.motion.map(|_| &job.motion_name),
                "load": job.load_name,
                "drives": job.drives_name,
                "controller": job.is_controlled().then_some(&job.control_name),
                "friction": if job.friction { "on" } else { "off" },
                "from": job.from,
                "until": job.until,
                "step": job.step,
                "stop": self.layout.stops,
                "method": method_name(job.settings.method),
                "relative_tolerance": job.settings.relative,
                "absolute_tolerance": job.settings.absolute,
                "time_step_tolerance": job.settings.time_step_tolerance,
            },
            "cautions": self.cautions(job, outcome),
            "units": "SI: s, m, rad, kg, N, N m, J, W",
            "ended": ended,
            "ended_because": why,
            "last_time": self.last.time,
            "samples": self.samples,
            "drives": drives,
            "joints": self.reactions.json(&names.joints),
            "friction": friction,
            "energy": {
                "kinetic": { "start": account.kinetic.0, "end": account.kinetic.1 },
                "potential": { "start": account.potential.0, "end": account.potential.1 },
                "drives": account.drives.iter().sum::<f64>(),
                "loads": account.loads,
                "dampers": account.dampers,
                "interfaces": account.interfaces.iter().sum::<f64>(),
                "error": error,
                "turnover": turnover,
                "error_relative": self.energy_error_relative(),
                "closes": self.energy_lost(&job.settings, &outcome.events).is_none(),
            },
            "method": { "event_driven": by_events, "time_stepping": in_steps },
            "events": self.count_events(&outcome.events),
            "verdicts": {
                "shares_unique": is_unique(&|kind| matches!(kind, EventKind::SharesNotUnique { .. })),
                "motion_unique": is_motion_unique,
                "other_motions": others,
                "start_rates_as_asked": !outcome.rates_changed,
                "redundant": outcome.redundant,
                "drives_unique": outcome.open_drives == 0,
                "closure": self.closure.peak,
                "evaluations": outcome.evaluations,
                "coarsest_step": outcome.coarsest.max(job.settings.relative),
            },
        });
        // Only runs in which a part is picked up or placed have these entries.
        if let Some((brought, lost)) = account.payloads {
            (value["energy"]["payloads"], value["energy"]["impacts"]) =
                (json!(brought), json!(lost));
        }
        // Only controlled simulations have this entry.
        if job.control.is_some() {
            value["verdicts"]["controller"] = outcome.tuning.json();
        }
        // Only models with gearings have this entry.
        if !self.gearings.is_empty() {
            value["gearings"] = gearings_json(&names.gearings, &self.gearings);
        }
        // Only models with drive trains have this entry.
        if !actuators.is_empty() {
            value["actuators"] = Value::Object(actuators);
        }
        value
    }

    /// Returns the magnitude, J, below which an energy counts as a rounding error.
    pub(super) fn rounding(&self) -> f64 {
        1e-13 * self.energies.peak.abs()
    }

    /// Returns the relative error of the energy balance; `None` if no energy is exchanged.
    pub(super) fn energy_error_relative(&self) -> Option<f64> {
        let turnover = self.account().turnover;
        (turnover > self.rounding()).then(|| self.energy_error.peak.abs() / turnover)
    }

    /// Returns the relative error of the energy balance if the tolerance of the integration scheme
    /// cannot explain it, so that the results are unreliable. `None` otherwise.
    pub fn energy_lost(&self, settings: &Settings, events: &[Event]) -> Option<f64> {
        let [_, in_steps] = methods(events, self.span());
        let most = match in_steps > 0.0 {
            true => LOST_IN_STEPS * settings.time_step_tolerance,
            false => LOST * settings.relative,
        };
        let most = most.min(LOST_AT_MOST);
        // In a run almost without motion, the exchanged energies are as small as rounding errors.
        let matters = self.energy_error.peak.abs() > 1e3 * self.rounding();
        self.energy_error_relative().filter(|part| *part > most && matters)
    }

    /// Returns the other possible motions as JSON if `event` reports that the solution is not
    /// unique; `None` for other events.
    fn others(&self, event: &Event) -> Option<Value> {
        let EventKind::NotUnique { joint, coupling, others } = &event.kind else { return None };
        let names = &self.layout.names;
        let each = others.iter().map(|other| {
            let loads = names.interfaces.iter().zip(&other.loads);
            let loads: Map<String, Value> =
                loads.map(|((name, _), load)| (name.clone(), json!(load))).collect();
            json!({ "loads": loads })
        });
        Some(json!({
            "time": event.time,
            "joint": names.joints[joint.0],
            "coupling": coupling,
            "others": each.collect::<Vec<_>>(),
        }))
    }

    /// Describes all events in chronological order, including excursions of joints beyond their
    /// ranges.
    pub(super) fn described(&self, events: &[Event]) -> Vec<DescribedEvent> {
        let mut described = describe_all(&self.layout, self.at_rest_first(), events);
        if self.ranges.all.is_empty() {
            return described;
        }
        for watched in &self.ranges.all {
            let detail = watched.limits_in_words();
            for excursion in &watched.excursions {
                let side = if excursion.above { "above" } else { "below" };
                let mut describe = |time: f64, what: &'static str| {
                    let (at, detail) = (watched.name.clone(), format!("{side} {detail}"));
                    described.push(DescribedEvent { time, what, at, detail });
                };
                describe(excursion.from, "leaves-range");
                if excursion.returns {
                    describe(excursion.until, "returns-to-range");
                }
            }
        }
        described.sort_by(|a, b| a.time.total_cmp(&b.time));
        described
    }

    /// Returns warnings about the samples of the recorded motion, about quantities that leave their
    /// ranges, and about the loads on the motors.
    pub(super) fn cautions(&self, job: &Job<'_>, outcome: &Outcome) -> Vec<String> {
        let trains = self.layout.motors.trains().zip(&self.motors);
        let motors = trains.flat_map(|(train, load)| load.cautions(train));
        let unstable = job.control.and_then(|control| outcome.tuning.caution(control.period));
        job.cautions()
            .into_iter()
            .chain(self.ranges.cautions())
            .chain(motors)
            .chain(unstable)
            .collect()
    }

    /// Returns the number of events of each kind as a JSON object.
    fn count_events(&self, events: &[Event]) -> Value {
        let described = self.described(events);
        let kinds = [
            "sticks",
            "slides",
            "reverses",
            "shares-not-unique",
            "not-unique",
            "singular",
            "method",
            "jump",
            "leaves-range",
            "returns-to-range",
        ];
        let count = |kind: &str| described.iter().filter(|event| event.what == kind).count();
        Value::Object(kinds.map(|kind| (kind.to_owned(), json!(count(kind)))).into_iter().collect())
    }
}

impl Sink<Rows> for Summary {
    fn add(&mut self, rows: &Rows) -> Result<(), SinkError> {
        let time = rows.time;
        self.first.get_or_insert_with(|| rows.clone());
        self.last.clone_from(rows);
        self.samples += 1;
        for actuator in 0..self.drives.len() {
            let (drive, reference) = self.layout.drive_in(&rows.forward, actuator);
            self.drives[actuator].add(time, drive);
            if let Some(reference) = reference {
                let dof = self.layout.dof_of_actuator[actuator];
                let position = self.layout.motion_in(&rows.forward, dof)[0];
                self.errors[actuator].add(time, position - reference);
            }
        }
        let motors = self.layout.motors.read(self.layout.motors_in(&rows.forward));
        for (load, (torque, speed)) in self.motors.iter_mut().zip(motors) {
            load.add(time, torque, speed);
        }
        let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let joints = (7 * self.layout.names.joints.len()).min(rows.reactions.len());
        let (reactions, gearings) = rows.reactions.split_at(joints);
        for ((size, all), row) in self.gearings.iter_mut().zip(gearings.chunks_exact(2)) {
            size.add(time, row[0]);
            *all &= row[1] == 1.0;
        }
        let reactions = reactions.chunks_exact(7);
        self.reactions.add(time, reactions.map(|row| (length(&row[..3]), length(&row[3..6]))));
        for (load, row) in self.loads.iter_mut().zip(rows.friction.chunks_exact(6)) {
            load.add(time, row[1]);
        }
        let layout = &self.layout;
        self.ranges.add(
            time,
            |of| layout.measured_in(&rows.forward, of),
            |joint, index| {
                let dofs = &layout.dofs;
                let place = dofs.iter().position(|dof| (dof.joint, dof.index) == (joint, index))?;
                let motion = layout.motion_in(&rows.forward, place);
                Some((motion[0], Some(motion[1])))
            },
        );
        self.closure.add(time, rows.forward.last().copied().unwrap_or(0.0));
        self.energy_error.add(time, rows.energy[rows.energy.len() - 2]);
        self.energies.add(time, rows.energy[0] + rows.energy[1].abs());
        Ok(())
    }
}

/// Terms of the energy balance, J. Kinetic and potential energy are values at the first and at the
/// last sample; all other terms are totals from the start to the last sample.
pub(super) struct Account<'a> {
    pub(super) kinetic: (f64, f64),
    pub(super) potential: (f64, f64),
    pub(super) drives: &'a [f64],
    pub(super) loads: f64,
    pub(super) dampers: f64,
    /// Energy added by payload changes, and energy dissipated in impacts with payloads, J; `None`
    /// if no payload changes.
    pub(super) payloads: Option<(f64, f64)>,
    pub(super) interfaces: &'a [f64],
    pub(super) turnover: f64,
}
