//! Forward and inverse dynamics are inverse to each other, on random mechanisms of every class. The
//! two computations share neither unknowns nor elimination.

use crate::common::random::*;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseError};
use stiction_core::forward::{EventKind, Forward, Inputs, View};
use stiction_core::topology::TreeRule;

struct Given {
    drives: Vec<f64>,
    loads: Vec<AppliedLoad<f64>>,
}

impl Inputs for Given {
    fn efforts(&mut self, _: &View<'_>, efforts: &mut [f64]) {
        efforts.copy_from_slice(&self.drives);
    }
    fn loads(&mut self, _: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        loads.extend_from_slice(&self.loads);
    }
}

#[test]
fn efforts_of_inverse_dynamics_cause_the_prescribed_accelerations() {
    let mut others = 0;
    let (mut compared, mut worst) = ([0; CLASSES.len()], [0.0_f64; 2]);
    for (index, class) in CLASSES.into_iter().enumerate() {
        for seed in 0..25 {
            let (_, case) = case(class, seed, 0.15);
            let solver = case.regular_solver(FrictionMode::Converged);
            let Some((mut solver, _)) = solver else { continue };
            match solver.solve(&case.loads) {
                Err(InverseError::Locked { .. }) => continue,
                other => other.unwrap(),
            };
            // If several solutions exist, the two computations may choose different ones.
            if !solver.coupling().is_some_and(|coupling| coupling < 0.9) {
                continue;
            }
            let forces = solver.forces().clone();
            let mut given = Given { drives: forces.efforts.clone(), loads: case.loads.clone() };
            // The state is that of the spanning tree of inverse dynamics.
            let model = Forward::with_tree(case.mechanism.clone(), TreeRule::Structure, &[]);
            let state = solver.state().clone();
            let fine = stiction_core::forward::Settings::default();
            let simulation = model
                .start(0.0, state, fine, &mut given)
                .unwrap_or_else(|e| panic!("{class:?} {seed}: {e}"));
            let now = simulation.instant();
            // Uniqueness for given efforts does not imply uniqueness for a given motion, or vice
            // versa.
            let certain = now.coupling.is_some_and(|coupling| coupling < 1.0);
            let list = |twists: &[stiction_core::spatial::Twist<f64>]| -> Vec<f64> {
                let each = twists.iter().flat_map(|t| [t.angular.to_array(), t.linear.to_array()]);
                each.flatten().collect()
            };
            let (found, wanted) =
                (list(&now.bodies.acceleration), list(&solver.bodies().acceleration));
            let accelerations = apart(&found, &wanted);
            if !certain && accelerations > 1e-8 {
                // The simulation must then report several solutions, and inverse dynamics must have
                // found another one of them.
                let told = simulation.events().iter().find_map(|event| match &event.kind {
                    EventKind::NotUnique { others, .. } => Some(others),
                    _ => None,
                });
                let told = told.unwrap_or_else(|| panic!("{class:?} {seed}: {accelerations:e}"));
                let loads: Vec<f64> = forces.interfaces.iter().map(|c| c.load).collect();
                let nearest =
                    told.iter().map(|o| apart(&o.loads, &loads)).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-8, "{class:?} {seed}: {nearest:e}");
                others += 1;
                continue;
            }
            let pairs = |all: &[(
                stiction_core::spatial::Vec3<f64>,
                stiction_core::spatial::Vec3<f64>,
            )]| {
                let each = all.iter().flat_map(|(f, m)| [f.to_array(), m.to_array()]);
                each.flatten().collect::<Vec<f64>>()
            };
            let reactions = apart(&pairs(&now.reactions()), &pairs(&forces.reactions));
            // Singularity indices of 1e-3 magnify rounding, in forces even by the square.
            assert!(accelerations < 1e-8, "{class:?} {seed}: accelerations {accelerations:e}");
            if class != Class::RedundantlyActuated {
                assert!(reactions < 1e-8, "{class:?} {seed}: reactions {reactions:e}");
            }
            worst = [worst[0].max(accelerations), worst[1].max(reactions)];
            compared[index] += 1;
        }
    }
    println!("{compared:?} {worst:?} {others}");
    assert!(compared.iter().all(|&count| count >= 5), "{compared:?}");
}
