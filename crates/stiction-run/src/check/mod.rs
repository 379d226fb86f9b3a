//! Check of a mechanism along a motion: mobility, redundant constraints, uniqueness of efforts and
//! reactions, and singularities.

mod along;
mod assembly_mode;
mod json;
mod page;
mod report;
mod sizes;
mod warnings;
mod words;

pub use along::{Kind, Nearness, Weakness};
pub use assembly_mode::AssemblyMode;
pub use page::{Page, draw_page};
pub use report::write_report;
pub use sizes::{BodyMass, Range, Sizes};

use crate::error::check_finite;
use crate::inverse::Phase;
use crate::inverse::sides::Sides;
use crate::inverse::verdict::idle_spins;
use crate::ranges::Ranges;
use crate::statistics::Least;
use crate::undetermined::open_components;
use crate::{Error, Job};
use along::Watch;
use sizes::Measuring;
use stiction_core::mobility::{Architecture, Mobility, Play, actuation_of_motion};
use stiction_core::statics::{Constraints, JointLoad};

/// Results of the check of a mechanism.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Degrees of freedom at the first pose of the motion.
    pub mobility: Mobility,
    /// Names of the bodies that can rotate freely about their own axes.
    pub idle_spins: Vec<String>,
    /// Number of actuated degrees of freedom.
    pub drives: usize,
    /// Generic ranks of the constraints and actuators, computed at random poses.
    pub architecture: Architecture,
    /// Self-stresses of the constraints at the first pose. Each self-stress lists the reactions of
    /// the joints that take part, up to a common factor.
    pub self_stresses: Vec<Vec<JointLoad>>,
    /// Joints with reactions that are statically indeterminate somewhere along the motion, each
    /// with the names of the indeterminate components.
    pub undetermined: Vec<(String, Vec<&'static str>)>,
    /// True if the frictionless efforts are statically determinate along the whole motion.
    pub drives_unique: bool,
    /// Closest approach of the motion to actuation singularities.
    pub actuation: Nearness,
    /// Closest approach of the motion to constraint singularities.
    pub constraint: Nearness,
    /// Closest approach of the motion to leg singularities; `None` if the mechanism has no legs.
    pub leg: Option<Nearness>,
    /// Least and greatest singularity index of the actuation, restricted to finite motions, and the
    /// time of the least index, s. `None` if all instantaneous motions of the mechanism are finite,
    /// or if branches of motion meet at the first pose.
    pub actuation_of_motion: Option<(f64, f64, f64)>,
    /// Pairs of times, s, of neighbouring samples between which the motion passes an actuation singularity.
    pub passed: Vec<(f64, f64)>,
    /// Assembly mode at the first pose of the motion.
    pub assembly: AssemblyMode,
    /// Number of samples of the motion.
    pub samples: usize,
    /// Time of the first sample, s.
    pub start: f64,
    /// Masses of the bodies, and the ranges of joints, legs and bodies along the motion.
    pub sizes: Sizes,
    /// Warnings about the mechanism and its motion, as sentences for the user.
    pub warnings: Vec<String>,
    /// Doubts about the data of a recorded motion, and excursions of joints beyond their ranges, in words.
    pub cautions: Vec<String>,
    pub(crate) ranges: Ranges,
}

impl Findings {
    /// Returns each kind of singularity with the closest approach of the motion to it. Leg
    /// singularities are included only if the mechanism has legs.
    pub fn singularities(&self) -> impl Iterator<Item = (Kind, &Nearness)> {
        let all = [Some(&self.actuation), Some(&self.constraint), self.leg.as_ref()];
        Kind::ALL.into_iter().zip(all).filter_map(|(kind, nearness)| Some((kind, nearness?)))
    }

    /// Returns true if every pose has a singularity of this kind, judged by random poses. `None` if
    /// the random poses are inconclusive: unclear singular values, undecided finite mobility, or a
    /// mechanism that cannot move to other poses. Also `None` for leg singularities, which are not
    /// examined at random poses.
    pub fn everywhere(&self, kind: Kind) -> Option<bool> {
        let Architecture { constraints, actuated, reach, .. } = &self.architecture;
        if *reach == 0.0 {
            return None;
        }
        let finite = self.mobility.finite.decided();
        match kind {
            Kind::Constraint => {
                finite.filter(|_| constraints.decided).map(|finite| constraints.open > finite)
            }
            Kind::Actuation => actuated.decided.then_some(actuated.open > self.idle_spins.len()),
            Kind::Leg => None,
        }
    }

    /// Returns true if the motion reaches a singular pose of this kind.
    pub fn is_singular(&self, kind: Kind) -> bool {
        let met = |n: &Nearness| n.singular_samples > 0 || !n.crossings.is_empty();
        self.singularities().any(|(known, nearness)| known == kind && met(nearness))
    }

    /// Returns the number of independent motions that the actuators must control, without the
    /// passive rotations of bodies about their own axes.
    pub fn to_be_driven(&self) -> usize {
        meant(&self.mobility, &self.architecture).saturating_sub(self.idle_spins.len())
    }

    /// Returns the play due to joint clearance, for each motion that is blocked at second order
    /// only.
    pub fn play(&self) -> &[Play] {
        &self.mobility.play
    }
}

/// Returns the number of degrees of freedom for which the mechanism is designed: the finite
/// mobility, or the generic instantaneous mobility if the finite mobility is undecided.
fn meant(mobility: &Mobility, architecture: &Architecture) -> usize {
    mobility.finite.decided().unwrap_or(architecture.constraints.open)
}

