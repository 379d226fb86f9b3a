//! Sensors of a controller: resolution, noise and delay.

use std::collections::VecDeque;
use stiction_core::random::Random;

/// Imperfections of the measured positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Imperfections {
    /// Increment of the encoders, m or rad; zero if positions are not rounded.
    pub(super) resolution: f64,
    /// Standard deviation of the noise of each position, m or rad.
    pub(super) noise: f64,
    /// Delay between measurement and effort, in periods of the controller.
    pub(super) delay: usize,
}

impl Imperfections {
    /// Returns `true` if rates are differences of measured positions, `false` if they are exact.
    fn differs(&self) -> bool {
        self.resolution > 0.0 || self.noise > 0.0
    }
}

/// Simulated sensors with their recent measurements.
#[derive(Clone, Debug)]
pub(super) struct Sensors {
    imperfections: Imperfections,
    period: f64,
    random: Random,
    before: Option<Vec<f64>>,
    queue: VecDeque<(Vec<f64>, Vec<f64>)>,
}

impl Sensors {
    pub(super) fn new(imperfections: Imperfections, period: f64, seed: u64) -> Self {
        let queue = VecDeque::new();
        Self { imperfections, period, random: Random::new(seed), before: None, queue }
    }

    /// Simulates the sensors at one sampling instant: returns measured positions and rates for the
    /// true ones, with resolution, noise and delay.
    pub(super) fn measure(&mut self, positions: &[f64], rates: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let Imperfections { resolution, noise, delay } = self.imperfections;
        let mut measured = positions.to_vec();
        for value in &mut measured {
            if noise > 0.0 {
                // The sum of twelve uniform numbers of variance 1/3 has variance 4.
                let sum: f64 = (0..12).map(|_| self.random.number()).sum();
                *value += 0.5 * noise * sum;
            }
            if resolution > 0.0 {
                *value = (*value / resolution).round() * resolution;
            }
        }
        let rates = match &self.before {
            Some(before) if self.imperfections.differs() => measured
                .iter()
                .zip(before)
                .map(|(now, before)| (now - before) / self.period)
                .collect(),
            _ => rates.to_vec(),
        };
        self.before = Some(measured.clone());
        self.queue.push_back((measured, rates));
        if self.queue.len() > delay + 1 {
            self.queue.pop_front();
        }
        self.queue[0].clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measurements_are_rounded_delayed_and_noisy() {
        let exact = Imperfections::default();
        let mut sensors = Sensors::new(exact, 0.001, 1);
        assert_eq!(sensors.measure(&[0.1], &[2.0]), (vec![0.1], vec![2.0]));
        let mut sensors = Sensors::new(Imperfections { delay: 1, ..exact }, 0.001, 1);
        sensors.measure(&[0.1], &[2.0]);
        assert_eq!(sensors.measure(&[0.2], &[3.0]), (vec![0.1], vec![2.0]));
        let mut sensors = Sensors::new(Imperfections { resolution: 0.25, ..exact }, 0.5, 1);
        sensors.measure(&[0.3], &[0.0]);
        // Rates are differences of rounded positions.
        assert_eq!(sensors.measure(&[0.9], &[0.0]), (vec![1.0], vec![1.5]));
        let mut sensors = Sensors::new(Imperfections { noise: 0.1, ..exact }, 0.5, 1);
        let all: Vec<f64> = (0..4000).map(|_| sensors.measure(&[1.0], &[0.0]).0[0] - 1.0).collect();
        let mean = all.iter().sum::<f64>() / 4000.0;
        let deviation = (all.iter().map(|x| x * x).sum::<f64>() / 4000.0).sqrt();
        // The limits are ten standard errors of the mean and of the standard deviation.
        assert!(mean.abs() < 0.016 && (deviation - 0.1).abs() < 0.012, "{mean} {deviation}");
    }
}
