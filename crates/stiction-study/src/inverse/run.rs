//! A mechanism carried along a motion under a load.

use super::certainty::{Asked, Certainty, Margin, OtherSolutions};
use super::chunks::{self, Work};
use super::efficiency::{Backward, look_back};
use super::uniqueness::{Singular, Uniqueness};
use crate::{Instants, InstantsError};
use stiction::dynamics::Weighting;
use stiction::dynamics::{
    AppliedLoad, Forces, FrictionMode, InverseDynamics, InverseError, Mirror, Settings, Shares,
};
use stiction::friction::ContactShape;
use stiction::kinematics::{AssemblyError, Bodies, Coordinate, Target};
use stiction::mechanism::Mechanism;
use stiction::mobility::{Constraints, Distances};
use stiction::spatial::Vec3;
use stiction_model::{Diagnostic, LoadCase, Model, Motion};
use thiserror::Error;

/// What is to be computed.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its motion.
    pub motion: &'a Motion,
    /// How the motion is called.
    pub motion_name: String,
    /// The load.
    pub load: &'a LoadCase,
    /// How the load is called.
    pub load_name: String,
    /// How friction is coupled.
    pub friction: FrictionMode,
    /// Time between samples, s, if it is not left to the motion.
    pub step: Option<f64>,
    /// Whether to find out how far friction can grow before it locks the mechanism.
    pub friction_margin: bool,
}

/// Everything about one instant.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Time, s.
    pub time: f64,
    /// All forces.
    pub forces: &'a Forces,
    /// Poses, twists and accelerations of all bodies, in world axes about the kernel origin.
    pub bodies: &'a Bodies<f64>,
    /// The kernel origin in the world, m.
    pub origin: Vec3<f64>,
    /// The loads from outside.
    pub loads: &'a [AppliedLoad<f64>],
    /// The largest loop-closure error, m (angles times the characteristic length).
    pub closure: f64,
    /// Distances to singular positions.
    pub distances: Distances,
    /// For each joint and each component of its reaction (force, then moment) whether the balance
    /// alone determines it.
    pub determined_reactions: &'a [[bool; 6]],
    /// For each contact whether its load is determined.
    pub determined_loads: &'a [bool],
    /// For each drive whether it is determined.
    pub determined_drives: &'a [bool],
    /// How strongly friction and reactions are coupled: below one there is no other solution. None
    /// where it is not known.
    pub coupling: Option<f64>,
    /// The factor by which all coefficients can grow before friction locks the mechanism, infinite if
    /// it does not; if that was asked for.
    pub friction_margin: Option<f64>,
    /// What each contact's friction causes of each drive.
    pub shares: &'a Shares<f64>,
    /// For each drive how the load drives it back; nothing without friction.
    pub backward: &'a [Backward],
}

/// What holds along the whole motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Number of samples.
    pub samples: usize,
    /// Freedoms that the constraints leave, the least along the motion, idle spins included.
    pub mobility: usize,
    /// Idle spins: rotations of bodies about their own axes that nothing determines.
    pub idle_spins: Vec<String>,
    /// Redundant constraints and actuators.
    pub redundancy: usize,
    /// What decides among the solutions; none where the careful path did.
    pub weighting: Option<Weighting>,
    /// Contacts that slide no faster than this count as resting, m/s.
    pub rest_speed: f64,
    /// How strongly friction and reactions are coupled, the most along the motion: below one there
    /// is no other solution than the one given. None where it is not known.
    pub coupling: Option<f64>,
    /// Pairs of neighbouring samples, s, between which the mechanism passes a singular position,
    /// where no finite driving force exists.
    pub passed_singularities: Vec<(f64, f64)>,
    /// Other solutions of friction and reactions that were found. Given is the one that is connected
    /// with no friction.
    pub other_solutions: Option<OtherSolutions>,
    /// How far friction can grow before it locks the mechanism, if that was asked for.
    pub friction_margin: Option<Margin>,
    /// Singular positions at samples, where the load could be carried nevertheless.
    pub singular: Option<Singular>,
}

/// What the job is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Following the motion.
    Motion,
    /// Computing forces.
    Forces,
}

