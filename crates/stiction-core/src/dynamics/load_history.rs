//! Normal loads at previous configurations of a motion, and their extrapolation to the next
//! configuration.

/// Number of stored configurations. The extrapolation uses a fourth-degree polynomial; higher
/// degrees amplify round-off.
const KEPT: usize = 5;

/// Extrapolation coefficients of the polynomials through one to five equidistant samples, newest
/// sample first.
const COEFFICIENTS: [&[f64]; KEPT] = [
    &[1.0],
    &[2.0, -1.0],
    &[3.0, -3.0, 1.0],
    &[4.0, -6.0, 4.0, -1.0],
    &[5.0, -10.0, 10.0, -5.0, 1.0],
];

/// Normal loads at up to five previous configurations of a motion.
#[derive(Clone, Debug, Default)]
pub(super) struct LoadHistory {
    /// Indices of the interfaces whose normal loads are stored.
    unknowns: Vec<usize>,
    /// Normal loads at previous configurations, N, newest first.
    loads: [Vec<f64>; KEPT],
    count: usize,
}

impl LoadHistory {
    /// Extrapolates the normal loads of the interfaces `unknowns` to the next configuration.
    /// Returns `false` if the history is empty or belongs to a different set of interfaces.
    pub(super) fn predict(&self, unknowns: &[usize], loads: &mut Vec<f64>) -> bool {
        if self.count == 0 || self.unknowns != unknowns {
            return false;
        }
        loads.clone_from(&self.loads[0]);
        let coefficients = COEFFICIENTS[self.count - 1];
        for (k, load) in loads.iter_mut().enumerate() {
            let kept = self.loads.iter().zip(coefficients);
            *load = kept.map(|(kept, factor)| factor * kept[k]).sum::<f64>().max(0.0);
        }
        true
    }

    /// Clears the history but retains the allocated buffers.
    pub(super) fn forget(&mut self) {
        self.unknowns.clear();
        self.count = 0;
    }

    /// Adds the normal loads at the next configuration to the history, N. Restarts the history if
    /// the interfaces differ from those in the history.
    pub(super) fn add(&mut self, unknowns: &[usize], loads: &[f64]) {
        if self.unknowns != unknowns {
            self.unknowns.clear();
            self.unknowns.extend_from_slice(unknowns);
            self.count = 0;
            // Fills all buffers now, so that later calls allocate no memory.
            for kept in &mut self.loads {
                kept.clear();
                kept.extend_from_slice(loads);
            }
        }
        self.loads.rotate_right(1);
        self.loads[0].clear();
        self.loads[0].extend_from_slice(loads);
        self.count = (self.count + 1).min(KEPT);
    }
}

#[cfg(test)]
mod tests {
    use super::LoadHistory;

    #[test]
    fn polynomials_of_the_fourth_degree_are_continued_exactly() {
        let mut history = LoadHistory::default();
        let load = |t: f64| vec![1.0 + 2.0 * t + 3.0 * t.powi(4), 7.0 - t];
        let mut found = Vec::new();
        assert!(!history.predict(&[4, 7], &mut found));
        for t in 0..5 {
            // From two samples on, the extrapolation is exact for straight lines.
            if t >= 2 {
                assert!(history.predict(&[4, 7], &mut found));
                assert_eq!(found[1], load(f64::from(t))[1]);
            }
            history.add(&[4, 7], &load(f64::from(t)));
        }
        assert!(history.predict(&[4, 7], &mut found));
        assert_eq!(found, load(5.0));
        // Without normal loads of the same interfaces there is no extrapolation.
        assert!(!history.predict(&[4], &mut found));
        history.add(&[4], &[2.0]);
        assert!(history.predict(&[4], &mut found));
        assert_eq!(found, [2.0]);
    }
}
