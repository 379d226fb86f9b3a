//! View of a mechanism along a motion, without forces: a page with the animated robot, and an
//! animated picture.

use crate::bodies::poses_in_world;
use crate::report::animation::Animation;
use crate::report::html::{self, section};
use crate::report::{footer, header, version};
use crate::{Error, Job};
use stiction_core::spatial::Pose;
use stiction_draw::drawing::moving_picture;
use stiction_draw::numbers::number;

/// Number of frames of the animated picture.
const FRAMES: usize = 32;
/// Shortest and longest duration of the animated picture, s.
const SECONDS: (f64, f64) = (2.0, 8.0);

/// HTML page and animated picture of a motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    /// Complete HTML page.
    pub html: String,
    /// Animated picture as SVG, on a white background.
    pub picture: String,
}

/// Draws the mechanism of a job along its motion.
///
/// # Errors
/// Returns an error of the job if the mechanism cannot follow the motion.
pub fn draw_view(job: &Job<'_>) -> Result<View, Error> {
    let instants = job.instants()?;
    let count = instants.count();
    let mechanism = &job.model.mechanism;
    let mut animation = Animation::of_motion(job.model, count);
    let mut follower = job.assemble(instants.at(0))?;
    let mut frames: Vec<Vec<Pose<f64>>> = Vec::new();
    for (k, time) in instants.iter().enumerate() {
        if k > 0 {
            follower.go_to(time)?;
        }
        // Frames are spaced as for a periodic motion, whose last instant equals the first.
        if k * FRAMES >= frames.len() * count && frames.len() < FRAMES {
            let solver = &follower.solver;
            frames.push(poses_in_world(solver.bodies(), solver.parameters().origin).collect());
        }
        animation.push_motion(time, &follower.solver);
    }
    let about =
        format!("Motion {}, {} s; no forces.", job.motion_name, number(job.motion.duration));
    let inner = [
        header(job.model, &about),
        section("The robot", &animation.figure(&job.motion.title, None)),
        version(),
        footer(job.model),
    ];
    let seconds = job.motion.duration.clamp(SECONDS.0, SECONDS.1);
    Ok(View {
        html: html::page_with_robot(&format!("{}: view", job.model.name), &inner.concat()),
        picture: moving_picture(mechanism, &frames, seconds),
    })
}
