//! Pictures of mechanisms: any joints, any number of legs, planar ones face-on.
//!
//! Everything comes from an assembled solver: bodies are drawn between the places of their joints,
//! joints as symbols that stand in space as their axes do.

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

/// How much a picture says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// With labels, legend, scale and axes.
    Full,
    /// A small one beside others: with scale and axes alone.
    Small,
}

/// A mechanism to be drawn, as it stands.
#[derive(Clone, Debug)]
pub struct Drawing<'a> {
    solver: &'a InverseDynamics,
    layout: Layout,
    trail: Option<&'a Trail>,
    normal: Option<Vec3<f64>>,
}

impl<'a> Drawing<'a> {
    /// The mechanism at the solver's present position.
    pub fn new(solver: &'a InverseDynamics) -> Self {
        let layout = Layout::new(solver);
        let normal = view::plane_normal(solver, &layout);
        Self { solver, layout, trail: None, normal }
    }

    /// With what a motion of the same mechanism left.
    pub fn with_trail(self, trail: &'a Trail) -> Self {
        Self { trail: Some(trail), ..self }
    }

    /// Whether all bodies move in planes that are parallel, by the joints.
    pub fn is_planar(&self) -> bool {
        self.normal.is_some()
    }

    /// From where it is seen best: a planar mechanism face-on, others from above at the right in
    /// front, turned so that joints hide each other as little as possible.
    pub fn best_view(&self) -> View {
        match self.normal {
            Some(normal) => view::face_on(self.solver, normal),
            None => view::axonometric(self.solver, &self.layout),
        }
    }

    /// How thick the mechanism appears in its best view, as a part of how long it is: zero where all
    /// joints lie on a line, as those of a slider-crank do at its dead centres.
    pub fn thickness(&self) -> f64 {
        view::thickness(&self.best_view(), &self.layout)
    }

    /// The picture as one element `svg`.
    pub fn svg(&self, view: &View, detail: Detail, surface: Surface) -> String {
        Sheet::new(self, view, detail).finish(surface)
    }
}
