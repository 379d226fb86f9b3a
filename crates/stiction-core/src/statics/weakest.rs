//! Least-constrained motions: the motion gained at a singular configuration, and the load that
//! joints and actuators cannot balance there.

use super::distance::{Constraints, of_legs};
use super::rank::{RANK_LIMIT, Statics};
use crate::linalg::{Decomposition, Svd};
use crate::mechanism::Mechanism;
use crate::spatial::{Twist, Vec3, describe_direction, describe_motion};
use nalgebra::{DMatrix, DVector};

/// A motion of all bodies. One of the bodies, [`Self::body`], serves to describe the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct GainedTwist {
    /// Twist of each body about the reference point, scaled such that `body` turns by one radian
    /// or, if it does not turn, moves by one metre.
    pub twists: Vec<Twist<f64>>,
    /// Body that describes the motion: the body with the most joints among those with considerable
    /// motion.
    pub body: usize,
    /// True if `body` turns.
    pub turns: bool,
    /// Number of independent unconstrained motions, including this one but not passive spins or
    /// other motions that are known beforehand; at least one.
    pub of: usize,
}

impl GainedTwist {
    /// Describes the motion in words: returns the name of the body and a description of its twist.
    /// `origin` is the reference point in the world.
    pub fn in_words(&self, mechanism: &Mechanism, origin: Vec3<f64>) -> (String, String) {
        let name = mechanism.bodies()[self.body].name.clone();
        let in_world = self.twists[self.body].about(-origin);
        (name, describe_motion(in_world, mechanism.characteristic_length()))
    }

    /// Describes in words a load on [`Self::body`] that is infeasible because it does work on the
    /// motion. `length` is the characteristic length, m.
    pub fn load_in_words(&self, length: f64) -> String {
        let Twist { angular, linear } = self.twists[self.body];
        let Some(axis) = angular.direction().filter(|_| self.turns) else {
            return match linear.direction() {
                Some(direction) => format!("a force along {}", describe_direction(direction)),
                None => "no load".to_owned(),
            };
        };
        let pitch = angular.dot(linear) / angular.norm_squared();
        if pitch.abs() > 1e-6 * length {
            format!("a moment about {} or a force along it", describe_direction(axis))
        } else {
            format!("a moment about {}", describe_direction(axis))
        }
    }
}

/// A passive spin: index of the body, and rotation axis in world axes.
pub(crate) type IdleAxis = (usize, Vec3<f64>);

/// Singular values below this fraction of the largest count as zero. Their singular vectors are not
/// unique.
const MIXED: f64 = 1e-9;

impl Statics {
    /// Finds the least-constrained motion with locked actuators, apart from the passive spins
    /// `idle`. This motion is the twist gained at a configuration with zero
    /// [`Statics::actuation_distance`]. Returns `None` if the balance does not have more equations
    /// than there are passive spins.
    pub fn weakest_motion(&self, idle: &[IdleAxis]) -> Option<GainedTwist> {
        let transposed = self.scaled_matrix().transpose();
        let bodies = self.system().bodies_of_rows();
        let transposed = Decomposition::new(transposed, &bodies, RANK_LIMIT);
        let equations: Vec<usize> = (0..bodies.len()).collect();
        self.weakest(&transposed, &equations, idle.len(), idle)
    }

