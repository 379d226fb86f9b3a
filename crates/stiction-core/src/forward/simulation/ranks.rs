//! Rank of the constraints of loops and prescribed joints at a configuration.

use crate::forward::Forward;
use crate::forward::balance::DEPENDENT;
use crate::forward::constraint_jacobian::StickingDof;
use crate::forward::constraint_jacobian::{ConstrainedDof, ConstraintRows};
use crate::forward::data::FrictionDistribution;
use crate::forward::sparse::rows::SparseRows;
use crate::kinematics::{Bodies, State, Target};
use crate::linalg::{ColumnOrder, LARGE, RowSpace, SparseMatrix, SparseQr};
use crate::random::Random;

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
    /// Rank at almost all coordinates, once it is known.
    generic: Option<usize>,
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
            generic: None,
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
        self.place(model, state);
        let Self { bodies, constrained, rows, sparse, generic, .. } = self;
        if let Some(sparse) = sparse {
            let generic = *generic.get_or_insert_with(|| generic_rank(model, constrained));
            // Rows that are nearly dependent have pivots like those of dependent rows.
            if sparse.decompose(model, bodies, rows, &[]) && sparse.rank() >= generic {
                return (sparse.rank(), sparse.distance());
            }
        }
        self.reflect(model)
    }

    /// Returns the rank of the constraints and the singularity index at a state like [`Self::at`],
    /// but always from orthogonal reflections, so that the index varies continuously even very
    /// close to a singular configuration.
    pub(super) fn precisely_at(&mut self, model: &Forward, state: &State<f64>) -> (usize, f64) {
        self.place(model, state);
        self.reflect(model)
    }

    /// Computes the constraint rows at a state.
    fn place(&mut self, model: &Forward, state: &State<f64>) {
        let (topology, parameters) = (&model.topology, &model.parameters);
        let Self { bodies, constrained, sticking, rows, targets, .. } = self;
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        model.constrain(targets, &[], &FrictionDistribution::default(), constrained, sticking);
        rows.update_rows(topology, parameters, bodies, constrained);
    }

    /// Decomposes the constraint rows by orthogonal reflections.
    fn reflect(&mut self, model: &Forward) -> (usize, f64) {
        let (topology, parameters) = (&model.topology, &model.parameters);
        let Self { bodies, rows, scaled, space, .. } = self;
        let n = topology.dofs();
        if n >= LARGE {
            return reflect_sparsely(model, bodies, rows);
        }
        rows.fill_matrix(topology, parameters, bodies);
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

/// Computes the rank of the constraint rows at random coordinates, at which the loops are open. The
/// rank at closed loops is at most this value.
fn generic_rank(model: &Forward, constrained: &[ConstrainedDof]) -> usize {
    let (topology, parameters) = (&model.topology, &model.parameters);
    let mut random = Random::new(1);
    let mut state = State::new(topology);
    let step: Vec<f64> = model.columns.iter().map(|column| column * random.number()).collect();
    state.advance(topology, &step);
    let mut bodies = Bodies::new(topology);
    bodies.place(topology, parameters, &state.coordinates);
    bodies.move_with(topology, &state.rates);
    let mut rows = ConstraintRows::default();
    rows.update_rows(topology, parameters, &bodies, constrained);
    reflect_sparsely(model, &bodies, &rows).0
}

/// Computes the rank and the singularity index of the constraint rows by sparse orthogonal
/// reflections.
fn reflect_sparsely(model: &Forward, bodies: &Bodies<f64>, rows: &ConstraintRows) -> (usize, f64) {
    let mut entries = Vec::new();
    for (index, row) in rows.rows.iter().enumerate() {
        row.each_entry((&model.topology, &model.parameters), bodies, |tree_dof, entry| {
            entries.push((tree_dof, index, entry * row.scale * model.columns[tree_dof]));
        });
    }
    let transposed =
        SparseMatrix::new((model.topology.dofs(), rows.rows.len()), entries.into_iter());
    let joints: Vec<usize> = rows.rows.iter().map(|row| row.joint).collect();
    let norm = |row| transposed.column(row).map(|(_, x)| x * x).sum::<f64>().sqrt();
    let largest = (0..rows.rows.len()).map(norm).fold(f64::MIN_POSITIVE, f64::max);
    let order = ColumnOrder::new(&transposed, &joints);
    let factor = SparseQr::new(&transposed, &order, DEPENDENT * largest.max(1.0));
    (factor.rank(), factor.diagonal().fold(1.0, |least, part| least.min(part / largest)))
}
