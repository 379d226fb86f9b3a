//! How near a motion comes to singular positions, between samples, too.

use crate::inverse::{Error, Job, SINGULAR};
use std::fmt::Write as _;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::mobility::{Mobility, blocked_motions};
use stiction_core::statics::{Constraints, GainedTwist, Statics};

/// A kind of singularity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Something can move while all actuators stand still (type 2).
    Actuation,
    /// The constraints leave a motion more.
    Constraint,
    /// Bodies of a leg can move while the bodies where legs end stand still (type 1).
    Leg,
}

impl Kind {
    /// In this order everywhere.
    pub const ALL: [Self; 3] = [Self::Actuation, Self::Constraint, Self::Leg];

    /// As in outputs.
    pub fn word(self) -> &'static str {
        match self {
            Self::Actuation => "actuation",
            Self::Constraint => "constraint",
            Self::Leg => "leg",
        }
    }
}

/// A motion in words, and the load that does work on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Weakness {
    /// The body that tells it.
    pub body: String,
    /// Its motion: what is gained at the singular position.
    pub motion: String,
    /// What cannot be carried there.
    pub load: String,
    /// For legs: what the hub on which most legs end can still do.
    pub left: Option<String>,
}

/// How near a motion comes to singular positions of a kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearness {
    /// The least distance and when, s; located between samples.
    pub least: f64,
    /// See `least`.
    pub time: f64,
    /// The motion that is resisted least then.
    pub weakness: Option<Weakness>,
    /// At how many samples the position is singular.
    pub singular_samples: usize,
    /// Instants, s, at which the motion passes through or touches a singular position, each with
    /// what is gained there; not while it stays singular over several samples.
    pub crossings: Vec<(f64, Weakness)>,
    /// Near approaches that were not looked into, since there are so many.
    pub not_searched: usize,
}

/// So many near approaches of one kind are looked into; each takes some fifty decompositions.
const REFINED: usize = 100;
/// A local minimum above this, and above the least found so far, is not looked into.
const NEAR: f64 = 0.05;
/// Where the search ends nearer than this to a singular position, the motion passes it: at the
/// position itself the motion may not be determined, and the search stops before it.
const CROSSED: f64 = 1e-7;
/// Steps of the search; each shortens the interval by the golden section.
const STEPS: usize = 60;

/// What the motion was like at a sample.
struct Sample {
    time: f64,
    solver: InverseDynamics,
    distances: [Option<f64>; 3],
}

/// Where a distance is least.
struct Found {
    time: f64,
    solver: InverseDynamics,
    distance: f64,
    /// If the distance vanishes there: when, s.
    passage: f64,
}

/// Watches a motion go by.
pub(super) struct Watch<'a> {
    job: &'a Job<'a>,
    /// Finite motions that the constraints are meant to leave, idle spins included.
    mobility: usize,
    spins: usize,
    last: Option<Sample>,
    before_last: Option<Sample>,
    found: [Option<Nearness>; 3],
    /// The mechanism where it is nearest, for each kind.
    nearest: [Option<InverseDynamics>; 3],
    refined: [usize; 3],
}

impl<'a> Watch<'a> {
    pub(super) fn new(job: &'a Job<'a>, mobility: usize, spins: usize) -> Self {
        Self {
            job,
            mobility,
            spins,
            last: None,
            before_last: None,
            found: [None, None, None],
            nearest: [None, None, None],
            refined: [0; 3],
        }
    }

    /// Looks at the next sample; `passed` if it lies on another side of the singular positions of
    /// actuation than the last one; whether it is so beyond rounding.
    pub(super) fn look(&mut self, solver: &InverseDynamics, time: f64, passed: bool) -> bool {
        let statics = solver.statics();
        let distances = Kind::ALL.map(|kind| self.distance(&statics, kind));
        let now = Sample { time, solver: solver.clone(), distances };
        for (k, kind) in Kind::ALL.into_iter().enumerate() {
            let Some(distance) = distances[k] else { continue };
            self.add(kind, time, distance, solver);
            if let Some(found) = &mut self.found[k] {
                found.singular_samples += usize::from(distance < SINGULAR);
            }
            self.look_back(kind, &now);
        }
        let is_regular = |sample: &Sample| sample.distances[0].is_some_and(|d| d >= SINGULAR);
        // In singular positions the side is that of rounding.
        let passed = passed && is_regular(&now) && self.last.as_ref().is_some_and(is_regular);
        if passed {
            self.pass(&now);
        }
        self.before_last = self.last.replace(now);
        passed
    }

