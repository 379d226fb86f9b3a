//! Motion of bodies in space: their paths, their references, and the tracking errors.

use stiction_core::kinematics::Coordinate;
use stiction_core::spatial::{Pose, Vec3};
use stiction_draw::figure::meaning::{REFERENCE, RESULT};
use stiction_draw::figure::{Figure, Line, Panel, PathTrace, Plane, Trace};
use stiction_format::{ModelFile, Motion};

/// Body whose motion in space is reported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tracked {
    /// Index of the body.
    pub body: usize,
    /// Name of the body.
    pub name: String,
    /// True if the orientation of the body is a part of its task; false if the motion prescribes
    /// only its position.
    pub turns: bool,
}

/// Tracking error of a body: distance of its origin from the origin of the reference, m, and angle
/// between both orientations, rad.
pub type SpaceError = [f64; 2];

/// Position, reference and tracking error of a body at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacePoint {
    /// Position of the body's origin in the world, m.
    pub position: [f64; 3],
    /// Position of the reference in the world, m.
    pub reference: [f64; 3],
    /// Tracking error: distance, m, and angle, rad.
    pub errors: SpaceError,
}

impl SpacePoint {
    /// Names and units of [`Self::values`].
    pub const COLUMNS: [&str; 8] = [
        "x [m]",
        "y [m]",
        "z [m]",
        "reference.x [m]",
        "reference.y [m]",
        "reference.z [m]",
        "error [m]",
        "error_angle [rad]",
    ];

    /// Number of leading columns that contain the position. `bodies.csv` contains these columns
    /// even without a reference.
    const POSITION: usize = 3;

    /// Returns the position, the reference and the tracking errors, in the order of
    /// [`Self::COLUMNS`].
    pub fn values(&self) -> [f64; 8] {
        let ([x, y, z], [of_x, of_y, of_z], [distance, angle]) =
            (self.position, self.reference, self.errors);
        [x, y, z, of_x, of_y, of_z, distance, angle]
    }

    /// Returns the reference and the tracking errors, in the order of the columns that [`columns`]
    /// names.
    pub(crate) fn followed(&self) -> impl Iterator<Item = f64> {
        self.values().into_iter().skip(Self::POSITION)
    }
}

/// Name of the horizontal axis of a plot over time.
const TIME: &str = "time [s]";
/// A path counts as constant along an axis if its extent along this axis is below this fraction of
/// its greatest extent along any axis.
const FLAT: f64 = 1e-6;
/// A projection of a path is not drawn if both its width and its height are below this fraction of
/// the greatest extent of the path along any axis.
const SMALL: f64 = 0.05;
/// Largest angle, rad, between two orientations that counts as a rounding error.
const ROUNDING: f64 = 1e-9;

/// Returns the bodies whose motion in space is reported: the bodies whose position or orientation
/// the motion prescribes. If there are none, returns the output bodies of the mechanism: platforms,
/// the end of an arm, or couplers.
pub fn tracked(model: &ModelFile, motion: Option<&Motion>) -> Vec<Tracked> {
    let name = |body: usize| model.mechanism.bodies()[body].name.clone();
    let mut found: Vec<Tracked> = Vec::new();
    for (coordinate, _) in motion.iter().flat_map(|motion| &motion.coordinates) {
        let (body, turns) = match coordinate {
            Coordinate::Position { body, .. } => (body.0, false),
            Coordinate::Angle { body, .. } | Coordinate::RotationVector { body, .. } => {
                (body.0, true)
            }
            Coordinate::Joint { .. } => continue,
        };
        match found.iter_mut().find(|known| known.body == body) {
            Some(known) => known.turns |= turns,
            None => found.push(Tracked { body, name: name(body), turns }),
        }
    }
    if found.is_empty() {
        let bodies = stiction_draw::drawing::outputs(&model.mechanism).into_iter();
        found.extend(bodies.map(|body| Tracked { body, name: name(body), turns: true }));
    }
    found
}

/// Returns the tracking error of a pose relative to its reference.
fn error(pose: &Pose<f64>, reference: &Pose<f64>) -> SpaceError {
    let turn = reference.rotation.transpose() * pose.rotation;
    [(pose.position - reference.position).norm(), turn.rotation_vector().norm()]
}

/// Returns the position, the reference and the tracking error of a pose.
pub(crate) fn compare(pose: &Pose<f64>, reference: &Pose<f64>) -> SpacePoint {
    SpacePoint {
        position: pose.position.to_array(),
        reference: reference.position.to_array(),
        errors: error(pose, reference),
    }
}

/// Returns the names of the columns in `bodies.csv` for the reference of a tracked body and its
/// errors.
pub(crate) fn columns(tracked: &Tracked) -> impl Iterator<Item = String> {
    let columns = SpacePoint::COLUMNS.into_iter().skip(SpacePoint::POSITION);
    columns.map(|column| format!("{}.{column}", tracked.name))
}

