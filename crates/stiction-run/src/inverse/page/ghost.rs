//! Motion that the mechanism gains near a singular configuration, for the animation of the robot.

use crate::instants::Instants;
use crate::job::Job;
use stiction_core::spatial::Vec3;
use stiction_draw::viewer::Ghost;

/// Number of samples that the mechanism advances in one step on the way to the requested time.
const STRIDE: usize = 16;

/// Determines the least-constrained motion of the mechanism with locked actuators at a time, s.
/// `index` is the actuation singularity index at this time. `None` if the mechanism cannot follow
/// the motion to that time, or has no such least-constrained motion.
pub(super) fn least_constrained(job: &Job<'_>, time: f64, index: f64) -> Option<Ghost> {
    let instants: Instants = job.instants().ok()?;
    let mut follower = job.assemble(instants.at(0)).ok()?;
    let between = instants.iter().skip(1).step_by(STRIDE).take_while(|at| *at < time);
    for at in between.collect::<Vec<_>>() {
        follower.go_to(at).ok()?;
    }
    if time > follower.time() {
        follower.go_to(time).ok()?;
    }
    let solver = &follower.solver;
    let gained = solver.statics().weakest_motion(&solver.idle_axes())?;
    let twists = gained.twists.iter().zip(&solver.bodies().pose).map(|(twist, pose)| {
        let velocity = twist.linear + twist.angular.cross(pose.position);
        [velocity, twist.angular].map(Vec3::to_array)
    });
    let twists: Vec<_> = twists.collect();
    twists.iter().flatten().flatten().all(|x| x.is_finite()).then_some(Ghost {
        time,
        index,
        twists,
    })
}
