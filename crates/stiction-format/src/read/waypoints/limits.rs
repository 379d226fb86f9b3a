//! Reader of the limits of speed, acceleration and jerk in motions through waypoints.

use super::curve::Curve;
use super::joints;
use super::{Channel, Goal};
use crate::diagnostic::{Diagnostic, number, quoted};
use crate::document::{Table, Value};
use crate::expression::Measure;
use crate::fields::Field;
use crate::fields::tables::{ANGULAR_LIMITS, LIMITS};
use crate::read::context::Record;
use crate::read::motion::Reader;
use crate::signal::law::{Limits, UNLIMITED};
use crate::source::Span;
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::{BodyId, JointId};
use stiction_core::spatial::{Mat3, Vec3};

/// Limits of speed, acceleration and jerk of one quantity: a coordinate, the position of a body's
/// origin, the orientation of a body, or a degree of freedom of a joint.
pub(super) struct Limited {
    pub(super) path: String,
    pub(super) limits: Limits,
    pub(super) way: LimitedPath,
}

/// Dependence of a limited quantity on the path parameter of a move.
pub(super) enum LimitedPath {
    /// Quantity that is linear in the path parameter, given by its displacement in each move. For a
    /// scalar coordinate, only the first component is used.
    Straight(Vec<Vec3<f64>>),
    /// Quantity that inverse kinematics computes from the coordinates of the waypoints.
    Followed(FollowedPath),
}

/// Quantity that is computed from the coordinates of the waypoints.
#[derive(Clone, Copy)]
pub(super) enum Followed {
    /// Coordinate of a degree of freedom of a joint.
    Joint(JointId, usize),
    /// Position of the origin of a body, with three components.
    Origin(BodyId),
}

impl Followed {
    /// Number of components of the quantity.
    pub(super) fn components(self) -> usize {
        match self {
            Self::Joint(..) => 1,
            Self::Origin(_) => 3,
        }
    }
}

/// Quantity that inverse kinematics computes. `curves` contains, for each move, the components of
/// the quantity as functions of the completed fraction of the move.
pub(super) struct FollowedPath {
    pub(super) of: Followed,
    pub(super) curves: Vec<Vec<Curve>>,
}

impl Limited {
    /// Returns the displacement of the quantity in move `k`; zero for a quantity computed by
    /// inverse kinematics.
    pub(super) fn step(&self, k: usize) -> Vec3<f64> {
        match &self.way {
            LimitedPath::Straight(steps) => steps.get(k).copied().unwrap_or(Vec3::zero()),
            LimitedPath::Followed(_) => Vec3::zero(),
        }
    }

    /// Returns the components of a quantity computed by inverse kinematics in move `k`; `None` if
    /// it does not change in this move, and for any other quantity.
    pub(super) fn curve(&self, k: usize) -> Option<&[Curve]> {
        let LimitedPath::Followed(way) = &self.way else { return None };
        let components = way.curves.get(k)?;
        components.iter().any(Curve::moves).then_some(components)
    }
}

