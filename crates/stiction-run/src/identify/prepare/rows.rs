//! Rows of the regression: regression columns of the model and measured efforts, passed through the
//! same filter.

use super::dwells::{self as rests, Standstill};
use super::effects::{self, Scales, State};
use super::filter::{RowFilter, within};
use super::motion::{Motion, ROWS_PER_PERIOD, Used};
use super::pieces::{in_pieces, pieces, starting};
use super::{reversals, saturation, spikes};
use crate::bodies::poses_in_world;
use crate::identify::chosen::{EffortColumn, refuse};
use crate::identify::{IdentifyError as Error, Progress};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use stiction_core::dynamics::Status;
use stiction_core::kinematics::{Coordinate, State as MechanismState, Target};
use stiction_core::spatial::{Pose, Vec3};
use stiction_format::{Drives, ModelFile};
use stiction_identify::{Block, Columns, Kind, Parameter, Regressor, Rest, Rows};

/// Limit on the fraction of a filtered row that comes from instants with friction at rest, and on
/// the fraction that comes from saturated samples. The regression uses only rows below both limits.
const RESTING: f64 = 0.02;
/// Smallest height of a spike in an effort, as a fraction of the standard deviation of the effort,
/// for which the spike is replaced.
const HARMLESS: f64 = 0.05;
/// Largest number of instants whose poses are stored for the animation in the report.
const SHOWN: usize = 600;
/// Number of signals of each actuator in addition to its regression columns: known effort, two
/// signals for friction at rest, direction, rate, and the signals of effects that the model may
/// lack.
const EXTRA: usize = 5 + effects::FILTERED.len();

/// Unfiltered regression columns of the model at the instants at which the regressor is evaluated.
pub(super) struct Computed {
    pub(super) instants: Vec<(f64, [Vec<f64>; 3])>,
    /// Times, s, and states of the mechanism at some instants; see [`starting`].
    pub(super) starts: Vec<(f64, MechanismState<f64>)>,
    /// Regression columns of the friction coefficients under unit normal loads, for each instant.
    pub(super) unit_friction: Vec<Vec<f64>>,
    /// Times, s, with the poses of all bodies in the world, the ground first, at some of the
    /// instants.
    pub(super) poses: Vec<(f64, Vec<Pose<f64>>)>,
    /// Indices of the parameters that are friction coefficients.
    pub(super) mu: Vec<usize>,
    /// Signals of each actuator for each instant: its regression columns, followed by its [`EXTRA`]
    /// signals. All instants are in one vector, whose memory returns to the system when it is released.
    signals: Vec<f64>,
    actuators: usize,
    width: usize,
    pub(super) caution: Option<String>,
    /// Time, s, and state of the mechanism at the beginning of each interval in which all actuators
    /// may be at rest.
    pub(super) rests: Vec<(f64, MechanismState<f64>)>,
}

impl Computed {
    /// Releases the memory of the unfiltered signals, which is most of the memory that a log needs.
    pub(super) fn release_signals(&mut self) {
        self.signals = Vec::new();
    }
}

/// Measured efforts in the rows of the regression.
pub(super) struct Measured {
    /// For each regression row, the filtered efforts of all actuators, N or N m, followed by the
    /// fraction of saturated samples.
    rows: Vec<Vec<f64>>,
    pub(super) noise: Option<Vec<f64>>,
    /// Samples of each effort before filtering, N or N m.
    pub(super) raw: Vec<Vec<f64>>,
}

/// Rows of the regression with regression columns, measured efforts and further signals.
pub(super) struct Assembled {
    pub(super) block: Block,
    pub(super) directions: Vec<Vec<[f64; 2]>>,
    pub(super) known: Vec<Vec<f64>>,
    /// Signals of effects that the model may lack, for the rows of each actuator.
    pub(super) effects: Vec<Vec<Vec<f64>>>,
    /// Times of all rows of the regression, s.
    pub(super) at: Vec<f64>,
    pub(super) standstills: Vec<Standstill>,
    /// Number of rows of all actuators that are left out because a joint is at rest.
    pub(super) at_rest: usize,
}

