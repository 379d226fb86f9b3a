//! Estimate of the assembly mode that meets the present one at a nearby singular configuration.

use super::super::bodies::State;
use super::super::least_squares::PositionEquations;
use super::super::system::Kinematics;
use super::Assembly;
use crate::linalg::Svd;
use crate::parameters::Parameters;

/// Step of the central difference, rad and characteristic lengths.
const DIFFERENCE: f64 = 1e-3;
/// Largest distance of the other mode, in rad and characteristic lengths, for which the estimate
/// from the quadratic equation is accepted.
const NEARBY: f64 = 1.0;

impl Assembly {
    /// Estimates a state near another assembly mode; `None` if that mode is far away.
    ///
    /// Let `d` be the smallest singular value of the Jacobian of the position equations, with the
    /// singular vectors `u` and `v`. Let `h` be the component along `u` of the second derivative of
    /// the equations along `v`. Besides zero, the equation `d s + h s^2 / 2 = 0` has the root
    /// `s = -2 d / h`; the returned state is at the distance `s` along `v`.
    pub(super) fn twin(&self, parameters: &Parameters<f64>) -> Option<State<f64>> {
        let (topology, constraints) = (&*self.model.topology, &*self.model.constraints);
        let mut kinematics = Kinematics::new(topology, constraints, &self.model.rates);
        let equations = PositionEquations::new(topology, parameters, constraints, &self.targets);
        let at_rest = equations.errors(&mut kinematics, &self.state);
        let jacobian = equations.jacobian(&mut kinematics);
        let last = topology.dofs().checked_sub(1)?;
        if jacobian.nrows() <= last {
            return None;
        }
        let svd = Svd::new(&jacobian.to_dense());
        let (u, v) = (svd.u.column(last).into_owned(), svd.v.column(last).into_owned());
        let mut moved = |by: f64| {
            let mut state = self.state.clone();
            state.advance(topology, &equations.unscaled(&(&v * by)));
            (equations.errors(&mut kinematics, &state), state)
        };
        let both = moved(DIFFERENCE).0 + moved(-DIFFERENCE).0 - at_rest * 2.0;
        let root = -2.0 * svd.singular_values[last] * DIFFERENCE.powi(2) / u.dot(&both);
        (root.abs() < NEARBY).then(|| moved(root).1)
    }
}
