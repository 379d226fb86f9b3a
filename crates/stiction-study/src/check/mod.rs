//! Verdicts on a mechanism: what it can do, what is redundant, unique, singular.

mod report;

pub use report::write_report;

use crate::inverse::run::{Sides, idle_spins};
use crate::inverse::statistics::Least;
use crate::inverse::summary::undetermined_components;
use crate::inverse::{Error, Job, Phase};
use serde_json::{Value, json};
use stiction::dynamics::InverseDynamics;
use stiction::mechanism::JointId;
use stiction::mobility::{Constraints, JointLoad, Mobility};
use stiction::spatial::Vec3;

/// Closer to a singular position than this is in it, to round-off.
pub(crate) const SINGULAR: f64 = 1e-9;

/// What was found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Degrees of freedom at the beginning of the motion.
    pub mobility: Mobility,
    /// Bodies that may spin about an axis of their own without any influence.
    pub idle_spins: Vec<String>,
    /// For each self-stress of the constraints at the beginning what the joints that take part carry,
    /// without a scale.
    pub self_stresses: Vec<Vec<JointLoad>>,
    /// For each joint the components of its reaction that the balance does not determine, anywhere
    /// along the motion.
    pub undetermined: Vec<(String, Vec<&'static str>)>,
    /// Whether driving forces without friction are determined along the whole motion.
    pub drives_unique: bool,
    /// The three distances along the motion; legs where there are some.
    pub actuation: Nearness,
    /// To a singularity of constraint.
    pub constraint: Nearness,
    /// To a singularity of a leg.
    pub leg: Option<Nearness>,
    /// Neighbouring samples, s, between which a singularity of actuation is passed.
    pub passed: Vec<(f64, f64)>,
    /// Number of samples.
    pub samples: usize,
    /// First instant, s.
    pub start: f64,
    /// Mass of all moving bodies, kg, and their common centre at the beginning, m.
    pub mass: f64,
    /// See `mass`.
    pub com: Vec3<f64>,
    /// For each scalar freedom of a joint its name, its unit, and the range along the motion.
    pub ranges: Vec<(String, &'static str, f64, f64)>,
    /// What a colleague would point at.
    pub warnings: Vec<String>,
}

/// How near a motion comes to singular positions of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearness {
    /// The least distance and when, s.
    pub least: f64,
    /// See `least`.
    pub time: f64,
    /// At how many samples the position is singular.
    pub singular_samples: usize,
}

/// Distances along a motion.
#[derive(Clone, Debug, Default)]
struct Series {
    least: Least,
    singular: usize,
}

impl Series {
    fn add(&mut self, time: f64, distance: f64) {
        self.least.add(time, distance);
        self.singular += usize::from(distance < SINGULAR);
    }

    fn nearness(&self) -> Nearness {
        let Least { value, time } = self.least;
        Nearness { least: value, time, singular_samples: self.singular }
    }
}

/// Examines the job's mechanism along its motion; loads and friction play no part. `progress` is
/// told the phase, the samples done and all, and answers whether to go on.
///
/// # Errors
/// The motion cannot be followed.
pub fn examine(
    job: &Job<'_>,
    mut progress: impl FnMut(Phase, usize, usize) -> bool,
) -> Result<Findings, Error> {
    let instants = job.instants()?;
    let (count, start) = (instants.count(), instants.at(0));
    let mut solver = job.assemble(start)?;
    let mechanism = &job.model.mechanism;
    let mobility = Mobility::of(&solver);
    let spins = idle_spins(&solver);
    let name = |joint: usize| mechanism.joints()[joint].name.clone();
    let statics = solver.statics();
    let self_stresses = Constraints::new(&statics).self_stresses();
    let (mass, com) = centre(&solver);

    let mut determined = vec![[true; 6]; mechanism.joints().len()];
    let drives = mechanism.actuators().count();
    let (mut actuation, mut constraint, mut leg) =
        (Series::default(), Series::default(), Series::default());
    let mut has_legs = false;
    let mut drives_unique = true;
    let mut passed = Vec::new();
    let mut ranges = Ranges::new(&solver);
    let (mut before, mut sides) = (start, Sides::default());
    for (k, time) in instants.iter().enumerate() {
        job.follow(&mut solver, before, time)?;
        let statics = solver.statics();
        let constraints = Constraints::new(&statics);
        actuation.add(time, statics.actuation_distance(spins.len()));
        constraint.add(time, constraints.distance(mobility.finite));
        if let Some(distance) = constraints.leg_distance(spins.len()) {
            has_legs = true;
            leg.add(time, distance);
        }
        for (all, now) in determined.iter_mut().zip(statics.determined_reactions()) {
            all.iter_mut().zip(now).for_each(|(all, now)| *all &= now);
        }
        drives_unique &= statics.determined_drives().iter().all(|determined| *determined);
        passed.extend(sides.look(&mut solver, time));
        ranges.add(&solver);
        before = time;
        if !progress(Phase::Motion, k + 1, count) {
            return Err(Error::Interrupted);
        }
    }
    let undetermined = determined
        .iter()
        .enumerate()
        .filter(|(_, flags)| flags.contains(&false))
        .map(|(joint, flags)| (name(joint), undetermined_components(flags)))
        .collect();
    // A position that is singular leaves them open even where nothing is redundant.
    drives_unique &= actuation.singular == 0;
    let mut findings = Findings {
        mobility,
        idle_spins: spins,
        self_stresses,
        undetermined,
        drives_unique,
        actuation: actuation.nearness(),
        constraint: constraint.nearness(),
        leg: has_legs.then(|| leg.nearness()),
        passed,
        samples: count,
        start,
        mass,
        com,
        ranges: ranges.finish(),
        warnings: mechanism.warnings().iter().map(ToString::to_string).collect(),
    };
    findings.warnings.extend(findings.own_warnings(drives));
    Ok(findings)
}