/// What is missing where loads cannot be carried.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Where it was found first, and what.
    pub first: InverseError,
    /// The first instant, s.
    pub time: f64,
    /// The least and the greatest missing force or moment along the motion, and its unit.
    pub range: (f64, f64),
    /// N or N m.
    pub unit: &'static str,
    /// At how many samples.
    pub samples: usize,
    /// Of how many.
    pub of: usize,
}

/// Why a job has no result.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// There are no instants.
    #[error(transparent)]
    Instants(#[from] InstantsError),
    /// A formula of the motion or of the load has no finite value.
    #[error("{}", .0.message)]
    NotFinite(
        /// Which, when, and why.
        Box<Diagnostic>,
    ),
    /// The mechanism cannot be brought into a position.
    #[error("at t = {time} s: {error}")]
    Assembly {
        /// Time, s.
        time: f64,
        /// Why.
        error: AssemblyError,
    },
    /// There are no forces.
    #[error("at t = {time} s: {error}")]
    Forces {
        /// Time, s.
        time: f64,
        /// Why.
        error: InverseError,
    },
    /// The load cannot be carried.
    #[error("at t = {} s: {}", .0.time, .0.first)]
    CannotCarry(Box<Missing>),
    /// The samples could not be received.
    #[error("{0}")]
    Receiver(String),
    /// The job was stopped.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Whether the input cannot be used (rather than that the question has no answer).
    pub fn is_bad_input(&self) -> bool {
        matches!(
            self,
            Self::Instants(_)
                | Self::NotFinite(_)
                | Self::Assembly {
                    error: AssemblyError::Open { .. } | AssemblyError::AngleRange { .. },
                    ..
                }
        )
    }
}

/// Slower than this part of the fastest sliding speed of the motion is rest: reversals come out of
/// the arithmetic as 1e-16 of it, not as zero.
const REST: f64 = 1e-9;
/// Slower than this is rest whatever the motion, m/s: an atom's width in minutes. It tells where all
/// samples are reversals, as a single pose may be, and nothing in the motion is fast.
const STANDSTILL: f64 = 1e-12;

