//! Animated picture of a mechanism as one SVG file: a sequence of frames that CSS shows one after
//! the other.

use super::labels::{Area, view_box};
use super::sheet::{Sheet, sheet};
use super::springs::spring_ends;
use super::style::{Surface, style};
use super::{Detail, Drawing, Trail};
use crate::xml::escape;
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::Pose;

/// Draws a motion that repeats every `seconds` s. Each frame contains the poses of all bodies, the
/// ground first; the frames are equally spaced in time. Viewers without animations and readers who
/// ask for reduced motion see the first frame.
pub fn moving_picture(mechanism: &Mechanism, frames: &[Vec<Pose<f64>>], seconds: f64) -> String {
    let Some(first) = frames.first() else { return String::new() };
    let mut trail = Trail::new(mechanism, first);
    frames[1..].iter().for_each(|poses| trail.add(mechanism, poses));
    let mut drawings: Vec<Drawing<'_>> =
        frames.iter().map(|poses| Drawing::new(mechanism, poses)).collect();
    let view = drawings[0].best_view();
    // All frames have the same scale, so the extent of each frame includes the joints of all
    // frames, the centres of bodies with a single joint, and the ends of springs.
    let lonely = |drawing: &Drawing<'_>, body: usize| drawing.layout.joints[body].len() < 2;
    let coms = drawings.iter().zip(frames).flat_map(|(drawing, poses)| {
        let bodies = mechanism.bodies().iter().zip(poses).enumerate().skip(1);
        let own = bodies.filter(|(body, _)| lonely(drawing, *body));
        own.map(|(_, (body, pose))| pose.apply(body.com)).collect::<Vec<_>>()
    });
    let places = drawings.iter().flat_map(|drawing| drawing.layout.places.iter().copied());
    let springs = drawings.iter().flat_map(|drawing| spring_ends(&drawing.placed));
    let extent: Vec<_> = places.chain(coms).chain(springs.flatten()).collect();
    drawings.iter_mut().for_each(|drawing| drawing.extent.clone_from(&extent));
    let with_paths = Drawing { trail: Some(&trail), ..drawings[0].clone() };
    // A path follows the mean position of a body's joints, so it lies within the extent.
    let (paths, mut area) = Sheet::new(&with_paths, &view, Detail::Full).paths();
    let every = 1.0 / frames.len() as f64;
    let mut drawn = String::new();
    for (k, drawing) in drawings.iter().enumerate() {
        let (frame, own) = Sheet::new(drawing, &view, Detail::Full).bare();
        area.include(&own);
        let delay = seconds * (k as f64 * every - 1.0);
        drawn += &format!(r#"<g class="frame" style="animation-delay:{delay:.3}s">{frame}</g>"#);
    }
    area.include(&Area::around([0.0; 2], [1.0; 2]));
    area.least = area.least.map(|x| (x - 10.0).floor());
    area.greatest = area.greatest.map(|x| (x + 10.0).ceil());
    let (name, share) = (escape(mechanism.name()), 100.0 * every);
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" class="mechanism" role="img" aria-label="{name}" viewBox="{}"><title>{name}</title><style>{}.frame{{visibility:hidden;animation:frame {seconds:.3}s step-end infinite}}.frame:first-of-type{{visibility:visible}}@keyframes frame{{0%{{visibility:visible}}{share:.4}%{{visibility:hidden}}100%{{visibility:hidden}}}}@media (prefers-reduced-motion:reduce){{.frame{{animation:none}}}}</style>{}{drawn}{paths}</svg>"#,
        view_box(&area),
        style(Surface::Paper),
        sheet(&area),
    )
}
