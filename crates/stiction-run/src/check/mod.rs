//! Verdicts on a mechanism: what it can do, what is redundant, unique, singular.

mod along;
mod json;
mod page;
mod report;
mod sizes;
mod warnings;
mod words;

pub use along::{Kind, Nearness, Weakness};
pub use page::{Page, draw_page};
pub use report::write_report;
pub use sizes::{BodyMass, Range, Sizes};

use crate::inverse::sides::Sides;
use crate::inverse::verdict::idle_spins;
use crate::inverse::{Error, Job, Phase};
use crate::statistics::Least;
use crate::undetermined::open_components;
use along::Watch;
use sizes::Measuring;
use stiction_core::mobility::{Architecture, Mobility, Play, governance};
use stiction_core::statics::{Constraints, JointLoad};

/// What was found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Degrees of freedom at the beginning of the motion.
    pub mobility: Mobility,
    /// Bodies that may spin about an axis of their own without any influence.
    pub idle_spins: Vec<String>,
    /// How many freedoms actuators drive.
    pub drives: usize,
    /// What holds in positions taken at random.
    pub architecture: Architecture,
    /// For each self-stress of the constraints at the beginning what the joints that take part
    /// carry, without a scale.
    pub self_stresses: Vec<Vec<JointLoad>>,
    /// For each joint the components of its reaction that the balance does not determine, anywhere
    /// along the motion.
    pub undetermined: Vec<(String, Vec<&'static str>)>,
    /// Whether driving forces without friction are determined along the whole motion.
    pub drives_unique: bool,
    /// How near the motion comes to singularities of actuation.
    pub actuation: Nearness,
    /// To those of constraint.
    pub constraint: Nearness,
    /// To those of legs, where there are some.
    pub leg: Option<Nearness>,
    /// Where some motions are free to first order only: how well the actuators govern the others,
    /// the least along the motion, the greatest, and the time, s, of the least.
    pub governance: Option<(f64, f64, f64)>,
    /// Neighbouring samples, s, between which a singularity of actuation is passed.
    pub passed: Vec<(f64, f64)>,
    /// Number of samples.
    pub samples: usize,
    /// First instant, s.
    pub start: f64,
    /// Masses, ranges, reach.
    pub sizes: Sizes,
    /// What a colleague would point at.
    pub warnings: Vec<String>,
}

impl Findings {
    /// The three kinds of singularities in their order; legs where there are some.
    pub fn singularities(&self) -> impl Iterator<Item = (Kind, &Nearness)> {
        let all = [Some(&self.actuation), Some(&self.constraint), self.leg.as_ref()];
        Kind::ALL.into_iter().zip(all).filter_map(|(kind, nearness)| Some((kind, nearness?)))
    }

    /// Whether a singularity of this kind is in every position, as far as positions taken at random
    /// say. None where they do not decide: as singular values or the count of finite motions are not
    /// clear, or as nothing moves to other positions; or where nobody asked: for legs.
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

    /// Whether the motion meets singular positions of this kind.
    pub fn is_singular(&self, kind: Kind) -> bool {
        let met = |n: &Nearness| n.singular_samples > 0 || !n.crossings.is_empty();
        self.singularities().any(|(known, nearness)| known == kind && met(nearness))
    }

    /// How many motions the actuators are to govern: idle spins are none.
    pub fn to_be_driven(&self) -> usize {
        meant(&self.mobility, &self.architecture).saturating_sub(self.idle_spins.len())
    }

    /// What clearance does to motions that are blocked to second order only.
    pub fn play(&self) -> &[Play] {
        &self.mobility.play
    }
}

/// How many motions the constraints are meant to leave: those of finite size, or, where these are in
/// doubt, what they leave in general.
fn meant(mobility: &Mobility, architecture: &Architecture) -> usize {
    mobility.finite.decided().unwrap_or(architecture.constraints.open)
}

/// Examines the job's mechanism along its motion; loads and friction play no part. `progress` is
/// told the phase, the samples done and all, and answers whether to go on.
///
/// # Errors
/// The motion cannot be followed.
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
        "the prescribed coordinates do not determine the motion: checked at its first instant only{locks}"
    ));
    Ok(findings)
}

/// Examines the mechanism along a motion that determines it.
fn examine_motion(
    job: &Job<'_>,
    mut progress: impl FnMut(Phase, usize, usize) -> bool,
) -> Result<Findings, Error> {
    let instants = job.instants()?;
    let (count, start) = (instants.count(), instants.at(0));
    let first = job.assemble(start)?;
    let mechanism = &job.model.mechanism;
    let mobility = Mobility::of(&first);
    let architecture = Architecture::of(&first);
    let spins = idle_spins(&first);
    let name = |joint: usize| mechanism.joints()[joint].name.clone();
    let self_stresses = Constraints::new(&first.statics()).self_stresses();
    let partly_blocked = mobility.finite.traced < mobility.instantaneous;

    let mut solver = first.clone();
    let mut determined = vec![[true; 6]; mechanism.joints().len()];
    let mut watch = Watch::new(job, meant(&mobility, &architecture), spins.len());
    let mut measuring = Measuring::new(&first);
    let mut governed: Option<(Least, f64)> = None;
    let mut drives_unique = true;
    let mut passed = Vec::new();
    let (mut before, mut sides) = (start, Sides::default());
    for (k, time) in instants.iter().enumerate() {
        job.follow(&mut solver, before, time)?;
        let passage = sides.look(&mut solver, time);
        if watch.look(&solver, time, passage.is_some()) {
            passed.extend(passage);
        }
        let statics = solver.statics();
        for (all, now) in determined.iter_mut().zip(statics.determined_reactions()) {
            all.iter_mut().zip(now).for_each(|(all, now)| *all &= now);
        }
        drives_unique &= statics.determined_drives().iter().all(|determined| *determined);
        // Where branches meet, motions of finite size are not those that the second order leaves.
        let governable = partly_blocked && !mobility.branches_meet;
        if let Some(value) = governable.then(|| governance(&solver)).flatten() {
            let (least, greatest) = governed.get_or_insert((Least::default(), value));
            least.add(time, value);
            *greatest = greatest.max(value);
        }
        measuring.look(&solver);
        before = time;
        if !progress(Phase::Motion, k + 1, count) {
            return Err(Error::Interrupted);
        }
    }
    // Where singular positions were looked for between samples, a recording may have failed.
    job.check_motion(before)?;
    let undetermined = determined
        .iter()
        .enumerate()
        .filter(|(_, flags)| flags.contains(&false))
        .map(|(joint, flags)| (name(joint), open_components(flags)))
        .collect();
    let [actuation, constraint, mut leg] = watch.finish();
    if let Some(leg) = &mut leg {
        for (time, weakness) in &mut leg.crossings {
            weakness.left = along::left_at(job, &first, start, *time)?;
        }
    }
    // There is at least one sample.
    let never = Nearness {
        least: f64::INFINITY,
        time: start,
        weakness: None,
        singular_samples: 0,
        crossings: Vec::new(),
        not_searched: 0,
    };
    let actuation = actuation.unwrap_or_else(|| never.clone());
    // A position that is singular leaves them open even where nothing is redundant.
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
        governance: governed.map(|(least, greatest)| (least.value, greatest, least.time)),
        passed,
        samples: count,
        start,
        sizes: measuring.finish(),
        warnings: mechanism.warnings().iter().map(ToString::to_string).collect(),
    };
    let own = warnings::warnings(&findings, job);
    findings.warnings.extend(own);
    findings.warnings.extend(first.assembly_report().notes());
    Ok(findings)
}