impl Job<'_> {
    /// The instants of the samples.
    ///
    /// # Errors
    /// See [`InstantsError`].
    pub fn instants(&self) -> Result<Instants, InstantsError> {
        Instants::of(self.motion, self.step)
    }

    /// Carries out the job; hands each sample to `receive`, and says how far it is to `progress`
    /// (phase, samples done, samples in all), which answers whether to go on.
    ///
    /// # Errors
    /// See [`enum@Error`].
    pub fn run(
        &self,
        receive: impl FnMut(&Sample<'_>) -> Result<(), String>,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Verdict, Error> {
        self.run_on(1, receive, progress)
    }

    /// The same on so many threads; `receive` and `progress` are called on this one. What comes out does
    /// not depend on their number.
    ///
    /// # Errors
    /// See [`enum@Error`].
    pub fn run_on(
        &self,
        threads: usize,
        mut receive: impl FnMut(&Sample<'_>) -> Result<(), String>,
        mut progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Verdict, Error> {
        let instants = self.instants()?;
        let count = instants.count();
        let mut start = self.assemble(instants.at(0))?;

        // First the motion alone: can it be followed, how fast does it slide.
        let mut pace = Pace { fastest: 0.0, mobility: usize::MAX };
        let following = Following { mobility_at: [0, count / 3, 2 * count / 3] };
        chunks::carry_out(self, &start, &following, threads, |range, piece: Pace| {
            pace.fastest = pace.fastest.max(piece.fastest);
            pace.mobility = pace.mobility.min(piece.mobility);
            range.into_iter().try_for_each(|k| go_on(progress(Phase::Motion, k + 1, count)))
        })?;

        let rest_speed = (REST * pace.fastest).max(STANDSTILL);
        *start.settings_mut() =
            Settings { friction: self.friction, rest_speed, ..Settings::default() };
        let spins = start.assembly().prescription().spins().len();
        let actuators = start.mechanism().actuators().count();
        // What the mechanism is meant to leave: what its actuators can govern.
        let meant = pace.mobility.min(actuators + spins);
        let verdict = Verdict {
            samples: count,
            mobility: pace.mobility,
            idle_spins: idle_spins(&start),
            redundancy: 0,
            weighting: start.weighting(),
            rest_speed,
            coupling: Some(0.0),
            passed_singularities: Vec::new(),
            other_solutions: None,
            friction_margin: None,
            singular: None,
        };
        let solving = Solving { job: self, uniqueness: Uniqueness::new(&start, meant) };
        let mut gathered = Gathered {
            verdict,
            origin: start.parameters().origin,
            sides: Sides::default(),
            last_distance: 1.0,
            certainty: Certainty::default(),
            missing: None,
            failed: None,
        };
        chunks::carry_out(self, &start, &solving, threads, |range, piece: Looks| {
            for look in piece.looks {
                gathered.take(start.mechanism(), look, &mut receive)?;
            }
            range.into_iter().try_for_each(|k| go_on(progress(Phase::Forces, k + 1, count)))
        })?;
        gathered.finish()
    }

    /// The mechanism at an instant.
    pub(crate) fn assemble(&self, time: f64) -> Result<InverseDynamics, Error> {
        let coordinates: Vec<Coordinate> =
            self.motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
        let mut targets =
            vec![Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; coordinates.len()];
        self.check_motion(time)?;
        self.targets_at(time, &mut targets);
        let (mechanism, homes) = (self.model.mechanism.clone(), &self.model.homes);
        InverseDynamics::new(mechanism, homes, &coordinates, &targets, Settings::default())
            .map_err(|error| Error::Assembly { time, error })
    }

    /// From one instant to the next.
    pub(crate) fn follow(
        &self,
        solver: &mut InverseDynamics,
        from: f64,
        to: f64,
    ) -> Result<(), Error> {
        self.check_motion(to)?;
        let followed = solver.follow(from, to, |t, targets| self.targets_at(t, targets));
        followed.or_else(|error| {
            // A recording may have failed on the way.
            self.check_motion(to)?;
            Err(Error::Assembly { time: to, error })
        })
    }

    fn targets_at(&self, time: f64, targets: &mut [Target<f64>]) {
        for (target, (_, course)) in targets.iter_mut().zip(&self.motion.coordinates) {
            *target = course.at(time);
        }
    }

    /// Why the motion has no value at an instant, if it has none.
    pub(crate) fn check_motion(&self, time: f64) -> Result<(), Error> {
        for (_, course) in &self.motion.coordinates {
            if let Some(fault) = course.fault_at(time) {
                return Err(Error::NotFinite(Box::new(fault)));
            }
        }
        Ok(())
    }

    pub(crate) fn loads_at(
        &self,
        time: f64,
        loads: &mut Vec<AppliedLoad<f64>>,
    ) -> Result<(), Error> {
        loads.clear();
        for wrench in &self.load.wrenches {
            for course in wrench.force.iter().chain(&wrench.moment) {
                if let Some(fault) = course.fault_at(time) {
                    return Err(Error::NotFinite(Box::new(fault)));
                }
            }
            loads.push(wrench.at(time));
        }
        Ok(())
    }
}

/// Follows the motion alone.
struct Following {
    /// Samples at which freedoms are counted.
    mobility_at: [usize; 3],
}

/// How fast contacts slide, and how many freedoms the constraints leave.
struct Pace {
    fastest: f64,
    mobility: usize,
}

impl Work for Following {
    type Piece = Pace;

    fn begin(&self) -> Pace {
        Pace { fastest: 0.0, mobility: usize::MAX }
    }

    fn look(
        &self,
        pace: &mut Pace,
        solver: &mut InverseDynamics,
        sample: usize,
        _time: f64,
    ) -> Result<(), Error> {
        pace.fastest = pace.fastest.max(fastest_contact(solver));
        if self.mobility_at.contains(&sample) {
            pace.mobility = pace.mobility.min(Constraints::new(&solver.statics()).mobility());
        }
        Ok(())
    }
}

/// Computes everything at each sample.
struct Solving<'a> {
    job: &'a Job<'a>,
    /// Room to begin with.
    uniqueness: Uniqueness,
}

/// What was found in a piece of the motion.
struct Looks {
    looks: Vec<Look>,
    uniqueness: Uniqueness,
    mirror: Mirror,
    has_failed: bool,
}

/// What was found at one sample.
struct Look {
    time: f64,
    found: Result<Box<Found>, InverseError>,
}

/// Everything about a sample at which there are forces.
struct Found {
    forces: Forces,
    bodies: Bodies<f64>,
    loads: Vec<AppliedLoad<f64>>,
    closure: f64,
    distances: Distances,
    redundancy: usize,
    determined_reactions: Vec<[bool; 6]>,
    determined_loads: Vec<bool>,
    determined_drives: Vec<bool>,
    is_singular: bool,
    singular: Option<Singular>,
    asked: Asked,
    shares: Shares<f64>,
    backward: Vec<Backward>,
    side: Option<f64>,
}

impl Work for Solving<'_> {
    type Piece = Looks;

    fn begin(&self) -> Looks {
        Looks {
            looks: Vec::new(),
            uniqueness: self.uniqueness.clone(),
            mirror: Mirror::default(),
            has_failed: false,
        }
    }

    fn look(
        &self,
        piece: &mut Looks,
        solver: &mut InverseDynamics,
        _sample: usize,
        time: f64,
    ) -> Result<(), Error> {
        let mut loads = Vec::new();
        self.job.loads_at(time, &mut loads)?;
        match solver.solve(&loads) {
            Err(error) => {
                piece.has_failed = true;
                piece.looks.push(Look { time, found: Err(error) });
            }
            // Where something failed nobody asks for the rest.
            Ok(_) if piece.has_failed => {}
            Ok(_) => {
                let found = self.find(piece, solver, loads, time);
                piece.looks.push(Look { time, found: Ok(Box::new(found)) });
            }
        }
        Ok(())
    }
}

