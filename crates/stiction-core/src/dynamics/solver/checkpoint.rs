//! Saves and restores the state of a solver, which then continues with bitwise identical results.

use super::InverseDynamics;

impl InverseDynamics {
    /// Saves the present state as numbers: coordinates, rates and accelerations of the spanning
    /// tree, prescribed targets, and the configurations at which the equations were compiled. A
    /// solver of the same mechanism that [restores](Self::restore) these numbers continues in the
    /// same assembly mode with bitwise identical results.
    pub fn save(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.assembly.save(&mut numbers);
        numbers.extend(&self.compiled_at);
        numbers
    }

    /// Restores a state saved by [`Self::save`] on a solver of the same mechanism with the same
    /// prescribed coordinates. Returns `None` if a number is not finite, or if the numbers belong
    /// to another mechanism; the state is then undefined.
    pub fn restore(&mut self, numbers: &[f64]) -> Option<()> {
        if !numbers.iter().all(|number| number.is_finite()) {
            return None;
        }
        self.friction_coupling.forget();
        let parameters = std::sync::Arc::clone(&self.parameters);
        let compiled_at = self.assembly.restore(&parameters, numbers)?;
        if compiled_at.len() != self.assembly.coordinates().len() {
            return None;
        }
        if compiled_at == self.compiled_at {
            return Some(());
        }
        self.assembly.place_at(&parameters, compiled_at);
        self.replan();
        self.assembly.restore(&self.parameters, numbers).map(|_| ())
    }
}
