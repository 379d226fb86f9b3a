//! Uniqueness and singularity indices at a sample.

use stiction_core::dynamics::{InverseDynamics, Weighting};
use stiction_core::statics::{Distances, NullDirection, SingularityDistances, Statics};

/// Index below which a pose counts as singular and the index as zero.
pub(crate) const SINGULAR: f64 = f64::MIN_POSITIVE;

/// Verdicts at one sample, with buffers for the next.
#[derive(Clone, Debug)]
pub(super) struct Uniqueness {
    /// Mobility intended by the design, local rotations included.
    mobility: usize,
    /// Calculator of the indices; `None` unless statics has as many unknowns as equations.
    pub(super) proximity: Option<SingularityDistances>,
    /// NaN if they are postponed.
    pub(super) distances: Distances,
    pub(super) redundancy: usize,
    pub(super) reactions: Vec<[bool; 6]>,
    pub(super) gearings: Vec<bool>,
    pub(super) loads: Vec<bool>,
    pub(super) drives: Vec<bool>,
    /// True if the pose is singular although the load is carried.
    pub(super) is_singular: bool,
    /// Details of the first singular pose.
    pub(super) singular: Option<Singular>,
    reported: bool,
}

/// Singular poses with finite forces: the load happens to be carried, and the solution is not
/// unique.
#[derive(Clone, Debug, PartialEq)]
pub struct Singular {
    /// Number of such samples.
    pub samples: usize,
    /// Time of the first, s.
    pub time: f64,
    /// Body that can move at that pose with all actuators locked.
    pub body: String,
    /// Motion of the body in words.
    pub motion: String,
    /// Load that could not be carried at that pose.
    pub load: String,
    /// Self-stresses that may be added to the forces at that pose.
    pub null_directions: Vec<NullDirection>,
}

impl Uniqueness {
    /// Creates a unique result with empty buffers.
    pub(super) fn new(solver: &InverseDynamics, mobility: usize) -> Self {
        let mechanism = solver.mechanism();
        Self {
            mobility,
            proximity: SingularityDistances::new(mechanism),
            distances: Distances { actuation: 1.0, constraint: 1.0 },
            redundancy: 0,
            reactions: vec![[true; 6]; mechanism.joints().len()],
            gearings: vec![true; mechanism.gearings().len()],
            loads: vec![true; solver.parameters().interfaces.len()],
            drives: vec![true; mechanism.actuators().count()],
            is_singular: false,
            singular: None,
            reported: false,
        }
    }

    /// Examines the current pose. If `postpones` and only the indices must be computed, returns bounds
    /// on their changes instead, see [`SingularityDistances::travel`].
    pub(super) fn observe(
        &mut self,
        solver: &InverseDynamics,
        time: f64,
        postpones: bool,
    ) -> Option<Distances> {
        (self.is_singular, self.singular) = (false, None);
        if is_determined(solver)
            && let Some(proximity) = &mut self.proximity
        {
            // Only the singularity indices must be computed.
            self.redundancy = 0;
            self.reactions.fill([true; 6]);
            self.gearings.fill(true);
            self.loads.fill(true);
            self.drives.fill(true);
            if postpones {
                self.distances = Distances { actuation: f64::NAN, constraint: f64::NAN };
                return Some(proximity.travel(solver.parameters(), solver.bodies()));
            }
            self.distances =
                proximity.measure(solver.mechanism(), solver.parameters(), solver.bodies());
            return None;
        }
        let spins = solver.constraints().spins().len();
        let statics: Statics = solver.statics();
        self.redundancy = statics.redundancy();
        self.reactions = statics.determined_reactions();
        self.gearings = statics.determined_gearings();
        self.loads = solver.determined_loads(&statics);
        self.drives = statics.determined_drives();
        self.distances = Distances::new(&statics, self.mobility, spins);
        self.is_singular = self.distances.actuation < SINGULAR;
        if self.is_singular && !self.reported {
            self.singular = singular(solver, &statics, time);
            self.reported = self.singular.is_some();
        }
        None
    }
}

/// True if statics determines all forces: no redundancy and no local rotation of a body.
pub(super) fn is_determined(solver: &InverseDynamics) -> bool {
    let has_spins = !solver.constraints().spins().is_empty();
    solver.weighting() == Some(Weighting::Determined) && !has_spins
}

/// Describes a singular pose.
fn singular(solver: &InverseDynamics, statics: &Statics, time: f64) -> Option<Singular> {
    let reported = statics.weakest_motion(&solver.idle_axes())?;
    let mechanism = solver.mechanism();
    let (body, motion) = reported.in_words(mechanism, solver.parameters().origin);
    let load = reported.load_in_words(mechanism.characteristic_length());
    let null_directions = statics.null_directions();
    Some(Singular { samples: 1, time, body, motion, load, null_directions })
}
