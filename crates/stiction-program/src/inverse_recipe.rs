//! What is recorded for inverse dynamics: the kernel's own run, and the coupling of friction on top of it.

use crate::coupling::Step;
use crate::given::Given;
use crate::graph::{Graph, Node};
use crate::loads::Loads;
use crate::meaning::{Merged, merge};
use crate::recipe::Recipe;
use crate::recorded::{Recorded, record_groups};
use crate::stages::holds;
use crate::transmission::Leg;
use crate::wrench::{local, reaction};
use stiction::dynamics::{AppliedLoad, FrictionMode, Settings, Sharing};
use stiction::kinematics::Target;
use stiction::parameters::{ContactParameters, Parameters};
use stiction::random::Random;
use stiction::scalar::Scalar;
use stiction::spatial::{Vec3, Wrench};

/// The stages as results of one graph.
pub(crate) struct InverseStages {
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

/// What inverse dynamics is recorded from beside the rest.
pub(crate) struct InverseRecipe<'a> {
    pub(crate) recipe: Recipe<'a>,
    pub(crate) given: &'a Given,
    /// Where it pays to solve for what legs transmit.
    pub(crate) legs: Option<&'a [Leg]>,
}

impl InverseRecipe<'_> {
    /// Records all stages with these contacts coupled, and merges what means the same.
    pub(crate) fn record(&self, coupled: &[usize], samples: &[Vec<f64>]) -> InverseStages {
        let inputs = self.given.count() + coupled.len();
        let (graph, [ideal, begin, step, rest, influence]) =
            record_groups(inputs, |inputs| self.follow(coupled, inputs));
        // Loads are inputs of their own: any will do.
        let mut random = Random::new(2);
        let samples: Vec<Vec<f64>> = samples
            .iter()
            .map(|sample| {
                let loads = coupled.iter().map(|_| 50.0 + 40.0 * random.number());
                sample.iter().copied().chain(loads).collect()
            })
            .collect();
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &samples);
        let with_friction = [&begin[..], &step, &rest].concat();
        let guards =
            [&ideal, &step, &with_friction].map(|stage| holds(&graph, stage, &guards, &mut merged));
        let new = |nodes: Vec<Node>| -> Vec<Node> {
            nodes.iter().map(|node| new_of[*node as usize]).collect()
        };
        let [ideal, begin, step, rest, influence] = [ideal, begin, step, rest, influence].map(new);
        InverseStages { graph: merged, ideal, begin, step, rest, guards, influence }
    }

    /// The results of the stages, and the influences.
    fn follow(&self, coupled: &[usize], inputs: &[Recorded]) -> [Vec<Recorded>; 5] {
        let Recipe { kernel, solver, loads } = self.recipe;
        let mechanism = solver.mechanism();
        // Numbers of the mechanism are constants: they are folded into the program.
        let parameters = Parameters::<Recorded>::new(mechanism);
        let mut workspace = kernel.workspace(&parameters, solver.assembly().state());
        let mut inputs = inputs.iter().copied();
        let mut next = || inputs.next().unwrap_or_else(Recorded::zero);
        // Rates and accelerations are found once more, from the targets, by more operations than it takes to
        // see that they are the same: what comes first stays.
        self.given.read(mechanism, &mut workspace.state, &mut next);
        let mut vector = || Vec3::new(next(), next(), next());
        let loads: Vec<AppliedLoad<Recorded>> = loads
            .iter()
            .map(|load| AppliedLoad { force: vector(), moment: vector(), ..load.lift() })
            .collect();
        let count = solver.assembly().prescription().coordinates().len();
        let targets: Vec<Target<Recorded>> = (0..count)
            .map(|_| Target { value: next(), rate: next(), acceleration: next() })
            .collect();
        let presses: Vec<Recorded> = coupled.iter().map(|_| next()).collect();

        let settings =
            Settings { friction: FrictionMode::Off, position_steps: 0, ..Settings::default() };
        kernel.run(&parameters, &mut workspace, &targets, &loads, &settings);
        let bodies = &workspace.kinematics.bodies;
        let inverse = &workspace.inverse;
        let setup = kernel.setup();
        let responses = Sharing::new(&setup).responses(&setup, &parameters, bodies, inverse);
        let at_contact = |contact: &ContactParameters<Recorded>, wrenches: &[Wrench<Recorded>]| {
            local(&bodies.frame_j[contact.joint], wrenches[contact.joint])
        };
        let contacts = parameters.contacts.iter();
        let without =
            contacts.clone().map(|contact| at_contact(contact, inverse.joint_wrenches())).collect();
        let added = contacts
            .map(|contact| {
                let of = |column: &usize| at_contact(contact, &responses[*column].wrenches);
                coupled.iter().map(of).collect()
            })
            .collect();
        let states = inverse.contacts();
        let loads = Loads { parameters: &parameters, bodies, states, coupled, without, added };

        let joints = 0..mechanism.joints().len();
        let mut ideal: Vec<Recorded> = inverse.drives().to_vec();
        ideal.extend(joints.clone().flat_map(|joint| reaction(inverse, bodies, joint)));

        let begin = loads.at_first();
        let Step { loads: next, determinant } = match self.legs {
            Some(legs) => loads.step_by_legs(mechanism, (inverse, &responses), legs, &presses),
            None => loads.step(&presses),
        };
        let square = |sum: Recorded, x: Recorded| sum + x * x;
        let change = presses.iter().zip(&next).map(|(press, next)| *next - *press);
        let change = change.fold(Recorded::zero(), square);
        let size = next.iter().copied().fold(Recorded::zero(), square);
        let mut step = next;
        step.extend([change, size, determinant]);

        // All forces with these frictions.
        let forces = loads.forces(&presses);
        let influence = loads.influences(&forces);
        let all_loads = loads.of_all(&presses, &forces);
        let all_forces = loads.forces_of_all(&all_loads);
        let mut rubbed = inverse.clone();
        rubbed.solve_with(&setup, &parameters, bodies, &all_forces);
        let mut rest: Vec<Recorded> = rubbed.drives().to_vec();
        rest.extend(joints.flat_map(|joint| reaction(&rubbed, bodies, joint)));
        rest.extend(&all_loads);
        rest.extend(states.iter().map(|state| state.velocity));
        rest.extend(&all_forces);
        [ideal, begin, step, rest, influence]
    }
}
