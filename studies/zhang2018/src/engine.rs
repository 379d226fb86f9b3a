//! Results of the general engine for the two gallery models, in the notation of the paper.

use super::Error;
use super::friction::OfJoints;
use super::reactions::{OF_LEG, unknown};
use serde_json::Value;
use stiction_core::dynamics::{FrictionMode, Power, Settings};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::spatial::Vec3;
use stiction_draw::figure::Figure;
use stiction_format::{ModelFile, Source, gallery, read};
use stiction_run::inverse::{self, Curves, Phase, Summary, Verdict};
use stiction_run::{Error as RunError, Job, Sink};

/// Loads a model of the gallery.
pub(super) fn model(name: &str) -> Result<ModelFile, Error> {
    let text = gallery::get(name).ok_or_else(|| Error::Gallery(name.to_owned()))?;
    let no_files = |file: &str| Err(format!("{file}: the gallery reads no files"));
    read(&Source::new(name, text), &no_files).map_err(|_| Error::Gallery(name.to_owned()))
}

/// Builds a job on a gallery model with the given motion and load.
pub(super) fn job<'a>(
    model: &'a ModelFile,
    motion: &str,
    load: &str,
    friction: FrictionMode,
) -> Result<Job<'a>, Error> {
    let missing = || Error::Gallery(model.name.clone());
    let motion = (motion, model.motion(motion).ok_or_else(missing)?);
    let load = (load, model.load(load).ok_or_else(missing)?);
    Ok(Job { friction, ..Job::new(model, motion, load) })
}

/// Engine results at one instant.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub(super) time: f64,
    pub(super) drives: [f64; 3],
    pub(super) ideal: [f64; 3],
    /// The 14 unknowns of equations (22) to (27) for each leg, in the leg's axes.
    pub(super) unknowns: [[f64; OF_LEG]; 3],
    pub(super) power: Power,
}