/// Results of the regressor at one instant.
struct Instant {
    columns: Columns,
    /// For each actuator, its rate and whether the friction of its own joint is at rest.
    rates: Vec<(f64, Rest)>,
    /// State of the mechanism, for the first instant of a piece and where all actuators begin to
    /// be at rest.
    state: Option<MechanismState<f64>>,
    /// Poses of all bodies, for some of the instants.
    poses: Option<Vec<Pose<f64>>>,
    /// The regressor after a piece in which its model was compiled again, for the last instant that was computed.
    changed: Option<Box<Regressor>>,
}

impl Instant {
    fn is_at_rest(&self) -> bool {
        self.rates.iter().all(|(_, own)| *own != Rest::Sliding)
    }
}

/// Evaluates the regressor at the instants of a motion, of which each `stride`-th has poses, and
/// calls `receive` with the results in order. `starts` contains times, s, and states of the mechanism
/// at some instants, from which pieces of the motion are computed on several threads.
fn each_instant(
    regressor: &Regressor,
    (motion, starts): (&Motion, &[(f64, MechanismState<f64>)]),
    (stride, origin): (usize, Vec3<f64>),
    receive: impl FnMut(Result<Instant, Status>),
) {
    let actuators = regressor.mechanism().actuators().count();
    let work = |piece: Range<usize>| -> Vec<Result<Instant, Status>> {
        let mut regressor = regressor.clone();
        if let Some(state) = starting(starts, motion.times[piece.start]) {
            regressor.start_from(state);
        }
        let (mut was_at_rest, mut is_first) = (false, true);
        let each = piece.map(|k| {
            let [q, v, a] = reversals::split(&motion.targets[k]);
            let columns = regressor.at(&q, &v, &a)?;
            let rate = |row| regressor.actuator_rate(row).unwrap_or((0.0, Rest::Sliding));
            let poses = || poses_in_world(regressor.bodies(), origin).collect();
            let mut own = Instant {
                columns,
                rates: (0..actuators).map(rate).collect(),
                state: None,
                poses: (k % stride == 0).then(poses),
                changed: None,
            };
            let is_at_rest = own.is_at_rest();
            if is_first || (is_at_rest && !was_at_rest) {
                own.state = Some(regressor.state().clone());
            }
            (was_at_rest, is_first) = (is_at_rest, false);
            Ok(own)
        });
        let mut all: Vec<Result<Instant, Status>> = each.collect();
        if regressor.is_compiled_again()
            && let Some(last) = all.iter_mut().rev().find_map(|one| one.as_mut().ok())
        {
            last.changed = Some(Box::new(regressor));
        }
        all
    };
    // No states are known of a table, whose successive rows may be far apart: it is one piece.
    in_pieces(pieces(&motion.times, starts), work, receive);
}

