//! Closest approaches of a motion to singular poses, located between samples.

use crate::Error;
use crate::follower::Follower;
use crate::inverse::SINGULAR;
use std::fmt::Write as _;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::mechanism::Mechanism;
use stiction_core::mobility::{Mobility, blocked_motions};
use stiction_core::statics::{
    Constraints, Distances, GainedTwist, LeastIndex, SingularityDistances, Statics, least_index,
    leg_distance,
};

/// Kind of singularity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Actuation (type 2): a body can move while all actuators are locked.
    Actuation,
    /// Constraint: the mechanism gains a degree of freedom that its joints normally prevent.
    Constraint,
    /// Leg (type 1): bodies of a leg can move while the bodies at both ends of the leg are fixed.
    Leg,
}

impl Kind {
    /// All kinds, in the order of output.
    pub const ALL: [Self; 3] = [Self::Actuation, Self::Constraint, Self::Leg];

    /// Returns the name of this kind of singularity in outputs.
    pub fn word(self) -> &'static str {
        match self {
            Self::Actuation => "actuation",
            Self::Constraint => "constraint",
            Self::Leg => "leg",
        }
    }
}

/// Description of the motion that a mechanism gains at a singular pose, and of the load that the
/// mechanism cannot carry there.
#[derive(Clone, Debug, PartialEq)]
pub struct Weakness {
    /// Name of the body that moves in the gained motion.
    pub body: String,
    /// Description of the motion of this body.
    pub motion: String,
    /// Description of a load that does work on the gained motion. The mechanism cannot carry this
    /// load.
    pub load: String,
    /// Description of the motions that the body with the most joints can still perform at a leg
    /// singularity; `None` for other kinds of singularities.
    pub left: Option<String>,
}

/// Closest approach of a motion to singular poses of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearness {
    /// Least singularity index along the motion, located between samples.
    pub least: f64,
    /// Time of the least singularity index, s.
    pub time: f64,
    /// Least-constrained motion at the time of the least singularity index.
    pub weakness: Option<Weakness>,
    /// Number of samples at which the pose is singular.
    pub singular_samples: usize,
    /// Times, s, at which the motion passes through or touches a singular pose, with the motion gained there. Times
    /// within a sequence of singular samples are not included.
    pub crossings: Vec<(f64, Weakness)>,
    /// Number of further close approaches that were not examined, because too many occurred.
    pub not_searched: usize,
}

/// Largest number of close approaches of one kind that are examined. Each examination takes about
/// ten matrix decompositions.
const REFINED: usize = 100;
/// Singularity index above which a local minimum along the motion is not examined, unless it is the
/// least minimum found so far.
const NEAR: f64 = 0.05;
/// Singularity index below which a local minimum counts as a passage through a singular pose. The
/// search may not reach the singular pose itself, because the motion may be undetermined there.
const CROSSED: f64 = 1e-7;
/// Index above which a balance with as many unknowns as equations has full rank.
const REGULAR: f64 = 1e-3;
/// Largest number of bisection steps in the search for a passage.
const STEPS: usize = 60;

/// Mechanism and its singularity indices at one sample.
struct Sample<'a> {
    follower: Follower<'a>,
    distances: [Option<f64>; 3],
}

/// Monitor of the singularity indices along a motion.
pub(super) struct Watch<'a> {
    /// Finite mobility for which the mechanism is designed, including local degrees of freedom.
    mobility: usize,
    spins: usize,
    /// Fast calculator of the indices of actuation and constraints; `None` unless the mechanism has
    /// one actuator for each degree of freedom, and no redundancy.
    proximity: Option<SingularityDistances>,
    last: Option<Sample<'a>>,
    before_last: Option<Sample<'a>>,
    found: [Option<Nearness>; 3],
    /// Mechanism at the closest approach to each kind of singularity.
    nearest: [Option<InverseDynamics>; 3],
    refined: [usize; 3],
}

