//! What is recorded: the kernel's own run, and the coupling of friction on top of it.

use crate::given::Given;
use crate::graph::{Graph, Node, Op, needed};
use crate::meaning::{Merged, merge};
use crate::recorded::{Recorded, record};
use std::collections::HashSet;
use stiction::dynamics::{
    AppliedLoad, FrictionMode, Inverse, InverseDynamics, Kernel, Settings, Sharing,
};
use stiction::kinematics::Target;
use stiction::parameters::Parameters;
use stiction::random::Random;
use stiction::scalar::Scalar;
use stiction::spatial::{Mat3, Pose, Vec3, Wrench};

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
    /// Loads of coupled contacts after a Newton step, the determinant of its matrix.
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
}

/// A wrench in the frame of a joint.
fn local(frame: &Pose<Recorded>, wrench: Wrench<Recorded>) -> Wrench<Recorded> {
    Wrench {
        force: frame.rotation.transpose_mul(wrench.force),
        moment: frame.rotation.transpose_mul(wrench.moment_about(frame.position)),
    }
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
        // Each stage says whether what it takes for granted holds.
        let guard = |stage: &[Node], merged: &mut Graph| {
            let needed = needed(graph.ops(), stage);
            let mut holds = merged.number(1.0);
            let mut known = HashSet::new();
            for guard in guards.iter().filter(|guard| needed[guard.selection as usize]) {
                if known.insert((guard.condition, guard.is_positive)) {
                    let none = merged.number(0.0);
                    let (of, [yes, no]) = (guard.condition, [holds, none]);
                    holds = merged.add(match guard.is_positive {
                        true => Op::Select { of, yes, no },
                        false => Op::Select { of, yes: no, no: yes },
                    });
                }
            }
            holds
        };
        let coupled = [old[1], old[2], old[3]].concat();
        let guards = [old[0], old[2], &coupled].map(|stage| guard(stage, &mut merged));
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
        let count = self.solver.assembly().prescription().coordinates().len();
        let targets: Vec<Target<Recorded>> = (0..count)
            .map(|_| Target { value: next(), rate: next(), acceleration: next() })
            .collect();
        let mut vector = || Vec3::new(next(), next(), next());
        let loads: Vec<AppliedLoad<Recorded>> = self
            .loads
            .iter()
            .map(|load| AppliedLoad { force: vector(), moment: vector(), ..load.lift() })
            .collect();
        let presses: Vec<Recorded> = coupled.iter().map(|_| next()).collect();

        let settings =
            Settings { friction: FrictionMode::Off, position_steps: 0, ..Settings::default() };
        self.kernel.run(&parameters, &mut workspace, &targets, &loads, &settings);
        let bodies = &workspace.kinematics.bodies;
        let inverse = &workspace.inverse;
        let setup = self.kernel.setup();
        let responses = Sharing::new(&setup).responses(&setup, &parameters, bodies, inverse);
        let contacts: Vec<_> = parameters.contacts.iter().zip(inverse.contacts()).collect();

        // Friction forces by the loads that are given, those of other contacts by loads of their own.
        let force = |contact: usize, load: Recorded| {
            let (coefficient, constant) = contacts[contact].1.resistance();
            coefficient * load + constant
        };
        let base: Vec<Wrench<Recorded>> = inverse.joint_wrenches().to_vec();
        let here = Pose { rotation: Mat3::identity(), position: Vec3::zero() };
        let loads_under = |row: usize, forces: &[Recorded]| {
            let (contact, state) = contacts[row];
            let joint = contact.joint;
            let (j, k) = (bodies.frame_j[joint], bodies.frame_k[joint]);
            // Components in the joint's frame: many a load needs but two of them.
            let mut wrench = local(&j, base[joint]);
            for (column, force) in coupled.iter().zip(forces) {
                wrench += local(&j, responses[*column].wrenches[joint]) * *force;
            }
            state.load_in(contact, parameters.pitch[joint], &here, &(j.inverse() * k), wrench)
        };
        let gradient_on = |row: usize, column: usize, load: &stiction::friction::Load<Recorded>| {
            let (contact, _) = contacts[row];
            let j = bodies.frame_j[contact.joint];
            load.gradient.power(local(&j, responses[column].wrenches[contact.joint]))
        };

        let reaction = |inverse: &Inverse<Recorded>, joint: usize| {
            let (force, moment) = inverse.reaction(bodies, joint);
            let [a, b, c] = force.to_array();
            let [d, e, f] = moment.to_array();
            [a, b, c, d, e, f]
        };
        let mut ideal: Vec<Recorded> = inverse.drives().to_vec();
        ideal.extend((0..counts.joints).flat_map(|joint| reaction(inverse, joint)));

        let none = vec![Recorded::zero(); coupled.len()];
        let begin = coupled.iter().map(|row| loads_under(*row, &none).value).collect();

        let forces: Vec<Recorded> =
            coupled.iter().zip(&presses).map(|(contact, press)| force(*contact, *press)).collect();
        let mut matrix = Vec::new();
        let mut misfit = Vec::new();
        for (row, press) in coupled.iter().zip(&presses) {
            let load = loads_under(*row, &forces);
            misfit.push(*press - load.value);
            matrix.push(
                coupled
                    .iter()
                    .map(|column| {
                        let own = Recorded::from_f64(if row == column { 1.0 } else { 0.0 });
                        let (coefficient, _) = contacts[*column].1.resistance();
                        own - gradient_on(*row, *column, &load) * coefficient
                    })
                    .collect::<Vec<_>>(),
            );
        }
        let influence = (0..contacts.len())
            .flat_map(|row| {
                let load = loads_under(row, &forces);
                coupled.iter().map(move |column| (row, *column, load)).collect::<Vec<_>>()
            })
            .map(|(row, column, load)| gradient_on(row, column, &load))
            .collect();
        let determinant = eliminate(&mut matrix, &mut misfit);
        let mut step: Vec<Recorded> =
            presses.iter().zip(&misfit).map(|(press, change)| *press - *change).collect();
        step.push(determinant);

        // All forces with these frictions. Loads that change nothing follow from the others.
        let mut all_loads = Vec::new();
        for row in 0..contacts.len() {
            let given = coupled.iter().position(|contact| *contact == row);
            all_loads.push(given.map_or_else(|| loads_under(row, &forces).value, |at| presses[at]));
        }
        let all_forces: Vec<Recorded> =
            all_loads.iter().enumerate().map(|(contact, load)| force(contact, *load)).collect();
        let mut rubbed = inverse.clone();
        rubbed.solve_with(&setup, &parameters, bodies, &all_forces);
        let mut rest: Vec<Recorded> = rubbed.drives().to_vec();
        rest.extend((0..counts.joints).flat_map(|joint| reaction(&rubbed, joint)));
        rest.extend(&all_loads);
        rest.extend(contacts.iter().map(|(_, state)| state.velocity));
        rest.extend(&all_forces);
        [ideal, begin, step, rest, influence]
    }
}

/// Solves in place, without looking for pivots: the matrix is near the identity while friction is far from
/// locking the mechanism. Returns the product of the pivots.
fn eliminate(matrix: &mut [Vec<Recorded>], right: &mut [Recorded]) -> Recorded {
    let count = right.len();
    let mut determinant = Recorded::one();
    for pivot in 0..count {
        determinant *= matrix[pivot][pivot];
        let over = matrix[pivot][pivot].recip();
        for row in pivot + 1..count {
            let factor = matrix[row][pivot] * over;
            for column in pivot + 1..count {
                let change = factor * matrix[pivot][column];
                matrix[row][column] -= change;
            }
            let change = factor * right[pivot];
            right[row] -= change;
        }
    }
    for row in (0..count).rev() {
        for column in row + 1..count {
            let change = matrix[row][column] * right[column];
            right[row] -= change;
        }
        right[row] = right[row] / matrix[row][row];
    }
    determinant
}
