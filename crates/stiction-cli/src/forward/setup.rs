//! From the options to the job.

use crate::arguments::{Forward, Method as Asked, Switch};
use crate::failure::Failure;
use crate::sources::Found;
use stiction_core::dynamics::FrictionMode;
use stiction_core::forward::{Method, Settings};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_format::{Control, Drives, LoadCase, ModelFile, Motion};
use stiction_run::forward::{Feed, Job, Start, arrange, pole};

/// Everything that a job borrows.
pub(super) struct Setup {
    model: ModelFile,
    motion: Option<(Motion, String)>,
    load: (LoadCase, String),
    drives: (Efforts, String),
    control: Option<(Control, String)>,
    prescribed: Vec<usize>,
    locked: Vec<usize>,
    start: Option<Motion>,
    friction: bool,
}

enum Efforts {
    Given(Drives),
    Inverse,
}

/// How long it lasts where nothing says, s.
const USUAL_DURATION: f64 = 10.0;
/// Time between samples where nothing says, s.
const USUAL_STEP: f64 = 0.01;
/// Samples of a controller.
const MOST_CONTROLS: f64 = 1e9;

impl Setup {
    pub(super) fn new(found: Found, options: &Forward) -> Result<Self, Failure> {
        let friction = match options.friction {
            Some(switch) => switch == Switch::On,
            None => found.model.default_friction != Some(FrictionMode::Off),
        };
        let mut locks = Vec::new();
        for name in &options.hold {
            for dof in joint_dofs(&found.model.mechanism, name)? {
                if !locks.contains(&dof) {
                    locks.push(dof);
                }
            }
        }
        let found = Found { model: arrange(&found.model, friction, &locks) };
        let mechanism = &found.model.mechanism;
        let actuators: Vec<_> = mechanism.actuators().collect();
        let mut prescribed = Vec::new();
        for name in &options.prescribe {
            for dof in joint_dofs(mechanism, name)? {
                if locks.contains(&dof) {
                    return Err(Failure::input(format!(
                        "joint `{name}` cannot be locked and moved at the same time"
                    ))
                    .help("either --hold it or --prescribe it"));
                }
                match actuators.iter().position(|actuator| *actuator == dof) {
                    Some(actuator) if prescribed.contains(&actuator) => {}
                    Some(actuator) => prescribed.push(actuator),
                    None => {
                        return Err(Failure::input(format!("joint `{name}` has no actuator")).help(
                            "only an actuator can move a joint as prescribed: add `actuated = true`",
                        ));
                    }
                }
            }
        }
        let locked: Vec<usize> =
            locks.iter().filter_map(|lock| actuators.iter().position(|a| a == lock)).collect();
        let motion = found.motion_if_any(options.motion.as_deref())?;
        let load = found.load(options.load.as_deref())?;
        let drives = match options.drives.as_deref() {
            None => (Efforts::Given(Drives::default()), "none".to_owned()),
            Some("inverse") => (Efforts::Inverse, "of inverse dynamics".to_owned()),
            Some(text) => {
                let (drives, name) = found.drives(text)?;
                (Efforts::Given(drives), name)
            }
        };
        if let Efforts::Given(drives) = &drives.0 {
            let named: Vec<usize> = drives.efforts.iter().map(|(actuator, _)| *actuator).collect();
            refuse_idle("--drives", &named, mechanism, (&locked, &prescribed))?;
        }
        let free = actuators.len() - locked.len();
        let alone = options.drives.is_none() && prescribed.is_empty() && free > 0;
        let control = match options.controller.as_deref() {
            Some("none") => None,
            Some(text) => Some(found.controller(text)?),
            None if alone && motion.as_ref().is_some_and(|(motion, _)| motion.duration > 0.0) => {
                Some(found.controller("computed-torque")?)
            }
            None => None,
        };
        if let Some((control, _)) = &control {
            refuse_idle("--controller", &control.named, mechanism, (&locked, &prescribed))?;
            let led = |actuator: &usize| locked.contains(actuator) || prescribed.contains(actuator);
            if (0..actuators.len()).all(|actuator| led(&actuator)) {
                return Err(Failure::input(
                    "--controller has nothing to drive: all actuators are locked or prescribed",
                )
                .help("leave it out, or leave an actuator to it"));
            }
        }
        let start = match options.from.as_deref() {
            None | Some("motion" | "rest") => None,
            Some(text) => Some(found.state(text)?),
        };
        let Found { model } = found;
        Ok(Self { model, motion, load, drives, control, prescribed, locked, start, friction })
    }

