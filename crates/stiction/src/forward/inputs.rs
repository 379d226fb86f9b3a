//! Look-up and checks of the inputs of a simulation.

use super::{Forward, MOST_CONTROLLER_SAMPLES};
use crate::error::Error;
use crate::names::find;
use stiction_core::forward::Known;
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_format::{Channel, Control, Drives, Motion};
use stiction_run::forward::{Feed, Job, pole};

/// Actuator efforts that act without a controller.
#[derive(Clone, Debug)]
pub(super) enum Efforts {
    Given(Drives),
    /// Efforts of inverse dynamics for the motion.
    Inverse,
}

/// State of the robot at the start of a simulation.
#[derive(Clone, Debug)]
pub(super) enum Start {
    /// Position and rates of the motion, or the home position if there is no motion.
    Motion,
    /// Position of the motion, with zero rates.
    AtRest,
    /// State at the first instant of a motion that is given as assignments.
    Given(Motion),
    /// Given coordinates and rates; all other coordinates follow from the loops and the home
    /// position.
    Known(Vec<Known>),
}

/// Separates assignments of rates, `d(NAME) = RATE`, from other assignments. Returns the name and
/// rate of each separated assignment, and the text of the other assignments.
pub(super) fn rates_apart(text: &str) -> (Vec<(String, String)>, String) {
    let (mut rates, mut rest) = (Vec::new(), Vec::new());
    for part in text.split([';', '\n']) {
        let rate = part.split_once('=').and_then(|(left, right)| {
            let name = left.trim().strip_prefix("d(")?.strip_suffix(')')?;
            Some((name.trim().to_owned(), right.trim().to_owned()))
        });
        match rate {
            Some(rate) => rates.push(rate),
            None => rest.push(part),
        }
    }
    let rest = rest.join(";");
    (rates, if rest.trim().is_empty() { String::new() } else { rest })
}

/// Renumbers the actuators in `drives` after actuators were added to the robot; `place` maps an old
/// index to the new one.
pub(super) fn renumber_drives(drives: &mut Drives, place: impl Fn(usize) -> usize) {
    for (actuator, _) in &mut drives.efforts {
        *actuator = place(*actuator);
    }
    for (actuator, _) in &mut drives.laws {
        *actuator = place(*actuator);
    }
}

/// Renumbers the actuators in a controller after actuators were added to the robot; `count` is the
/// new number of actuators, and `place` maps an old index to the new one.
pub(super) fn renumber_control(
    control: &mut Control,
    count: usize,
    place: impl Fn(usize) -> usize,
) {
    let mut channels = vec![Channel::NONE; count];
    for (old, channel) in control.channels.iter().enumerate() {
        channels[place(old)] = *channel;
    }
    control.channels = channels;
    for actuator in &mut control.named {
        *actuator = place(*actuator);
    }
}

impl Forward {
    /// Finds the degrees of freedom that `name` denotes: all degrees of freedom of a joint, or a
    /// single one as `JOINT.DOF`.
    pub(super) fn dofs_of(&self, name: &str) -> Result<Vec<(JointId, usize)>, Error> {
        let joints = self.robot.mechanism().joints();
        let names: Vec<String> = joints.iter().map(|joint| joint.name.clone()).collect();
        let one = name.rsplit_once('.').and_then(|(owner, dof)| {
            let joint = joints.iter().position(|joint| joint.name == owner)?;
            let dofs = joints[joint].joint_type.dofs();
            Some((joint, dofs.iter().position(|known| known.name == dof)?))
        });
        let (joint, dofs) = match one.filter(|_| !names.iter().any(|known| known == name)) {
            Some((joint, dof)) => (joint, vec![(JointId(joint), dof)]),
            None => {
                let joint = find("joint", name, &names)?;
                let count = joints[joint].joint_type.dofs().len();
                (joint, (0..count).map(|dof| (JointId(joint), dof)).collect())
            }
        };
        if !joints[joint].joint_type.has_scalar_coordinates() {
            return Err(Error::input(format!("joint `{name}` has no scalar coordinate to lock"))
                .with_help(
                    "lock other joints; ball joints (S) and `free` joints cannot be locked",
                ));
        }
        Ok(dofs)
    }

