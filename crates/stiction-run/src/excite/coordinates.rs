//! Coordinates of the designed motion, their names, and the position at which the motion begins.

use super::{ExciteError, ExciteSettings};
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AngleOrder, Bodies, Coordinate, Target};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_format::{ModelFile, did_you_mean};

/// Coordinates of the designed motion, and their values (`centre`) at the beginning and end of each
/// period of the motion.
pub(super) struct Chosen {
    pub(super) coordinates: Vec<Coordinate>,
    pub(super) names: Vec<String>,
    /// True for each coordinate that is an angle, rad; false for each length, m.
    pub(super) is_angle: Vec<bool>,
    pub(super) centre: Vec<f64>,
    pub(super) solver: InverseDynamics,
}

impl Chosen {
    pub(super) fn unit(&self, index: usize) -> &'static str {
        if self.is_angle[index] { "rad" } else { "m" }
    }
}

/// Chooses the coordinates of the designed motion: those of the selected motion of the model, or
/// those of the actuators. Assembles the mechanism at the first instant of the selected motion.
pub(super) fn choose(model: &ModelFile, settings: &ExciteSettings) -> Result<Chosen, ExciteError> {
    let mechanism = &model.mechanism;
    let actuated: Vec<Coordinate> =
        mechanism.actuators().map(|(joint, dof)| Coordinate::Joint { joint, dof }).collect();
    if actuated.is_empty() {
        return Err(ExciteError::input(
            "the mechanism has no actuator: no effort can be measured",
            "mark the driven joints of the model with `actuated = true`",
        ));
    }
    let first = match motion_of(model, settings)? {
        Some(motion) => {
            let coordinates: Vec<Coordinate> =
                motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
            let values: Vec<f64> = motion.at(motion.start).map(|target| target.value).collect();
            assembled(model, &coordinates, &values)?
        }
        None => {
            let values: Vec<f64> = mechanism
                .actuators()
                .map(|(joint, dof)| mechanism.joints()[joint.0].start_or_zero()[dof])
                .collect();
            assembled(model, &actuated, &values)?
        }
    };
    let prescribed = first.constraints().coordinates().to_vec();
    let (coordinates, solver) = match settings.by_actuators {
        false => (prescribed, first),
        true => {
            let values: Vec<f64> = mechanism
                .actuators()
                .map(|(joint, dof)| first.joint_motion(joint, dof).value)
                .collect();
            let again = assembled_near(model, &actuated, &values, &first)?;
            (actuated, again)
        }
    };
    let types: Vec<JointType> = mechanism.joints().iter().map(|joint| joint.joint_type).collect();
    let names = coordinates.iter().map(|c| name(mechanism, *c)).collect::<Result<_, _>>()?;
    let is_angle = coordinates.iter().map(|c| c.is_angle(&types)).collect();
    let bodies = solver.bodies();
    let at = |c: &Coordinate| match *c {
        Coordinate::Joint { joint, dof } => dof_value(mechanism, bodies, joint, dof),
        _ => f64::NAN,
    };
    let prescribed = motion_of(model, settings)?.filter(|_| !settings.by_actuators);
    let centre = match prescribed {
        Some(motion) => motion.at(motion.start).map(|target| target.value).collect(),
        None => coordinates.iter().map(at).collect(),
    };
    Ok(Chosen { coordinates, names, is_angle, centre, solver })
}

fn motion_of<'a>(
    model: &'a ModelFile,
    settings: &ExciteSettings,
) -> Result<Option<&'a stiction_format::Motion>, ExciteError> {
    match &settings.motion {
        Some(name) => model.motion(name).map(Some).ok_or_else(|| {
            let names: Vec<&str> = model.motions.iter().map(|(name, _)| name.as_str()).collect();
            let near = did_you_mean(name, "motions", names.iter().copied());
            ExciteError::input(
                format!("the model has no motion `{name}`"),
                near.unwrap_or_else(|| match names.is_empty() {
                    true => "leave --motion out: the model has no motions".to_owned(),
                    false => format!("the motions are {}", names.join(", ")),
                }),
            )
        }),
        None => {
            let name = model.default_motion.as_deref();
            let named = name.and_then(|name| model.motion(name));
            let first = model.motions.first().map(|(_, motion)| motion);
            Ok(named.or(first))
        }
    }
}

fn assembled(
    model: &ModelFile,
    coordinates: &[Coordinate],
    values: &[f64],
) -> Result<InverseDynamics, ExciteError> {
    let targets: Vec<Target<f64>> =
        values.iter().map(|&value| Target { value, rate: 0.0, acceleration: 0.0 }).collect();
    let (mechanism, poses) = (model.mechanism.clone(), &model.initial_poses);
    InverseDynamics::new(mechanism, poses, coordinates, &targets, Settings::default()).map_err(
        |error| {
            ExciteError::no_answer(
                format!("the mechanism cannot be assembled at the first position: {error}"),
                "choose another motion with --motion, or check `home` and `start` in the model",
            )
        },
    )
}

/// Assembles the mechanism with other prescribed coordinates, starting from the configuration of
/// `near`, so that the mechanism stays in the same assembly mode.
fn assembled_near(
    model: &ModelFile,
    coordinates: &[Coordinate],
    values: &[f64],
    near: &InverseDynamics,
) -> Result<InverseDynamics, ExciteError> {
    let poses = near.bodies().pose.iter().enumerate().skip(1);
    let mut model = model.clone();
    model.initial_poses =
        poses.map(|(body, pose)| (stiction_core::mechanism::BodyId(body), *pose)).collect();
    assembled(&model, coordinates, values)
}

/// Returns the name that a coordinate has in the columns of recorded motions.
fn name(mechanism: &Mechanism, coordinate: Coordinate) -> Result<String, ExciteError> {
    const AXES: [char; 3] = ['x', 'y', 'z'];
    let body = |body: stiction_core::mechanism::BodyId| &mechanism.bodies()[body.0].name;
    Ok(match coordinate {
        Coordinate::Position { body: b, axis } => format!("{}.{}", body(b), AXES[axis]),
        Coordinate::RotationVector { body: b, axis } => format!("{}.rv{}", body(b), AXES[axis]),
        Coordinate::Angle { body: b, order: AngleOrder::XYZ, index } => {
            format!("{}.r{}", body(b), AXES[index])
        }
        Coordinate::Angle { body: b, .. } => {
            return Err(ExciteError::input(
                format!(
                    "the angles of {} are not in the order xyz, which is the only one that a CSV file can express",
                    body(b)
                ),
                "give --actuators, or a motion with angles in the order xyz",
            ));
        }
        Coordinate::Joint { joint, dof } => mechanism.joints()[joint.0].dof_name(dof),
    })
}

/// Returns the coordinate of a joint's degree of freedom, m or rad, with angles within half a turn.
/// Returns NaN if the joint has no scalar coordinates.
pub(super) fn dof_value(
    mechanism: &Mechanism,
    bodies: &Bodies<f64>,
    joint: JointId,
    dof: usize,
) -> f64 {
    let content = &mechanism.joints()[joint.0];
    if !content.joint_type.has_scalar_coordinates() {
        return f64::NAN;
    }
    let relative = bodies.frame_j[joint.0].inverse() * bodies.frame_k[joint.0];
    content.joint_type.misfit(relative, content.pitch).1[dof]
}
