//! Recording of [`Feedforward`] programs.

use super::{Feedforward, FeedforwardSizes, IndexLayout, Outcome, Routine, Routines};
use crate::code::{Slots, compile};
use crate::compiled::Compiled;
use crate::error::RecordError;
use crate::graph::{Graph, Node, Op};
use crate::inverse_stages::InverseStages;
use crate::machine::fuses;
use crate::program_inputs::{InputLayout, load_to_array, target_to_array};
use crate::recorded::{Recorded, extend_graph, record_groups};
use crate::recording::RecordingSource;
use crate::samples::{Sample, StateRange, creeps, seeded_samples};
use crate::stages::{early, holds, passed_on};
use crate::tunable::Tunable;
use crate::value_numbering::{Merged, merge};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::parameters::Parameters;
use stiction_core::random::Random;
use stiction_core::scalar::Scalar;

/// Largest accepted difference between the actuator forces of program and solver, relative to the
/// largest joint force. This limit allows for rounding errors, which are magnified at
/// ill-conditioned samples near singular positions.
const AGREES: f64 = 1e-9;

/// Results of the position routines as nodes of a graph.
struct PositionStages {
    graph: Graph,
    /// Sum of squares of all closure errors; lengths are divided by the characteristic length,
    /// angles are in rad.
    square: Node,
    next: Vec<Node>,
    guard: Node,
}

impl Feedforward {
    /// Records the routines of a mechanism.
    ///
    /// `signal` contains prescribed values within the intended range of motion, each close enough
    /// to the previous one for the solver to follow. The first of these positions is the home
    /// position: new memory starts with the loops closed at this position. `tunables` become inputs
    /// of the program; there are no external loads except those in `tunables`. Friction is that of
    /// the mechanism, coupled with the reactions, independently of the solver's settings.
    ///
    /// # Errors
    /// See [`RecordError`].
    pub fn record(
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
        tunables: &[Tunable],
    ) -> Result<Self, RecordError> {
        let mut solver = solver.clone();
        let home = signal.first().ok_or(RecordError::EmptySignal)?;
        solver.move_to(home).map_err(|error| RecordError::Signal { position: 0, error })?;
        let solver = &solver;
        let model = solver.model().map_err(|_| RecordError::NoPlan)?;
        let parameters = solver.parameters();
        let value_of = |tunable: &Tunable| {
            let values = tunable.values(parameters).ok_or(RecordError::NoTunable(*tunable))?;
            Ok((*tunable, values))
        };
        let mut tunables = tunables.to_vec();
        tunables.sort_by_key(|tunable| tunable.load().is_some());
        let tunables = &tunables;
        let values = tunables.iter().map(value_of).collect::<Result<Vec<_>, RecordError>>()?;
        let loads = &loads_of(tunables);
        let source = RecordingSource { model: &model, solver, loads };
        let index = source.index_layout();
        let layout = InputLayout::of_tree(solver, tunables);
        let signal = &there_and_back(signal);
        let all = seeded_samples(1, StateRange::Wide, solver, signal, &[])?;
        let position = source.record_position(&all);
        let kinematics = source.record_kinematics(&all).compile()?;
        let length = solver.mechanism().characteristic_length();
        let rows = rows(solver, &all, tunables);
        let stages = source.record_inverse(&layout, &rows, &[])?;
        let (stages, determinant) = source.with_determinant(stages, home);
        let counts = source.counts(0);
        let sizes = FeedforwardSizes {
            prescribed: counts.targets,
            drives: counts.drives,
            joints: counts.joints,
            bodies: solver.mechanism().bodies().len() - 1,
            coordinates: counts.coordinates,
            tunables: values.iter().map(|(_, values)| values.len()).sum(),
            unknowns: stages.from.len(),
        };
        let routines =
            |detail| Routines::compile(sizes, &layout, &position, (&stages, determinant), detail);
        let plain = Detail { fuse: false, wrenches: false, places: true };
        let source = routines(plain)?;
        let native = routines(Detail { fuse: fuses(), places: false, ..plain })?;
        let wrenches = routines(Detail { wrenches: true, ..plain })?.forces;
        let parts = |routines: &[Routine]| routines.iter().map(|r| r.parts.clone()).collect();
        let [a, b]: [Vec<_>; 2] = array(parts(&native.position));
        let [c, d, e]: [Vec<_>; 3] = array(parts(&native.forces));
        let code = (
            Compiled::new([a, b], native.position_slots, true),
            Compiled::new([c, d, e], native.force_slots, true),
        );
        let values_at_home = home.iter().map(|target| target.value).collect();
        let home = (solver.state().coordinates.clone(), values_at_home);
        let unknown_slots = stages.from.clone();
        let tunables = values;
        let made = Self {
            sizes,
            length,
            home,
            tunables,
            unknown_slots,
            index,
            source,
            wrenches,
            kinematics,
            derivatives: None,
            native,
            code,
        };
        let others = seeded_samples(9, StateRange::Wide, solver, signal, loads)?;
        if made.agrees_with(solver, &others) { Ok(made) } else { Err(RecordError::NotConfirmed) }
    }