    pub(super) fn job(&self, options: &Forward) -> Result<Job<'_>, Failure> {
        let motion = self.motion.as_ref().map(|(motion, _)| motion);
        let at_rest = options.from.as_deref() == Some("rest");
        let start = match (&self.start, motion) {
            (Some(given), _) => Start::Given(given),
            (None, None) => Start::Home,
            (None, Some(_)) if at_rest => Start::AtRest,
            (None, Some(_)) => Start::Moving,
        };
        let from = motion.map_or(0.0, |motion| motion.start);
        let drives = match &self.drives.0 {
            Efforts::Given(drives) => Feed::Given(drives),
            Efforts::Inverse => Feed::Inverse,
        };
        let mut job = Job {
            model: &self.model,
            motion,
            motion_name: self.motion.as_ref().map_or("none", |(_, name)| name).to_owned(),
            load: &self.load.0,
            load_name: self.load.1.clone(),
            drives,
            drives_name: self.drives.1.clone(),
            control: self.control.as_ref().map(|(control, _)| control),
            control_name: self.control.as_ref().map_or("none", |(_, name)| name).to_owned(),
            prescribed: self.prescribed.clone(),
            locked: self.locked.clone(),
            start,
            from,
            until: from + USUAL_DURATION,
            step: USUAL_STEP,
            settings: Settings::default(),
            friction: self.friction,
        };
        if job.follows() && motion.is_none() {
            return Err(Failure::input("there is no motion to follow")
                .help("add one to the model as [motions.NAME], or give one: --motion \"...\""));
        }
        let recorded = match &self.drives.0 {
            Efforts::Given(drives) => {
                drives.samples.as_ref().and_then(|samples| samples.ends()).map(|(_, last)| last)
            }
            Efforts::Inverse => None,
        };
        match (motion, recorded) {
            (Some(motion), _) if job.follows() => job.until = from + motion.duration,
            (_, Some(last)) => job.until = last,
            _ => {}
        }
        if let Some(step) = options.step.or(motion.and_then(|motion| motion.step)) {
            job.step = step;
        }
        if let Some(until) = options.until {
            if until.is_nan() || until.is_infinite() {
                return Err(Failure::input(format!("--until is {until} s"))
                    .help("give an instant: a number of seconds"));
            }
            if until < from {
                return Err(Failure::input(format!(
                    "--until is {until} s, but it starts at {from} s"
                ))
                .help("give a later instant"));
            }
            let end = motion.map(|m| m.start + m.duration);
            let recorded = motion.is_some_and(|motion| motion.samples.is_some());
            if let Some(end) = end.filter(|end| recorded && job.follows() && until > *end) {
                return Err(Failure::input(format!(
                    "the recorded motion ends at {end} s, before --until {until} s"
                ))
                .help("nothing is known of where to go then"));
            }
            job.until = until;
        }
        if let Efforts::Given(drives) = &self.drives.0 {
            refuse_gaps(drives, &self.drives.1, (job.from, job.until))?;
        }
        if let Some(control) = job.control {
            let samples = (job.until - job.from) / control.period;
            if samples > MOST_CONTROLS {
                return Err(Failure::input(format!(
                    "the controller's period of {} s makes {samples:.1e} samples until {} s; at most \
                     {MOST_CONTROLS:.0e} are computed",
                    control.period, job.until
                ))
                .help("give the controller a longer period, or end earlier"));
            }
        }
        self.refuse_poles(&job)?;
        let tolerance = options.tolerance;
        if !(1e-14..=1e-2).contains(&tolerance) {
            return Err(Failure::input(format!("--tolerance is {tolerance}"))
                .help("it is a relative error between 1e-14 and 1e-2; 1e-10 is usual"));
        }
        let usual = Settings::default();
        let part = tolerance / usual.relative;
        let method = match options.method {
            Asked::Automatic => Method::Automatic,
            Asked::EventDriven => Method::EventDriven,
            Asked::TimeStepping => Method::TimeStepping,
        };
        job.settings = Settings {
            relative: tolerance,
            absolute: usual.absolute * part,
            time_step_tolerance: usual.time_step_tolerance * part,
            method,
            ..usual
        };
        Ok(job)
    }

    /// Forces that pass through infinity would be integrated over it, with whatever comes out.
    fn refuse_poles(&self, job: &Job<'_>) -> Result<(), Failure> {
        let (from, until) = (job.from, job.until);
        let refuse = |what: String, at: f64| {
            let message = format!("{what} has no finite value at t = {at} s");
            Err(Failure::input(message)
                .help("end before that, or give a formula that stays finite"))
        };
        let mechanism = &self.model.mechanism;
        if let Efforts::Given(drives) = &self.drives.0
            && drives.samples.is_none()
        {
            let actuators: Vec<_> = mechanism.actuators().collect();
            for (actuator, signal) in &drives.efforts {
                if let Some(at) = pole(signal, from, until) {
                    let (joint, dof) = actuators[*actuator];
                    let name = mechanism.joints()[joint.0].actuator_name(dof);
                    return refuse(format!("the effort of `{name}`"), at);
                }
            }
        }
        for wrench in &self.load.0.wrenches {
            let mut signals = wrench.force.iter().chain(&wrench.moment);
            if let Some(at) = signals.find_map(|signal| pole(signal, from, until)) {
                return refuse(
                    format!("the load on `{}`", mechanism.bodies()[wrench.body.0].name),
                    at,
                );
            }
        }
        Ok(())
    }
}