/// Checks the mechanism of a job along its motion, without loads and friction. `progress` receives
/// the phase, the number of completed samples and the total number of samples; if it returns false,
/// the check stops.
///
/// # Errors
/// Returns [`Error::Assembly`] or another error if the mechanism cannot follow the motion, and
/// [`Error::Interrupted`] if `progress` stops the check.
pub fn examine(
    job: &Job<'_>,
    progress: impl FnMut(Phase, usize, usize) -> bool,
) -> Result<Findings, Error> {
    let Some((motion, locks)) = job.locked_start()? else { return examine_motion(job, progress) };
    let mut findings = examine_motion(&Job { motion: &motion, ..job.clone() }, progress)?;
    let locks = match locks.as_slice() {
        [] => String::new(),
        locks => format!(", with {} locked", locks.join(", ")),
    };
    findings.warnings.push(format!(
        "the prescribed coordinates do not determine the motion: the check examines only the first instant{locks}"
    ));
    Ok(findings)
}

/// Checks the mechanism along a motion that determines all joint coordinates.
fn examine_motion(
    job: &Job<'_>,
    mut progress: impl FnMut(Phase, usize, usize) -> bool,
) -> Result<Findings, Error> {
    let instants = job.instants()?;
    let (count, start) = (instants.count(), instants.at(0));
    let at_start = job.assemble(start)?;
    let first = &at_start.solver;
    let mechanism = &job.model.mechanism;
    let mobility = Mobility::of(first);
    let architecture = Architecture::of(first);
    let spins = idle_spins(first);
    let name = |joint: usize| mechanism.joints()[joint].name.clone();
    let self_stresses = Constraints::new(&first.statics()).self_stresses();
    let partly_blocked = mobility.finite.traced < mobility.instantaneous;

    let mut determined = vec![[true; 6]; mechanism.joints().len()];
    let mut watch = Watch::new(mechanism, meant(&mobility, &architecture), spins.len());
    let mut measuring = Measuring::new(first);
    let mut ranges = Ranges::new(mechanism);
    let mut governed: Option<(Least, f64)> = None;
    let mut drives_unique = true;
    let mut passed = Vec::new();
    let (mut follower, mut sides) = (at_start.clone(), Sides::default());
    for (k, time) in instants.iter().enumerate() {
        follower.go_to(time)?;
        let passage = sides.observe(&mut follower.solver, time);
        let (is_passage, statics) = watch.observe(&follower, passage.is_some());
        if is_passage {
            passed.extend(passage);
        }
        if let Some(statics) = statics {
            for (all, now) in determined.iter_mut().zip(statics.determined_reactions()) {
                all.iter_mut().zip(now).for_each(|(all, now)| *all &= now);
            }
            drives_unique &= statics.determined_drives().iter().all(|determined| *determined);
        }
        let solver = &follower.solver;
        // At a branch point the finite motions differ from those that second-order conditions
        // allow.
        let governable = partly_blocked && !mobility.branches_meet;
        if let Some(value) = governable.then(|| actuation_of_motion(solver)).flatten() {
            let (least, greatest) = governed.get_or_insert((Least::default(), value));
            least.add(time, value);
            *greatest = greatest.max(value);
        }
        measuring.observe(solver);
        let bodies = solver.bodies();
        ranges.add(
            time,
            |of| of.value(bodies),
            |joint, dof| {
                let rate = solver.joint_motion(joint, dof).rate;
                Some((measuring.coordinate(joint, dof)?, Some(rate)))
            },
        );
        if !progress(Phase::Motion, k + 1, count) {
            return Err(Error::Interrupted);
        }
    }
    // If the search between samples has failed to read a recorded motion, the error is returned
    // here.
    check_finite(job.motion.signals(), follower.time())?;
    let undetermined = determined
        .iter()
        .enumerate()
        .filter(|(_, flags)| flags.contains(&false))
        .map(|(joint, flags)| (name(joint), open_components(flags)))
        .collect();
    let [actuation, constraint, mut leg] = watch.finish();
    if let Some(leg) = &mut leg {
        for (time, weakness) in &mut leg.crossings {
            weakness.left = along::left_at(&at_start, *time)?;
        }
    }
    // Placeholder for a motion without samples. Every motion has at least one sample, so the
    // placeholder is never used.
    let never = Nearness {
        least: f64::INFINITY,
        time: start,
        weakness: None,
        singular_samples: 0,
        crossings: Vec::new(),
        not_searched: 0,
    };
    let actuation = actuation.unwrap_or_else(|| never.clone());
    // At a singular pose the actuator efforts are undetermined even without redundant actuators.
    drives_unique &= actuation.singular_samples == 0;
    let mut findings = Findings {
        mobility,
        idle_spins: spins,
        drives: mechanism.actuators().count(),
        architecture,
        self_stresses,
        undetermined,
        drives_unique,
        actuation,
        constraint: constraint.unwrap_or(never),
        leg,
        actuation_of_motion: governed.map(|(least, greatest)| (least.value, greatest, least.time)),
        passed,
        assembly: AssemblyMode::of(first),
        samples: count,
        start,
        sizes: measuring.finish(),
        warnings: (mechanism.warnings().iter().map(ToString::to_string))
            .chain(job.model.import_warnings())
            .collect(),
        cautions: job.cautions().into_iter().chain(ranges.cautions()).collect(),
        ranges,
    };
    let own = warnings::warnings(&findings, job);
    findings.warnings.extend(own);
    findings.warnings.extend(first.assembly_report().notes());
    Ok(findings)
}