    /// Compares the program with its solver at states other than those of the recording. States at
    /// which the program or the solver computes no forces are skipped. Returns `false` if the
    /// actuator forces differ at a state, or if all states are skipped.
    fn agrees_with(&self, solver: &InverseDynamics, samples: &[Sample]) -> bool {
        let mut solver = solver.clone();
        solver.settings_mut().friction = FrictionMode::Converged;
        let mut memory = self.memory();
        let length = solver.mechanism().characteristic_length().max(1.0);
        let mut compared = 0;
        let plain = self.tunables.iter().filter(|(tunable, _)| tunable.load().is_none());
        let plain: Vec<f64> = plain.flat_map(|(_, values)| values.iter().copied()).collect();
        let same = samples.iter().all(|Sample { state, targets, loads, .. }| {
            let wrenches = loads.iter().flat_map(load_to_array);
            self.tune(&mut memory, &plain.iter().copied().chain(wrenches).collect::<Vec<_>>());
            self.start_at(&mut memory, &state.coordinates);
            let of = |f: fn(&Target<f64>) -> f64| targets.iter().map(f).collect::<Vec<f64>>();
            let (q, v, a) = (of(|t| t.value), of(|t| t.rate), of(|t| t.acceleration));
            let Outcome { shortfall: None, .. } = self.run(&mut memory, &q, &v, &a) else {
                return true;
            };
            // The solver continues from these coordinates, because another assembly mode has other
            // forces.
            let known = [&state.coordinates, &state.rates, &state.accelerations];
            if !solver.return_to(known.map(Vec::as_slice), targets) {
                return true;
            }
            let Ok(forces) = solver.solve(loads) else { return true };
            if creeps(forces) {
                return true;
            }
            compared += 1;
            let largest = forces.reactions.iter().map(|(force, _)| force.norm());
            let largest = largest.fold(f64::MIN_POSITIVE, f64::max) * length;
            let mut drives = forces.efforts.iter().enumerate();
            drives.all(|(k, x)| (self.drive(&memory, k) - x).abs() <= AGREES * largest)
        });
        same && compared > 0
    }
}

/// Returns the external loads among the tunable parameters, with zero force and moment.
pub(super) fn loads_of(tunables: &[Tunable]) -> Vec<AppliedLoad<f64>> {
    tunables.iter().filter_map(|tunable| tunable.load()).collect()
}

/// Returns a row of values of all inputs for each sample, with random values of the tunable
/// parameters; extreme samples have no loads.
pub(super) fn rows(
    solver: &InverseDynamics,
    samples: &[Sample],
    tunables: &[Tunable],
) -> Vec<Vec<f64>> {
    let (parameters, length) = (solver.parameters(), solver.mechanism().characteristic_length());
    let mut random = Random::new(5);
    let mut row = |Sample { state, targets, is_extreme, .. }: &Sample| {
        let mut row = state.coordinates.clone();
        for tunable in tunables {
            let strength = if *is_extreme && tunable.load().is_some() { 0.0 } else { 1.0 };
            let values = tunable.any(parameters, length, || random.number());
            row.extend(values.iter().map(|value| strength * value));
        }
        row.extend(targets.iter().flat_map(target_to_array));
        row
    };
    samples.iter().map(&mut row).collect()
}

