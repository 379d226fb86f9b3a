//! The present position of a solver as numbers, from which it continues to the last bit.

use super::InverseDynamics;

impl InverseDynamics {
    /// The present position as numbers: coordinates, rates and accelerations of the tree, prescribed targets,
    /// and the positions at which the equations were compiled. A solver of the same mechanism that
    /// [restores](Self::restore) them continues in the same assembly mode, to the last bit.
    pub fn save(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.assembly.save(&mut numbers);
        numbers.extend(&self.compiled_at);
        numbers
    }

    /// Moves to a position saved by [`Self::save`] on a solver of the same mechanism with the same prescribed
    /// coordinates. Returns `None`, and stays at no defined position, if the numbers are of another one.
    pub fn restore(&mut self, numbers: &[f64]) -> Option<()> {
        if !numbers.iter().all(|number| number.is_finite()) {
            return None;
        }
        let parameters = std::sync::Arc::clone(&self.parameters);
        let compiled_at = self.assembly.restore(&parameters, numbers)?;
        if compiled_at.len() != self.assembly.coordinates().len() {
            return None;
        }
        self.assembly.place_at(&parameters, compiled_at);
        self.replan();
        self.assembly.restore(&self.parameters, numbers).map(|_| ())
    }
}
