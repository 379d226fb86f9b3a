//! What is unique at a sample, and how far it is from a singular position.

use stiction_core::dynamics::{InverseDynamics, Weighting};
use stiction_core::joint::JointType;
use stiction_core::statics::{Distances, NullDirection, SingularityDistances, Statics};

/// Closer to a singular position than this is in it: distances are zero where ranks do not count.
pub(crate) const SINGULAR: f64 = f64::MIN_POSITIVE;

/// The look at one sample, and room for the next.
#[derive(Clone, Debug)]
pub(super) struct Uniqueness {
    /// Freedoms that the constraints are meant to leave, idle spins included.
    mobility: usize,
    joint_types: Vec<JointType>,
    /// Where the balance has as many unknowns as equations.
    proximity: Option<SingularityDistances>,
    pub(super) distances: Distances,
    pub(super) redundancy: usize,
    pub(super) reactions: Vec<[bool; 6]>,
    pub(super) loads: Vec<bool>,
    pub(super) drives: Vec<bool>,
    /// Whether the position is singular, although the load could be carried.
    pub(super) is_singular: bool,
    /// The first of those that were looked at, when it is looked at.
    pub(super) singular: Option<Singular>,
    told: bool,
}

/// Singular positions in which forces are finite, since the load happens to be carried, but not
/// unique.
#[derive(Clone, Debug, PartialEq)]
pub struct Singular {
    /// At how many samples.
    pub samples: usize,
    /// The first of them, s.
    pub time: f64,
    /// The body that can move there while all actuators stand still, and how.
    pub body: String,
    /// See `body`.
    pub motion: String,
    /// What could not be carried there.
    pub load: String,
    /// What may be added to the forces there.
    pub null_directions: Vec<NullDirection>,
}

impl Uniqueness {
    /// Everything unique until looked at.
    pub(super) fn new(solver: &InverseDynamics, mobility: usize) -> Self {
        let mechanism = solver.mechanism();
        Self {
            mobility,
            joint_types: mechanism.joints().iter().map(|j| j.joint_type).collect(),
            proximity: SingularityDistances::new(mechanism),
            distances: Distances { actuation: 1.0, constraint: 1.0 },
            redundancy: 0,
            reactions: vec![[true; 6]; mechanism.joints().len()],
            loads: vec![true; solver.parameters().interfaces.len()],
            drives: vec![true; mechanism.actuators().count()],
            is_singular: false,
            singular: None,
            told: false,
        }
    }

    /// Looks at the present position.
    pub(super) fn look(&mut self, solver: &InverseDynamics, time: f64) {
        (self.is_singular, self.singular) = (false, None);
        if is_determined(solver) {
            // Only the distances are asked for.
            self.redundancy = 0;
            self.reactions.fill([true; 6]);
            self.loads.fill(true);
            self.drives.fill(true);
            self.distances = match &mut self.proximity {
                Some(proximity) => {
                    proximity.measure(solver.mechanism(), solver.parameters(), solver.bodies())
                }
                None => Distances::of_square(&solver.balance(), &self.joint_types),
            };
            return;
        }
        let spins = solver.constraints().spins().len();
        let statics: Statics = solver.statics();
        self.redundancy = statics.redundancy();
        self.reactions = statics.determined_reactions();
        self.loads = solver.determined_loads(&statics);
        self.drives = statics.determined_drives();
        self.distances = Distances::new(&statics, self.mobility, spins);
        self.is_singular = self.distances.actuation < SINGULAR;
        if self.is_singular && !self.told {
            self.singular = singular(solver, &statics, time);
            self.told = self.singular.is_some();
        }
    }
}

/// Whether the balance leaves nothing open: no redundancy, and no body that spins idly.
pub(super) fn is_determined(solver: &InverseDynamics) -> bool {
    let has_spins = !solver.constraints().spins().is_empty();
    solver.weighting() == Some(Weighting::Determined) && !has_spins
}

/// What a singular position is like.
fn singular(solver: &InverseDynamics, statics: &Statics, time: f64) -> Option<Singular> {
    let told = statics.weakest_motion(&solver.idle_axes())?;
    let mechanism = solver.mechanism();
    let (body, motion) = told.in_words(mechanism, solver.parameters().origin);
    let load = told.load_in_words(mechanism.characteristic_length());
    let null_directions = statics.null_directions();
    Some(Singular { samples: 1, time, body, motion, load, null_directions })
}