/// Reads the limits of a motion through waypoints from the table `value`. Reports an error and
/// returns `None` if a limit is invalid.
pub(super) fn read(
    reader: &Reader<'_>,
    (motion, value): (&Record<'_>, &Value),
    (channels, tables): (&[Channel], &[&Table]),
) -> Option<Vec<Limited>> {
    let context = reader.context;
    let Some(table) = value.as_table() else {
        context.wrong(value, "a table such as { tool = { speed = \"1 m/s\" } }");
        return None;
    };
    let mut found: Vec<Limited> = Vec::new();
    let mut pending: Vec<(String, &Table, Span)> = vec![(String::new(), table, value.span.clone())];
    while let Some((path, table, span)) = pending.pop() {
        let is_limit = |key: &str| LIMITS.iter().any(|field| field.key == key);
        let (own, inner): (Vec<_>, Vec<_>) =
            table.entries.iter().partition(|(key, _)| is_limit(&key.name));
        for (key, value) in inner {
            match value.as_table() {
                Some(table) => {
                    let dot = if path.is_empty() { "" } else { "." };
                    pending.push((format!("{path}{dot}{}", key.name), table, key.span.clone()));
                }
                None => {
                    context.push(
                        Diagnostic::error("unknown-key", "this is not a limit")
                            .at(context.place(&key.span), "unknown key")
                            .help("limits are `speed`, `acceleration` and `jerk`"),
                    );
                    return None;
                }
            }
        }
        if own.is_empty() {
            continue;
        }
        let straight = steps(&path, channels, reader);
        let joints = match straight {
            Some(_) => Vec::new(),
            None => joints::named(reader, &path)?,
        };
        let origin = if straight.is_none() { reader.names.body(&path) } else { None };
        let fields = match (&straight, joints.first()) {
            (Some((_, fields)), _) => Some(*fields),
            (None, Some((.., Measure::Angle))) => Some(ANGULAR_LIMITS),
            (None, joint) => joint.map(|_| LIMITS).or(origin.map(|_| LIMITS)),
        };
        let Some(fields) = fields else {
            let message = match path.as_str() {
                "" => "a limit needs the name of a coordinate, body or joint".to_owned(),
                path => format!("{} is not a coordinate of the waypoints", quoted(path)),
            };
            let names: Vec<String> = channels.iter().map(|c| quoted(&c.path)).collect();
            context.push(
                Diagnostic::error("motion", message).at(context.place(&span), "not limited").help(
                    format!(
                        "limits can be given for coordinates of the waypoints ({}), a body whose origin \
                         moves, a joint, or all `actuators`, for example `limits.BODY.speed`",
                        names.join(", ")
                    ),
                ),
            );
            return None;
        };
        let record = Record::open(context, table, fields, "the limits");
        let mut limits = UNLIMITED;
        for (limit, field) in limits.iter_mut().zip(fields) {
            let Some(value) = record.value(field.key) else { continue };
            *limit = record.quantity(field.key)?;
            if *limit <= 0.0 {
                let message =
                    format!("`{}` is {}, but must be greater than 0", field.key, number(*limit));
                context.push(
                    Diagnostic::error("range", message)
                        .at(context.place(&value.span), "not positive"),
                );
                return None;
            }
        }
        if limits[2].is_finite()
            && let Some(law) = joints::unlimited_jerk(motion, tables)
        {
            let message = "the acceleration of the law `trapezoid` jumps, so that its jerk cannot \
                be limited";
            context.push(
                Diagnostic::error("motion", message)
                    .at(context.place(&law), "this law")
                    .also(context.place(&record.span("jerk")), "limited here")
                    .help("use the law `s-curve`, or delete the limit of the jerk"),
            );
            return None;
        }
        match straight {
            Some((steps, _)) => {
                found.push(Limited { path, limits, way: LimitedPath::Straight(steps) })
            }
            None => {
                for (path, at, _) in joints {
                    let of = Followed::Joint(at.0, at.1);
                    let way = LimitedPath::Followed(FollowedPath { of, curves: Vec::new() });
                    found.push(Limited { path, limits, way });
                }
                if let Some(body) = origin {
                    let of = Followed::Origin(body);
                    let way = LimitedPath::Followed(FollowedPath { of, curves: Vec::new() });
                    found.push(Limited { path, limits, way });
                }
            }
        }
    }
    Some(found)
}

/// Returns the displacements, one for each move, of the coordinate or body named `path`, and the
/// keys of its limits. Returns `None` if the waypoints contain neither this coordinate nor the
/// position of this body.
fn steps(
    path: &str,
    channels: &[Channel],
    reader: &Reader<'_>,
) -> Option<(Vec<Vec3<f64>>, &'static [Field])> {
    let along = |values: &[f64], axis: usize| -> Vec<Vec3<f64>> {
        values.windows(2).map(|pair| Vec3::unit(axis) * (pair[1] - pair[0])).collect()
    };
    if let Some(channel) = channels.iter().find(|channel| channel.path == path) {
        return Some(match &channel.goal {
            Goal::Orientation(_, values) => {
                let turn = |pair: &[Mat3<f64>]| (pair[0].transpose() * pair[1]).rotation_vector();
                (values.windows(2).map(turn).collect(), ANGULAR_LIMITS)
            }
            Goal::Scalar(_, Measure::Angle, values) => (along(values, 0), ANGULAR_LIMITS),
            Goal::Scalar(_, _, values) => (along(values, 0), LIMITS),
        });
    }
    let body = reader.names.body(path)?;
    let mut sums: Vec<Vec3<f64>> = Vec::new();
    for channel in channels {
        if let Goal::Scalar(Coordinate::Position { body: moved, axis }, _, values) = &channel.goal
            && *moved == body
        {
            let steps = along(values, *axis);
            sums.resize(steps.len(), Vec3::zero());
            sums.iter_mut().zip(steps).for_each(|(sum, step)| *sum += step);
        }
    }
    (!sums.is_empty()).then_some((sums, LIMITS))
}