impl Solving<'_> {
    /// Everything that is told of a solved sample.
    fn find(
        &self,
        piece: &mut Looks,
        solver: &mut InverseDynamics,
        loads: Vec<AppliedLoad<f64>>,
        time: f64,
    ) -> Found {
        let side = solver.side();
        let mut backward = Vec::new();
        if self.job.friction != FrictionMode::Off && !solver.forces().contacts.is_empty() {
            look_back(solver, &mut piece.mirror, &loads, &mut backward);
        }
        let shares = solver.shares().clone();
        let uniqueness = &mut piece.uniqueness;
        uniqueness.look(solver, time);
        let asked = Asked::of(solver, &loads, self.job.friction_margin);
        Found {
            forces: solver.forces().clone(),
            bodies: solver.bodies().clone(),
            loads,
            closure: solver.closure_error(),
            distances: uniqueness.distances,
            redundancy: uniqueness.redundancy,
            determined_reactions: uniqueness.reactions.clone(),
            determined_loads: uniqueness.loads.clone(),
            determined_drives: uniqueness.drives.clone(),
            is_singular: uniqueness.is_singular,
            singular: uniqueness.singular.take(),
            asked,
            shares,
            backward,
            side,
        }
    }
}

/// Everything along the motion so far.
struct Gathered {
    verdict: Verdict,
    origin: Vec3<f64>,
    sides: Sides,
    /// From the actuators' singular positions, at the last sample.
    last_distance: f64,
    certainty: Certainty,
    missing: Option<Missing>,
    failed: Option<(f64, InverseError)>,
}

