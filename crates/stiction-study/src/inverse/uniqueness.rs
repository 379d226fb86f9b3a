//! What is unique at a sample, and how far it is from a singular position.

use stiction::dynamics::{InverseDynamics, Weighting};
use stiction::joint::JointType;
use stiction::mobility::{Distances, Statics};

/// The look at one sample, and room for the next.
#[derive(Clone, Debug)]
pub(super) struct Uniqueness {
    /// Freedoms that the constraints are meant to leave, idle spins included.
    mobility: usize,
    joint_types: Vec<JointType>,
    pub(super) distances: Distances,
    pub(super) redundancy: usize,
    pub(super) reactions: Vec<[bool; 6]>,
    pub(super) loads: Vec<bool>,
    pub(super) drives: Vec<bool>,
}

impl Uniqueness {
    /// Everything unique until looked at.
    pub(super) fn new(solver: &InverseDynamics, mobility: usize) -> Self {
        let mechanism = solver.mechanism();
        Self {
            mobility,
            joint_types: mechanism.joints().iter().map(|j| j.joint_type).collect(),
            distances: Distances { actuation: 1.0, constraint: 1.0 },
            redundancy: 0,
            reactions: vec![[true; 6]; mechanism.joints().len()],
            loads: vec![true; solver.parameters().contacts.len()],
            drives: vec![true; mechanism.actuators().count()],
        }
    }

    /// Looks at the present position.
    pub(super) fn look(&mut self, solver: &InverseDynamics) {
        let spins = solver.assembly().prescription().spins().len();
        if solver.weighting() == Some(Weighting::Determined) && spins == 0 {
            // Everything is unique; only the distances are asked for.
            self.redundancy = 0;
            self.reactions.fill([true; 6]);
            self.loads.fill(true);
            self.drives.fill(true);
            self.distances = Distances::of_square(&solver.balance(), &self.joint_types);
            return;
        }
        let statics: Statics = solver.statics();
        self.redundancy = statics.redundancy();
        self.reactions = statics.determined_reactions();
        self.loads = solver.determined_loads(&statics);
        self.drives = statics.determined_drives();
        self.distances = Distances::new(&statics, self.mobility, spins);
    }
}