    pub(super) fn refuse_both(&self, joint: &str, both: bool) -> Result<(), Error> {
        match both {
            false => Ok(()),
            true => Err(Error::input(format!(
                "joint `{joint}` cannot be locked and have a prescribed motion at the same time"
            ))
            .with_help("either lock it or prescribe its motion")
            .with_option("hold")),
        }
    }
}

/// Rejects a simulation with contradictory options, or with efforts or loads that become infinite.
pub(super) fn check(request: &Forward, job: &Job<'_>) -> Result<(), Error> {
    let mechanism = &job.model.mechanism;
    if let Feed::Given(drives) = job.drives {
        let named: Vec<usize> = drives.actuators().collect();
        refuse_unused(("an effort is given for", "drives"), &named, mechanism, job)?;
    }
    if let Some(control) = job.control {
        refuse_unused(("the controller names", "controller"), &control.named, mechanism, job)?;
        let is_taken =
            |actuator: &usize| job.locked.contains(actuator) || job.prescribed.contains(actuator);
        if (0..mechanism.actuators().count()).all(|actuator| is_taken(&actuator)) {
            return Err(Error::input(
                "the controller has no actuator: all are locked or have a prescribed motion",
            )
            .with_help("leave the controller out, or free an actuator")
            .with_option("controller"));
        }
    }
    if job.law.is_some() && job.control.is_some() {
        return Err(Error::input("both a control law and a controller are given")
            .with_help("leave one of them out")
            .with_option("controller"));
    }
    if job.follows() && job.motion.is_none() {
        return Err(request.robot.motion_missing());
    }
    check_start(request)?;
    check_until(request, job)?;
    if let Feed::Given(drives) = job.drives {
        refuse_gaps(drives, &job.drives_name, (job.from, job.until))?;
    }
    let sampled = job.control.map(|control| control.period).filter(|period| *period > 0.0);
    if let Some(period) = job.law.map(|law| law.period).or(sampled) {
        let samples = (job.until - job.from) / period;
        if samples > MOST_CONTROLLER_SAMPLES {
            return Err(Error::input(format!(
                "with its period of {period} s, the controller would sample {samples:.1e} times until {} s; the \
                 limit is {MOST_CONTROLLER_SAMPLES:.0e}",
                job.until
            ))
            .with_help("give the controller a longer period, or end the simulation earlier")
            .with_option("until"));
        }
    }
    refuse_poles(job)
}

/// Rejects an initial state that gives the rate of a rotation vector without its three values,
/// because the angular velocity depends on both the values and the rates.
fn check_start(request: &Forward) -> Result<(), Error> {
    let Start::Known(known) = &request.task.start else { return Ok(()) };
    let is_incomplete = known.iter().any(|one| match one.coordinate {
        Coordinate::RotationVector { body, .. } => {
            let parts = known.iter().filter(|other| {
                matches!(other.coordinate, Coordinate::RotationVector { body: own, .. } if own == body)
                    && other.value.is_some()
            });
            one.rate.is_some_and(|rate| rate != 0.0) && parts.count() < 3
        }
        _ => false,
    });
    match is_incomplete {
        false => Ok(()),
        true => Err(Error::input(
            "the rate of a rotation vector is given, but not all three of its components",
        )
        .with_help("give all of `rvx`, `rvy` and `rvz` of the body")
        .with_option("at")),
    }
}

