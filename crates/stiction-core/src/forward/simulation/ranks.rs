//! Rank of the constraints of loops and prescribed joints at a configuration.

use crate::forward::Forward;
use crate::forward::balance::DEPENDENT;
use crate::forward::constraint_jacobian::StickingDof;
use crate::forward::constraint_jacobian::{ConstrainedDof, ConstraintRows};
use crate::forward::data::FrictionDistribution;
use crate::forward::sparse::rows::SparseRows;
use crate::kinematics::{Bodies, State, Target};
use crate::linalg::{ColumnOrder, RowSpace, SparseMatrix, SparseQr};
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
    /// Rank at random coordinates and elimination order of the rows, once they are known.
    generic: Option<(usize, ColumnOrder)>,
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
            targets: no_targets(model),
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
        let Self { bodies, rows, sparse, generic, .. } = self;
        if let Some(sparse) = sparse {
            let (generic, _) = generic.get_or_insert_with(|| generic_rank(model));
            // Rows that are nearly dependent have pivots like those of dependent rows.
            if sparse.decompose(model, bodies, rows, &[]) && sparse.rank() >= *generic {
                return (sparse.rank(), sparse.distance());
            }
        }
        self.reflect(model)
    }

    /// Returns the rank of the constraints and the singularity index at a state like [`Self::at`],
    /// but always from orthogonal reflections, so that indices very close to a singular
    /// configuration can be compared.
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
        let Self { bodies, rows, scaled, space, sparse, generic, .. } = self;
        if sparse.is_some() {
            let (_, order) = generic.get_or_insert_with(|| generic_rank(model));
            return reflect_sparsely(&transposed(model, bodies, rows), order);
        }
        rows.fill_matrix(topology, parameters, bodies);
        rows.scale_into(&model.columns, scaled);
        space.decompose(scaled, rows.rows.len(), topology.dofs(), DEPENDENT);
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

/// Returns targets of zero for the prescribed joints.
fn no_targets(model: &Forward) -> Vec<Target<f64>> {
    vec![Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; model.prescribed.len()]
}

/// Computes the rank of the constraint rows at random coordinates, at which the loops are open, and
/// the elimination order of the rows. The rank at closed loops is at most this value.
fn generic_rank(model: &Forward) -> (usize, ColumnOrder) {
    let (topology, parameters) = (&model.topology, &model.parameters);
    let mut random = Random::new(1);
    let mut state = State::new(topology);
    let step: Vec<f64> = model.columns.iter().map(|column| column * random.number()).collect();
    state.advance(topology, &step);
    let mut bodies = Bodies::new(topology);
    bodies.place(topology, parameters, &state.coordinates);
    bodies.move_with(topology, &state.rates);
    let (mut constrained, mut rows) = (Vec::new(), ConstraintRows::default());
    let even = FrictionDistribution::default();
    model.constrain(&no_targets(model), &[], &even, &mut constrained, &mut Vec::new());
    rows.update_rows(topology, parameters, &bodies, &constrained);
    let matrix = transposed(model, &bodies, &rows);
    let joints: Vec<usize> = rows.rows.iter().map(|row| row.joint).collect();
    let order = ColumnOrder::new(&matrix, &joints);
    (reflect_sparsely(&matrix, &order).0, order)
}

/// Returns the transposed constraint Jacobian, with scales that make angles and lengths comparable.
fn transposed(model: &Forward, bodies: &Bodies<f64>, rows: &ConstraintRows) -> SparseMatrix {
    let (topology, parameters) = (&model.topology, &model.parameters);
    let mut entries = Vec::new();
    for (index, row) in rows.rows.iter().enumerate() {
        row.each_entry((topology, parameters), bodies, |tree_dof, entry| {
            entries.push((tree_dof, index, entry * row.scale * model.columns[tree_dof]));
        });
    }
    SparseMatrix::new((topology.dofs(), rows.rows.len()), entries.into_iter())
}

/// Computes the rank and the singularity index of constraint rows, the columns of `transposed`, by
/// sparse orthogonal reflections.
fn reflect_sparsely(transposed: &SparseMatrix, order: &ColumnOrder) -> (usize, f64) {
    let norm = |row| transposed.column(row).map(|(_, x)| x * x).sum::<f64>().sqrt();
    let largest = (0..transposed.ncols()).map(norm).fold(f64::MIN_POSITIVE, f64::max);
    let factor = SparseQr::new(transposed, order, DEPENDENT * largest.max(1.0));
    (factor.rank(), factor.diagonal().fold(1.0, |least, part| least.min(part / largest)))
}