    /// What was found of each kind; legs where there are some.
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

    /// Whether a minimum lies between the last samples, and where.
    fn look_back(&mut self, kind: Kind, now: &Sample) {
        let k = kind as usize;
        let (Some(before), Some(last)) = (&self.before_last, &self.last) else { return };
        let distances = [before, last, now].map(|sample| sample.distances[k]);
        let [Some(before_it), Some(least), Some(after_it)] = distances else { return };
        if before_it < least || after_it <= least {
            return;
        }
        if least < SINGULAR {
            // At the sample itself; alone it is a passage, in a row the motion stays singular.
            if before_it >= SINGULAR {
                let (time, weakness) = (last.time, self.weakness(&last.solver, kind));
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
        let apart = 1e-3 * (now.time - before.time);
        let Some(found) = self.search(kind, before, now.time) else { return };
        let Found { time, solver, distance, passage } = found;
        self.add(kind, time, distance, &solver);
        // Where all positions are nearly singular, a least one is no passage.
        if distance < CROSSED && distance < 1e-3 * before_it.max(after_it) {
            let weakness = self.weakness(&solver, kind);
            self.cross(kind, passage, apart, weakness);
        }
    }

    /// A passage between the last sample and this one, by bisection of the side on which the
    /// mechanism is: certain, whether or not the distance can be followed to zero.
    fn pass(&mut self, now: &Sample) {
        let Some(last) = &self.last else { return };
        let mut at_last = last.solver.clone();
        let Some(side) = at_last.side() else { return };
        let (mut low, mut high) = (last.time, now.time);
        let mut nearest = now.solver.clone();
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            let mut solver = last.solver.clone();
            if middle <= low || middle >= high {
                break;
            }
            // At the singular position itself the motion may not be determined.
            let Ok(()) = self.job.follow(&mut solver, last.time, middle) else { break };
            match solver.side() {
                Some(here) if here == side => low = middle,
                Some(_) => high = middle,
                None => break,
            }
            nearest = solver;
        }
        let apart = 1e-3 * (now.time - last.time);
        let time = 0.5 * (low + high);
        let weakness = self.weakness(&nearest, Kind::Actuation);
        if let Some(distance) = self.distance(&nearest.statics(), Kind::Actuation) {
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
        // Rounding does not move the least to a later instant.
        if distance < found.least * (1.0 - 1e-9) - 1e-12 {
            (found.least, found.time) = (distance, time);
            self.nearest[kind as usize] = Some(solver.clone());
        }
    }

    /// Notes a passage, unless the last one is less than `apart`, s, away: then it is the same.
    fn cross(&mut self, kind: Kind, time: f64, apart: f64, weakness: Option<Weakness>) {
        if let (Some(found), Some(weakness)) = (&mut self.found[kind as usize], weakness)
            && found.crossings.iter().rev().take(2).all(|(known, _)| (time - known).abs() > apart)
        {
            found.crossings.push((time, weakness));
        }
    }

    /// The instant of the least distance between a sample and `to`, s, by golden section.
    fn search(&self, kind: Kind, from: &Sample, to: f64) -> Option<Found> {
        let at = |time: f64| -> Option<(f64, InverseDynamics, f64)> {
            let mut solver = from.solver.clone();
            self.job.follow(&mut solver, from.time, time).ok()?;
            let distance = self.distance(&solver.statics(), kind)?;
            Some((time, solver, distance))
        };
        let golden = (5f64.sqrt() - 1.0) / 2.0;
        let (mut low, mut high) = (from.time, to);
        let mut left = at(high - golden * (high - low))?;
        let mut right = at(low + golden * (high - low))?;
        for _ in 0..STEPS {
            // At the singular position itself the motion may not be determined: near it, then.
            let lower_half = left.2 < right.2;
            let next = match lower_half {
                true => at(right.0 - golden * (right.0 - low)),
                false => at(left.0 + golden * (high - left.0)),
            };
            let Some(next) = next else { break };
            if lower_half {
                high = right.0;
                right = core::mem::replace(&mut left, next);
            } else {
                low = left.0;
                left = core::mem::replace(&mut right, next);
            }
            // Smooth minima are found to the root of rounding only.
            let flat = (left.2 - right.2).abs() <= 1e-13 && left.2 > 1e-6;
            if flat || high - low <= 1e-14 * high.abs().max(low.abs()) {
                break;
            }
        }
        // Of a passage, where distances are like a V, the tip is between both ends.
        let both = left.2 + right.2;
        let passage =
            if both > 0.0 { (left.0 * right.2 + right.0 * left.2) / both } else { left.0 };
        let (time, solver, distance) = if left.2 < right.2 { left } else { right };
        Some(Found { time, solver, distance, passage })
    }

    fn distance(&self, statics: &Statics, kind: Kind) -> Option<f64> {
        match kind {
            Kind::Actuation => Some(statics.actuation_distance(self.spins)),
            Kind::Constraint => Some(Constraints::new(statics).distance(self.mobility)),
            Kind::Leg => Constraints::new(statics).leg_distance(self.spins),
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
        let told: GainedTwist = match kind {
            Kind::Actuation => statics.weakest_motion(&idle),
            Kind::Constraint => constraints.weakest_motion(self.mobility, &idle),
            Kind::Leg => constraints.weakest_leg_motion(&idle),
        }?;
        let (body, mut motion) = told.in_words(mechanism, origin);
        if told.of > 1 {
            let _ = write!(motion, " (one of {} such motions)", told.of);
        }
        let load = told.load_in_words(mechanism.characteristic_length());
        Some(Weakness { body, motion, load, left: None })
    }

    /// What a singular position of constraint adds to the motions of finite size: what is blocked to
    /// second order; or, where branches of motion meet, nothing can be called the added one.
    fn constraint_weakness(&self, solver: &InverseDynamics) -> Option<Weakness> {
        let mechanism = solver.mechanism();
        let length = mechanism.characteristic_length();
        let bodies = Mobility::of(solver).bodies;
        if let Some(told) = blocked_motions(solver).first() {
            let name = &mechanism.bodies()[told.body].name;
            let words = bodies.iter().find(|body| body.body == *name).map(|b| &b.first_order_only);
            let motion = match words {
                Some(words) if !words.is_empty() => words.join("; "),
                _ => told.in_words(mechanism, solver.parameters().origin).1,
            };
            let load = told.load_in_words(length);
            return Some(Weakness { body: name.clone(), motion, load, left: None });
        }
        let most = bodies.into_iter().rev().max_by_key(|body| body.motions.len())?;
        Some(Weakness {
            motion: format!("a motion more, where branches meet: {}", most.motions.join("; ")),
            body: most.body,
            load: "some of the loads along these".to_owned(),
            left: None,
        })
    }
}

/// What the body with most joints can do at an instant: what is left of its motions where a leg is
/// singular.
pub(super) fn left_at(
    job: &Job<'_>,
    start: &InverseDynamics,
    from: f64,
    time: f64,
) -> Result<Option<String>, Error> {
    let mut solver = start.clone();
    job.follow(&mut solver, from, time)?;
    let mechanism = solver.mechanism();
    let joints = |name: &str| {
        let of = |id: usize| mechanism.bodies()[id].name == name;
        mechanism.joints().iter().filter(|j| of(j.predecessor.0) || of(j.successor.0)).count()
    };
    let bodies = Mobility::of(&solver).bodies;
    let hub = bodies.into_iter().max_by_key(|body| joints(&body.body));
    Ok(hub.map(|hub| {
        let motions = hub.motions.iter().chain(&hub.first_order_only).cloned();
        let motions: Vec<String> = motions.collect();
        match motions.is_empty() {
            true => format!("{} cannot move at all", hub.body),
            false => format!("{} is left with {}", hub.body, motions.join("; ")),
        }
    }))
}