/// Results along a motion.
pub(super) struct Run {
    pub(super) samples: Vec<Sample>,
    pub(super) verdict: Verdict,
    /// Contents of `summary.json`.
    pub(super) summary: Value,
    /// Plots of `stiction inverse`.
    pub(super) figures: Vec<(&'static str, Figure)>,
}

impl Run {
    /// Runs a job on one of the two robots.
    pub(super) fn of(
        job: &Job<'_>,
        mut progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Self, Error> {
        let count = job.instants().map_err(RunError::from)?.count();
        let mut summary = Summary::new(job);
        let mut curves = Curves::new(job, count);
        let mut samples = Vec::with_capacity(count);
        let mechanism = &job.model.mechanism;
        let verdict = job.run(
            |sample| {
                (&mut summary, &mut curves).add(sample)?;
                samples.push(of_sample(sample, mechanism)?);
                Ok(())
            },
            &mut progress,
        )?;
        let summary = summary.json(job, &verdict);
        Ok(Self { samples, verdict, summary, figures: curves.figures() })
    }
}

/// Joints of leg n, in the order of the model's chain.
fn joints(mechanism: &Mechanism, n: usize) -> Result<[JointId; 3], Error> {
    let id = |joint: &str| {
        let found = mechanism.joint_id(&format!("leg{}.{joint}", n + 1));
        found.ok_or_else(|| Error::Gallery(mechanism.name().to_owned()))
    };
    Ok([id("R")?, id("P")?, id("S")?])
}

/// The first three values of a slice.
fn three<T: Copy>(values: &[T], mechanism: &Mechanism) -> Result<[T; 3], Error> {
    match *values {
        [a, b, c, ..] => Ok([a, b, c]),
        _ => Err(Error::Gallery(mechanism.name().to_owned())),
    }
}

fn of_sample(sample: &inverse::Sample, mechanism: &Mechanism) -> Result<Sample, Error> {
    let forces = &sample.forces;
    let mut unknowns = [[0.0; OF_LEG]; 3];
    for n in 0..3 {
        let ids = joints(mechanism, n)?;
        let [r, p, s] = ids.map(|id| forces.reactions[id.0]);
        // Axes of the P joint's frame in the leg: t, y, u.
        let frame = sample.bodies.frame_j[ids[1].0].rotation;
        let [t, y, u] = [0, 1, 2].map(|k| frame * Vec3::unit(k));
        let of = &mut unknowns[n];
        for (i, axis) in [t, y, u].into_iter().enumerate() {
            of[unknown::FR + i] = r.0.dot(axis);
            of[unknown::MP + i] = p.1.dot(axis);
            // The paper states the reaction on the rod.
            of[unknown::FS + i] = -s.0.dot(axis);
        }
        for (i, axis) in [t, u].into_iter().enumerate() {
            of[unknown::MR + i] = r.1.dot(axis);
        }
        for (i, axis) in [t, y].into_iter().enumerate() {
            of[unknown::FP + i] = p.0.dot(axis);
        }
        of[unknown::TAU] = forces.efforts[n];
    }
    Ok(Sample {
        time: sample.time,
        drives: three(&forces.efforts, mechanism)?,
        ideal: three(&forces.efforts_frictionless, mechanism)?,
        unknowns,
        power: forces.power,
    })
}

/// Leg lengths and the rates of the P, R and S joints of each leg along a job's motion.
pub(super) fn positions(job: &Job<'_>) -> Result<Vec<(f64, [f64; 3], OfJoints)>, Error> {
    let instants = job.instants().map_err(RunError::from)?;
    let mut follower = job.assemble(instants.at(0))?;
    let mut all = Vec::with_capacity(instants.count());
    for time in instants.iter() {
        follower.go_to(time)?;
        let solver = &follower.solver;
        let (topology, bodies) = (solver.topology(), solver.bodies());
        let (mut lengths, mut rates) = ([0.0; 3], [[0.0; 3]; 3]);
        for n in 0..3 {
            let [r, p, s] = joints(solver.mechanism(), n)?;
            let rate = |joint: JointId, dof: usize| {
                bodies.joint_rates(topology, joint.0).get(dof).copied()
            };
            lengths[n] = solver.joint_coordinates(p).first().copied().unwrap_or(f64::NAN);
            // A ball joint's rate about its y axis, which is parallel to all R axes.
            let all = [rate(p, 0), rate(r, 0), rate(s, 1)].map(|rate| rate.unwrap_or(f64::NAN));
            rates[n] = all;
        }
        all.push((time, lengths, rates));
    }
    Ok(all)
}

/// Intervals of the actuator forces that static friction leaves undetermined at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    /// Inner bounds of each actuator force, N: lower and upper.
    pub(super) attained: [(f64, f64); 3],
    /// Guaranteed bounds of each actuator force, N.
    pub(super) outer: [(f64, f64); 3],
}

impl Interval {
    /// Largest gap between the inner and the guaranteed bounds, N.
    pub(super) fn beyond(&self) -> f64 {
        let pairs = self.attained.iter().zip(&self.outer);
        pairs.map(|(a, o)| (a.0 - o.0).max(o.1 - a.1)).fold(0.0, f64::max)
    }
}

/// Actuator force intervals at one instant.
pub(super) fn interval(job: &Job<'_>, time: f64, rest_speed: f64) -> Result<Interval, Error> {
    let mut solver = job.assemble(time)?.solver;
    *solver.settings_mut() = Settings { friction: job.friction, rest_speed, ..Settings::default() };
    let mut loads = Vec::new();
    job.loads_at(time, &mut loads)?;
    solver.solve(&loads).map_err(|error| RunError::Forces { time, error })?;
    let forces = solver.forces();
    Ok(Interval {
        attained: three(&forces.effort_bounds, solver.mechanism())?,
        outer: three(&forces.effort_outer_bounds, solver.mechanism())?,
    })
}
