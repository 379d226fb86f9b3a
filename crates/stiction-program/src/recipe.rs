//! What is recorded: the kernel's own run, and the coupling of friction on top of it.

use crate::coupling::{Coupling, Step};
use crate::given::Given;
use crate::graph::{Graph, Node};
use crate::meaning::{Merged, merge};
use crate::recorded::{Recorded, record};
use crate::stages::holds;
use crate::transmission::Leg;
use stiction::dynamics::{
    AppliedLoad, FrictionMode, Inverse, InverseDynamics, Kernel, Settings, Sharing,
};
use stiction::kinematics::Target;
use stiction::parameters::Parameters;
use stiction::random::Random;
use stiction::scalar::Scalar;
use stiction::spatial::Vec3;

/// Sizes of a program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    /// Numbers that are given.
    pub(crate) inputs: usize,
    pub(crate) contacts: usize,
    /// Contacts whose friction changes some load.
    pub(crate) coupled: usize,
    pub(crate) drives: usize,
    pub(crate) joints: usize,
}

/// The stages as results of one graph.
pub(crate) struct RecordedStages {
    pub(crate) graph: Graph,
    /// Drives and reactions without friction.
    pub(crate) ideal: Vec<Node>,
    /// Frictionless loads of coupled contacts.
    pub(crate) begin: Vec<Node>,
    /// Loads of coupled contacts after a Newton step; the squares of their changes and of themselves,
    /// summed; the determinant of the step's matrix.
    pub(crate) step: Vec<Node>,
    /// Drives, reactions, loads, velocities, frictions.
    pub(crate) rest: Vec<Node>,
    /// Positive where what is taken for granted holds: without friction, in a step, with friction.
    pub(crate) guards: [Node; 3],
    /// For each contact and each coupled one how the friction of the second changes the first's load.
    pub(crate) influence: Vec<Node>,
}

/// Everything that is recorded from.
pub(crate) struct Recipe<'a> {
    pub(crate) kernel: &'a Kernel,
    pub(crate) solver: &'a InverseDynamics,
    pub(crate) loads: &'a [AppliedLoad<f64>],
    pub(crate) given: &'a Given,
    /// Where it pays to solve for what legs transmit.
    pub(crate) legs: Option<&'a [Leg]>,
}

