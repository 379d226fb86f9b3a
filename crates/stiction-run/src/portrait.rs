//! Pictures of a mechanism for HTML pages: the mechanism at the most legible instant of its motion,
//! in the best view.

use crate::report::animation::Animation;
use crate::{Error, Job};
use stiction_core::dynamics::InverseDynamics;
use stiction_draw::drawing::{Detail, Drawing, Surface, Trail, View};

/// Ratio of thickness to length of the drawn mechanism. Below this ratio, the mechanism looks like
/// a line, and other instants of the motion are compared.
const THIN: f64 = 0.1;
/// Number of instants of the motion that are compared to find the most legible drawing.
const COMPARED: usize = 12;

/// Pictures of a mechanism at the most legible instant of its motion, with the paths of its bodies.
pub struct Portrait {
    /// Mechanism at the start of the motion.
    pub start: InverseDynamics,
    /// Mechanism at the pictured instant.
    shown: InverseDynamics,
    /// Time of the pictured instant, s.
    pub time: f64,
    trail: Trail,
    /// Animation of the whole motion; `None` if the motion is a single pose.
    motion: Option<Animation>,
}

impl Portrait {
    /// Follows the motion of a job and selects the most legible instant.
    ///
    /// # Errors
    /// See [`enum@Error`].
    pub fn of(job: &Job<'_>) -> Result<Self, Error> {
        let instants = job.instants()?;
        let first = instants.at(0);
        let mut follower = job.assemble(first)?;
        let start = follower.solver.clone();
        let mechanism = &job.model.mechanism;
        let count = instants.count();
        let mut motion = (count > 1).then(|| Animation::of_motion(job.model, count));
        if let Some(motion) = &mut motion {
            motion.push_motion(first, &start);
        }
        let mut trail = Trail::new(mechanism, &start.bodies().pose);
        let mut best = Drawing::new(mechanism, &start.bodies().pose).thickness();
        let (mut shown, mut time) = (start.clone(), first);
        let every = (instants.count() / COMPARED).max(1);
        for (k, now) in instants.iter().enumerate().skip(1) {
            follower.go_to(now)?;
            let solver = &follower.solver;
            trail.add(mechanism, &solver.bodies().pose);
            if let Some(motion) = &mut motion {
                motion.push_motion(now, solver);
            }
            if best < THIN && k.is_multiple_of(every) {
                let thickness = Drawing::new(mechanism, &solver.bodies().pose).thickness();
                if thickness > 2.0 * best + 1e-3 {
                    (best, time) = (thickness, now);
                    shown = solver.clone();
                }
            }
        }
        Ok(Self { start, shown, time, trail, motion })
    }

    fn drawing(&self) -> Drawing<'_> {
        Drawing::new(self.shown.mechanism(), &self.shown.bodies().pose).with_trail(&self.trail)
    }

    /// Draws the mechanism in the best view.
    pub fn svg(&self, surface: Surface) -> String {
        let drawing = self.drawing();
        drawing.svg(&drawing.best_view(), Detail::Full, surface)
    }

    /// Draws the mechanism in the best view, for inclusion in a page.
    pub fn inline_svg(&self) -> String {
        self.svg(Surface::Inline)
    }

    /// Returns the HTML of the animated robot, for a page that contains the script of the viewer;
    /// `None` if the motion is a single pose.
    pub(crate) fn moving(&self, caption: &str) -> Option<String> {
        Some(self.motion.as_ref()?.figure(caption, None))
    }

    /// Draws further views, each with its name; none for a planar mechanism, whose best view is face-on.
    pub fn more_views(&self) -> Vec<(&'static str, String)> {
        let drawing = self.drawing();
        if drawing.is_planar() {
            return Vec::new();
        }
        let named =
            |view: View| Some((view.words()?, drawing.svg(&view, Detail::Small, Surface::Inline)));
        [View::front(), View::side(), View::top()].into_iter().filter_map(named).collect()
    }
}
