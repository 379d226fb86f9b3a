//! How many conditions the loops and what is prescribed make at a position.

use crate::forward::Forward;
use crate::forward::balance::DEPENDENT;
use crate::forward::constraint_jacobian::{Held, Rows};
use crate::kinematics::{Bodies, State, Target};
use crate::linalg::RowSpace;

/// Room for ranks at positions.
#[derive(Clone, Debug)]
pub(super) struct Ranks {
    bodies: Bodies<f64>,
    held: Vec<Held>,
    holding: Vec<(usize, usize, usize)>,
    rows: Rows,
    scaled: Vec<f64>,
    space: RowSpace,
    /// What is prescribed.
    pub(super) targets: Vec<Target<f64>>,
}

impl Ranks {
    /// Room for a model.
    pub(super) fn new(model: &Forward) -> Self {
        Self {
            bodies: Bodies::new(&model.topology),
            held: Vec::new(),
            holding: Vec::new(),
            rows: Rows::default(),
            scaled: Vec::new(),
            space: RowSpace::default(),
            targets: Vec::new(),
        }
    }

    /// The rank of loops and of what is prescribed, and how far they are from losing it.
    pub(super) fn at(&mut self, model: &Forward, state: &State<f64>) -> (usize, f64) {
        let (topology, parameters) = (&model.topology, &model.parameters);
        let Self { bodies, held, holding, rows, scaled, space, targets } = self;
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        model.held_into(targets, &[], (&[], &[]), held, holding);
        rows.update(topology, parameters, bodies, held);
        let n = topology.dofs();
        scaled.clone_from(&rows.matrix);
        for (row, entries) in rows.rows.iter().zip(scaled.chunks_exact_mut(n.max(1))) {
            entries.iter_mut().zip(&model.columns).for_each(|(e, c)| *e *= row.scale * c);
        }
        space.decompose(scaled, rows.rows.len(), n, DEPENDENT);
        (space.rank(), space.least_part())
    }

    /// The same after moving on for a time that may be negative.
    pub(super) fn ahead(&mut self, model: &Forward, state: &State<f64>, time: f64) -> (usize, f64) {
        let mut ahead = state.clone();
        let by: Vec<f64> = state.rates.iter().map(|rate| time * rate).collect();
        ahead.advance(&model.topology, &by);
        self.at(model, &ahead)
    }
}