    /// Finds the motion that is resisted least, apart from `others` known motions that are resisted
    /// even less. The rows of `transposed` are unit wrenches of the scaled balance; its columns are
    /// the equations with the indices `equations`.
    fn weakest(
        &self,
        transposed: &Decomposition,
        equations: &[usize],
        others: usize,
        idle: &[IdleAxis],
    ) -> Option<GainedTwist> {
        let kept = equations.len().checked_sub(others + 1)?;
        let zero = MIXED * transposed.largest().max(f64::MIN_POSITIVE);
        let in_place = |vector: &[f64]| {
            let mut all = DVector::zeros(self.system().matrix.nrows());
            equations.iter().zip(vector).for_each(|(&row, &x)| all[row] = x);
            all
        };
        if let Some(motion) = transposed.weakest()
            && transposed.rank() == kept + 1
            && transposed.value(kept) > zero
        {
            // All motions that are resisted less are known.
            return Some(self.described(&self.scale_rows(&in_place(motion))));
        }
        let svd = transposed.svd();
        let basis: Vec<DVector<f64>> =
            svd.null_space(kept).iter().map(|vector| in_place(vector.as_slice())).collect();
        let distinct = svd.singular_values[kept] > zero;
        let motion = if distinct || basis.len() == 1 {
            basis.first()?.clone()
        } else {
            // Select the unconstrained motion with the smallest passive-spin component.
            let rest: Vec<_> = basis.iter().map(|vector| without_spins(vector, idle)).collect();
            let amounts = Svd::new(&DMatrix::from_columns(&rest)).v.column(0).into_owned();
            DMatrix::from_columns(&basis) * amounts
        };
        let open = svd.singular_values.iter().filter(|&&value| value <= zero).count();
        let of = open.saturating_sub(others).max(1);
        Some(GainedTwist { of, ..self.described(&self.scale_rows(&motion)) })
    }

    /// Describes a motion of all bodies. `motion` contains the velocity of the centre of mass and
    /// the angular velocity of each body except the ground.
    pub(crate) fn described(&self, motion: &DVector<f64>) -> GainedTwist {
        let part = |body: usize, at: usize| {
            let row = 6 * (body - 1) + at;
            Vec3::new(motion[row], motion[row + 1], motion[row + 2])
        };
        let bodies = motion.len() / 6;
        let size = |body: usize| part(body, 0).norm().max(part(body, 3).norm() * self.length());
        // Prefer a body with many joints and considerable motion: a platform.
        let most = (1..=bodies).map(size).fold(0.0, f64::max);
        let joints = self.system().joints_at_bodies();
        let body = (1..=bodies)
            .filter(|&body| size(body) > 0.2 * most)
            .max_by(|&a, &b| joints[a].cmp(&joints[b]).then(size(a).total_cmp(&size(b))))
            .unwrap_or(1);
        let (moves, turns_by) = (part(body, 0).norm(), part(body, 3).norm());
        let turns = turns_by * self.length() > 1e-6 * moves;
        let size = if turns { turns_by } else { moves };
        let scale = if size > 0.0 { 1.0 / size } else { 0.0 };
        let mut twists = vec![Twist::zero()];
        for body in 1..=bodies {
            let (velocity, angular) = (part(body, 0) * scale, part(body, 3) * scale);
            twists
                .push(Twist { angular, linear: velocity - angular.cross(self.system().com(body)) });
        }
        GainedTwist { twists, body, turns, of: 1 }
    }
}

impl Constraints<'_> {
    /// Finds the motion that the constraints resist least, apart from the `mobility` motions that
    /// they permit in every regular configuration. `idle` are the axes of the passive spins.
    pub fn weakest_motion(&self, mobility: usize, idle: &[IdleAxis]) -> Option<GainedTwist> {
        let equations: Vec<usize> = (0..self.transposed().matrix().ncols()).collect();
        self.statics().weakest(self.transposed(), &equations, mobility, idle)
    }

    /// Finds the motion of the bodies between hubs that the constraints resist least while the hubs
    /// are fixed.
    pub fn weakest_leg_motion(&self, idle: &[IdleAxis]) -> Option<GainedTwist> {
        let equations = of_legs(self.statics().system());
        self.statics().weakest(&self.legs(&equations), &equations, idle.len(), idle)
    }
}

/// Removes the passive spins of bodies from a motion.
fn without_spins(motion: &DVector<f64>, idle: &[IdleAxis]) -> DVector<f64> {
    let mut rest = motion.clone();
    for &(body, axis) in idle {
        let row = 6 * (body - 1) + 3;
        let spin = (0..3).map(|k| rest[row + k] * axis.component(k)).sum::<f64>();
        (0..3).for_each(|k| rest[row + k] -= spin * axis.component(k));
    }
    rest
}
