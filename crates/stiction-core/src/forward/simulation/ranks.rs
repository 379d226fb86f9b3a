//! Rank of the constraints of loops and prescribed joints at a configuration.

use crate::forward::Forward;
use crate::forward::balance::DEPENDENT;
use crate::forward::constraint_jacobian::StickingDof;
use crate::forward::constraint_jacobian::{ConstrainedDof, ConstraintRows};
use crate::forward::data::FrictionDistribution;
use crate::forward::sparse::rows::SparseRows;
use crate::kinematics::{Bodies, State, Target};
use crate::linalg::RowSpace;

/// Buffers for computing the rank of the constraints at a configuration.
#[derive(Clone, Debug)]
pub(super) struct Ranks {
    bodies: Bodies<f64>,
    constrained: Vec<ConstrainedDof>,
    sticking: Vec<StickingDof>,
    rows: ConstraintRows,
    scaled: Vec<f64>,
    space: RowSpace,
    sparse: Option<SparseRows>,
    /// Coordinates of the last configuration, its rank and its singularity index.
    last: (Vec<f64>, usize, f64),
    /// Target motions of the prescribed joints.
    pub(super) targets: Vec<Target<f64>>,
}

impl Ranks {
    /// Allocates the buffers for a model.
    pub(super) fn new(model: &Forward) -> Self {
        Self {
            bodies: Bodies::new(&model.topology),
            constrained: Vec::new(),
            sticking: Vec::new(),
            rows: ConstraintRows::default(),
            scaled: Vec::new(),
            space: RowSpace::default(),
            sparse: SparseRows::new(model),
            last: (Vec::new(), 0, 0.0),
            targets: Vec::new(),
        }
    }

    /// Returns the rank of the constraints at a state, and the singularity index, see
    /// [`RowSpace::least_part`].
    pub(super) fn at(&mut self, model: &Forward, state: &State<f64>) -> (usize, f64) {
        if self.last.0 != state.coordinates || state.coordinates.is_empty() {
            let (rank, distance) = self.decompose(model, state);
            self.know(state, rank, distance);
        }
        (self.last.1, self.last.2)
    }

    /// Stores the rank and the singularity index at a state that are already known.
    pub(super) fn know(&mut self, state: &State<f64>, rank: usize, distance: f64) {
        self.last.0.clone_from(&state.coordinates);
        (self.last.1, self.last.2) = (rank, distance);
    }

    fn decompose(&mut self, model: &Forward, state: &State<f64>) -> (usize, f64) {
        let (topology, parameters) = (&model.topology, &model.parameters);
        let Self { bodies, constrained, sticking, rows, scaled, space, sparse, targets, .. } = self;
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        model.constrain(targets, &[], &FrictionDistribution::default(), constrained, sticking);
        rows.update_rows(topology, parameters, bodies, constrained);
        if let Some(sparse) = sparse
            && sparse.decompose(model, bodies, rows, &[])
        {
            return (sparse.rank(), sparse.distance());
        }
        rows.fill_matrix(topology, parameters, bodies);
        let n = topology.dofs();
        rows.scale_into(&model.columns, scaled);
        space.decompose(scaled, rows.rows.len(), n, DEPENDENT);
        (space.rank(), space.least_part())
    }

    /// Returns the rank of the constraints and the singularity index at the configuration that the
    /// rates in `state` reach after `time`, s. Negative times are allowed.
    pub(super) fn ahead(&mut self, model: &Forward, state: &State<f64>, time: f64) -> (usize, f64) {
        let mut ahead = state.clone();
        let by: Vec<f64> = state.rates.iter().map(|rate| time * rate).collect();
        ahead.advance(&model.topology, &by);
        self.at(model, &ahead)
    }
}
