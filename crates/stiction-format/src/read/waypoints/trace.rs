//! Motions of joints and body origins, computed from the coordinates of waypoints by inverse
//! kinematics.

use super::curve::Curve;
use super::limits::{Followed, FollowedPath, Limited, LimitedPath};
use super::{Channel, Goal};
use crate::diagnostic::{Diagnostic, quoted};
use crate::document::Table;
use crate::read::motion::Reader;
use crate::signal::waypoints::{Course, Moves, Turning};
use std::sync::Arc;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::{AssemblyError, Coordinate, Target};

/// Distance from an end of an interval, as a fraction of the interval's length. Motions are
/// evaluated at this distance from the ends instead of at the ends.
const INSIDE: f64 = 1e-12;

/// Coordinates that the waypoints prescribe, with their values as functions of time.
pub(super) struct Goals {
    courses: Vec<(Coordinate, Course)>,
    turnings: Vec<(Vec<Coordinate>, Turning)>,
}

impl Goals {
    /// Creates the signals of the coordinates of all channels for these moves.
    pub(super) fn new(channels: &[Channel], moves: &Arc<Moves>) -> Self {
        let (mut courses, mut turnings) = (Vec::new(), Vec::new());
        for channel in channels {
            match &channel.goal {
                Goal::Scalar(coordinate, _, values) => {
                    let course = Course { moves: Arc::clone(moves), values: values.clone() };
                    courses.push((*coordinate, course));
                }
                Goal::Orientation(body, orientations) => {
                    let axes = (0..3).map(|axis| Coordinate::RotationVector { body: *body, axis });
                    turnings.push((axes.collect(), Turning::new(moves, orientations.clone())));
                }
            }
        }
        Self { courses, turnings }
    }

    fn coordinates(&self) -> Vec<Coordinate> {
        let scalars = self.courses.iter().map(|(coordinate, _)| *coordinate);
        scalars.chain(self.turnings.iter().flat_map(|(axes, _)| axes.clone())).collect()
    }

    /// Returns the targets of all coordinates when the fraction `part` of move `k` is completed.
    /// Their derivatives are with respect to this fraction.
    fn along(&self, k: usize, part: f64) -> Vec<Target<f64>> {
        let scalars = self.courses.iter().map(|(_, course)| course.along(k, part));
        let state = [part, 1.0, 0.0];
        scalars.chain(self.turnings.iter().flat_map(|(_, turn)| turn.along(k, state))).collect()
    }

    /// Targets of the prescribed coordinates at a time, s.
    fn at(&self, t: f64) -> Vec<Target<f64>> {
        let scalars = self.courses.iter().map(|(_, course)| course.at(t));
        scalars.chain(self.turnings.iter().flat_map(|(_, turning)| turning.at(t))).collect()
    }
}

/// Assembles the mechanism at the first waypoint. Returns `None` if the mechanism has defects.
fn first(reader: &Reader<'_>, goals: &Goals) -> Option<Result<InverseDynamics, AssemblyError>> {
    let assembly = reader.assembly?;
    let (mechanism, poses) = (assembly.mechanism.clone(), assembly.initial_poses);
    let targets = goals.along(0, 0.0);
    let settings = Settings::default();
    Some(InverseDynamics::new(mechanism, poses, &goals.coordinates(), &targets, settings))
}

/// Fits curves to quantities along a motion of the mechanism. `targets` returns the prescribed
/// coordinates at an argument in `interval`. Returns the curves of the components of all
/// quantities, one quantity after another; `None` if they are not smooth.
fn fit(
    solver: &mut InverseDynamics,
    followed: &[Followed],
    interval: (f64, f64),
    targets: impl Fn(f64) -> Vec<Target<f64>>,
) -> Result<Option<Vec<Curve>>, AssemblyError> {
    // Rates may jump at the beginning of the interval; the solver starts with those just after it.
    solver.move_to(&targets(interval.0))?;
    let begin = solver.clone();
    let go_to = |solver: &mut InverseDynamics, from: f64, to: f64| {
        solver.follow(from, to, |at, out| {
            out.iter_mut().zip(targets(at)).for_each(|(out, target)| *out = target);
        })
    };
    let components = followed.iter().map(|each| each.components()).sum();
    let curves = Curve::fit(interval, components, |arguments| {
        *solver = begin.clone();
        let mut now = interval.0;
        let mut samples = Vec::with_capacity(arguments.len());
        for &argument in arguments {
            go_to(solver, now, argument)?;
            now = argument;
            samples.push(followed.iter().flat_map(|each| motion_of(solver, *each)).collect());
        }
        Ok(samples)
    })?;
    Ok(curves)
}