/// Computes the regression columns of the model at the instants of a motion. `starts` are those of
/// [`reversals::refine`]. Instants that the model cannot reach are left out. Fails if too many
/// instants cannot be reached, or if an effort term has no finite value.
pub(super) fn computed(
    regressor: &mut Regressor,
    (motion, starts): (&Motion, &[(f64, MechanismState<f64>)]),
    (coordinates, terms): (&[Coordinate], &[Drives]),
    origin: Vec3<f64>,
    (name, progress): (&str, Progress<'_>),
) -> Result<Computed, Error> {
    let parameters = regressor.parameters().to_vec();
    let width = parameters.len();
    let actuators = coordinates.len();
    let mu: Vec<usize> =
        (0..width).filter(|&k| matches!(parameters[k].kind, Kind::Mu(_))).collect();
    let (mut reached, mut unit_friction) = (Vec::new(), Vec::new());
    let (mut poses, mut states_of_pieces) = (Vec::new(), Vec::new());
    let stride = motion.times.len().div_ceil(SHOWN).max(1);
    // For each actuator and instant, whether any friction that contributes to its effort is at
    // rest, then whether the friction of its own joint is at rest.
    let mut rests: Vec<[Vec<Rest>; 2]> = vec![Default::default(); actuators];
    let (mut rest_states, mut was_at_rest) = (Vec::new(), false);
    let per_instant = actuators * (width + EXTRA);
    let mut signals = Vec::with_capacity(motion.times.len() * per_instant);
    let mut states: Vec<Vec<State>> = vec![Vec::new(); actuators];
    // Coordinate of each actuator, and true if the coordinate is an angle.
    let driven: Vec<(Coordinate, bool)> = regressor
        .mechanism()
        .actuators()
        .map(|(joint, dof)| {
            let is_angle =
                !regressor.mechanism().joints()[joint.0].joint_type.dofs()[dof].translates();
            (Coordinate::Joint { joint, dof }, is_angle)
        })
        .collect();
    let mut failure: Option<(f64, &str)> = None;
    let (mut refused, mut changed) = (None, None);
    let mut targets = motion.times.iter().zip(&motion.targets).enumerate();
    each_instant(regressor, (motion, starts), (stride, origin), |found| {
        let Some((done, (&time, targets))) = targets.next() else { return };
        progress("computing the model along the logs", done, motion.times.len());
        let mut found = match found {
            Ok(found) => found,
            Err(status) => {
                failure.get_or_insert((time, status.reason()));
                return;
            }
        };
        changed = found.changed.take().or_else(|| changed.take());
        let columns = &mut found.columns;
        write_terms(terms, time, (coordinates, targets), &parameters, &mut columns.matrix);
        for (k, p) in parameters.iter().enumerate() {
            let is_term = matches!(p.kind, Kind::Term(_));
            if is_term && columns.matrix.column(k).iter().any(|x| !x.is_finite()) {
                refused.get_or_insert_with(|| {
                    refuse(
                        format!("{name}: the term `{}` cannot be evaluated at {time:.4} s", p.name),
                        "a formula can contain only the independent coordinates of the log: those \
                         of the actuators, or those that are logged in their place",
                    )
                });
            }
        }
        let friction =
            mu.iter().flat_map(|&k| columns.matrix.column(k).iter().copied().collect::<Vec<_>>());
        unit_friction.push(friction.collect());
        let mut row = Vec::with_capacity(per_instant);
        for (channel, &(rate, own)) in found.rates.iter().enumerate() {
            rests[channel][0].push(columns.rest[channel]);
            rests[channel][1].push(own);
            let direction = if rate == 0.0 { 0.0 } else { rate.signum() };
            row.extend(columns.matrix.row(channel).iter());
            let known = columns.known[channel];
            row.extend([known, 0.0, 0.0, direction, rate]);
            row.extend([0.0; effects::FILTERED.len()]);
            let position =
                (coordinates[channel] == driven[channel].0).then(|| targets[channel].value);
            states[channel].push(State { direction, rate, position, known });
        }
        signals.extend(row);
        poses.extend(found.poses.take().map(|poses| (time, poses)));
        let is_at_rest = found.is_at_rest();
        if let Some(state) = found.state {
            if is_at_rest && !was_at_rest {
                rest_states.push((time, state.clone()));
            }
            states_of_pieces.push((time, state));
        }
        was_at_rest = is_at_rest;
        reached.push((time, reversals::split(targets)));
    });
    if let Some(refused) = refused {
        return Err(refused);
    }
    if let Some(changed) = changed {
        *regressor = *changed;
    }
    let count = motion.times.len();
    let mut caution = None;
    if let Some((time, why)) = failure {
        let failed = count - reached.len();
        let least = if motion.cutoff.is_some() { 20 } else { 4 };
        if reached.len() < least || failed as f64 > super::MAY_FAIL * count as f64 {
            return Err(refuse(
                format!(
                    "{name}: the model cannot follow {failed} of {count} positions, first at {time:.4} s: {why}"
                ),
                "check units, signs and offsets of the positions, and the geometry of the model",
            ));
        }
        caution = Some(format!(
            "{name}: {failed} of {count} positions that the model cannot reach are left out with their surroundings, \
             first at {time:.4} s: {why}"
        ));
    }
    let times: Vec<f64> = reached.iter().map(|(time, _)| *time).collect();
    let shortest = motion.cutoff.map_or(0.0, f64::recip);
    for (channel, rests) in rests.iter().enumerate() {
        let base = channel * (width + EXTRA) + width;
        let [all, own] = rests.each_ref().map(|rest| dwells(&times, rest, shortest));
        for ((row, all), own) in signals.chunks_exact_mut(per_instant).zip(all).zip(own) {
            row[base + 1] = f64::from(u8::from(all[0] || own[1]));
            row[base + 2] = f64::from(u8::from(all[1]));
        }
        let scales = Scales::of(&states[channel], driven[channel].1);
        for (row, state) in signals.chunks_exact_mut(per_instant).zip(&states[channel]) {
            row[base + 5..base + EXTRA].copy_from_slice(&scales.signals(state));
        }
    }
    let rests = rest_states;
    Ok(Computed {
        poses,
        instants: reached,
        starts: states_of_pieces,
        unit_friction,
        mu,
        signals,
        actuators,
        width,
        caution,
        rests,
    })
}

/// Decides for each instant whether the friction in an effort is certainly at rest, and whether it
/// may be at rest. An interval of rates within the noise that is shorter than `shortest`, s, counts
/// as a reversal, at which friction changes its sign once.
fn dwells(times: &[f64], rest: &[Rest], shortest: f64) -> Vec<[bool; 2]> {
    let mut all: Vec<[bool; 2]> = rest.iter().map(|rest| [*rest == Rest::Resting; 2]).collect();
    let mut from = 0;
    while from < rest.len() {
        let length = rest[from..].iter().take_while(|rest| **rest != Rest::Sliding).count();
        if length > 0 && times[from + length - 1] - times[from] >= shortest {
            all[from..from + length].iter_mut().for_each(|[_, uncertain]| *uncertain = true);
        }
        from += length.max(1);
    }
    all
}

/// Filters the measured efforts and marks saturated samples.
pub(super) fn measured(
    used: &Used<'_>,
    efforts: &[EffortColumn],
    motion: &Motion,
    cautions: &mut Vec<String>,
) -> Result<Measured, Error> {
    let log = used.log;
    let each = efforts.iter().map(|EffortColumn { column, factor, .. }| {
        used.pick(*column).iter().map(|x| factor * x).collect::<Vec<f64>>()
    });
    let mut raw: Vec<Vec<f64>> = each.collect();
    let mut saturated = vec![false; used.times.len()];
    for (EffortColumn { column, factor, unit, .. }, values) in efforts.iter().zip(&mut raw) {
        let name = &log.log.columns[*column].name;
        if values.iter().all(|x| *x == values[0]) {
            return Err(refuse(
                format!("{}: `{name}` is constant", log.name),
                "log the measured effort, or leave the log out",
            ));
        }
        if motion.cutoff.is_none() {
            continue;
        }
        if let Some((first, count)) = saturation::mark(values, &mut saturated) {
            cautions.push(format!(
                "{}: {count} samples of `{name}` are saturated and left out, first in line {}",
                log.name, log.log.lines[used.rows[first]]
            ));
        }
        let mut spikes = spikes::replace(&used.times, values, &used.samples(), HARMLESS);
        // Cautions name the values of the log.
        spikes.largest /= factor.abs();
        cautions.extend(used.spikes_caution((name, unit), &spikes));
    }
    let write = |k: usize, out: &mut [f64]| {
        for (slot, values) in out.iter_mut().zip(&raw) {
            *slot = values[k];
        }
        out[raw.len()] = f64::from(u8::from(saturated[k]));
    };
    let rows = motion.filter.apply(&used.times, raw.len() + 1, write, &motion.rows);
    let noise = motion.cutoff.map(|cutoff| {
        let left = (1.8 * cutoff / used.rate).sqrt();
        let ends: Vec<_> = used.stretches.iter().map(|ends| within(&used.times, *ends)).collect();
        let each = raw.iter().map(|values| {
            let (sum, count) = ends.iter().fold((0.0, 0.0), |(sum, count), samples| {
                let weight = samples.len() as f64;
                let own = saturation::roughness(&values[samples.clone()]);
                (sum + weight * own * own, count + weight)
            });
            (sum / f64::max(count, 1.0)).sqrt() * left
        });
        each.collect()
    });
    Ok(Measured { rows, noise, raw })
}

/// Combines the regression columns and the measured efforts. Rows with friction at rest or with
/// saturated efforts are left out.
pub(super) fn assembled(
    computed: &Computed,
    measured: &Measured,
    motion: &Motion,
    cautions: &mut Vec<String>,
    (name, model): (&str, &ModelFile),
) -> Assembled {
    let Computed { actuators, width, .. } = *computed;
    let grid: Vec<f64> = computed.instants.iter().map(|(time, _)| *time).collect();
    let is_filtered = matches!(motion.filter, RowFilter::LowPass(_));
    // Without a filter, each regression row is one instant. Rows at instants that the model cannot
    // reach are left out.
    let kept: Vec<usize> = (0..motion.rows.len())
        .filter(|&k| is_filtered || grid.binary_search_by(|t| t.total_cmp(&motion.rows[k])).is_ok())
        .collect();
    let at: Vec<f64> = kept.iter().map(|&k| motion.rows[k]).collect();
    let place = |k: usize, channel: usize| (k * actuators + channel) * (width + EXTRA);
    // The columns of one actuator at a time are filtered below, because those of all would need much memory.
    let filtered = motion.filter.apply(
        &grid,
        actuators * EXTRA,
        |k, out| {
            for (channel, out) in out.chunks_exact_mut(EXTRA).enumerate() {
                out.copy_from_slice(&computed.signals[place(k, channel) + width..][..EXTRA]);
            }
        },
        &at,
    );
    // The mechanism is at rest if all actuators are at rest. Rows with saturated efforts do not
    // count as rows at rest.
    let is_resting = |k: usize| {
        is_filtered
            && (0..actuators).all(|channel| {
                let base = channel * EXTRA;
                filtered[k][base + 1] > 1.0 - RESTING
            })
            && measured.rows[kept[k]][actuators].abs() < RESTING
    };
    let position = |k: usize| {
        let place = grid.partition_point(|t| *t < at[k]).min(grid.len() - 1);
        computed.instants[place].1[0].clone()
    };
    let effort = |k: usize, channel: usize| measured.rows[kept[k]][channel];
    let standstills = rests::standstills(&at, is_resting, effort, (actuators, position));
    let (mut channels, mut directions, mut known) = (Vec::new(), Vec::new(), Vec::new());
    let (mut effects, mut at_rest) = (Vec::new(), 0);
    let joints = model.mechanism.joints();
    let names = model.mechanism.actuators().map(|(joint, dof)| joints[joint.0].actuator_name(dof));
    for (channel, actuator) in names.enumerate() {
        let base = channel * EXTRA;
        let moving = |signal: usize| -> Vec<usize> {
            let is_moving = |k: &usize| {
                filtered[*k][base + signal].abs() < RESTING
                    && measured.rows[kept[*k]][actuators].abs() < RESTING
            };
            (0..at.len()).filter(is_moving).collect()
        };
        let (mut used, certain) = (moving(2), moving(1));
        if 2 * used.len() < at.len() && used.len() < certain.len() {
            cautions.push(format!(
                "{name}: noise of the rates hides the direction of friction in {} of {} rows of {actuator}; they \
                 are used with the direction of the filtered rate",
                certain.len() - used.len(),
                at.len()
            ));
            used = certain;
        }
        let resting = (0..at.len()).filter(|&k| filtered[k][base + 2].abs() >= RESTING).count();
        if resting > 0 && used.len() < at.len() {
            at_rest += at.len() - used.len();
            cautions.push(format!(
                "{name}: {} of {} rows of {actuator} are left out, because a joint is at rest \
                 there and its friction is known only within limits",
                at.len() - used.len(),
                at.len()
            ));
        }
        let columns = motion.filter.apply(
            &grid,
            width,
            |k, out| out.copy_from_slice(&computed.signals[place(k, channel)..][..width]),
            &at,
        );
        let matrix = DMatrix::from_fn(used.len(), width, |row, column| columns[used[row]][column]);
        let total = DVector::from_fn(used.len(), |row, _| measured.rows[kept[used[row]]][channel]);
        let own = DVector::from_fn(used.len(), |row, _| filtered[used[row]][base]);
        directions
            .push(used.iter().map(|&k| [filtered[k][base + 3], filtered[k][base + 4]]).collect());
        effects.push(
            used.iter().map(|&k| filtered[k][base + 5..base + EXTRA].to_vec()).collect::<Vec<_>>(),
        );
        known.push(own.as_slice().to_vec());
        let right = &total - own;
        channels.push(Rows { matrix, right, measured: total, instruments: None, steps: used });
    }
    let independence = if is_filtered { 2.0 / ROWS_PER_PERIOD } else { 1.0 };
    // The rows of a log with gaps are not evenly spaced.
    let is_even = matches!(&motion.filter, RowFilter::LowPass(pieces) if pieces.len() == 1);
    let spacing = motion.cutoff.filter(|_| is_even);
    let spacing = spacing.map(|cutoff| (ROWS_PER_PERIOD * cutoff).recip());
    let mut block = Block::new(channels, independence);
    block.spacing = spacing;
    Assembled { block, directions, known, effects, at, standstills, at_rest }
}

/// Writes the regression columns of the effort terms, which the options define by formulas, at one instant.
pub(in crate::identify) fn write_terms(
    terms: &[Drives],
    time: f64,
    (coordinates, targets): (&[Coordinate], &[Target<f64>]),
    parameters: &[Parameter],
    matrix: &mut DMatrix<f64>,
) {
    let measure = |wanted: Coordinate| {
        let place = coordinates.iter().position(|own| *own == wanted);
        place.map_or(Target { value: f64::NAN, rate: f64::NAN, acceleration: f64::NAN }, |k| {
            targets[k]
        })
    };
    for (column, parameter) in parameters.iter().enumerate() {
        let Kind::Term(index) = parameter.kind else { continue };
        let drives = &terms[index];
        for (actuator, law) in &drives.laws {
            matrix[(*actuator, column)] = law.at(time, measure, &[]);
        }
        for (actuator, signal) in &drives.efforts {
            matrix[(*actuator, column)] = signal.at(time).value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that a short interval with rates within the noise counts as a reversal, and a long
    /// interval as a dwell.
    #[test]
    fn dwells_are_distinguished_from_reversals() {
        use Rest::{Resting as R, Sliding as S, Uncertain as U};
        let rest = [S, U, U, S, S, U, R, U, U, U, S, R, S];
        let times: Vec<f64> = (0..rest.len()).map(|k| 0.1 * k as f64).collect();
        let found = dwells(&times, &rest, 0.35);
        let marked =
            |which: usize| -> Vec<usize> { (0..rest.len()).filter(|&k| found[k][which]).collect() };
        assert_eq!(marked(0), [6, 11]);
        assert_eq!(marked(1), [5, 6, 7, 8, 9, 11]);
    }
}