impl<'a> Watch<'a> {
    pub(super) fn new(mechanism: &Mechanism, mobility: usize, spins: usize) -> Self {
        let is_driven = spins == 0 && mobility == mechanism.actuators().count();
        Self {
            mobility,
            spins,
            proximity: is_driven.then(|| SingularityDistances::new(mechanism)).flatten(),
            last: None,
            before_last: None,
            found: [None, None, None],
            nearest: [None, None, None],
            refined: [0; 3],
        }
    }

    /// Adds a sample. `passed` is true if the determinant of the loop constraints with locked
    /// actuators has changed its sign since the previous sample. Returns true if this sign change
    /// is a passage through a singular pose rather than a rounding error, and the balance at the
    /// sample, which is `None` if all forces are unique.
    pub(super) fn observe(
        &mut self,
        follower: &Follower<'a>,
        passed: bool,
    ) -> (bool, Option<Statics>) {
        let (distances, statics) = self.distances(&follower.solver);
        let now = Sample { follower: follower.clone(), distances };
        for (k, kind) in Kind::ALL.into_iter().enumerate() {
            let Some(distance) = distances[k] else { continue };
            self.add(kind, follower.time(), distance, &follower.solver);
            if let Some(found) = &mut self.found[k] {
                found.singular_samples += usize::from(distance < SINGULAR);
            }
            self.examine_minimum(kind, &now);
        }
        let is_regular = |sample: &Sample<'_>| sample.distances[0].is_some_and(|d| d >= SINGULAR);
        // At singular poses only rounding determines the sign of the determinant.
        let passed = passed && is_regular(&now) && self.last.as_ref().is_some_and(is_regular);
        if passed {
            self.pass(&now);
        }
        self.before_last = self.last.replace(now);
        (passed, statics)
    }

    /// Computes the indices of all kinds at the pose of `solver`. Also returns the balance, unless indices far from zero show that it has full rank.
    fn distances(&mut self, solver: &InverseDynamics) -> ([Option<f64>; 3], Option<Statics>) {
        // The first sample is always decomposed, because its indices come from an iteration without
        // a bound from an earlier sample.
        if let Some(proximity) = self.proximity.as_mut().filter(|_| self.last.is_some()) {
            let (mechanism, parameters) = (solver.mechanism(), solver.parameters());
            let Distances { actuation, constraint } =
                proximity.measure(mechanism, parameters, solver.bodies());
            if actuation > REGULAR && constraint > REGULAR {
                let types: Vec<_> = mechanism.joints().iter().map(|j| j.joint_type).collect();
                let system = solver.balance();
                let leg = leg_distance(&system, &system.scaled_matrix(&types), self.spins);
                return ([Some(actuation), Some(constraint), leg], None);
            }
        }
        let statics = solver.statics();
        let constraints = Constraints::new(&statics);
        (Kind::ALL.map(|kind| self.distance(&constraints, kind)), Some(statics))
    }

