//! Motions that several logs repeat.

use crate::block::Block;
use crate::period::{REPEATED, change_between, instants, signals_of_both};
use crate::repetition::Repetition;
use crate::rows::Rows;

/// Two logs have the same motion only if they overlap by at least this fraction of the shorter one.
const OVERLAP: f64 = 0.5;
/// Largest number of shifts that are compared for two logs.
const SHIFTS: usize = 4000;

/// Returns the indices of the blocks of each motion, in the order of their first blocks.
pub(crate) fn motions(blocks: &[Block]) -> Vec<Vec<usize>> {
    let mut motions: Vec<(Option<usize>, Vec<usize>)> = Vec::new();
    for (index, block) in blocks.iter().enumerate() {
        let own = block.repetition().map(|repetition| repetition.motion);
        let known = motions.iter_mut().find(|(motion, _)| own.is_some() && *motion == own);
        match known {
            Some((_, members)) => members.push(index),
            None => motions.push((own, vec![index])),
        }
    }
    motions.into_iter().map(|(_, members)| members).collect()
}

impl Block {
    /// Finds the logs that repeat one motion, from the columns of the regression. Errors of the model are the same in all
    /// of them. Logs whose rows have other distances in time do not count as repetitions.
    pub fn relate(blocks: &mut [&mut Self]) {
        let lengths: Vec<usize> = blocks.iter().map(|block| instants(&block.channels)).collect();
        // Index of the first log of the motion of each log, and the shift from it to the log.
        let mut found: Vec<(usize, isize)> = (0..blocks.len()).map(|k| (k, 0)).collect();
        for k in 1..blocks.len() {
            let earlier = (0..k).filter(|first| found[*first].0 == *first);
            let shift = earlier.filter_map(|first| {
                let [a, b] = [&*blocks[first], &*blocks[k]];
                let is_alike = a.spacing.is_some() && a.spacing == b.spacing;
                Some((first, is_alike.then(|| shift(&a.channels, &b.channels))??))
            });
            if let Some(own) = shift.into_iter().next() {
                found[k] = own;
            }
        }
        for first in 0..blocks.len() {
            let members: Vec<usize> = (0..blocks.len()).filter(|&k| found[k].0 == first).collect();
            let begin = members.iter().map(|&k| found[k].1).min().unwrap_or(0);
            let end = members.iter().map(|&k| found[k].1 + lengths[k] as isize).max().unwrap_or(0);
            // The longest log with repetitions determines their period best.
            let repeated = members.iter().filter(|&&k| blocks[k].period().is_some());
            let longest = repeated.max_by_key(|&&k| lengths[k]);
            let period = longest.and_then(|&k| blocks[k].period());
            for &k in &members {
                let shift = (found[k].1 - begin) as usize;
                let length = (end - begin) as usize;
                let own = Repetition { motion: first, shift, length };
                blocks[k].repeat((members.len() > 1).then_some(own), period);
            }
        }
    }
}

/// Returns the shift, in instants, from the start of the first log to the start of the second log if both have the same
/// motion.
fn shift(first: &[Rows], second: &[Rows]) -> Option<isize> {
    let (n, m) = (instants(first), instants(second));
    let [a, b] = signals_of_both([first, second])?;
    let least = (OVERLAP * n.min(m) as f64).ceil() as isize;
    let (low, high) = (least - m as isize, n as isize - least);
    let change = |shift: isize| change_between((&a, n), (&b, m), shift);
    let best = |shifts: &mut dyn Iterator<Item = isize>| {
        shifts.map(|own| (own, change(own))).min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let stride = ((high - low) as usize).div_ceil(SHIFTS).max(1);
    // Most logs of one motion begin at its start.
    let near = (low.max(-2 * stride as isize)..=high.min(2 * stride as isize)).chain([0]);
    let (found, least) = best(&mut near.into_iter())?;
    if least < REPEATED {
        return Some(found);
    }
    let (coarse, _) = best(&mut (low..=high).step_by(stride))?;
    let reach = stride as isize;
    let (found, least) = best(&mut ((coarse - reach).max(low)..=(coarse + reach).min(high)))?;
    (least < REPEATED).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(length: usize, motion: impl Fn(f64) -> f64) -> Block {
        let mut block = Block::new(vec![Rows::of_motion(length, motion)], 0.5);
        block.spacing = Some(0.01);
        block
    }

    #[test]
    fn logs_of_one_motion_are_found_wherever_they_begin() {
        let motion = |t: f64| (0.05 * t).sin() + 0.6 * (0.0811 * t + 1.0).cos();
        let other = |t: f64| (0.04 * t).sin() + 0.6 * (0.1011 * t + 1.0).cos();
        let mut all = [
            block(600, motion),
            block(600, other),
            block(500, |t| motion(t + 37.0)),
            block(600, |t| motion(t - 12.0)),
        ];
        Block::relate(&mut all.each_mut());
        assert_eq!(motions(&all), [vec![0, 2, 3], vec![1]]);
        let shifts = [0, 2, 3].map(|k: usize| all[k].repetition().unwrap().instant(0));
        assert_eq!(shifts, [12, 49, 0]);
        assert_eq!(all[0].repetition().unwrap().length, 612);
        assert_eq!(all[1].repetition(), None);
        // Half the amplitude, and another place.
        let mut all =
            [block(600, motion), block(600, |t| 0.5 * motion(t)), block(600, |t| motion(t) + 3.0)];
        Block::relate(&mut all.each_mut());
        assert_eq!(motions(&all).len(), 3);
        // Rows with another distance in time.
        let mut all = [block(600, motion), block(600, motion)];
        all[1].spacing = Some(0.02);
        Block::relate(&mut all.each_mut());
        assert_eq!(motions(&all).len(), 2);
    }
}