/// Number of columns that [`columns`] returns.
pub(crate) const WIDTH: usize = SpacePoint::COLUMNS.len() - SpacePoint::POSITION;

/// One curve in a plot of paths: the path of a body in one run, or the path of its reference.
/// Points are in m.
pub(crate) struct Path {
    pub(crate) label: String,
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) colour: usize,
    pub(crate) dashed: bool,
}

/// Draws the paths of bodies, projected on the planes in which the bodies move; `None` if no path
/// extends along two axes.
pub(crate) fn paths(title: &str, bodies: &[(&Tracked, Vec<Path>)]) -> Option<Figure> {
    let mut panels = Vec::new();
    for (tracked, paths) in bodies {
        for axes in planes(paths.iter().flat_map(|path| &path.points)) {
            let line = |path: &Path| Line {
                label: path.label.clone(),
                points: path.points.iter().map(|point| (point[axes[0]], point[axes[1]])).collect(),
                colour: path.colour,
                dashed: path.dashed,
            };
            let label = |axis: usize| format!("{}.{} [m]", tracked.name, ["x", "y", "z"][axis]);
            panels.push(Panel {
                y_label: label(axes[1]),
                lines: paths.iter().map(line).collect(),
                plane: Some(Plane { x_label: label(axes[0]), body: tracked.body, axes }),
                ..Panel::default()
            });
        }
    }
    let title = title.to_owned();
    (!panels.is_empty()).then_some(Figure { title, x_label: String::new(), panels })
}

/// Returns the planes on which paths are projected: the views from the front, from the side and
/// from above. Each plane is given by the indices of its horizontal and vertical axes (0 is x).
/// Projections that show only a line along an axis, or almost a point, are left out.
fn planes<'p>(points: impl Iterator<Item = &'p [f64; 3]>) -> Vec<[usize; 2]> {
    let mut ends = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    for point in points.filter(|point| point.iter().all(|x| x.is_finite())) {
        for ((low, high), x) in ends.iter_mut().zip(point) {
            (*low, *high) = (low.min(*x), high.max(*x));
        }
    }
    let extents = ends.map(|(low, high)| (high - low).max(0.0));
    let sizes = ends.map(|(low, high)| low.abs().max(high.abs()));
    let greatest = extents.into_iter().fold(0.0, f64::max);
    // Far from the origin, rounding errors are larger.
    let noise = 1e-12 * sizes.into_iter().filter(|x| x.is_finite()).fold(0.0, f64::max);
    let moves = extents.map(|extent| extent > (FLAT * greatest).max(noise));
    [[0, 2], [1, 2], [0, 1]]
        .into_iter()
        .filter(|[a, b]| moves[*a] && moves[*b])
        .filter(|[a, b]| extents[*a].max(extents[*b]) > SMALL * greatest)
        .collect()
}

/// Returns the title of the plot of paths.
pub(crate) fn title_of<'t>(tracked: impl Iterator<Item = &'t Tracked>) -> String {
    let names: Vec<&str> = tracked.map(|tracked| tracked.name.as_str()).collect();
    format!("Path of {}", names.join(", "))
}

/// Curves of the tracking errors of a body in one run over time: distance and angle.
#[derive(Clone, Debug)]
pub(crate) struct Followed {
    pub(crate) label: String,
    pub(crate) colour: usize,
    pub(crate) dashed: bool,
    pub(crate) errors: [Trace; 2],
    peaks: [f64; 2],
}

impl Followed {
    /// Creates empty curves with room for `count` samples.
    pub(crate) fn new(label: &str, (colour, dashed): (usize, bool), count: usize) -> Self {
        let errors = [Trace::new(count), Trace::new(count)];
        Self { label: label.to_owned(), colour, dashed, errors, peaks: [0.0; 2] }
    }

    /// Adds the tracking errors at a time, s.
    pub(crate) fn push(&mut self, time: f64, errors: SpaceError) {
        for ((trace, peak), value) in self.errors.iter_mut().zip(&mut self.peaks).zip(errors) {
            trace.push(time, value);
            if value.is_finite() {
                *peak = peak.max(value);
            }
        }
    }

    /// Largest distance, m, and largest angle, rad, of a body as far as plots show them: zero for an angle that is no
    /// part of the task or is a rounding error.
    pub(crate) fn shown_peaks(&self, tracked: &Tracked) -> SpaceError {
        let [distance, angle] = self.peaks;
        [distance, if tracked.turns && angle > ROUNDING { angle } else { 0.0 }]
    }
}