    /// Returns the closest approach to each kind of singularity; `None` for legs if the mechanism
    /// has no legs.
    pub(super) fn finish(mut self) -> [Option<Nearness>; 3] {
        for kind in Kind::ALL {
            let solver = self.nearest[kind as usize].take();
            let weakness = solver.and_then(|solver| self.weakness(&solver, kind));
            if let Some(found) = &mut self.found[kind as usize] {
                found.weakness = weakness;
                found.crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        self.found
    }

    /// Examines the sample before `now` if its singularity index is a local minimum. Locates the
    /// minimum between samples, and records a passage through a singular pose if the index vanishes
    /// there.
    fn examine_minimum(&mut self, kind: Kind, now: &Sample<'a>) {
        let k = kind as usize;
        let (Some(before), Some(last)) = (&self.before_last, &self.last) else { return };
        let distances = [before, last, now].map(|sample| sample.distances[k]);
        let [Some(before_it), Some(least), Some(after_it)] = distances else { return };
        // Rounding must not create a minimum. Of equal least indices, the last one counts.
        if is_less(before_it, least) || !is_less(least, after_it) {
            return;
        }
        if least < SINGULAR {
            // A single singular sample is a passage through a singular pose. In a sequence of
            // singular samples, the motion stays at singular poses.
            if before_it >= SINGULAR {
                let (time, weakness) =
                    (last.follower.time(), self.weakness(&last.follower.solver, kind));
                self.cross(kind, time, 0.0, weakness);
            }
            return;
        }
        let known = self.found[k].as_ref().map_or(f64::INFINITY, |found| found.least);
        if least > NEAR && least > known {
            return;
        }
        if self.refined[k] >= REFINED {
            if let Some(found) = &mut self.found[k] {
                found.not_searched += 1;
            }
            return;
        }
        self.refined[k] += 1;
        let apart = 1e-3 * (now.follower.time() - before.follower.time());
        let Some(found) = self.search(kind, [before, last, now]) else { return };
        let LeastIndex { configuration: follower, index, passage, .. } = found;
        self.add(kind, follower.time(), index, &follower.solver);
        // If all poses are nearly singular, a minimum is not a passage.
        if index < CROSSED && index < 1e-3 * before_it.max(after_it) {
            let weakness = self.weakness(&follower.solver, kind);
            self.cross(kind, passage, apart, weakness);
        }
    }

    /// Locates a passage through a singular pose between the last two samples by bisection on the
    /// sign of the determinant. The sign remains reliable where rounding prevents the singularity
    /// index from reaching zero.
    fn pass(&mut self, now: &Sample<'a>) {
        let Some(Sample { follower: last, .. }) = &self.last else { return };
        let mut at_last = last.solver.clone();
        let Some(side) = at_last.side() else { return };
        let (mut low, mut high) = (last.time(), now.follower.time());
        let mut nearest = now.follower.solver.clone();
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            let mut follower = last.clone();
            if middle <= low || middle >= high {
                break;
            }
            // At the singular pose the motion may be undetermined.
            let Ok(()) = follower.go_to(middle) else { break };
            match follower.solver.side() {
                Some(here) if here == side => low = middle,
                Some(_) => high = middle,
                None => break,
            }
            nearest = follower.solver;
        }
        let apart = 1e-3 * (now.follower.time() - last.time());
        let time = 0.5 * (low + high);
        let weakness = self.weakness(&nearest, Kind::Actuation);
        if let Some(distance) =
            self.distance(&Constraints::new(&nearest.statics()), Kind::Actuation)
        {
            self.add(Kind::Actuation, time, distance, &nearest);
        }
        self.cross(Kind::Actuation, time, apart, weakness);
    }

    fn add(&mut self, kind: Kind, time: f64, distance: f64, solver: &InverseDynamics) {
        let found = self.found[kind as usize].get_or_insert(Nearness {
            least: f64::INFINITY,
            time,
            weakness: None,
            singular_samples: 0,
            crossings: Vec::new(),
            not_searched: 0,
        });
        // Rounding must not move the least value to a later instant.
        if is_less(distance, found.least) {
            (found.least, found.time) = (distance, time);
            self.nearest[kind as usize] = Some(solver.clone());
        }
    }

    /// Records a passage through a singular pose at `time`, s. If one of the last two recorded
    /// passages is at most `apart`, s, away, both count as the same passage, and nothing is
    /// recorded.
    fn cross(&mut self, kind: Kind, time: f64, apart: f64, weakness: Option<Weakness>) {
        if let (Some(found), Some(weakness)) = (&mut self.found[kind as usize], weakness)
            && found.crossings.iter().rev().take(2).all(|(known, _)| (time - known).abs() > apart)
        {
            found.crossings.push((time, weakness));
        }
    }

    /// Locates the least singularity index between the first and the last of three samples, of
    /// which the second has the least index.
    fn search(
        &self,
        kind: Kind,
        [before, last, now]: [&Sample<'a>; 3],
    ) -> Option<LeastIndex<Follower<'a>>> {
        let at = |time: f64| {
            let mut follower = before.follower.clone();
            follower.go_to(time).ok()?;
            let statics = follower.solver.statics();
            let distance = self.distance(&Constraints::new(&statics), kind)?;
            Some((distance, follower))
        };
        let known =
            |sample: &Sample<'_>| Some((sample.follower.time(), sample.distances[kind as usize]?));
        let (low, mut least, high) = (known(before)?, known(last)?, known(now)?);
        let follower = last.follower.clone();
        if self.proximity.is_some() {
            // Compare only values of one method.
            least.1 = self.distance(&Constraints::new(&follower.solver.statics()), kind)?;
        }
        Some(least_index([low, least, high], follower, at))
    }

    fn distance(&self, constraints: &Constraints<'_>, kind: Kind) -> Option<f64> {
        match kind {
            Kind::Actuation => Some(constraints.statics().actuation_distance(self.spins)),
            Kind::Constraint => Some(constraints.distance(self.mobility)),
            Kind::Leg => constraints.leg_distance(self.spins),
        }
    }

    fn weakness(&self, solver: &InverseDynamics, kind: Kind) -> Option<Weakness> {
        let statics = solver.statics();
        let constraints = Constraints::new(&statics);
        let idle = solver.idle_axes();
        let mechanism = solver.mechanism();
        let origin = solver.parameters().origin;
        if kind == Kind::Constraint && constraints.distance(self.mobility) < SINGULAR {
            return self.constraint_weakness(solver);
        }
        let gained: GainedTwist = match kind {
            Kind::Actuation => statics.weakest_motion(&idle),
            Kind::Constraint => constraints.weakest_motion(self.mobility, &idle),
            Kind::Leg => constraints.weakest_leg_motion(&idle),
        }?;
        let (body, mut motion) = gained.in_words(mechanism, origin);
        if gained.of > 1 {
            let _ = write!(motion, " (one of {} such motions)", gained.of);
        }
        let load = gained.load_in_words(mechanism.characteristic_length());
        Some(Weakness { body, motion, load, left: None })
    }

    /// Describes the motion that the mechanism gains at a constraint singularity. Either the
    /// constraints block this motion at second order, or branches of motion meet. In the second
    /// case the gained motion is not unique, and the description names the motions of all branches.
    fn constraint_weakness(&self, solver: &InverseDynamics) -> Option<Weakness> {
        let mechanism = solver.mechanism();
        let length = mechanism.characteristic_length();
        let bodies = Mobility::of(solver).bodies;
        if let Some(gained) = blocked_motions(solver).first() {
            let name = &mechanism.bodies()[gained.body].name;
            let words = bodies.iter().find(|body| body.body == *name).map(|b| &b.first_order_only);
            let motion = match words {
                Some(words) if !words.is_empty() => words.join("; "),
                _ => gained.in_words(mechanism, solver.parameters().origin).1,
            };
            let load = gained.load_in_words(length);
            return Some(Weakness { body: name.clone(), motion, load, left: None });
        }
        let most = bodies.into_iter().rev().max_by_key(|body| body.motions.len())?;
        Some(Weakness {
            motion: format!(
                "one more motion, because branches of motion meet here: {}",
                most.motions.join("; ")
            ),
            body: most.body,
            load: "some of the loads along these motions".to_owned(),
            left: None,
        })
    }
}

/// Returns true if an index is less than another one by more than rounding.
fn is_less(index: f64, other: f64) -> bool {
    index < other * (1.0 - 1e-9) - 1e-12
}

/// Describes the motions that the body with the most joints can still perform at `time`, s, when a
/// leg is singular.
pub(super) fn left_at(start: &Follower<'_>, time: f64) -> Result<Option<String>, Error> {
    let mut follower = start.clone();
    follower.go_to(time)?;
    let solver = &follower.solver;
    let mechanism = solver.mechanism();
    let joints = |name: &str| {
        let of = |id: usize| mechanism.bodies()[id].name == name;
        mechanism.joints().iter().filter(|j| of(j.predecessor.0) || of(j.successor.0)).count()
    };
    let bodies = Mobility::of(solver).bodies;
    let hub = bodies.into_iter().max_by_key(|body| joints(&body.body));
    Ok(hub.map(|hub| {
        let motions = hub.motions.iter().chain(&hub.first_order_only).cloned();
        let motions: Vec<String> = motions.collect();
        match motions.is_empty() {
            true => format!("{} cannot move at all", hub.body),
            false => format!("{} retains {}", hub.body, motions.join("; ")),
        }
    }))
}
