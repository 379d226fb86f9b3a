//! Plots of a run of inverse dynamics.

use super::contributions::ShareCurves;
use super::motor_curves::MotorCurves;
use super::sample::Sample;
use crate::by_leg::ByLeg;
use crate::in_space::{SpaceCurves, tracked};
use crate::job::Job;
use crate::names::{Names, legs_of_actuators, legs_of_interfaces};
use crate::{Sink, SinkError};
use stiction_core::dynamics::{FrictionMode, InterfaceForce};
use stiction_draw::figure::meaning::{
    CONSTRAINT, ENERGY, FRICTION, LIMIT, LOAD, OF_LEG, REFERENCE, RESULT,
};
use stiction_draw::figure::{BandTrace, Figure, JumpTrace, Panel, Trace, reversal};

/// Collects the curves of an inverse dynamics run, sample by sample.
#[derive(Clone, Debug)]
pub struct Curves {
    names: Names,
    /// Index of the leg of each actuator; `None` for actuators outside the legs.
    legs: Vec<Option<usize>>,
    /// Index of the leg of each friction interface; `None` for interfaces outside the legs.
    interface_legs: Vec<Option<usize>>,
    has_friction: bool,
    title: String,
    drives: Vec<(JumpTrace, Trace)>,
    /// For each actuator, the interval of possible efforts at samples at which joints are at rest.
    intervals: Vec<BandTrace>,
    friction: ByLeg,
    power: [Trace; 4],
    distances: [Trace; 2],
    /// Time, s, and sliding velocities of the friction interfaces, m/s, at the last added sample.
    last: Option<(f64, Vec<f64>)>,
    shares: ShareCurves,
    motors: MotorCurves,
    space: SpaceCurves,
}

impl Curves {
    /// Creates empty curves with room for `count` samples.
    pub fn new(job: &Job<'_>, count: usize) -> Self {
        let names = Names::new(&job.model.mechanism);
        let trace = Trace::new(count);
        Self {
            has_friction: job.friction != FrictionMode::Off && !names.interfaces.is_empty(),
            title: format!("{} - {}, load {}", job.model.name, job.motion_name, job.load_name),
            drives: vec![(JumpTrace::new(count), trace.clone()); names.drives.len()],
            intervals: vec![BandTrace::new(count); names.drives.len()],
            friction: ByLeg::new(job.model, &names, count),
            power: std::array::from_fn(|_| trace.clone()),
            distances: [trace.clone(), trace],
            last: None,
            shares: ShareCurves::new(&names, count),
            motors: MotorCurves::new(job, count),
            space: SpaceCurves::new(tracked(job.model, Some(job.motion)), false, count),
            legs: legs_of_actuators(&job.model.mechanism),
            interface_legs: legs_of_interfaces(&job.model.mechanism, &names),
            names,
        }
    }