/// Draws the tracking errors of bodies over time; `None` if all distances are zero and no shown
/// angle exceeds rounding errors.
pub(crate) fn errors_of(title: &str, bodies: Vec<(&Tracked, Vec<Followed>)>) -> Option<Figure> {
    let mut panels = Vec::new();
    for (tracked, runs) in bodies {
        let peak =
            |k: usize| runs.iter().map(|run| run.shown_peaks(tracked)[k]).fold(0.0, f64::max);
        let (distance, angle) = (unit_of_length(peak(0)), unit_of_angle(peak(1)));
        let is_shown = [peak(0) > 0.0, peak(1) > 0.0];
        let mut lines = [Vec::new(), Vec::new()];
        for run in runs {
            let factors = [distance.1, angle.1];
            for ((lines, trace), factor) in lines.iter_mut().zip(run.errors).zip(factors) {
                let mut line = trace.line(&run.label, run.colour, run.dashed);
                line.points.iter_mut().for_each(|point| point.1 *= factor);
                lines.push(line);
            }
        }
        let units = [distance.0, angle.0];
        let whats = ["distance from the reference", "angle from the reference"];
        for (((lines, is_shown), unit), what) in
            lines.into_iter().zip(is_shown).zip(units).zip(whats)
        {
            if is_shown {
                let y_label = format!("{}: {what} [{unit}]", tracked.name);
                panels.push(Panel { y_label, lines, ..Panel::default() });
            }
        }
    }
    let figure = Figure { title: title.to_owned(), x_label: TIME.to_owned(), panels };
    (!figure.is_empty()).then_some(figure)
}

/// Returns a unit of length in which `peak`, m, has few digits before the decimal point, and the
/// factor from metres to this unit.
pub(crate) fn unit_of_length(peak: f64) -> (&'static str, f64) {
    match peak {
        x if x < 1e-4 => ("um", 1e6),
        x if x < 1.0 => ("mm", 1e3),
        _ => ("m", 1.0),
    }
}

/// Returns a unit of angle in which `peak`, rad, has few digits before the decimal point, and the
/// factor from radians to this unit.
pub(crate) fn unit_of_angle(peak: f64) -> (&'static str, f64) {
    match peak.to_degrees() {
        x if x < 1e-2 => ("mdeg", 1f64.to_degrees() * 1e3),
        _ => ("deg", 1f64.to_degrees()),
    }
}

/// Collects the paths of bodies in a run, and their tracking errors if the run follows a reference.
#[derive(Clone, Debug)]
pub(crate) struct SpaceCurves {
    tracked: Vec<Tracked>,
    paths: Vec<PathTrace>,
    /// Paths of the references of the tracked bodies; empty if the run follows no reference.
    references: Vec<PathTrace>,
    errors: Vec<Followed>,
}

impl SpaceCurves {
    /// Creates empty curves with room for `count` samples.
    pub(crate) fn new(tracked: Vec<Tracked>, follows: bool, count: usize) -> Self {
        let followed = if follows { tracked.len() } else { 0 };
        Self {
            paths: vec![PathTrace::new(count); tracked.len()],
            references: vec![PathTrace::new(count); followed],
            errors: vec![Followed::new("error", (RESULT, false), count); followed],
            tracked,
        }
    }

    /// Adds the positions of the tracked bodies; `position` returns the position of the body with a
    /// given index, m.
    pub(crate) fn add(&mut self, position: impl Fn(usize) -> Vec3<f64>) {
        for (path, tracked) in self.paths.iter_mut().zip(&self.tracked) {
            path.push(position(tracked.body).to_array());
        }
    }

    /// Adds the references and the tracking errors at a time, s; for each tracked body, `numbers`
    /// contains the values of the columns that [`columns`] names.
    pub(crate) fn add_references(&mut self, time: f64, numbers: &[f64]) {
        let each = self.references.iter_mut().zip(&mut self.errors);
        for ((path, errors), row) in each.zip(numbers.chunks_exact(WIDTH)) {
            path.push([row[0], row[1], row[2]]);
            errors.push(time, [row[3], row[4]]);
        }
    }

    /// Returns the plots of the paths and of the tracking errors with their file names.
    pub(crate) fn figures(self, about: &str) -> Vec<(&'static str, Figure)> {
        let mut references = self.references.into_iter();
        let mut errors = self.errors.into_iter();
        let (mut bodies, mut followed) = (Vec::new(), Vec::new());
        for (tracked, path) in self.tracked.iter().zip(self.paths) {
            let drawn = |label: &str, colour: usize, trace: PathTrace| Path {
                label: label.to_owned(),
                points: trace.into_points(),
                colour,
                dashed: colour == REFERENCE,
            };
            let mut own = vec![drawn("path", RESULT, path)];
            own.extend(references.next().map(|trace| drawn("reference", REFERENCE, trace)));
            bodies.push((tracked, own));
            followed.extend(errors.next().map(|errors| (tracked, vec![errors])));
        }
        let paths = paths(&format!("{}: {about}", title_of(self.tracked.iter())), &bodies);
        let errors = errors_of(&format!("Tracking error in space: {about}"), followed);
        let paths = paths.map(|figure| ("path", figure));
        paths.into_iter().chain(errors.map(|figure| ("space-error", figure))).collect()
    }
}