/// The mass of all moving bodies and their common centre in the world.
fn centre(solver: &InverseDynamics) -> (f64, Vec3<f64>) {
    let bodies = solver.mechanism().bodies().iter().zip(&solver.bodies().pose).skip(1);
    let (mut mass, mut moment) = (0.0, Vec3::zero());
    for (body, pose) in bodies {
        mass += body.mass;
        moment += pose.apply(body.com) * body.mass;
    }
    let from_origin = if mass > 0.0 { moment * (1.0 / mass) } else { Vec3::zero() };
    (mass, from_origin + solver.parameters().origin)
}

/// Ranges of joint coordinates; angles over several turns.
struct Ranges(Vec<Range>);

struct Range {
    joint: usize,
    freedom: usize,
    name: String,
    unit: &'static str,
    last: f64,
    least: f64,
    greatest: f64,
}

impl Ranges {
    fn new(solver: &InverseDynamics) -> Self {
        let mut ranges = Vec::new();
        for (joint, content) in solver.mechanism().joints().iter().enumerate() {
            let freedoms = content.joint_type.freedoms();
            let coordinates = solver.joint_coordinates(JointId(joint));
            for (freedom, value) in coordinates.into_iter().enumerate() {
                let name = match freedoms.len() {
                    1 => content.name.clone(),
                    _ => format!("{}.{}", content.name, freedoms[freedom].name),
                };
                let unit = if freedoms[freedom].units().1 == "N m" { "rad" } else { "m" };
                let (last, least, greatest) = (value, value, value);
                ranges.push(Range { joint, freedom, name, unit, last, least, greatest });
            }
        }
        Self(ranges)
    }

    fn add(&mut self, solver: &InverseDynamics) {
        for range in &mut self.0 {
            let value = solver.joint_coordinates(JointId(range.joint))[range.freedom];
            let turn = std::f64::consts::TAU;
            let turns =
                if range.unit == "rad" { ((range.last - value) / turn).round() } else { 0.0 };
            range.last = value + turns * turn;
            range.least = range.least.min(range.last);
            range.greatest = range.greatest.max(range.last);
        }
    }

    fn finish(self) -> Vec<(String, &'static str, f64, f64)> {
        self.0.into_iter().map(|r| (r.name, r.unit, r.least, r.greatest)).collect()
    }
}

impl Findings {
    fn own_warnings(&self, drives: usize) -> Vec<String> {
        let mut warnings = Vec::new();
        let driven = self.mobility.finite.saturating_sub(self.idle_spins.len());
        if drives > 0 && drives < driven {
            warnings.push(format!(
                "{drives} actuators cannot govern {driven} degrees of freedom: actuate more joints"
            ));
        }
        if drives > driven {
            warnings.push(format!(
                "{drives} actuators govern {driven} degrees of freedom: driving forces are chosen by \
                 a rule where they are not unique"
            ));
        }
        let kinds = [("actuation", self.actuation), ("constraint", self.constraint)];
        for (kind, nearness) in kinds {
            if nearness.singular_samples > 0 {
                warnings.push(format!(
                    "singular in {kind} at {} of {} samples",
                    nearness.singular_samples, self.samples
                ));
            }
        }
        if self.mobility.finite < self.mobility.instantaneous {
            warnings.push(
                "some motion is free to first order: clearance and compliance make it large"
                    .to_owned(),
            );
        }
        let (kept, _) = self.mobility.gap;
        if let Some(kept) = kept.filter(|kept| *kept < 1e-6) {
            warnings.push(format!(
                "the instantaneous count is hardly decidable: a singular value of {kept:.1e} counts \
                 as not zero"
            ));
        }
        warnings
    }

    /// For programs.
    pub fn json(&self, job: &Job<'_>) -> Value {
        let nearness = |nearness: &Nearness| {
            let Nearness { least, time, singular_samples } = nearness;
            json!({ "distance": least, "time": time, "singular_samples": singular_samples })
        };
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
                    "joint": job.model.mechanism.joints()[load.joint.0].name,
                    "force": load.force.to_array(),
                    "moment": load.moment.to_array(),
                })
            });
            Value::Array(joints.collect())
        });
        let undetermined = self.undetermined.iter().flat_map(|(joint, components)| {
            components.iter().map(move |component| format!("{joint}.{component}"))
        });
        let ranges = self.ranges.iter().map(|(name, unit, least, greatest)| {
            json!({ "freedom": name, "unit": unit, "least": least, "greatest": greatest })
        });
        json!({
            "model": job.model.name,
            "motion": job.motion_name,
            "samples": self.samples,
            "mobility": {
                "gruebler": self.mobility.gruebler,
                "instantaneous": self.mobility.instantaneous,
                "finite": self.mobility.finite,
                "idle": self.idle_spins,
                "smallest_kept": self.mobility.gap.0,
                "largest_dropped": self.mobility.gap.1,
                "bodies": bodies.collect::<Vec<_>>(),
            },
            "redundant_constraints": self.mobility.redundant_constraints,
            "self_stresses": stresses.collect::<Vec<_>>(),
            "undetermined_reactions": undetermined.collect::<Vec<_>>(),
            "drives_unique": self.drives_unique,
            "singularities": {
                "constraint": nearness(&self.constraint),
                "actuation": nearness(&self.actuation),
                "leg": self.leg.as_ref().map(nearness),
                "passed": self.passed,
                "characteristic_length": job.model.mechanism.characteristic_length(),
            },
            "mass": { "total": self.mass, "centre": self.com.to_array() },
            "ranges": ranges.collect::<Vec<_>>(),
            "warnings": self.warnings,
        })
    }
}
