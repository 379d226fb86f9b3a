//! Gearings as equations between coordinates of the spanning tree.
//!
//! Equation (G12) of the book's theory.

use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::topology::{GearedDofs, Topology};

impl GearedDofs {
    /// Computes the error of the gearing equation, rad or m: the weighted sum of the geared
    /// coordinates minus the required value.
    pub(crate) fn error<T: Scalar>(&self, parameters: &Parameters<T>, coordinates: &[T]) -> T {
        let numbers = &parameters.gearings[self.gearing];
        let mut sum = -numbers.offset;
        for (&(_, coordinate), &coefficient) in self.dofs.iter().zip(&numbers.coefficients) {
            sum += coordinates[coordinate] * coefficient;
        }
        sum
    }

    /// Returns the coefficient of degree of freedom `tree_dof` of the spanning tree in the weighted
    /// sum; zero for a degree of freedom that is not in the sum.
    pub(crate) fn coefficient<T: Scalar>(&self, parameters: &Parameters<T>, tree_dof: usize) -> T {
        let numbers = &parameters.gearings[self.gearing];
        let own = self.dofs.iter().position(|&(known, _)| known == tree_dof);
        own.map_or(T::zero(), |own| numbers.coefficients[own])
    }

    /// Lists all degrees of freedom of the geared joints, as indices in the spanning tree,
    /// including those with the coefficient zero.
    pub(crate) fn tree_dofs<'a>(
        &'a self,
        topology: &'a Topology,
    ) -> impl Iterator<Item = usize> + 'a {
        self.nodes.iter().flat_map(|&node| topology.nodes[node].tree_dofs.clone())
    }

    /// Lists the degrees of freedom in the gearing's sum, as indices in the spanning tree, with
    /// their coefficients.
    pub(crate) fn terms<'a, T: Scalar>(
        &'a self,
        parameters: &'a Parameters<T>,
    ) -> impl Iterator<Item = (usize, T)> + 'a {
        let numbers = &parameters.gearings[self.gearing];
        self.dofs.iter().zip(&numbers.coefficients).map(|(&(dof, _), &c)| (dof, c))
    }
}
