//! Normal loads at previous configurations of a motion, and their extrapolation to the next
//! configuration.

use crate::linalg::VectorHistory;

/// Normal loads at previous configurations of a motion.
#[derive(Clone, Debug, Default)]
pub(super) struct LoadHistory {
    /// Indices of the interfaces whose normal loads are stored.
    unknowns: Vec<usize>,
    /// Normal loads, N.
    loads: VectorHistory,
}

impl LoadHistory {
    /// Extrapolates the normal loads of the interfaces `unknowns` to the next configuration.
    /// Returns `false` if the history is empty or belongs to a different set of interfaces.
    pub(super) fn predict(&self, unknowns: &[usize], loads: &mut Vec<f64>) -> bool {
        let found = self.unknowns == unknowns && self.loads.predict(unknowns.len(), loads);
        if found {
            loads.iter_mut().for_each(|load| *load = load.max(0.0));
        }
        found
    }

    /// Clears the history but retains the allocated buffers.
    pub(super) fn forget(&mut self) {
        self.loads.forget();
    }

    /// Adds the normal loads at the next configuration to the history, N. Restarts the history if
    /// the interfaces differ from those in the history.
    pub(super) fn add(&mut self, unknowns: &[usize], loads: &[f64]) {
        if self.unknowns != unknowns {
            self.unknowns.clear();
            self.unknowns.extend_from_slice(unknowns);
            self.loads.forget();
        }
        self.loads.add(loads);
    }
}

#[cfg(test)]
mod tests {
    use super::LoadHistory;

    #[test]
    fn loads_of_other_interfaces_are_not_extrapolated() {
        let mut history = LoadHistory::default();
        let mut found = Vec::new();
        history.add(&[4, 7], &[3.0, 1.0]);
        history.add(&[4, 7], &[2.0, 0.25]);
        // Normal loads are not negative.
        assert!(history.predict(&[4, 7], &mut found));
        assert_eq!(found, [1.0, 0.0]);
        assert!(!history.predict(&[4, 5], &mut found));
        history.add(&[4, 5], &[2.0, 6.0]);
        assert!(history.predict(&[4, 5], &mut found));
        assert_eq!(found, [2.0, 6.0]);
    }
}
