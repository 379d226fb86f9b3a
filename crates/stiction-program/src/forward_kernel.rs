//! Evaluation of the kernel of inverse dynamics from which forward dynamics is recorded, with
//! recorded scalars.
//!
//! Equations (P4) and (P5) of the book's theory.

use crate::loads::Loads;
use crate::locality::{Replacement, WrenchForm, at_fixed_accelerations, frame};
use crate::motions::{Inertial, UnitAccelerations, run};
use crate::recorded::Recorded;
use crate::recording::{Counts, RecordingSource};
use crate::samples::Sample;
use crate::small_lu::largest_pivots;
use crate::wrench::{components, from_components, local, reaction};
use stiction_core::dynamics::{AppliedLoad, Data, Response, Sharing};
use stiction_core::forward::moving_results;
use stiction_core::friction::Load;
use stiction_core::kinematics::{Bodies, Target, measure_motion};
use stiction_core::parameters::Parameters;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::Wrench;

/// Number of sets of accelerations that are solutions of linear systems: without friction, for the
/// initial guess, for both sets of estimated normal loads, and with the friction of all interfaces.
pub(crate) const SOLUTIONS: usize = 5;

/// Recorded evaluation of inverse dynamics, and its changes due to unit accelerations and unit
/// friction forces.
struct KernelResponses {
    parameters: Parameters<Recorded>,
    base: Data<Recorded>,
    units: UnitAccelerations<Recorded>,
    responses: Vec<Response<Recorded>>,
    efforts: Vec<Recorded>,
    loads: Vec<AppliedLoad<Recorded>>,
}

/// Results of an evaluation of the kernel.
#[derive(Clone, Debug)]
pub(crate) struct KernelResults<T> {
    /// Matrix of efforts per unit acceleration.
    pub(crate) masses: T,
    /// Right-hand sides of the linear systems for all sets of accelerations.
    pub(crate) rights: T,
    /// Changes of efforts per unit normal load.
    pub(crate) per_load: T,
    /// Results without friction.
    pub(crate) ideal: T,
    /// Normal loads of the coupled interfaces without friction.
    pub(crate) frictionless: T,
    /// Normal loads under the friction that the frictionless normal loads cause.
    pub(crate) begin: T,
    /// Derivatives of the normal loads for the first set of estimates.
    pub(crate) slopes: T,
    /// Normal loads that result from both sets of estimates, then both sets of estimates.
    pub(crate) found: T,
    /// Results with friction.
    pub(crate) rest: T,
    /// Ratio and divisor of each replacement.
    pub(crate) ratios: T,
}

impl<T> KernelResults<T> {
    pub(crate) fn into_array(self) -> [T; 10] {
        let Self {
            masses,
            rights,
            per_load,
            ideal,
            frictionless,
            begin,
            slopes,
            found,
            rest,
            ratios,
        } = self;
        [masses, rights, per_load, ideal, frictionless, begin, slopes, found, rest, ratios]
    }

    /// The inverse of [`Self::into_array`].
    pub(crate) fn from_array(groups: [T; 10]) -> Self {
        let [masses, rights, per_load, ideal, frictionless, begin, slopes, found, rest, ratios] =
            groups;
        Self { masses, rights, per_load, ideal, frictionless, begin, slopes, found, rest, ratios }
    }
}