impl Recipe<'_> {
    pub(crate) fn counts(&self, coupled: usize) -> Counts {
        let solver = self.solver;
        Counts {
            inputs: self.given.count(),
            contacts: solver.parameters().contacts.len(),
            coupled,
            drives: solver.mechanism().actuators().count(),
            joints: solver.mechanism().joints().len(),
        }
    }

    /// Records all stages with these contacts coupled, and merges what means the same.
    pub(crate) fn record(&self, coupled: &[usize], samples: &[Vec<f64>]) -> RecordedStages {
        let counts = self.counts(coupled.len());
        let mut sizes = [0; 4];
        let (graph, nodes) = record(counts.inputs + coupled.len(), |inputs| {
            let stages = self.follow(&counts, coupled, inputs);
            sizes = [0, 1, 2, 3].map(|k| stages[k].len());
            stages.into_iter().flatten().collect()
        });
        // Loads are inputs of their own: any will do.
        let mut random = Random::new(2);
        let samples: Vec<Vec<f64>> = samples
            .iter()
            .map(|sample| {
                let loads = coupled.iter().map(|_| 50.0 + 40.0 * random.number());
                sample.iter().copied().chain(loads).collect()
            })
            .collect();
        let mut left = nodes.as_slice();
        let mut take = |count: usize| {
            let (front, back) = left.split_at(count);
            left = back;
            front
        };
        let old = sizes.map(&mut take);
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &samples);
        let new = |nodes: &[Node]| -> Vec<Node> {
            nodes.iter().map(|node| new_of[*node as usize]).collect()
        };
        let [ideal, begin, step, rest] = old.map(new);
        let influence = new(left);
        let coupled = [old[1], old[2], old[3]].concat();
        let guards =
            [old[0], old[2], &coupled].map(|stage| holds(&graph, stage, &guards, &mut merged));
        RecordedStages { graph: merged, ideal, begin, step, rest, guards, influence }
    }

    /// The results of the stages, and the influences.
    fn follow(
        &self,
        counts: &Counts,
        coupled: &[usize],
        inputs: &[Recorded],
    ) -> [Vec<Recorded>; 5] {
        // Numbers of the mechanism are constants: they are folded into the program.
        let parameters = Parameters::<Recorded>::new(self.solver.mechanism());
        let mut workspace = self.kernel.workspace(&parameters, self.solver.assembly().state());
        let mut inputs = inputs.iter().copied();
        let mut next = || inputs.next().unwrap_or_else(Recorded::zero);
        // Rates and accelerations are found once more, from the targets, by more operations than it takes to
        // see that they are the same: what comes first stays.
        self.given.read(self.solver.mechanism(), &mut workspace.state, &mut next);
        let mut vector = || Vec3::new(next(), next(), next());
        let loads: Vec<AppliedLoad<Recorded>> = self
            .loads
            .iter()
            .map(|load| AppliedLoad { force: vector(), moment: vector(), ..load.lift() })
            .collect();
        let count = self.solver.assembly().prescription().coordinates().len();
        let targets: Vec<Target<Recorded>> = (0..count)
            .map(|_| Target { value: next(), rate: next(), acceleration: next() })
            .collect();
        let presses: Vec<Recorded> = coupled.iter().map(|_| next()).collect();

        let settings =
            Settings { friction: FrictionMode::Off, position_steps: 0, ..Settings::default() };
        self.kernel.run(&parameters, &mut workspace, &targets, &loads, &settings);
        let bodies = &workspace.kinematics.bodies;
        let inverse = &workspace.inverse;
        let setup = self.kernel.setup();
        let responses = Sharing::new(&setup).responses(&setup, &parameters, bodies, inverse);
        let coupling =
            Coupling { parameters: &parameters, bodies, inverse, responses: &responses, coupled };

        let reaction = |inverse: &Inverse<Recorded>, joint: usize| {
            let (force, moment) = inverse.reaction(bodies, joint);
            let [a, b, c] = force.to_array();
            let [d, e, f] = moment.to_array();
            [a, b, c, d, e, f]
        };
        let mut ideal: Vec<Recorded> = inverse.drives().to_vec();
        ideal.extend((0..counts.joints).flat_map(|joint| reaction(inverse, joint)));

        let none = vec![Recorded::zero(); coupled.len()];
        let begin = coupled.iter().map(|row| coupling.load_under(*row, &none).value).collect();

        let forces: Vec<Recorded> = coupled
            .iter()
            .zip(&presses)
            .map(|(contact, press)| coupling.force(*contact, *press))
            .collect();
        let Step { loads: next, determinant } = match self.legs {
            Some(legs) => coupling.step_by_legs(self.solver.mechanism(), legs, &presses),
            None => coupling.step(&presses),
        };
        let square = |sum: Recorded, x: Recorded| sum + x * x;
        let change = presses.iter().zip(&next).map(|(press, next)| *next - *press);
        let change = change.fold(Recorded::zero(), square);
        let size = next.iter().copied().fold(Recorded::zero(), square);
        let mut step = next;
        step.extend([change, size, determinant]);
        let influence = (0..counts.contacts)
            .flat_map(|row| {
                let load = coupling.load_under(row, &forces);
                coupled.iter().map(move |column| (row, *column, load)).collect::<Vec<_>>()
            })
            .map(|(row, column, load)| coupling.influence(&load, row, column))
            .collect();

        // All forces with these frictions. Loads that change nothing follow from the others.
        let mut all_loads = Vec::new();
        for row in 0..counts.contacts {
            let given = coupled.iter().position(|contact| *contact == row);
            let load = || coupling.load_under(row, &forces).value;
            all_loads.push(given.map_or_else(load, |at| presses[at]));
        }
        let all_forces: Vec<Recorded> = all_loads
            .iter()
            .enumerate()
            .map(|(contact, load)| coupling.force(contact, *load))
            .collect();
        let mut rubbed = inverse.clone();
        rubbed.solve_with(&setup, &parameters, bodies, &all_forces);
        let mut rest: Vec<Recorded> = rubbed.drives().to_vec();
        rest.extend((0..counts.joints).flat_map(|joint| reaction(&rubbed, joint)));
        rest.extend(&all_loads);
        rest.extend(inverse.contacts().iter().map(|state| state.velocity));
        rest.extend(&all_forces);
        [ideal, begin, step, rest, influence]
    }
}