fn check_until(request: &Forward, job: &Job<'_>) -> Result<(), Error> {
    let Some(until) = request.task.until else { return Ok(()) };
    if until.is_nan() || until.is_infinite() {
        return Err(Error::input(format!(
            "the simulation would end at {until} s, but its end must be a finite time"
        ))
        .with_help("give the time of the last sample, a finite number of seconds")
        .with_option("until"));
    }
    if until < job.from {
        return Err(Error::input(format!(
            "the simulation would end at {until} s, before its start at {} s",
            job.from
        ))
        .with_help("give a later end")
        .with_option("until"));
    }
    let recorded = job.motion.filter(|motion| motion.samples.is_some() && job.follows());
    match recorded.map(|motion| motion.start + motion.duration) {
        Some(end) if until > end => Err(Error::input(format!(
            "the recorded motion ends at {end} s, before the end of the simulation at {until} s"
        ))
        .with_help(format!("end the simulation at {end} s, or record a longer motion"))
        .with_option("until")),
        _ => Ok(()),
    }
}

/// Rejects given efforts for actuators whose effort is a result of the simulation: locked
/// actuators, and actuators with a prescribed motion.
fn refuse_unused(
    (subject, option): (&str, &'static str),
    named: &[usize],
    mechanism: &Mechanism,
    job: &Job<'_>,
) -> Result<(), Error> {
    for &actuator in named {
        let (state, cure) = if job.locked.contains(&actuator) {
            ("is locked", "do not lock it")
        } else if job.prescribed.contains(&actuator) {
            ("has a prescribed motion", "do not prescribe its motion")
        } else {
            continue;
        };
        let Some((joint, dof)) = mechanism.actuators().nth(actuator) else { continue };
        let name = mechanism.joints()[joint.0].dof_name(dof);
        return Err(Error::input(format!(
            "{subject} `{name}`, which {state}: its effort is a result of the simulation"
        ))
        .with_help(format!("leave `{name}` out, or {cure}"))
        .with_option(option));
    }
    Ok(())
}

/// Rejects a simulation that begins before the first or ends after the last sample of recorded
/// efforts.
fn refuse_gaps(drives: &Drives, name: &str, (from, until): (f64, f64)) -> Result<(), Error> {
    // A single sample is valid at all times.
    let Some(samples) = drives.samples.as_ref().filter(|samples| samples.count() > 1) else {
        return Ok(());
    };
    let Some((first, last)) = samples.ends() else { return Ok(()) };
    // Times that differ only by the rounding of decimal numbers count as equal.
    let close = 1e-9 * (last - first);
    if from < first - close {
        return Err(Error::input(format!(
            "the recorded efforts of {name} begin at {first} s, after the start of the simulation at {from} s"
        ))
        .with_help(format!("record them from {from} s on, or give the motion a later `start`")));
    }
    if until > last + close {
        return Err(Error::input(format!(
            "the recorded efforts of {name} end at {last} s, before the end of the simulation at {until} s"
        ))
        .with_help(format!("end the simulation at {last} s, or record the efforts for longer"))
        .with_option("until"));
    }
    Ok(())
}

/// Rejects forces that have a pole in time, because integration would step over the pole with
/// arbitrary results.
fn refuse_poles(job: &Job<'_>) -> Result<(), Error> {
    let refuse = |what: String, at: f64| {
        Err(Error::input(format!("{what} has no finite value at t = {at} s"))
            .with_help("end the simulation before that time, or give a formula that stays finite")
            .with_option("until"))
    };
    let mechanism = &job.model.mechanism;
    if let Feed::Given(drives) = job.drives
        && drives.samples.is_none()
    {
        for (actuator, signal) in &drives.efforts {
            if let Some(at) = pole(signal, job.from, job.until)
                && let Some((joint, dof)) = mechanism.actuators().nth(*actuator)
            {
                let name = mechanism.joints()[joint.0].actuator_name(dof);
                return refuse(format!("the effort of `{name}`"), at);
            }
        }
    }
    for wrench in &job.load.wrenches {
        let mut signals = wrench.force.iter().chain(&wrench.moment);
        if let Some(at) = signals.find_map(|signal| pole(signal, job.from, job.until)) {
            let body = &mechanism.bodies()[wrench.body.0].name;
            return refuse(format!("the load on `{body}`"), at);
        }
    }
    Ok(())
}