impl KernelResponses {
    /// Returns the data of the normal loads, with multiples of the equations of the efforts added
    /// to the wrenches. `remaining` are the efforts for accelerations and friction. Also returns
    /// the ratio of each replacement, followed by its divisor.
    fn loads<'a>(
        &'a self,
        coupled: &'a [usize],
        form: &WrenchForm,
        remaining: &[Recorded],
    ) -> (Loads<'a>, Vec<Recorded>) {
        let Self { parameters, base, units, responses, .. } = self;
        let (bodies, states) = (&base.kinematics.bodies, base.inverse.interfaces());
        let of_frictions = at_fixed_accelerations(parameters, bodies, responses);
        let mut loads = Loads {
            parameters,
            bodies,
            states,
            coupled,
            units,
            by_tree: form.is_by_tree(),
            rows: Vec::new(),
        };
        let mut ratios = Vec::new();
        let rows = parameters.interfaces.iter().zip(&of_frictions).zip(&form.replacements);
        for ((interface, of_frictions), replacements) in rows {
            let (frame, joint) = (frame(interface, bodies), interface.joint);
            let mut multiples = Vec::new();
            for (component, replacement) in replacements.iter().enumerate() {
                let Some(Replacement { drive, interface }) = *replacement else { continue };
                let divisor = responses[interface].efforts[drive];
                let ratio = components(of_frictions[interface])[component] / divisor;
                ratios.extend([ratio, divisor]);
                multiples.push((component, drive, ratio));
            }
            // Subtracts the multiples of a term of the efforts from the same term of the wrench.
            let rest = |wrench: Wrench<Recorded>, efforts: &[Recorded]| {
                let mut numbers = components(wrench);
                for (component, drive, ratio) in &multiples {
                    numbers[*component] -= *ratio * efforts[*drive];
                }
                from_components(&numbers)
            };
            let given: Vec<Recorded> = remaining.iter().map(|effort| -*effort).collect();
            let ideal = rest(local(&frame, base.inverse.joint_wrenches()[joint]), &given);
            let pairs = of_frictions.iter().zip(responses);
            let by_friction: Vec<Wrench<Recorded>> =
                pairs.map(|(wrench, response)| rest(*wrench, &response.efforts)).collect();
            let of_acceleration =
                |unit: &Inertial<Recorded>| rest(local(&frame, unit.wrenches[joint]), &unit.drives);
            let of_tree: Vec<Wrench<Recorded>> = units.forces.iter().map(of_acceleration).collect();
            loads.push(ideal, &by_friction, &of_tree);
        }
        (loads, ratios)
    }
}

