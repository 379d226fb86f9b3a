//! Selection of coordinates to lock, such that no motion remains undetermined.

use super::super::bodies::State;
use super::super::coordinate::{Coordinate, Target};
use super::super::least_squares::PositionEquations;
use super::super::motion_constraints::MotionConstraints;
use super::super::partial::{MET, Missed, What, assemble_partly};
use super::super::system::Kinematics;
use super::super::{AssemblyError, Gap, dof};
use super::reference::Given;
use crate::linalg::{Decomposition, Limit, SparseMatrix, StaticLu, Svd};
use crate::mechanism::{BodyId, JointId};
use nalgebra::{DMatrix, DVector};

/// Singular vectors with singular values below this limit span the near-null space of the Jacobian.
const NEARLY_SINGULAR: f64 = 1e-5;
/// Step of the central differences of the Jacobian, in rad or in characteristic lengths.
const DIFFERENCE: f64 = 1e-4;
/// Maximum number of Newton steps towards a singular configuration.
const REFINEMENTS: usize = 4;

impl Given<'_> {
    /// Finds coordinates, with their values, that lock all instantaneous motions left undetermined
    /// by the prescribed coordinates at the closed configuration near the reference. If the found
    /// coordinates are prescribed as well, the configuration is regular even if the mechanism is
    /// singular or shaky.
    pub(in crate::kinematics) fn locks(&self) -> Result<Vec<(Coordinate, f64)>, AssemblyError> {
        let (topology, parameters) = (self.topology, self.parameters);
        let values: Vec<f64> = self.targets.iter().map(|target| target.value).collect();
        let prescribed = (self.coordinates, values.as_slice());
        let mut state =
            assemble_partly(self.mechanism, topology, parameters, self.homes, prescribed)
                .map_err(|missed| AssemblyError::Gap(self.gap_of(&missed)))?;
        self.refine_singular(&mut state);
        let (jacobian, _) = self.rows(&state, &[]);
        let decomposition = dof::decompose(jacobian);
        let open = decomposition.orthonormal_null_space(decomposition.rank()).dense();
        if open.is_empty() {
            return Ok(Vec::new());
        }
        let candidates = self.candidates();
        let mut rates = DMatrix::zeros(candidates.len(), open.len());
        let mut values = vec![0.0; candidates.len()];
        // Prescribing all three components of a rotation vector yields other equations than
        // prescribing one alone. Each group therefore contains at most one of the three components
        // for each body.
        for axis in 0..3 {
            let is_of = |coordinate: &Coordinate| match coordinate {
                Coordinate::RotationVector { axis: own, .. } => *own == axis,
                _ => axis == 0,
            };
            let group: Vec<usize> =
                (0..candidates.len()).filter(|&k| is_of(&candidates[k])).collect();
            let own: Vec<Coordinate> = group.iter().map(|&k| candidates[k]).collect();
            let (jacobian, errors) = self.rows(&state, &own);
            let first = errors.len() - own.len();
            for (motion, direction) in open.iter().enumerate() {
                let moved = jacobian.times(direction.as_slice());
                group.iter().zip(&moved[first..]).for_each(|(&k, rate)| rates[(k, motion)] = *rate);
            }
            group.iter().zip(&errors[first..]).for_each(|(&k, error)| values[k] = *error);
        }
        // `rates` contains the rate of each candidate (row) in each undetermined motion (column).
        // Repeatedly lock a candidate with a large rate, and remove the locked motion from the
        // rates.
        let mut locks = Vec::new();
        for _ in 0..open.len() {
            let sizes: Vec<f64> = rates.row_iter().map(|row| row.norm()).collect();
            // Take the first candidate whose rate exceeds half the greatest, so that small
            // differences do not change the choice.
            let greatest = sizes.iter().copied().fold(0.0, f64::max);
            let Some(chosen) = sizes.iter().position(|size| *size > 0.5 * greatest) else { break };
            let direction: DVector<f64> = rates.row(chosen).transpose() / sizes[chosen];
            let parts = &rates * &direction;
            rates -= parts * direction.transpose();
            locks.push((candidates[chosen], values[chosen]));
        }
        Ok(locks)
    }

    /// Computes the scaled Jacobian and the unscaled errors of loop closure, the prescribed
    /// coordinates and the `further` coordinates. All targets are zero, so the error of a
    /// coordinate is its value. The rows of `further` come last.
    fn rows(&self, state: &State<f64>, further: &[Coordinate]) -> (SparseMatrix, Vec<f64>) {
        let topology = self.topology;
        let all = [self.coordinates, further].concat();
        let constraints = MotionConstraints::new(topology, &all, &[]);
        let targets = vec![Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; all.len()];
        let mut kinematics = Kinematics::new(topology, &constraints, &StaticLu::default());
        let equations = PositionEquations::new(topology, self.parameters, &constraints, &targets);
        equations.errors(&mut kinematics, state);
        (equations.jacobian(&mut kinematics), kinematics.errors().to_vec())
    }

    /// Converts a condition that the assembly does not satisfy to a [`Gap`] for the error message.
    fn gap_of(&self, missed: &Missed) -> Gap {
        let scale = self.parameters.length;
        let (length, angle) = if missed.is_angle { (0.0, missed.by) } else { (missed.by, 0.0) };
        let open = Gap { length, angle, scale, ..Gap::default() };
        match missed.what {
            What::Joint(joint) => {
                Gap { joint: Some(self.mechanism.joints()[joint].name.clone()), ..open }
            }
            What::Gearing(gearing) => {
                let joint = Some(self.mechanism.gearings()[gearing].name.clone());
                Gap { joint, of_gearing: true, ..open }
            }
            What::Given(_) => {
                let cut = self.topology.cuts.first();
                let joint = cut.map(|cut| self.mechanism.joints()[cut.joint].name.clone());
                let missed = Gap { missed_length: length, missed_angle: angle, ..Gap::default() };
                Gap { joint, scale, ..missed }
            }
        }
    }

    /// Refines a singular configuration, which loop closure determines only to the square root of
    /// round-off. The singular values vanish linearly, so Newton's method on the near-null space of
    /// the Jacobian determines the configuration to round-off. This method solves
    /// `P J(q + V t) V = 0` for `t`, with the near-null vectors `V` and the projection `P` on the
    /// left near-null space.
    fn refine_singular(&self, state: &mut State<f64>) {
        let topology = self.topology;
        let constraints = MotionConstraints::new(topology, self.coordinates, &[]);
        let mut kinematics = Kinematics::new(topology, &constraints, &StaticLu::default());
        let equations =
            PositionEquations::new(topology, self.parameters, &constraints, self.targets);
        let mut at = |state: &State<f64>| {
            let errors = equations.errors(&mut kinematics, state);
            (errors, equations.jacobian(&mut kinematics))
        };
        let moved = |state: &State<f64>, step: &DVector<f64>| {
            let mut state = state.clone();
            state.advance(topology, &equations.unscaled(step));
            state
        };
        for _ in 0..REFINEMENTS {
            let (_, jacobian) = at(state);
            if jacobian.nrows() == 0 {
                return;
            }
            let groups: Vec<usize> = (0..jacobian.ncols()).collect();
            let limit = Limit::OfOrderOne(NEARLY_SINGULAR);
            let decomposition = Decomposition::new(jacobian, &groups, limit);
            let open = decomposition.orthonormal_null_space(decomposition.rank()).dense();
            if open.is_empty() {
                return;
            }
            let basis = DMatrix::from_columns(&open);
            // The least-squares solution leaves the part of the image outside the column space.
            let projected = |jacobian: &SparseMatrix| {
                let outside = open.iter().flat_map(|direction| {
                    let image = jacobian.times(direction.as_slice());
                    let within = decomposition.matrix().times(&decomposition.solve(&image));
                    image.into_iter().zip(within).map(|(all, part)| all - part).collect::<Vec<_>>()
                });
                DVector::from_vec(outside.collect())
            };
            let columns: Vec<DVector<f64>> = open
                .iter()
                .map(|direction| {
                    let step = direction * DIFFERENCE;
                    let ahead = projected(&at(&moved(state, &step)).1);
                    let behind = projected(&at(&moved(state, &-step)).1);
                    (ahead - behind) / (2.0 * DIFFERENCE)
                })
                .collect();
            let slopes = Svd::new(&DMatrix::from_columns(&columns));
            let right = -projected(decomposition.matrix());
            let amounts = slopes.solve(&right, slopes.rank_of_order_one(NEARLY_SINGULAR));
            let step: DVector<f64> = &basis * amounts;
            // Longer steps would lead to another configuration.
            if step.norm().is_nan() || step.norm() >= DIFFERENCE {
                return;
            }
            let refined = moved(state, &step);
            // Close the loops in the directions orthogonal to the near-null space.
            let (errors, jacobian) = at(&refined);
            let decomposition = Decomposition::new(jacobian, &groups, limit);
            let step = -DVector::from_vec(decomposition.solve(errors.as_slice()));
            let refined = moved(&refined, &step);
            // The loops stay open at a singular configuration that is no solution, such as a
            // stretched arm between its two elbow configurations.
            let open = at(&refined).0.amax();
            if open > MET || open.is_nan() {
                return;
            }
            *state = refined;
        }
    }

    /// Lists the scalar coordinates that can be locked, first those of joints, then those of
    /// bodies.
    fn candidates(&self) -> Vec<Coordinate> {
        let joints = self.mechanism.joints().iter().enumerate();
        let of_joints = joints.filter(|(_, j)| j.joint_type.has_scalar_coordinates());
        let of_joints = of_joints.flat_map(|(joint, content)| {
            (0..content.joint_type.dofs().len())
                .map(move |dof| Coordinate::Joint { joint: JointId(joint), dof })
        });
        let of_bodies = (1..self.mechanism.bodies().len()).flat_map(|body| {
            let body = BodyId(body);
            let position = (0..3).map(move |axis| Coordinate::Position { body, axis });
            position.chain((0..3).map(move |axis| Coordinate::RotationVector { body, axis }))
        });
        let all = of_joints.chain(of_bodies);
        all.filter(|coordinate| !self.coordinates.contains(coordinate)).collect()
    }
}