impl Gathered {
    fn take(
        &mut self,
        mechanism: &Mechanism,
        look: Look,
        receive: &mut impl FnMut(&Sample<'_>) -> Result<(), String>,
    ) -> Result<(), Error> {
        let Look { time, found } = look;
        let verdict = &mut self.verdict;
        let found = match found {
            Ok(found) if self.missing.is_none() && self.failed.is_none() => found,
            Ok(_) => return Ok(()),
            Err(error) => {
                self.sides = Sides::default();
                match error {
                    InverseError::CannotCarry { .. } => {
                        add_missing(&mut self.missing, time, error, verdict.samples);
                    }
                    // What cannot be carried elsewhere says more about why.
                    _ => {
                        self.failed.get_or_insert((time, error));
                    }
                }
                return Ok(());
            }
        };
        let passage = self.sides.see(found.side, time);
        // In singular positions the side is that of rounding.
        if self.last_distance != 0.0 && found.distances.actuation > 0.0 {
            verdict.passed_singularities.extend(passage);
        }
        self.last_distance = found.distances.actuation;
        if found.is_singular {
            match &mut verdict.singular {
                Some(known) => known.samples += 1,
                None => verdict.singular.clone_from(&found.singular),
            }
        }
        self.certainty.add(mechanism, time, &found.asked);
        let coupling = found.asked.coupling;
        verdict.coupling = verdict.coupling.zip(coupling).map(|(a, b)| a.max(b));
        verdict.redundancy = verdict.redundancy.max(found.redundancy);
        let sample = Sample {
            time,
            forces: &found.forces,
            bodies: &found.bodies,
            origin: self.origin,
            loads: &found.loads,
            closure: found.closure,
            distances: found.distances,
            determined_reactions: &found.determined_reactions,
            determined_loads: &found.determined_loads,
            determined_drives: &found.determined_drives,
            coupling,
            friction_margin: found.asked.locks_at(),
            shares: &found.shares,
            backward: &found.backward,
        };
        receive(&sample).map_err(Error::Receiver)
    }

    fn finish(self) -> Result<Verdict, Error> {
        let Self { mut verdict, certainty, missing, failed, .. } = self;
        match (missing, failed) {
            (None, None) => {
                verdict.other_solutions = certainty.others;
                verdict.friction_margin = certainty.margin;
                Ok(verdict)
            }
            (Some(missing), None) => Err(Error::CannotCarry(Box::new(missing))),
            // A mechanism that locks before says more than one that is singular later.
            (Some(missing), Some((time, error @ InverseError::Locked { .. })))
                if missing.time > time =>
            {
                Err(Error::Forces { time, error })
            }
            (Some(missing), Some(_)) => Err(Error::CannotCarry(Box::new(missing))),
            (None, Some((time, error))) => Err(Error::Forces { time, error }),
        }
    }
}

/// Watches on which side of the singular positions of its actuators a mechanism is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sides {
    /// The last sample, s, and the side there.
    last: Option<(f64, f64)>,
}

impl Sides {
    /// Looks at the next sample; the two samples, s, between which the side changed.
    pub(crate) fn look(&mut self, solver: &mut InverseDynamics, time: f64) -> Option<(f64, f64)> {
        self.see(solver.side(), time)
    }

    /// The same with the side at the sample.
    fn see(&mut self, side: Option<f64>, time: f64) -> Option<(f64, f64)> {
        let now = side.map(|side| (time, side));
        let before = core::mem::replace(&mut self.last, now)?;
        (now?.1 != before.1).then_some((before.0, time))
    }
}

fn go_on(answer: bool) -> Result<(), Error> {
    if answer { Ok(()) } else { Err(Error::Interrupted) }
}

fn add_missing(missing: &mut Option<Missing>, time: f64, error: InverseError, of: usize) {
    let InverseError::CannotCarry { missing: amount, unit, .. } = error else { return };
    match missing {
        Some(known) => {
            known.samples += 1;
            if known.unit == unit {
                known.range = (known.range.0.min(amount), known.range.1.max(amount));
            }
        }
        None => {
            let range = (amount, amount);
            *missing = Some(Missing { first: error, time, range, unit, samples: 1, of });
        }
    }
}

/// The fastest sliding speed of any contact at the present motion, m/s.
fn fastest_contact(solver: &InverseDynamics) -> f64 {
    let (topology, bodies) = (solver.topology(), solver.bodies());
    let speed = |contact: &stiction::parameters::ContactParameters<f64>| {
        let rates = bodies.joint_rates(topology, contact.joint);
        let own = &rates[contact.shape.freedoms()];
        let arms = contact.arms(solver.parameters().pitch[contact.joint]);
        let length = |rates: &[f64]| rates.iter().map(|rate| rate * rate).sum::<f64>().sqrt();
        match contact.shape {
            ContactShape::Plate => length(&[own[0], own[1], own[2] * arms[2]]),
            _ => length(own) * arms[0],
        }
    };
    solver.parameters().contacts.iter().map(speed).fold(0.0, f64::max)
}

pub(crate) fn idle_spins(solver: &InverseDynamics) -> Vec<String> {
    let bodies = solver.mechanism().bodies();
    let spins = solver.assembly().prescription().spins();
    spins.iter().map(|spin| bodies[spin.body.0].name.clone()).collect()
}
