//! Uniqueness and singularity indices at a sample.

use stiction_core::dynamics::{InverseDynamics, Weighting};
use stiction_core::statics::{Distances, NullDirection, SingularityDistances, Statics};

/// Singularity index below which a pose counts as singular: the index is exactly zero, or too small
/// for a normalised number.
pub(crate) const SINGULAR: f64 = f64::MIN_POSITIVE;

/// Uniqueness and singularity of the solution at one sample, with buffers that the next sample
/// reuses.
#[derive(Clone, Debug)]
pub(super) struct Uniqueness {
    /// Mobility for which the mechanism is designed, including local rotations.
    mobility: usize,
    /// Fast calculator of the singularity indices; `None` if the number of statics equations
    /// differs from the number of unknowns.
    pub(super) proximity: Option<SingularityDistances>,
    /// Singularity indices of the sample; NaN if their computation is postponed.
    pub(super) distances: Distances,
    pub(super) redundancy: usize,
    pub(super) reactions: Vec<[bool; 6]>,
    pub(super) gearings: Vec<bool>,
    pub(super) loads: Vec<bool>,
    pub(super) drives: Vec<bool>,
    /// True if the pose is singular although the mechanism carries the load.
    pub(super) is_singular: bool,
    /// Details of the singular pose, set only at the first sample with a singular pose.
    pub(super) singular: Option<Singular>,
    reported: bool,
}

/// Singular poses with finite forces. At a singular pose, the mechanism gains a motion with locked
/// actuators. The forces are finite because the load does no work on this motion, but the forces
/// are not unique.
#[derive(Clone, Debug, PartialEq)]
pub struct Singular {
    /// Number of samples at singular poses with finite forces.
    pub samples: usize,
    /// Time of the first sample at a singular pose with finite forces, s.
    pub time: f64,
    /// Name of a body that can move at the singular pose at `time`, although all actuators are
    /// locked.
    pub body: String,
    /// Motion of this body, in words.
    pub motion: String,
    /// Load that the mechanism could not carry in the singular pose at `time`, in words.
    pub load: String,
    /// Self-stresses that can be added to the forces in the singular pose at `time`.
    pub null_directions: Vec<NullDirection>,
}

impl Uniqueness {
    /// Creates the buffers before the first sample; `mobility` is the mobility for which the
    /// mechanism is designed.
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

    /// Examines the present pose. If `postpones` is true and only the singularity indices remain to
    /// be computed, returns bounds on the changes of these indices instead of computing the
    /// indices, see [`SingularityDistances::travel`].
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

/// Returns true if all forces are statically determinate: the mechanism has no redundancy, and no
/// body has a local rotation.
pub(super) fn is_determined(solver: &InverseDynamics) -> bool {
    let has_spins = !solver.constraints().spins().is_empty();
    solver.weighting() == Some(Weighting::Determined) && !has_spins
}

/// Describes the singular pose of the solver at `time`, s; `None` if no body can move.
fn singular(solver: &InverseDynamics, statics: &Statics, time: f64) -> Option<Singular> {
    let reported = statics.weakest_motion(&solver.idle_axes())?;
    let mechanism = solver.mechanism();
    let (body, motion) = reported.in_words(mechanism, solver.parameters().origin);
    let load = reported.load_in_words(mechanism.characteristic_length());
    let null_directions = statics.null_directions();
    Some(Singular { samples: 1, time, body, motion, load, null_directions })
}
