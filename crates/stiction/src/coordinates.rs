//! Look-up of independent coordinates by name.

use crate::error::Error;
use crate::robot::Robot;
use stiction_core::kinematics::Coordinate as Which;
use stiction_run::exchange::Home;

/// Returns the name, the coordinate and the home value, m or rad, of each independent coordinate:
/// the coordinates with the given names or, if `names` is `None`, those of all actuators.
pub(crate) fn named(
    robot: &Robot,
    home: &Home<'_>,
    names: Option<&[String]>,
) -> Result<Vec<(String, Which, f64)>, Error> {
    let of_joint = |which| match which {
        Which::Joint { joint, dof } => home.coordinates[joint.0].get(dof).copied().flatten(),
        _ => None,
    };
    match names {
        None => {
            let actuators = home.mechanism.actuators().zip(&robot.names().actuators);
            let each = actuators.map(|((joint, dof), (name, _))| {
                let which = Which::Joint { joint, dof };
                (name.clone(), which, of_joint(which).unwrap_or(0.0))
            });
            Ok(each.collect())
        }
        Some(names) => {
            let each = names.iter().map(|name| {
                let which = which(robot, name)?;
                let mut prescribed = home.motion.iter();
                let known = prescribed.find(|(known, _)| *known == which);
                let value = known.map(|(_, target)| target.value).or_else(|| of_joint(which));
                let value = value.ok_or_else(|| {
                    Error::input(format!(
                        "the home value of `{name}` is not known: the motion does not prescribe it"
                    ))
                    .with_help("use joint coordinates, or a motion that prescribes this coordinate")
                    .with_option("motion")
                })?;
                Ok((name.clone(), which, value))
            });
            each.collect()
        }
    }
}

/// Finds the coordinate with the given name, such as `leg1.P` or `platform.x`.
pub(crate) fn which(robot: &Robot, name: &str) -> Result<Which, Error> {
    let is_name = |c: char| c.is_alphanumeric() || "._-".contains(c);
    if name.is_empty() || !name.chars().all(is_name) {
        return Err(Error::input(format!("`{}` is not a coordinate", name.escape_debug()))
            .with_help("give a name such as `leg1.P` or `platform.x`"));
    }
    let names = robot.names();
    if let Ok(index) = names.coordinate(name) {
        let (_, joint, dof) = names.coordinates[index];
        return Ok(Which::Joint { joint, dof });
    }
    let motion = robot.parse_state(&format!("{name} = 0; duration = 0"))?;
    match motion.coordinates.first() {
        Some((coordinate, _)) => Ok(*coordinate),
        None => Err(Error::input(format!("`{name}` is not a coordinate"))),
    }
}