/// Orders positions so that each position is close to the next, and the last one to the first,
/// because the samples pass through the list repeatedly. The result contains every second position
/// and then all remaining positions in reverse order.
pub(super) fn there_and_back(signal: &[Vec<Target<f64>>]) -> Vec<Vec<Target<f64>>> {
    let there = signal.iter().step_by(2);
    let mut back: Vec<_> = signal.iter().skip(1).step_by(2).collect();
    back.reverse();
    there.chain(back).cloned().collect()
}

/// Converts the items to an array of length `N`; missing items are empty.
fn array<T: Default, const N: usize>(items: Vec<T>) -> [T; N] {
    let mut items = items.into_iter();
    core::array::from_fn(|_| items.next().unwrap_or_default())
}

impl RecordingSource<'_> {
    /// Records the closure errors at a position, and the Newton step that corrects the position.
    /// Value numbering uses random coordinates near closed loops.
    fn record_position(&self, samples: &[Sample]) -> PositionStages {
        let (solver, counts) = (self.solver, self.counts(0));
        let length = solver.mechanism().characteristic_length();
        let (graph, [square, next]) =
            record_groups(counts.coordinates + counts.targets, |inputs| {
                let (coordinates, values) = inputs.split_at(counts.coordinates);
                let still = |value: &Recorded| Target {
                    value: *value,
                    rate: Recorded::zero(),
                    acceleration: Recorded::zero(),
                };
                let targets: Vec<Target<Recorded>> = values.iter().map(still).collect();
                let parameters = Parameters::<Recorded>::new(solver.mechanism());
                let mut data = self.model.data(solver.state(), Settings::default());
                data.state.coordinates.copy_from_slice(coordinates);
                self.model.approach(&parameters, &mut data, &targets);
                let mut square = Recorded::zero();
                for error in data.kinematics.scaled_errors(self.model.constraints(), length) {
                    square += error * error;
                }
                [vec![square], data.state.coordinates]
            });
        let mut random = Random::new(3);
        let rows: Vec<Vec<f64>> = samples
            .iter()
            .map(|Sample { state, targets, .. }| {
                // Corrections act on open loops, so samples are offset from closed ones.
                let mut off = || 0.02 * length.min(1.0) * random.number();
                let mut row: Vec<f64> = state.coordinates.iter().map(|q| q + off()).collect();
                row.extend(targets.iter().map(|target| target.value + off()));
                row
            })
            .collect();
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &rows);
        let all = [&square[..], &next].concat();
        let guard = holds(&graph, &all, &guards, &mut merged);
        let new = |node: &Node| new_of[*node as usize];
        let (square, next) = (new(&square[0]), next.iter().map(new).collect());
        PositionStages { graph: merged, square, next, guard }
    }

    /// Adds the determinant of the rate equations, relative to its value at the home position. If
    /// not all prescribed coordinates are actuated, the result is multiplied by the relative
    /// determinant of the force balance, because only this determinant vanishes at positions where
    /// the actuators do not determine the motion.
    fn with_determinant(
        &self,
        stages: InverseStages,
        home: &[Target<f64>],
    ) -> (InverseStages, Node) {
        let mut data = self.model.data::<f64>(self.solver.state(), Settings::default());
        data.settings.position_steps = 0;
        data.settings.friction = FrictionMode::Off;
        self.model.evaluate(self.solver.parameters(), &mut data, home, &[]);
        let mut at_home = self.model.rate_pivots(&data);
        let InverseStages { graph, rate_pivots, balance_pivots, .. } = stages;
        let mut pivots = rate_pivots.clone();
        if !self.follows_actuators() {
            at_home.extend(data.inverse.reciprocal_pivots(self.model));
            pivots.extend(&balance_pivots);
        }
        let (graph, found) = extend_graph(graph, &pivots, |reciprocals| {
            let ratios = reciprocals.iter().zip(&at_home);
            let product = ratios.fold(Recorded::one(), |product, (now, home)| {
                product * (*now * Recorded::from_f64(1.0 / home))
            });
            vec![product.recip()]
        });
        (InverseStages { graph, rate_pivots, balance_pivots, ..stages }, found[0])
    }

    /// Returns the data with which source code computes the singularity index.
    pub(crate) fn index_layout(&self) -> IndexLayout {
        let spins = self.model.constraints().spins().iter().map(|spin| (spin.body.0, spin.axis));
        IndexLayout::new(self.solver.mechanism(), &spins.collect::<Vec<_>>())
    }

    /// Returns true if all prescribed coordinates are actuated.
    fn follows_actuators(&self) -> bool {
        let actuators: Vec<_> = self.solver.mechanism().actuators().collect();
        self.solver.constraints().coordinates().iter().all(|coordinate| match coordinate {
            Coordinate::Joint { joint, dof } => actuators.contains(&(*joint, *dof)),
            _ => false,
        })
    }
}