    /// Names of the files of the figures of all runs, without extension.
    pub const FILES: [&'static str; 7] =
        ["drives", "path", "motors", "friction", "contributions", "power", "singularity"];

    /// Returns all figures, each with the name of its file without extension.
    pub fn figures(self) -> Vec<(&'static str, Figure)> {
        let x_label = "time [s]".to_owned();
        let mut figures = Vec::new();

        let mut panels = Vec::new();
        let drives = self.drives.into_iter().zip(self.intervals);
        let drives = self.names.drives.iter().zip(drives).zip(&self.legs);
        for (((name, unit), ((with, without), interval)), &leg) in drives {
            let lines = if self.has_friction {
                vec![
                    without.line("frictionless", REFERENCE, true),
                    with.line("with friction", OF_LEG, false),
                ]
            } else {
                vec![without.line("effort", OF_LEG, false)]
            };
            let bands = interval.band("possible at rest", LIMIT).into_iter().collect();
            panels.push(Panel {
                y_label: format!("{name} [{unit}]"),
                lines,
                bands,
                leg,
                ..Panel::default()
            });
        }
        if !panels.is_empty() {
            let title = format!("Actuator efforts: {}", self.title);
            figures.push(("drives", Figure { title, x_label: x_label.clone(), panels }));
        }

        figures.extend(self.space.figures(&self.title));
        figures.extend(self.motors.figure(&self.title).map(|figure| ("motors", figure)));
        if self.has_friction {
            let colours = self.friction.colours();
            let panels = self.friction.panels(&self.names, "N");
            let title = format!("Friction forces at the friction interfaces: {}", self.title);
            figures.push(("friction", Figure { title, x_label: x_label.clone(), panels }));
            if !self.names.drives.is_empty() {
                let title = format!("Friction contributions to the efforts: {}", self.title);
                let legs = (&self.legs[..], &self.interface_legs[..]);
                let figure =
                    self.shares.figure(&self.names, legs, &colours, title, x_label.clone());
                figures.push(("contributions", figure));
            }
        }

        let labels = [
            ("actuators", RESULT),
            ("loads", LOAD),
            ("rate of energy", ENERGY),
            ("dissipated", FRICTION),
        ];
        let lines = labels.iter().zip(self.power);
        let lines =
            lines.map(|((label, colour), trace)| trace.line(label, *colour, false)).collect();
        let panel = Panel { y_label: "power [W]".to_owned(), lines, ..Panel::default() };
        let panels = vec![panel.without_zeros()];
        let title = format!("Power balance: {}", self.title);
        figures.push(("power", Figure { title, x_label: x_label.clone(), panels }));
        let [actuation, constraint] = self.distances;
        let lines = vec![
            actuation.line("actuation", RESULT, false),
            constraint.line("constraint", CONSTRAINT, true),
        ];
        let panels =
            vec![Panel { y_label: "singularity index".to_owned(), lines, ..Panel::default() }];
        let title = format!("Singularity indices, zero is singular: {}", self.title);
        figures.push(("singularity", Figure { title, x_label, panels }));
        debug_assert!(figures.iter().all(|(name, _)| Self::FILES.contains(name)));
        figures
    }
}

impl Sink<Sample> for Curves {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let (time, forces) = (sample.time, &sample.forces);
        self.space.add(|body| sample.bodies.pose[body].position + sample.origin);
        let velocities: Vec<f64> =
            forces.interfaces.iter().map(|interface| interface.velocity).collect();
        // Time of the first velocity reversal of an interface since the previous sample. Efforts
        // may jump at this time.
        let crossing = self.last.as_ref().and_then(|(before, known)| {
            let pairs = known.iter().zip(&velocities);
            let all = pairs.filter_map(|(v0, v1)| reversal((*before, *v0), (time, *v1)));
            all.reduce(f64::min)
        });
        let rests: Vec<bool> = forces.effort_bounds.iter().map(|(low, high)| high > low).collect();
        for (k, (with, without)) in self.drives.iter_mut().enumerate() {
            let smooth = forces.efforts_frictionless[k];
            let (low, high) = forces.effort_bounds[k];
            with.push(time, smooth, forces.efforts[k] - smooth, rests[k], crossing);
            without.push(time, smooth);
            self.intervals[k].push(time, rests[k].then_some((low, high)));
        }
        self.last = Some((time, velocities));
        self.shares.add(time, &sample.shares, &rests, crossing);
        let rests = |interface: &InterfaceForce| !interface.slides && interface.limit > 0.0;
        let frictions = forces.interfaces.iter();
        self.friction.add(time, frictions.map(|own| (own.velocity, own.friction, rests(own))));
        self.motors.add(&sample.motors);
        let power = &forces.power;
        for (trace, value) in self.power.iter_mut().zip([
            power.actuators,
            power.loads,
            power.energy,
            power.dissipated,
        ]) {
            trace.push(time, value);
        }
        for (trace, value) in
            self.distances.iter_mut().zip([sample.distances.actuation, sample.distances.constraint])
        {
            trace.push(time, value);
        }
        Ok(())
    }
}
