//! Motions through waypoints: consecutive moves from rest to rest, which overlap in blends.

use super::law::Profile;
use std::sync::Arc;
use stiction_core::kinematics::Target;
use stiction_core::spatial::{Mat3, Vec3};

/// A move between two waypoints.
#[derive(Clone, Debug)]
pub(crate) struct Move {
    /// Time at which the move begins, s.
    pub(crate) begin: f64,
    pub(crate) profile: Profile,
}

impl Move {
    pub(crate) fn end(&self) -> f64 {
        self.begin + self.profile.duration
    }
}

/// Moves of a motion, in increasing order of both their begin and their end. Neighbouring moves may
/// overlap.
#[derive(Clone, Debug)]
pub(crate) struct Moves(pub(crate) Vec<Move>);

impl Moves {
    /// Returns the number of moves that have ended at the time `t`, s, and the moves under way.
    /// Each move under way is given by its index, and by its completed fraction with the first two
    /// derivatives.
    fn under_way(&self, t: f64) -> (usize, impl Iterator<Item = (usize, [f64; 3])> + '_) {
        let ended = self.0.partition_point(|each| each.end() <= t);
        let begun = self.0.iter().enumerate().skip(ended).take_while(move |(_, m)| m.begin < t);
        (ended, begun.map(move |(k, each)| (k, each.profile.at(t - each.begin))))
    }

    /// Returns the first time after `t`, s, at which a move begins, ends, or passes one of its
    /// [`Profile::knots`]; `None` if no such time follows.
    pub(crate) fn after(&self, t: f64) -> Option<f64> {
        let near = self.0.iter().skip(self.0.partition_point(|each| each.end() <= t)).take(2);
        near.flat_map(|each| {
            let knots = each.profile.knots().into_iter().map(|knot| each.begin + knot);
            [each.begin, each.end()].into_iter().chain(knots)
        })
        .filter(|&knot| knot > t)
        .min_by(f64::total_cmp)
    }
}

/// A coordinate that moves through given values; there is one value more than moves.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    pub(crate) moves: Arc<Moves>,
    pub(crate) values: Vec<f64>,
}

impl Course {
    /// Value and derivatives of the coordinate with respect to the completed fraction `part` of
    /// move `k`.
    pub(crate) fn along(&self, k: usize, part: f64) -> Target<f64> {
        let value = |k: usize| self.values.get(k).copied().unwrap_or(f64::NAN);
        let step = value(k + 1) - value(k);
        Target { value: value(k) + step * part, rate: step, acceleration: 0.0 }
    }

    pub(crate) fn at(&self, t: f64) -> Target<f64> {
        let value = |k: usize| self.values.get(k).copied().unwrap_or(f64::NAN);
        let (ended, under_way) = self.moves.under_way(t);
        let mut sum = [value(ended), 0.0, 0.0];
        for (k, profile) in under_way {
            let step = value(k + 1) - value(k);
            for (sum, part) in sum.iter_mut().zip(profile) {
                *sum += step * part;
            }
        }
        let [value, rate, acceleration] = sum;
        Target { value, rate, acceleration }
    }
}

/// A body that rotates through given orientations, in each move about a fixed axis according to the motion law. The
/// moves do not overlap.
#[derive(Clone, Debug)]
pub(crate) struct Turning {
    pub(crate) moves: Arc<Moves>,
    /// Orientations at the waypoints; there is one more than moves.
    pub(crate) orientations: Vec<Mat3<f64>>,
    /// Rotation vector of each move, in the body's axes at the beginning of the move.
    pub(crate) turns: Vec<Vec3<f64>>,
}

impl Turning {
    pub(crate) fn new(moves: &Arc<Moves>, orientations: Vec<Mat3<f64>>) -> Self {
        let turns = orientations
            .windows(2)
            .map(|pair| (pair[0].transpose() * pair[1]).rotation_vector())
            .collect();
        Self { moves: Arc::clone(moves), orientations, turns }
    }

    /// Returns a time, s, near which the rotation vector passes half a turn, so that its components
    /// jump; `None` if this does not happen.
    pub(crate) fn half_turn(&self) -> Option<f64> {
        let vector = |t: f64| {
            let [x, y, z] = self.at(t).map(|target| target.value);
            Vec3::new(x, y, z)
        };
        self.moves.0.iter().find_map(|each| {
            let time = |k: u32| each.begin + each.profile.duration * f64::from(k) / 100.0;
            // In a hundredth of a move, the body rotates by less than one radian, so a greater
            // change is a jump.
            (1..=100).find(|&k| (vector(time(k)) - vector(time(k - 1))).norm() > 1.0).map(time)
        })
    }

    /// Rotation vector of the orientation at time `t`, s, with its time derivatives.
    pub(crate) fn at(&self, t: f64) -> [Target<f64>; 3] {
        let (ended, mut under_way) = self.moves.under_way(t);
        let rotation = self.orientations.get(ended).copied().unwrap_or(Mat3::identity());
        match under_way.next() {
            None => Target::of_rotation(rotation, Vec3::zero(), Vec3::zero()),
            Some((k, state)) => self.along(k, state),
        }
    }

    /// Rotation vector of the orientation, with its derivatives, when the fraction `part` of move
    /// `k` is completed. `rate` and `acceleration` are the derivatives of this fraction.
    pub(crate) fn along(&self, k: usize, [part, rate, acceleration]: [f64; 3]) -> [Target<f64>; 3] {
        let rotation = self.orientations.get(k).copied().unwrap_or(Mat3::identity());
        let turn = self.turns.get(k).copied().unwrap_or(Vec3::zero());
        let axis = rotation * turn;
        let about = turn.direction().unwrap_or(Vec3::unit(0));
        let turned = rotation * Mat3::rotation(about, turn.norm() * part);
        Target::of_rotation(turned, axis * rate, axis * acceleration)
    }
}