/// Actuators that are locked or move as prescribed exert what that takes: an effort for them would go nowhere.
fn refuse_idle(
    option: &str,
    named: &[usize],
    mechanism: &Mechanism,
    (locked, prescribed): (&[usize], &[usize]),
) -> Result<(), Failure> {
    for &actuator in named {
        let (what, other) = if locked.contains(&actuator) {
            ("locked", "--hold")
        } else if prescribed.contains(&actuator) {
            ("moved as prescribed", "--prescribe")
        } else {
            continue;
        };
        let Some((joint, dof)) = mechanism.actuators().nth(actuator) else { continue };
        let name = mechanism.joints()[joint.0].dof_name(dof);
        return Err(Failure::input(format!(
            "{option} names `{name}`, which is {what} by {other}: its effort is whatever that takes"
        ))
        .help(format!("leave `{name}` out of {option}, or out of {other}")));
    }
    Ok(())
}

/// Recorded drives say nothing of times outside their samples.
fn refuse_gaps(drives: &Drives, name: &str, (from, until): (f64, f64)) -> Result<(), Failure> {
    // One sample holds for ever.
    let Some(samples) = drives.samples.as_ref().filter(|samples| samples.count() > 1) else {
        return Ok(());
    };
    let Some((first, last)) = samples.ends() else { return Ok(()) };
    // Samples that are apart by rounding of decimal numbers are the same.
    let close = 1e-9 * (last - first);
    if from < first - close {
        return Err(Failure::input(format!(
            "the drives of {name} begin at {first} s, after the start at {from} s"
        ))
        .help("record them from the start on, or begin later: `start` of the motion"));
    }
    if until > last + close {
        return Err(Failure::input(format!(
            "the drives of {name} end at {last} s, before the last instant, {until} s"
        ))
        .help(format!("end with them, --until {last}, or record them for longer")));
    }
    Ok(())
}

/// The freedoms of a joint that a name means: all of the joint, or one of them.
fn joint_dofs(mechanism: &Mechanism, name: &str) -> Result<Vec<(JointId, usize)>, Failure> {
    let joints = mechanism.joints();
    let whole = joints.iter().position(|joint| joint.name == name);
    let one = name.rsplit_once('.').and_then(|(owner, dof)| {
        let joint = joints.iter().position(|joint| joint.name == owner)?;
        let dofs = joints[joint].joint_type.dofs();
        Some((joint, dofs.iter().position(|known| known.name == dof)?))
    });
    let found = match (whole, one) {
        (Some(joint), _) => {
            let count = joints[joint].joint_type.dofs().len();
            (0..count).map(|dof| (JointId(joint), dof)).collect()
        }
        (None, Some((joint, dof))) => vec![(JointId(joint), dof)],
        (None, None) => Vec::new(),
    };
    match found.first() {
        None => {
            let nearest = joints
                .iter()
                .map(|joint| (strsim::damerau_levenshtein(&joint.name, name), &joint.name))
                .min()
                .filter(|(distance, known)| *distance <= 1 + known.len() / 3);
            let failure = Failure::input(format!("there is no joint `{name}`"));
            Err(match nearest {
                Some((_, known)) => failure.help(format!("did you mean `{known}`?")),
                None => {
                    let names: Vec<&str> =
                        joints.iter().map(|j| j.name.as_str()).take(12).collect();
                    failure.help(format!("joints: {}", names.join(", ")))
                }
            })
        }
        Some((JointId(joint), _)) if !joints[*joint].joint_type.has_scalar_coordinates() => {
            Err(Failure::input(format!("joint `{name}` has no coordinate that could be held"))
                .help("hold other joints"))
        }
        Some(_) => Ok(found),
    }
}