/// Rate and acceleration of each component of a quantity.
fn motion_of(solver: &InverseDynamics, followed: Followed) -> Vec<[f64; 2]> {
    match followed {
        Followed::Joint(joint, dof) => {
            let Target { rate, acceleration, .. } = solver.joint_motion(joint, dof);
            vec![[rate, acceleration]]
        }
        Followed::Origin(body) => {
            let bodies = solver.bodies();
            let (place, twist) = (bodies.pose[body.0].position, bodies.twist[body.0]);
            let velocity = twist.velocity_at(place);
            let acceleration =
                bodies.acceleration[body.0].velocity_at(place) + twist.angular.cross(velocity);
            let pairs = velocity.to_array().into_iter().zip(acceleration.to_array());
            pairs.map(|(rate, acceleration)| [rate, acceleration]).collect()
        }
    }
}

/// Groups the curves of components by quantity.
pub(super) fn by_quantity(followed: &[Followed], curves: &[Curve]) -> Vec<Vec<Curve>> {
    let mut rest = curves;
    let each = followed.iter().map(|each| {
        let (own, after) = rest.split_at(each.components().min(rest.len()));
        rest = after;
        own.to_vec()
    });
    each.collect()
}

/// Computes the curves, in each move, of all limited quantities that follow from the coordinates of
/// the waypoints, and stores them in `found`. Returns `None` if the mechanism cannot follow a move
/// or a quantity is not smooth; the error has then been reported.
pub(super) fn joints(
    reader: &Reader<'_>,
    channels: &[Channel],
    tables: &[&Table],
    found: &mut [Limited],
) -> Option<()> {
    let joints: Vec<Followed> = found.iter().filter_map(followed).collect();
    if joints.is_empty() {
        return Some(());
    }
    let goals = Goals::new(channels, &Arc::new(Moves(Vec::new())));
    let refuse = |table: &Table, why: String| {
        let names: Vec<String> = found
            .iter()
            .filter(|each| followed(each).is_some())
            .take(3)
            .map(|each| quoted(&each.path))
            .collect();
        reader.context.push(
            Diagnostic::error(
                "motion",
                format!("the limits of {} cannot be evaluated: {why}", names.join(", ")),
            )
            .at(reader.context.place(&table.span), "on the way to this waypoint")
            .help("choose other waypoints, or limit the coordinates of the waypoints instead"),
        );
    };
    let mut solver = match first(reader, &goals)? {
        Ok(solver) => solver,
        Err(error) => {
            refuse(tables.first()?, error.to_string());
            return None;
        }
    };
    let mut all: Vec<Vec<Vec<Curve>>> = Vec::new();
    for (k, table) in tables.iter().skip(1).enumerate() {
        let curves = fit(&mut solver, &joints, (0.0, 1.0), |part| goals.along(k, part));
        let problem = match curves {
            Ok(Some(curves)) => {
                all.push(by_quantity(&joints, &curves));
                continue;
            }
            Ok(None) => "the motion of these coordinates is not smooth there, for example near a \
                singular position"
                .to_owned(),
            Err(error) => error.to_string(),
        };
        refuse(table, problem);
        return None;
    }
    let ways = found.iter_mut().filter_map(|limited| match &mut limited.way {
        LimitedPath::Followed(way) => Some(way),
        LimitedPath::Straight(_) => None,
    });
    for (index, FollowedPath { curves, .. }) in ways.enumerate() {
        curves.extend(all.iter().map(|of_move| of_move[index].clone()));
    }
    Some(())
}

fn followed(limited: &Limited) -> Option<Followed> {
    match &limited.way {
        LimitedPath::Followed(way) => Some(way.of),
        LimitedPath::Straight(_) => None,
    }
}

/// Computes curves, as functions of time, of all limited quantities that follow from the
/// coordinates of the waypoints. `start` is the time, s, at which the motion starts. `corners` are
/// the times, s, at which overlapping moves begin, end or change their phase. Returns the
/// components for each interval between corners and each quantity; `None` if a quantity is not
/// smooth or the mechanism cannot follow the motion.
pub(super) fn between(
    reader: &Reader<'_>,
    goals: &Goals,
    limited: &[Limited],
    (start, corners): (f64, &[f64]),
) -> Option<Vec<Vec<Vec<Curve>>>> {
    let joints: Vec<Followed> = limited.iter().filter_map(followed).collect();
    let mut solver = first(reader, goals)?.ok()?;
    let mut now = start;
    let mut all = Vec::new();
    for pair in corners.windows(2) {
        let go = |at: f64, out: &mut [Target<f64>]| {
            out.iter_mut().zip(goals.at(at)).for_each(|(out, target)| *out = target);
        };
        let [from, to] = [pair[0], pair[1]];
        solver.follow(now, from, go).ok()?;
        // The acceleration may jump at corners, so the motion is evaluated only between them.
        let inside = (INSIDE * (to - from)).max(4.0 * f64::EPSILON * to.abs());
        let targets = |t: f64| goals.at(t.max(from + inside).min(to - inside));
        all.push(by_quantity(&joints, &fit(&mut solver, &joints, (from, to), targets).ok()??));
        now = to;
    }
    Some(all)
}