/// Options for compiling the routines.
#[derive(Clone, Copy, Debug)]
struct Detail {
    /// True if a product and a sum are compiled to one fused multiply-add.
    fuse: bool,
    /// True if the results contain the complete wrench of each joint instead of its force.
    wrenches: bool,
    /// True if the results contain the geometric data for the singularity index, see
    /// [`IndexLayout::places`].
    places: bool,
}

impl Routines {
    fn compile(
        sizes: FeedforwardSizes,
        layout: &InputLayout,
        position: &PositionStages,
        (stages, determinant): (&InverseStages, Node),
        Detail { fuse, wrenches, places }: Detail,
    ) -> Result<Self, RecordError> {
        let PositionStages { graph, square, next, guard } = position;
        let ops = graph.ops();
        let mut slots = Slots::of_inputs(ops, 0..sizes.coordinates + sizes.prescribed);
        let errors = [*square, *guard];
        let all = |_: usize| true;
        let first = [&errors[..], &passed_on(ops, &errors, next, all)].concat();
        let parts = compile(ops, &first, &mut slots, fuse);
        let errors = Routine { parts, results: slots.places(&errors)? };
        let parts = compile(ops, next, &mut slots, fuse);
        let correction = Routine { parts, results: slots.places(next)? };
        let position_slots = slots.count();

        // The guard fails if the supports of an interface no longer overlap, because they then
        // carry no load.
        let mut graph = stages.graph.clone();
        let none = graph.number(0.0);
        let [ideal_guard, mut guard, _] = stages.guards;
        for overlap in &stages.overlaps {
            guard = graph.add(Op::Select { of: *overlap, yes: guard, no: none });
        }
        let ops = graph.ops();
        let inputs = layout.count();
        let mut slots = Slots::of_inputs(ops, 0..stages.slope_inputs.start);
        let is_late = |input| input >= inputs;
        let drives = sizes.drives;
        let mut beginning = stages.begin.clone();
        beginning.extend(&stages.ideal[..drives]);
        beginning.extend([ideal_guard, determinant]);
        let width = if wrenches { 6 } else { 3 };
        if wrenches {
            beginning.extend(&stages.ideal[drives..drives + width * sizes.joints]);
        }
        if places {
            beginning.extend(&stages.places);
        }
        let step = [&stages.next[..], &stages.control].concat();
        let mut last = stages.rest[..drives].to_vec();
        for joint in 0..sizes.joints {
            let first = drives + 6 * joint;
            last.extend(&stages.rest[first..first + width]);
        }
        last.push(guard);
        let mut first = early(ops, &[&step[..], &last].concat(), is_late);
        first.extend(&beginning);
        let parts = compile(ops, &first, &mut slots, fuse);
        let preparation = Routine { parts, results: slots.places(&beginning)? };
        let second = [&step[..], &passed_on(ops, &step, &last, is_late)].concat();
        let parts = compile(ops, &second, &mut slots, fuse);
        let step = Routine { parts, results: slots.places(&step)? };
        let parts = compile(ops, &last, &mut slots, fuse);
        let forces = Routine { parts, results: slots.places(&last)? };
        Ok(Self {
            position: [errors, correction],
            position_slots,
            forces: [preparation, step, forces],
            force_slots: slots.count(),
        })
    }
}
