//! A histogram of magnitudes with logarithmic bins.

/// Number of bins per octave of the magnitude.
const PER_OCTAVE: f64 = 4.0;
/// Limit of the binary exponents: the bins cover magnitudes from `2^-RANGE` to `2^RANGE`.
const RANGE: f64 = 256.0;

/// Histogram of magnitudes; its quantiles are accurate to a fifth of their value.
#[derive(Clone, Debug)]
pub(super) struct Histogram {
    bins: Vec<u64>,
    count: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { bins: vec![0; (2.0 * RANGE * PER_OCTAVE) as usize + 1], count: 0 }
    }
}

impl Histogram {
    /// Adds a magnitude to the histogram.
    pub(super) fn add(&mut self, size: f64) {
        let place = (size.max(f64::MIN_POSITIVE).log2() + RANGE).clamp(0.0, 2.0 * RANGE);
        let bin = (place * PER_OCTAVE) as usize;
        self.count += 1;
        if let Some(count) = self.bins.get_mut(bin) {
            *count += 1;
        }
    }

    /// Returns the upper limit of the bin that contains the quantile for the fraction `part`, from
    /// 0 to 1; 0 if this is the lowest bin.
    pub(super) fn quantile(&self, part: f64) -> f64 {
        let rank = part * self.count as f64;
        let mut below = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            below += count;
            if below as f64 >= rank {
                let limit = ((bin as f64 + 1.0) / PER_OCTAVE - RANGE).exp2();
                return if bin == 0 { 0.0 } else { limit };
            }
        }
        0.0
    }
}
