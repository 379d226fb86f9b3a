//! Vectors at previous configurations of a motion, and their extrapolation to the next
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

/// Vectors at up to five successive configurations of a motion.
#[derive(Clone, Debug, Default)]
pub(crate) struct VectorHistory {
    /// Vectors at previous configurations, newest first.
    vectors: [Vec<f64>; KEPT],
    count: usize,
}

impl VectorHistory {
    /// Extrapolates the vector to the next configuration. Returns `false` if the history is empty
    /// or contains vectors of another length.
    pub(crate) fn predict(&self, length: usize, vector: &mut Vec<f64>) -> bool {
        if self.count == 0 || self.vectors[0].len() != length {
            return false;
        }
        vector.clone_from(&self.vectors[0]);
        let coefficients = COEFFICIENTS[self.count - 1];
        for (k, number) in vector.iter_mut().enumerate() {
            let kept = self.vectors.iter().zip(coefficients);
            *number = kept.map(|(kept, factor)| factor * kept[k]).sum::<f64>();
        }
        true
    }

    /// Returns the newest vector; `None` if the history is empty.
    pub(crate) fn last(&self) -> Option<&[f64]> {
        (self.count > 0).then_some(&*self.vectors[0])
    }

    /// Returns the number of vectors.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Forgets all vectors but the newest.
    pub(crate) fn keep_last(&mut self) {
        self.count = self.count.min(1);
    }

    /// Clears the history but retains the allocated buffers.
    pub(crate) fn forget(&mut self) {
        self.count = 0;
    }

    /// Adds the vector at the next configuration. Restarts the history if the length has changed.
    pub(crate) fn add(&mut self, vector: &[f64]) {
        if self.vectors[0].len() != vector.len() {
            self.count = 0;
            // Fills all buffers now, so that later calls allocate no memory.
            for kept in &mut self.vectors {
                kept.clear();
                kept.extend_from_slice(vector);
            }
        }
        self.vectors.rotate_right(1);
        self.vectors[0].copy_from_slice(vector);
        self.count = (self.count + 1).min(KEPT);
    }
}

#[cfg(test)]
mod tests {
    use super::VectorHistory;

    #[test]
    fn polynomials_of_the_fourth_degree_are_continued_exactly() {
        let mut history = VectorHistory::default();
        let vector = |t: f64| vec![1.0 + 2.0 * t + 3.0 * t.powi(4), 7.0 - t];
        let mut found = Vec::new();
        assert!(!history.predict(2, &mut found));
        for t in 0..5 {
            // From two samples on, the extrapolation is exact for straight lines.
            if t >= 2 {
                assert!(history.predict(2, &mut found));
                assert_eq!(found[1], vector(f64::from(t))[1]);
            }
            history.add(&vector(f64::from(t)));
        }
        assert!(history.predict(2, &mut found));
        assert_eq!(found, vector(5.0));
        // Without vectors of the same length there is no extrapolation.
        assert!(!history.predict(1, &mut found));
        history.add(&[2.0]);
        assert!(history.predict(1, &mut found));
        assert_eq!(found, [2.0]);
        history.forget();
        assert!(!history.predict(1, &mut found));
    }
}
