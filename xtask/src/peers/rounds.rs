//! Timed batches of all engines in rotation.

use super::process::Process;

/// Duration of a batch, ns. It is much longer than a request and shorter than a time slice of the
/// scheduler, so that most batches run without interruption.
const BATCH: f64 = 1e6;

/// Times of one subject: ns per evaluation, one entry per round.
pub(crate) struct Timing {
    pub(crate) engine: &'static str,
    pub(crate) subject: String,
    pub(crate) difference: f64,
    pub(crate) batches: Vec<f64>,
    /// Number of evaluations in each batch.
    pub(crate) size: usize,
}

impl Timing {
    pub(crate) fn median(&self) -> f64 {
        median(self.batches.clone())
    }

    pub(crate) fn minimum(&self) -> f64 {
        self.batches.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Median, over the rounds, of the ratio within a round. A slowdown that affects the whole
    /// round cancels.
    pub(crate) fn ratio_to(&self, other: &Self) -> f64 {
        median(
            self.batches.iter().zip(&other.batches).map(|(ours, theirs)| ours / theirs).collect(),
        )
    }
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let half = numbers.len() / 2;
    if numbers.len() % 2 == 1 { numbers[half] } else { 0.5 * (numbers[half - 1] + numbers[half]) }
}

pub(crate) fn run(processes: &mut [Process], rounds: usize) -> Result<Vec<Timing>, String> {
    let mut timings = Vec::new();
    let mut places = Vec::new();
    for (at, process) in processes.iter_mut().enumerate() {
        for subject in 0..process.subjects.len() {
            // The first batch warms the caches.
            process.batch(subject, 100)?;
            let each = process.batch(subject, 100)?;
            let size = ((BATCH / each) as usize).max(1);
            let name = process.subjects[subject].name.clone();
            let difference = process.subjects[subject].difference;
            let batches = Vec::with_capacity(rounds);
            let engine = process.name;
            timings.push(Timing { engine, subject: name, difference, batches, size });
            places.push((at, subject));
        }
    }
    for round in 0..rounds {
        for k in 0..timings.len() {
            // The order rotates, so that no subject always runs after the same one.
            let k = (k + round) % timings.len();
            let (at, subject) = places[k];
            let time = processes[at].batch(subject, timings[k].size)?;
            timings[k].batches.push(time);
        }
    }
    Ok(timings)
}

#[cfg(test)]
mod tests {
    use super::Timing;

    fn timing(batches: &[f64]) -> Timing {
        let batches = batches.to_vec();
        Timing { engine: "any", subject: "inverse".into(), difference: 0.0, batches, size: 1 }
    }

    #[test]
    fn common_slowdowns_do_not_change_a_ratio() {
        let (ours, theirs) = (timing(&[2.0, 20.0, 2.0, 20.0]), timing(&[4.0, 40.0, 4.0, 40.0]));
        assert_eq!(ours.ratio_to(&theirs), 0.5);
        assert_eq!((ours.median(), ours.minimum()), (11.0, 2.0));
        assert_eq!(timing(&[3.0, 1.0, 9.0]).median(), 3.0);
    }
}
