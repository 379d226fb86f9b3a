//! What is recorded: the kernel's own run, and the coupling of friction on top of it.

use crate::graph::{Graph, Node};
use crate::inverse::lifted;
use crate::meaning::merge;
use crate::recorded::{Recorded, record};
use crate::samples::Random;
use stiction::dynamics::{
    AppliedLoad, FrictionMode, InverseDynamics, Kernel, Settings, Sharing,
};
use stiction::kinematics::Target;
use stiction::scalar::Scalar;
use stiction::spatial::{Mat3, Pose, Vec3, Wrench};

/// Sizes of a program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    pub(crate) coordinates: usize,
    pub(crate) freedoms: usize,
    pub(crate) targets: usize,
    pub(crate) loads: usize,
    pub(crate) contacts: usize,
    /// Contacts whose friction changes some load.
    pub(crate) coupled: usize,
    pub(crate) drives: usize,
    pub(crate) joints: usize,
}

impl Counts {
    /// Inputs but for the loads of coupled contacts, which follow.
    pub(crate) fn inputs(&self) -> usize {
        self.coordinates + 2 * self.freedoms + 3 * self.targets + 6 * self.loads
    }
}

/// The three stages as results of one graph.
pub(crate) struct RecordedStages {
    pub(crate) graph: Graph,
    /// Frictionless loads of coupled contacts, frictionless drives.
    pub(crate) begin: Vec<Node>,
    /// Loads of coupled contacts after a Newton step, the determinant of its matrix.
    pub(crate) step: Vec<Node>,
    /// Drives, reactions, loads, velocities, frictions.
    pub(crate) rest: Vec<Node>,
    /// For each contact and each coupled one how the friction of the second changes the first's load.
    pub(crate) influence: Vec<Node>,
}

/// Everything that is recorded from.
pub(crate) struct Recipe<'a> {
    pub(crate) kernel: &'a Kernel,
    pub(crate) solver: &'a InverseDynamics,
    pub(crate) loads: &'a [AppliedLoad<f64>],
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
        let (solver, state) = (self.solver, self.solver.assembly().state());
        Counts {
            coordinates: state.coordinates.len(),
            freedoms: state.rates.len(),
            targets: solver.assembly().prescription().coordinates().len(),
            loads: self.loads.len(),
            contacts: solver.parameters().contacts.len(),
            coupled,
            drives: solver.mechanism().actuators().count(),
            joints: solver.mechanism().joints().len(),
        }
    }

    /// Records all stages with these contacts coupled, and merges what means the same.
    pub(crate) fn record(&self, coupled: &[usize], samples: &[Vec<f64>]) -> RecordedStages {
        let counts = self.counts(coupled.len());
        let mut sizes = [0; 3];
        let (graph, nodes) = record(counts.inputs() + coupled.len(), |inputs| {
            let stages = self.follow(&counts, coupled, inputs);
            sizes = [stages[0].len(), stages[1].len(), stages[2].len()];
            stages.into_iter().flatten().collect()
        });
        // Loads are inputs of their own: any will do.
        let mut random = Random(2);
        let samples: Vec<Vec<f64>> = samples
            .iter()
            .map(|sample| {
                let loads = coupled.iter().map(|_| 50.0 + 40.0 * random.number());
                sample.iter().copied().chain(loads).collect()
            })
            .collect();
        let (graph, nodes) = merge(&graph, &nodes, &samples);
        let mut nodes = nodes.into_iter();
        let mut take = |count: usize| nodes.by_ref().take(count).collect::<Vec<Node>>();
        let (begin, step, rest) = (take(sizes[0]), take(sizes[1]), take(sizes[2]));
        RecordedStages { graph, begin, step, rest, influence: nodes.collect() }
    }

    /// The results of the stages, and the influences.
    fn follow(&self, counts: &Counts, coupled: &[usize], inputs: &[Recorded]) -> [Vec<Recorded>; 4] {
        let parameters = lifted(self.solver);
        let mut workspace = self.kernel.workspace(&parameters, self.solver.assembly().state());
        let mut inputs = inputs.iter().copied();
        let mut next = || inputs.next().unwrap_or_else(Recorded::zero);
        workspace.state.coordinates.iter_mut().for_each(|q| *q = next());
        // Rates and accelerations are found from the targets, by more operations than it takes to see that
        // they are what was given: the given ones come first and stay.
        (0..2 * counts.freedoms).for_each(|_| {
            next();
        });
        let targets: Vec<Target<Recorded>> = (0..counts.targets)
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

        let none = vec![Recorded::zero(); coupled.len()];
        let mut begin: Vec<Recorded> =
            coupled.iter().map(|row| loads_under(*row, &none).value).collect();
        begin.extend(inverse.drives());

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
        let mut rest: Vec<Recorded> = Vec::new();
        for (drive, ideal) in inverse.drives().iter().enumerate() {
            let mut sum = *ideal;
            for (response, force) in responses.iter().zip(&all_forces) {
                sum += response.drives[drive] * *force;
            }
            rest.push(sum);
        }
        for joint in 0..counts.joints {
            // About the joint's origin.
            let about = |wrench: Wrench<Recorded>| {
                let origin = bodies.frame_j[joint].position;
                Wrench { force: wrench.force, moment: wrench.moment_about(origin) }
            };
            let mut sum = about(base[joint]);
            for (response, force) in responses.iter().zip(&all_forces) {
                sum += about(response.wrenches[joint]) * *force;
            }
            rest.extend(sum.force.to_array().into_iter().chain(sum.moment.to_array()));
        }
        rest.extend(&all_loads);
        rest.extend(contacts.iter().map(|(_, state)| state.velocity));
        rest.extend(&all_forces);
        [begin, step, rest, influence]
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
