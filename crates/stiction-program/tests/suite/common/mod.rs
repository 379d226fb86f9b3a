//! Robots of the gallery along their default motions, for recording.
#![allow(dead_code, reason = "each test uses a part")]

use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_format::{ModelFile, Source, gallery, read};

/// A solver at the first position of a motion, and the inputs of a recording.
pub(crate) struct Robot {
    pub(crate) solver: InverseDynamics,
    /// Prescribed values in the middle part of the motion.
    pub(crate) signal: Vec<Vec<Target<f64>>>,
    pub(crate) loads: Vec<AppliedLoad<f64>>,
}

/// Reads a model from its text.
pub(crate) fn model(name: &str, text: &str) -> ModelFile {
    match read(&Source::new(name, text), &|_| Err("no files".into())) {
        Ok(model) => model,
        Err(error) => panic!("{name}: {error:?}"),
    }
}

impl Robot {
    /// A gallery model under one of its loads, or the default one.
    pub(crate) fn new(name: &str, load: Option<&str>) -> Self {
        Self::of(&model(name, gallery::get(name).unwrap()), load)
    }

    /// The default motion of a model.
    pub(crate) fn of(model: &ModelFile, load: Option<&str>) -> Self {
        let motion = model.motion(model.default_motion.as_deref().unwrap()).unwrap();
        let load = model.load(load.or(model.default_load.as_deref()).unwrap()).unwrap();
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let signal: Vec<Vec<_>> = (0..10)
            .map(|k| motion.at(0.1 * (f64::from(k) + 0.37) * motion.duration).collect())
            .collect();
        let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
        let solver = InverseDynamics::new(
            mechanism,
            initial_poses,
            &coordinates,
            &signal[0],
            Settings::default(),
        );
        let solver = solver.unwrap_or_else(|error| panic!("{error}"));
        let loads = load.at(0.1).collect();
        Self { solver, signal, loads }
    }
}

/// A solver with the actuators as independent coordinates, and their positions along the default
/// motion.
pub(crate) struct Loop {
    pub(crate) solver: InverseDynamics,
    pub(crate) signal: Vec<Vec<Target<f64>>>,
}

/// The control loop of a gallery model; `None` if the actuators do not determine the motion.
pub(crate) fn gallery_loop(name: &str) -> Option<Loop> {
    Loop::of(Robot::new(name, None))
}

impl Loop {
    /// The control loop of a robot; `None` if its actuators do not determine the motion.
    pub(crate) fn of(robot: Robot) -> Option<Self> {
        let Robot { mut solver, signal, .. } = robot;
        let actuators: Vec<_> = solver.mechanism().actuators().collect();
        let mut own: Vec<Vec<Target<f64>>> = Vec::new();
        let mut home = None;
        for targets in &signal {
            solver.move_to(targets).ok()?;
            let mut now = Vec::new();
            for (k, (joint, dof)) in actuators.iter().enumerate() {
                let mut target = solver.joint_motion(*joint, *dof);
                (target.rate, target.acceleration) = (0.0, 0.0);
                // The solver returns angles within half a turn; this makes them continuous.
                let is_angle =
                    !solver.mechanism().joints()[joint.0].joint_type.dofs()[*dof].translates();
                if let Some(before) = own.last().filter(|_| is_angle) {
                    let turns = ((target.value - before[k].value) / core::f64::consts::TAU).round();
                    target.value -= turns * core::f64::consts::TAU;
                }
                now.push(target);
            }
            own.push(now);
            home.get_or_insert_with(|| {
                solver.mechanism().starting_at(solver.bodies().joint_poses())
            });
        }
        let coordinate = |(joint, dof): &(_, _)| Coordinate::Joint { joint: *joint, dof: *dof };
        let coordinates: Vec<_> = actuators.iter().map(coordinate).collect();
        let solver = InverseDynamics::new(home?, &[], &coordinates, &own[0], Settings::default());
        Some(Self { solver: solver.ok()?, signal: own })
    }
}

/// A slide, two hinges of which the second has a collar, and a screw that a guide prevents from
/// turning, with `friction` at the joint in question.
pub(crate) fn machine(kind: &str, friction: &str) -> Loop {
    let body = |name: &str, com: f64| {
        format!(
            "[bodies.{name}]\nmass = \"10 kg\"\ncom = [\"{com} m\", 0, 0]\n\
             inertia = [\"0.1 kg m^2\", \"0.2 kg m^2\", \"0.25 kg m^2\"]\n"
        )
    };
    let parts = match kind {
        "slide" => {
            body("block", 0.0)
                + "[joints.x]\ntype = \"P\"\nfrom = \"ground\"\nto = \"block\"\naxis = \"x\"\n\
                   actuated = true\nfriction = "
                + friction
        }
        "wrist" => {
            body("arm", 0.2)
                + &body("hand", 0.1)
                + "[joints.x]\ntype = \"R\"\nfrom = \"ground\"\nto = \"arm\"\naxis = \"y\"\n\
                   actuated = true\n\
                   [joints.y]\ntype = \"R\"\nfrom = \"arm\"\nto = \"hand\"\nat = [\"0.4 m\", 0, 0]\n\
                   axis = \"z\"\nactuated = true\nfriction = "
                + friction
        }
        _ => {
            body("spindle", 0.0)
                + &body("nut", 0.01)
                + "[joints.x]\ntype = \"R\"\nfrom = \"ground\"\nto = \"spindle\"\naxis = \"z\"\n\
                   actuated = true\n\
                   [joints.guide]\ntype = \"P\"\nfrom = \"ground\"\nto = \"nut\"\naxis = \"z\"\n\
                   at = [\"0.2 m\", 0, 0]\nto_at = [\"0.2 m\", 0, 0]\n\
                   friction = { mu = 0.05, bending_span = \"0.1 m\" }\n\
                   [joints.screw]\ntype = \"H\"\nfrom = \"spindle\"\nto = \"nut\"\naxis = \"z\"\n\
                   pitch = \"10 mm/rev\"\nfriction = "
                + friction
        }
    };
    let unit = if kind == "slide" { "m" } else { "rad" };
    let second = if kind == "wrist" { "y = \"0.3 rad*t\"\n" } else { "" };
    let text = format!(
        "gravity = [0, 0, \"-9.81 m/s^2\"]\n{parts}\n[motions.m]\nduration = \"1 s\"\n\
         x = \"0.1 {unit}*t\"\n{second}[loads.none]\n[default]\nmotion = \"m\"\nload = \"none\"\n"
    );
    Loop::of(Robot::of(&model(kind, &text), None)).unwrap()
}
