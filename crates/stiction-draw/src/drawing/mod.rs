//! Pictures of mechanisms: any joints, any number of legs, planar ones face-on.
//!
//! An assembled solver provides the geometry: bodies are drawn between the positions of their
//! joints, and joints as symbols oriented along their axes in space.

mod hull;
mod labels;
mod layout;
mod legend;
mod sheet;
mod style;
mod svg;
mod symbols;
mod trail;
mod view;

pub use style::Surface;
pub use trail::Trail;
pub use view::View;

use layout::Layout;
use sheet::Sheet;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::spatial::Vec3;

/// Level of detail of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// With labels, legend, scale and axes.
    Full,
    /// Small, with scale and axes only.
    Small,
}

/// Drawing of a mechanism at its current pose.
#[derive(Clone, Debug)]
pub struct Drawing<'a> {
    solver: &'a InverseDynamics,
    layout: Layout,
    trail: Option<&'a Trail>,
    normal: Option<Vec3<f64>>,
}

impl<'a> Drawing<'a> {
    /// Draws the mechanism at the solver's current pose.
    pub fn new(solver: &'a InverseDynamics) -> Self {
        let layout = Layout::new(solver);
        let normal = view::plane_normal(solver, &layout);
        Self { solver, layout, trail: None, normal }
    }

    /// Adds the paths of a motion of the same mechanism.
    pub fn with_trail(self, trail: &'a Trail) -> Self {
        Self { trail: Some(trail), ..self }
    }

    /// True if all bodies move in parallel planes.
    pub fn is_planar(&self) -> bool {
        self.normal.is_some()
    }

    /// Best view: face-on for a planar mechanism; otherwise oblique from the upper right front,
    /// rotated so that joints hide each other as little as possible.
    pub fn best_view(&self) -> View {
        match self.normal {
            Some(normal) => view::face_on(self.solver, normal),
            None => view::axonometric(self.solver, &self.layout),
        }
    }

    /// Apparent thickness in the best view relative to the length: zero if all joints lie on a
    /// line, as for a slider-crank at its dead centres.
    pub fn thickness(&self) -> f64 {
        view::thickness(&self.best_view(), &self.layout)
    }

    /// Picture as one `svg` element.
    pub fn svg(&self, view: &View, detail: Detail, surface: Surface) -> String {
        Sheet::new(self, view, detail).finish(surface)
    }
}
