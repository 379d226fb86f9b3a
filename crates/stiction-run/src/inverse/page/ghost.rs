//! Motion that the mechanism gains near a singular configuration, for the animation of the robot.

use crate::inverse::animation::Nearest;
use stiction_core::mechanism::Mechanism;
use stiction_core::parameters::Parameters;
use stiction_core::spatial::Vec3;
use stiction_core::statics::Statics;
use stiction_core::statics::newton_euler::NewtonEuler;
use stiction_draw::viewer::Ghost;

/// Determines the least-constrained motion of the mechanism with locked actuators at a sample. `idle_axes` contains each
/// body that can rotate freely about an axis, with this axis in the axes of the body. `None` if the mechanism has no such
/// least-constrained motion.
pub(super) fn least_constrained(
    mechanism: &Mechanism,
    idle_axes: &[(usize, Vec3<f64>)],
    at: &Nearest,
) -> Option<Ghost> {
    let (bodies, pose) = (&at.bodies, &at.bodies.pose);
    let balance = NewtonEuler::new(mechanism, &Parameters::new(mechanism), bodies);
    let statics = Statics::new(mechanism, balance, bodies.frame_j.clone());
    let idle: Vec<_> =
        idle_axes.iter().map(|&(body, axis)| (body, pose[body].rotation * axis)).collect();
    let gained = statics.weakest_motion(&idle)?;
    let twists = gained.twists.iter().zip(pose).map(|(twist, pose)| {
        let velocity = twist.linear + twist.angular.cross(pose.position);
        [velocity, twist.angular].map(Vec3::to_array)
    });
    let twists: Vec<_> = twists.collect();
    twists.iter().flatten().flatten().all(|x| x.is_finite()).then_some(Ghost {
        time: at.time,
        index: at.index,
        twists,
    })
}
