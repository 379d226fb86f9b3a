//! Checkpoint of the current configuration, from which an assembly continues with bitwise identical
//! results.

use super::Assembly;
use crate::kinematics::coordinate::Target;
use crate::parameters::Parameters;

impl Assembly {
    /// Appends the current configuration and motion to `numbers`: coordinates, rates and
    /// accelerations of the spanning tree, the targets, and the coordinates for which the rate
    /// equations were compiled.
    pub(crate) fn save(&self, numbers: &mut Vec<f64>) {
        let Self { state, planned_at, targets, .. } = self;
        let parts = [&state.coordinates, &state.rates, &state.accelerations, planned_at];
        parts.into_iter().for_each(|part| numbers.extend(part));
        numbers.extend(targets.iter().flat_map(|t| [t.value, t.rate, t.acceleration]));
    }

    /// Restores the data saved by [`Self::save`] from the start of `numbers` and returns the
    /// remaining numbers. Returns `None` if numbers are missing or the rate equations cannot be
    /// compiled at the saved configuration.
    pub(crate) fn restore<'n>(
        &mut self,
        parameters: &Parameters<f64>,
        numbers: &'n [f64],
    ) -> Option<&'n [f64]> {
        self.extrapolation.forget();
        let (coordinates, rest) = numbers.split_at_checked(self.state.coordinates.len())?;
        let (rates, rest) = rest.split_at_checked(self.state.rates.len())?;
        let (accelerations, rest) = rest.split_at_checked(self.state.accelerations.len())?;
        let (planned_at, rest) = rest.split_at_checked(self.planned_at.len())?;
        let (targets, rest) = rest.split_at_checked(3 * self.targets.len())?;
        for (target, numbers) in self.targets.iter_mut().zip(targets.chunks_exact(3)) {
            let (value, rate, acceleration) = (numbers[0], numbers[1], numbers[2]);
            *target = Target { value, rate, acceleration };
        }
        if planned_at != self.planned_at {
            self.state.coordinates.copy_from_slice(planned_at);
            self.plan(parameters).ok()?;
        }
        self.state.coordinates.copy_from_slice(coordinates);
        self.differentiate(parameters);
        // Restore the saved rates and accelerations as well: at a singular configuration, they
        // differ from the solution of the equations.
        self.state.rates.copy_from_slice(rates);
        self.state.accelerations.copy_from_slice(accelerations);
        let Self { kinematics, model, state, .. } = self;
        kinematics.move_with(&model.topology, state);
        kinematics.factor_here(model, parameters);
        Some(rest)
    }

    /// Coordinates of the spanning tree at the current configuration.
    pub(crate) fn coordinates(&self) -> &[f64] {
        &self.state.coordinates
    }

    /// Moves to the given `coordinates` of the spanning tree. Computes the poses, rates and
    /// accelerations at these coordinates for the current targets.
    pub(crate) fn place_at(&mut self, parameters: &Parameters<f64>, coordinates: &[f64]) {
        self.extrapolation.forget();
        self.state.coordinates.copy_from_slice(coordinates);
        self.differentiate(parameters);
    }
}