impl RecordingSource<'_> {
    /// Chooses the order of pivots for the matrix of actuator forces per unit acceleration. Returns
    /// `None` if the actuator forces do not determine the accelerations.
    pub(crate) fn mass_pivots(&self, samples: &[Sample]) -> Option<Vec<(usize, usize)>> {
        let counts = self.counts(0);
        let Sample { state, targets, .. } = samples.first()?;
        let (like, coordinates) = (self.solver.state(), &state.coordinates);
        let parameters = self.solver.parameters();
        let units = UnitAccelerations::new(self.model, parameters, like, coordinates, targets);
        largest_pivots(units.masses(counts.drives))
    }

    fn kernel_responses(
        &self,
        counts: &Counts,
        inputs: &mut dyn Iterator<Item = Recorded>,
    ) -> KernelResponses {
        // The parameters of the mechanism are constants of the program.
        let parameters = Parameters::<Recorded>::new(self.solver.mechanism());
        let like = self.solver.state();
        let mut next = || inputs.next().unwrap_or_else(Recorded::zero);
        let coordinates: Vec<Recorded> = (0..counts.coordinates).map(|_| next()).collect();
        let rates: Vec<Recorded> = (0..counts.dofs).map(|_| next()).collect();
        let topology = self.model.topology();
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, &parameters, &coordinates);
        bodies.move_with(topology, &rates);
        // The kernel computes the rates again from those of the prescribed coordinates. Value
        // numbering merges them with the rates of the tree, which precede them in the graph.
        let prescribed = self.solver.constraints().coordinates().iter();
        let targets: Vec<Target<Recorded>> = prescribed
            .map(|own| measure_motion(*own, topology, &parameters, &bodies, &coordinates))
            .collect();
        let loads = self.read_loads(&mut next);
        let efforts = (0..counts.drives).map(|_| next()).collect();
        let base = run(self.model, &parameters, like, &coordinates, (&targets, &loads), 0);
        let model = self.model;
        let bodies = &base.kinematics.bodies;
        let responses = Sharing::new(model).responses(model, &parameters, bodies, &base.inverse);
        let units = UnitAccelerations::new(self.model, &parameters, like, &coordinates, &targets);
        KernelResponses { parameters, base, units, responses, efforts, loads }
    }

    /// Evaluates the kernel with recorded scalars.
    pub(crate) fn follow_forward(
        &self,
        counts: &Counts,
        coupled: &[usize],
        form: &WrenchForm,
        inputs: &[Recorded],
    ) -> KernelResults<Vec<Recorded>> {
        let mut inputs = inputs.iter().copied();
        let kernel = self.kernel_responses(counts, &mut inputs);
        let mut take = |count: usize| -> Vec<Recorded> { inputs.by_ref().take(count).collect() };
        let [estimates, estimates_later] = [take(coupled.len()), take(coupled.len())];
        let free = take(counts.targets);
        let start = take(coupled.len());
        let [of_start, of_estimates, of_later, with_friction] =
            [(); SOLUTIONS - 1].map(|()| take(counts.targets));
        let KernelResponses { base, units, responses, efforts, .. } = &kernel;
        let states = base.inverse.interfaces();

        let masses = units.masses(counts.drives).concat();
        let remaining: Vec<Recorded> =
            efforts.iter().zip(base.inverse.efforts()).map(|(effort, h)| *effort - *h).collect();
        let (loads, ratios) = kernel.loads(coupled, form, &remaining);
        // Efforts that remain without those parts of all friction forces that depend on normal
        // loads, and the changes of efforts per unit normal load.
        let mut unloaded = remaining.clone();
        let mut per_load = Vec::new();
        for (drive, unloaded) in unloaded.iter_mut().enumerate() {
            for (state, response) in states.iter().zip(responses) {
                *unloaded -= response.efforts[drive] * state.resistance().1;
            }
            per_load.extend(coupled.iter().map(|interface| {
                responses[*interface].efforts[drive] * states[*interface].resistance().0
            }));
        }
        let right = |loads: &[Recorded]| -> Vec<Recorded> {
            let rows = unloaded.iter().zip(per_load.chunks(coupled.len().max(1)));
            let of_row = |(start, row): (&Recorded, &[Recorded])| {
                row.iter().zip(loads).fold(*start, |sum, (change, load)| sum - *change * *load)
            };
            match coupled {
                [] => unloaded.clone(),
                _ => rows.map(of_row).collect(),
            }
        };
        let values =
            |loads: &[Load<Recorded>]| -> Vec<Recorded> { loads.iter().map(|l| l.value).collect() };
        let [free_of_tree, of_start, of_estimates, of_later] =
            [&free, &of_start, &of_estimates, &of_later].map(|set| loads.accelerations(set));
        let found = loads.all_under(&estimates, &of_estimates);
        let found_later = loads.all_under(&estimates_later, &of_later);
        let all_loads = loads.of_all(&estimates_later, &of_later);
        let all_forces = loads.forces_of_all(&all_loads);
        // Normal loads of interfaces that are not coupled change accelerations, too.
        let others = (0..states.len()).filter(|interface| !coupled.contains(interface));
        let right_last = others.fold(right(&estimates_later), |mut right, interface| {
            for (right, change) in right.iter_mut().zip(&responses[interface].efforts) {
                *right -= *change * (states[interface].resistance().0 * all_loads[interface]);
            }
            right
        });
        let rights = [
            remaining.clone(),
            right(&start),
            right(&estimates),
            right(&estimates_later),
            right_last,
        ];
        let ideal = self.finish(&kernel, &free, None);
        let mut rest = self.finish(&kernel, &with_friction, Some(&all_forces));
        rest.extend(&all_loads);
        rest.extend(states.iter().map(|state| state.velocity));
        rest.extend(&all_forces);
        let (topology, bodies) = (self.model.topology(), &base.kinematics.bodies);
        rest.extend(moving_results(topology, &kernel.parameters, bodies, &kernel.loads));
        KernelResults {
            masses,
            rights: rights.concat(),
            per_load,
            ideal,
            frictionless: loads.frictionless(&free_of_tree),
            begin: values(&loads.all_under(&start, &of_start)),
            slopes: loads.slopes(&found).concat(),
            found: [values(&found), values(&found_later), estimates, estimates_later].concat(),
            rest,
            ratios,
        }
    }

    /// Evaluates the accelerations of the prescribed coordinates and of the tree, and all
    /// reactions, for the given accelerations and friction forces.
    fn finish(
        &self,
        kernel: &KernelResponses,
        accelerations: &[Recorded],
        frictions: Option<&[Recorded]>,
    ) -> Vec<Recorded> {
        let KernelResponses { parameters, base, units, loads, .. } = kernel;
        let changes = units.of_tree(accelerations);
        let due_to_rates = base.state.accelerations.iter();
        let tree: Vec<Recorded> =
            due_to_rates.zip(changes).map(|(a, change)| *a + change).collect();
        let mut data = base.clone();
        self.model.forces(parameters, &mut data, &tree, loads);
        let bodies = &data.kinematics.bodies;
        if let Some(frictions) = frictions {
            data.inverse.solve_with(self.model, parameters, bodies, frictions);
        }
        let mut results = accelerations.to_vec();
        results.extend(tree);
        for joint in 0..self.solver.mechanism().joints().len() {
            results.extend(reaction(&data.inverse, bodies, joint));
        }
        results
    }
}
