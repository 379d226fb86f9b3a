//! Detects gaps: time steps much longer than all others, across which a coordinate moves.

/// Minimum ratio of a gap to the time steps beside it.
const BESIDE: f64 = 10.0;
/// Minimum ratio of a gap to the mean of the other time steps. Times that are irregular on purpose,
/// such as those of events, have short steps beside long ones.
const MEAN: f64 = 5.0;

/// The longest gap of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gap {
    /// Time of the last sample before the gap, s.
    pub(crate) time: f64,
    /// Length of the gap, s.
    pub(crate) length: f64,
    /// Mean of the other time steps, s.
    pub(crate) usual: f64,
    /// Number of gaps.
    pub(crate) count: usize,
}

/// A time step between two samples.
#[derive(Clone, Copy, Debug)]
struct Step {
    time: f64,
    length: f64,
    moves: bool,
}

/// Search for gaps, sample by sample.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gaps {
    last: Option<(f64, Vec<f64>)>,
    /// The last step and the one before it.
    steps: [Option<Step>; 2],
    sum: f64,
    number: usize,
    longest: Option<Step>,
    count: usize,
}

impl Gaps {
    /// Adds a sample: its time, s, and its values.
    pub(crate) fn push(&mut self, time: f64, values: &[f64]) {
        if let Some((before, known)) = &self.last {
            let step = Step { time: *before, length: time - before, moves: known != values };
            self.judge(Some(step));
            self.steps = [Some(step), self.steps[0]];
            (self.sum, self.number) = (self.sum + step.length, self.number + 1);
        }
        let room = &mut self.last.get_or_insert_default().1;
        room.clear();
        room.extend_from_slice(values);
        if let Some((own, _)) = &mut self.last {
            *own = time;
        }
    }

    /// Decides if the last step is a gap; `next` is the step after it.
    fn judge(&mut self, next: Option<Step>) {
        let [Some(own), before] = self.steps else { return };
        let beside = [before, next].into_iter().flatten().map(|step| step.length);
        // The only step of a recording is not a gap.
        let least = beside.fold(0.0, f64::max);
        if own.moves && least > 0.0 && own.length > BESIDE * least {
            self.count += 1;
            if self.longest.is_none_or(|known| known.length < own.length) {
                self.longest = Some(own);
            }
        }
    }

    /// Completes the search; returns the longest gap, if there is one.
    pub(crate) fn finish(mut self) -> Option<Gap> {
        self.judge(None);
        let Step { time, length, .. } = self.longest?;
        let usual = (self.sum - length) / (self.number.saturating_sub(1)) as f64;
        (length > MEAN * usual).then_some(Gap { time, length, usual, count: self.count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(times: &[f64], value: impl Fn(f64) -> f64) -> Option<Gap> {
        let mut gaps = Gaps::default();
        times.iter().for_each(|time| gaps.push(*time, &[value(*time)]));
        gaps.finish()
    }

    #[test]
    fn a_long_step_with_motion_is_a_gap() {
        let gap = found(&[0.0, 0.1, 0.2, 3.2, 3.3, 3.4], |t| t).unwrap();
        assert_eq!((gap.time, gap.length, gap.count), (0.2, 3.0, 1));
        assert!((gap.usual - 0.1).abs() < 1e-12);
        // At the ends.
        assert_eq!(found(&[0.0, 0.1, 0.2, 9.0], |t| t).unwrap().time, 0.2);
        assert_eq!(found(&[0.0, 9.0, 9.1, 9.2], |t| t).unwrap().time, 0.0);
    }

    #[test]
    fn rest_and_irregular_times_are_no_gaps() {
        assert_eq!(found(&[0.0, 0.1, 0.2, 3.2, 3.3, 3.4], |_| 1.0), None);
        // Missing rows, keyframes, growing steps, and pairs of rows at events.
        assert_eq!(found(&[0.0, 0.1, 0.2, 0.7, 0.8, 0.9], |t| t), None);
        assert_eq!(found(&[0.0, 5.0], |t| t), None);
        assert_eq!(found(&[0.0, 0.001, 0.01, 0.1, 1.0], |t| t), None);
        assert_eq!(found(&[0.0, 1e-9, 1.0, 1.0 + 1e-9, 2.0, 2.0 + 1e-9], |t| t), None);
    }
}
