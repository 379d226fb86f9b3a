//! Pictures of mechanisms with any joints and any number of legs; planar mechanisms are seen face-on.
//!
//! The poses of the bodies provide the geometry: bodies are drawn between the positions of their
//! joints, and joints as symbols oriented along their axes in space.

mod hull;
mod labels;
mod layout;
mod legend;
mod moving;
mod placed;
mod scene;
mod sheet;
mod springs;
mod style;
mod svg;
mod symbols;
mod trail;
mod view;

pub use layout::{legs_of_joints, outputs};
pub use moving::moving_picture;
pub(crate) use style::tones;
pub use style::{BRANCHES, BRANCHES_ON_DARK, Surface};
pub(crate) use svg::{Px, px};
pub use trail::Trail;
pub use view::View;

use layout::Layout;
use placed::Placed;
use sheet::Sheet;
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::{Pose, Vec3};

/// Level of detail of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// Picture with labels, legend, scale and axes.
    Full,
    /// Small picture with scale and axes only.
    Small,
}

/// Drawing of a mechanism at given poses of its bodies.
#[derive(Clone, Debug)]
pub struct Drawing<'a> {
    placed: Placed<'a>,
    layout: Layout,
    trail: Option<&'a Trail>,
    /// Points that the picture must contain in addition to those of the drawn mechanism, m. The
    /// list begins with one position of each joint; these positions determine the size of the
    /// symbols.
    extent: Vec<Vec3<f64>>,
    normal: Option<Vec3<f64>>,
}

impl<'a> Drawing<'a> {
    /// Creates the drawing of a mechanism. `poses` are the poses of all bodies, the ground first,
    /// in world axes and relative to a common origin.
    pub fn new(mechanism: &'a Mechanism, poses: &[Pose<f64>]) -> Self {
        let placed = Placed::new(mechanism, poses);
        let layout = Layout::new(&placed);
        let normal = view::plane_normal(&placed, &layout);
        Self { placed, layout, trail: None, extent: Vec::new(), normal }
    }

    /// Adds the paths of a motion of this mechanism to the drawing.
    pub fn with_trail(self, trail: &'a Trail) -> Self {
        Self { trail: Some(trail), ..self }
    }

    /// Returns `true` if all bodies move in parallel planes.
    pub fn is_planar(&self) -> bool {
        self.normal.is_some()
    }

    /// Returns the best view: face-on for a planar mechanism; otherwise oblique from the upper
    /// right front, rotated so that joints hide each other as little as possible.
    pub fn best_view(&self) -> View {
        match self.normal {
            Some(normal) => view::face_on(&self.placed, normal),
            None => view::axonometric(&self.placed, &self.layout),
        }
    }

    /// Returns the mean position of the joints in world axes, relative to the common origin of the
    /// poses, m.
    pub fn middle(&self) -> Vec3<f64> {
        layout::mean(self.layout.places.iter().copied()).unwrap_or_else(Vec3::zero)
    }

    /// Returns the apparent thickness of the mechanism in the best view, relative to the apparent
    /// length: zero if all joints lie on a line, as in a slider-crank at its dead centres.
    pub fn thickness(&self) -> f64 {
        view::thickness(&self.best_view(), &self.layout)
    }

    /// Draws the picture as one `svg` element.
    pub fn svg(&self, view: &View, detail: Detail, surface: Surface) -> String {
        Sheet::new(self, view, detail).finish(surface)
    }
}
