//! Inputs of a program: motions of floating bodies, coordinates that have no closed form, tunable
//! parameters, prescribed values, and loads.

use crate::samples::Sample;
use crate::tunable::Tunable;
use core::ops::Range;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Settings};
use stiction_core::kinematics::{Legs, State, Target};
use stiction_core::mechanism::{BodyId, Mechanism};
use stiction_core::parameters::Parameters;
use stiction_core::scalar::{Dual, Scalar};
use stiction_core::spatial::{Mat3, Pose, Quaternion, Vec3};
use stiction_core::topology::Topology;

/// Motion of a body frame and its origin, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMotion<T> {
    /// Position of the origin, m.
    pub position: Vec3<T>,
    /// Orientation of the body: unit quaternion of the rotation from body axes to world axes.
    pub orientation: Quaternion<T>,
    /// Velocity of the origin, m/s.
    pub velocity: Vec3<T>,
    /// Angular velocity, rad/s.
    pub angular_velocity: Vec3<T>,
    /// Acceleration of the origin, m/s^2.
    pub acceleration: Vec3<T>,
    /// Angular acceleration, rad/s^2.
    pub angular_acceleration: Vec3<T>,
}

/// Inputs of one state in a batch.
#[derive(Clone, Copy, Debug)]
pub struct StateOfMotion<'a> {
    /// Motions of [`crate::InverseProgram::bodies`], in the order of these bodies.
    pub bodies: &'a [BodyMotion<f64>],
    /// Coordinates of the tree. The program reads only those in
    /// [`crate::InverseProgram::coordinates`]; the slice may be empty if it reads none.
    pub coordinates: &'a [f64],
    /// Values, rates and accelerations of the prescribed coordinates. At states where the program
    /// is invalid and the solver replaces it, only they determine the motion.
    pub targets: &'a [Target<f64>],
    /// Loads with the bodies, points and axes of the recording.
    pub loads: &'a [AppliedLoad<f64>],
}

/// Number of components of a [`BodyMotion`].
const MOTION: usize = 19;

impl<T: Scalar> BodyMotion<T> {
    fn to_array(self) -> [T; MOTION] {
        let Self { position: p, orientation: Quaternion { w, v: q }, velocity: v, .. } = self;
        let (u, a, b) = (self.angular_velocity, self.acceleration, self.angular_acceleration);
        [
            p.x, p.y, p.z, w, q.x, q.y, q.z, v.x, v.y, v.z, u.x, u.y, u.z, a.x, a.y, a.z, b.x, b.y,
            b.z,
        ]
    }

    fn read(next: &mut impl FnMut() -> T) -> Self {
        let position = vector(next);
        let w = next();
        Self {
            position,
            orientation: Quaternion { w, v: vector(next) },
            velocity: vector(next),
            angular_velocity: vector(next),
            acceleration: vector(next),
            angular_acceleration: vector(next),
        }
    }
}

fn vector<T>(next: &mut impl FnMut() -> T) -> Vec3<T> {
    let [x, y, z] = [next(), next(), next()];
    Vec3 { x, y, z }
}

pub(crate) fn load_to_array(
    AppliedLoad { force: f, moment: m, .. }: &AppliedLoad<f64>,
) -> [f64; 6] {
    [f.x, f.y, f.z, m.x, m.y, m.z]
}

pub(crate) fn target_to_array(target: &Target<f64>) -> [f64; 3] {
    [target.value, target.rate, target.acceleration]
}

/// Writes the `N` numbers of each lane to the next `N` slots.
#[inline]
fn write_rows<'a, const N: usize, const L: usize>(
    slots: &mut impl Iterator<Item = &'a mut [f64; L]>,
    rows: [[f64; N]; L],
) {
    for (k, slot) in (0..N).zip(slots) {
        *slot = core::array::from_fn(|lane| rows[lane][k]);
    }
}

/// Layout of a program's inputs. The inputs are, in this order: motions of the floating bodies,
/// tree coordinates without a closed form, tunable parameters, loads, prescribed values.
#[derive(Clone, Debug)]
pub(crate) struct InputLayout {
    topology: Topology,
    origin: Vec3<f64>,
    legs: Legs,
    /// `true` if the motions of the floating bodies are inputs; `false` if all coordinates of the
    /// tree are inputs instead.
    by_motions: bool,
    /// Indices of the tree coordinates that are inputs: those that neither belong to a floating
    /// body nor have a closed form.
    free: Vec<usize>,
    tunables: Vec<Tunable>,
    count: usize,
    /// Number of inputs that are prescribed values; they come last.
    prescribed: usize,
}

impl InputLayout {
    /// Determines a layout with motions of bodies as inputs. `positions` are tree coordinates at
    /// positions within the intended range of motion, and `loads` is the number of external loads.
    pub(crate) fn new(solver: &InverseDynamics, positions: &[Vec<f64>], loads: usize) -> Self {
        let (topology, parameters) = (solver.topology().clone(), solver.parameters());
        let legs = Legs::new(&topology, parameters, positions);
        let floats = |place: &usize| topology.floating().any(|(_, own, _)| own.contains(place));
        let is_free = |place: &usize| !floats(place) && !legs.finds(*place);
        let free: Vec<usize> = (0..topology.coordinates()).filter(is_free).collect();
        let targets = solver.constraints().coordinates().len();
        let motions = MOTION * topology.floating().count();
        let count = motions + free.len() + 3 * targets + 6 * loads;
        let (origin, tunables) = (parameters.origin, Vec::new());
        let prescribed = 3 * targets;
        Self { origin, topology, legs, by_motions: true, free, tunables, count, prescribed }
    }

    /// Creates a layout in which all coordinates of the tree and the tunable parameters are inputs,
    /// instead of motions of bodies. Tunable loads must be the last tunable parameters.
    pub(crate) fn of_tree(solver: &InverseDynamics, tunables: &[Tunable]) -> Self {
        let topology = solver.topology().clone();
        let free: Vec<usize> = (0..topology.coordinates()).collect();
        debug_assert!(tunables.is_sorted_by_key(|tunable| tunable.load().is_some()));
        let prescribed = 3 * solver.constraints().coordinates().len();
        let widths: usize = tunables.iter().map(|tunable| tunable.width()).sum();
        Self {
            origin: solver.parameters().origin,
            topology,
            legs: Legs::default(),
            by_motions: false,
            count: free.len() + widths + prescribed,
            free,
            tunables: tunables.to_vec(),
            prescribed,
        }
    }

    /// Floating bodies whose motions are inputs, with the ranges of their coordinates and DOFs.
    fn floating(&self) -> impl Iterator<Item = (BodyId, Range<usize>, Range<usize>)> + '_ {
        self.topology.floating().filter(|_| self.by_motions)
    }

    /// Adapts the solver settings to this layout. If coordinates of the tree are inputs, even the
    /// slowest rates count as motion, because they indicate the direction of incipient motion at
    /// rest.
    pub(crate) fn adapt(&self, settings: &mut Settings) {
        if !self.by_motions {
            settings.rest_speed = 0.0;
        }
    }

    /// Replaces the tunable parameters of the mechanism by inputs, which `next` returns one after
    /// the other.
    pub(crate) fn tune<T: Scalar>(
        &self,
        parameters: &mut Parameters<T>,
        next: &mut impl FnMut() -> T,
    ) {
        for tunable in self.tunables.iter().filter(|tunable| tunable.load().is_none()) {
            let numbers: Vec<T> = (0..tunable.width()).map(|_| next()).collect();
            tunable.apply(parameters, &numbers);
        }
    }

    /// Number of inputs.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Returns the index of the first prescribed value among the inputs.
    pub(crate) fn first_prescribed(&self) -> usize {
        self.count - self.prescribed
    }

    /// Bodies whose motions are inputs.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = BodyId> + '_ {
        self.floating().map(|(body, ..)| body)
    }

    /// Indices of the tree coordinates that are inputs.
    pub(crate) fn free(&self) -> &[usize] {
        &self.free
    }

    /// Calls `write` with the values of the inputs, in the order of the inputs: motions of the
    /// floating bodies, those coordinates of the tree that are inputs, loads, and prescribed
    /// values.
    #[inline]
    pub(crate) fn visit(
        &self,
        motions: impl IntoIterator<Item = BodyMotion<f64>>,
        coordinates: &[f64],
        targets: &[Target<f64>],
        loads: &[AppliedLoad<f64>],
        mut write: impl FnMut(&[f64]),
    ) {
        for motion in motions {
            write(&motion.to_array());
        }
        for place in &self.free {
            // A missing coordinate is NaN, so that no guard holds.
            write(&[coordinates.get(*place).copied().unwrap_or(f64::NAN)]);
        }
        for load in loads {
            write(&load_to_array(load));
        }
        for target in targets {
            write(&target_to_array(target));
        }
    }

    /// Writes the inputs of one state for each lane; corresponding inputs of all lanes are
    /// adjacent. Writing one state after the other would multiply the number of memory accesses by
    /// the number of lanes.
    #[inline]
    pub(crate) fn write_lanes<const L: usize>(
        &self,
        states: [&StateOfMotion<'_>; L],
        reads_targets: bool,
        slots: &mut [[f64; L]],
    ) {
        let mut slots = slots.iter_mut();
        for body in 0..self.floating().count() {
            write_rows(&mut slots, states.map(|state| state.bodies[body].to_array()));
        }
        for place in &self.free {
            // A missing coordinate is NaN, so that no guard holds.
            let coordinate = |state: &StateOfMotion<'_>| state.coordinates.get(*place).copied();
            write_rows(&mut slots, states.map(|state| [coordinate(state).unwrap_or(f64::NAN)]));
        }
        for load in 0..states[0].loads.len() {
            write_rows(&mut slots, states.map(|state| load_to_array(&state.loads[load])));
        }
        for target in 0..if reads_targets { states[0].targets.len() } else { 0 } {
            write_rows(&mut slots, states.map(|state| target_to_array(&state.targets[target])));
        }
    }

    /// Returns the values of all inputs of the program at a sample, in the order of the inputs.
    pub(crate) fn row(&self, Sample { state, targets, loads, .. }: &Sample) -> Vec<f64> {
        let mut row = Vec::with_capacity(self.count);
        self.visit(self.motions(state), &state.coordinates, targets, loads, |x| row.extend(x));
        row
    }

    /// Computes the motions of the floating bodies from a state of the tree.
    pub(crate) fn motions<'a>(
        &'a self,
        state: &'a State<f64>,
    ) -> impl Iterator<Item = BodyMotion<f64>> + 'a {
        let part = |numbers: &[f64], start: usize| {
            Vec3::new(numbers[start], numbers[start + 1], numbers[start + 2])
        };
        self.floating().map(move |(_, coordinates, dofs)| {
            let q = &state.coordinates[coordinates];
            let from_origin = part(q, 0);
            let (v, w) = (&state.rates, dofs.start);
            let [velocity, turning] = [part(v, w), part(v, w + 3)];
            let a = &state.accelerations;
            let [acceleration, change] = [part(a, w), part(a, w + 3)];
            let velocity = velocity + turning.cross(from_origin);
            BodyMotion {
                position: from_origin + self.origin,
                orientation: Quaternion::from_coordinates(&q[3..]),
                velocity,
                angular_velocity: turning,
                acceleration: acceleration + change.cross(from_origin) + turning.cross(velocity),
                angular_acceleration: change,
            }
        })
    }

    /// Reads motions of the floating bodies and coordinates, which `next` returns one after the
    /// other, and sets the state of the tree: all coordinates, and those rates and accelerations
    /// that follow from the motions.
    pub(crate) fn read<T: Scalar>(
        &self,
        mechanism: &Mechanism,
        state: &mut State<T>,
        next: &mut impl FnMut() -> T,
    ) {
        let mut poses = Vec::new();
        for (body, coordinates, dofs) in self.floating() {
            let motion = BodyMotion::read(next);
            let position = motion.position - self.origin.lift();
            let q = &mut state.coordinates[coordinates];
            q[..3].copy_from_slice(&position.to_array());
            motion.orientation.write(&mut q[3..]);
            let (turning, change) = (motion.angular_velocity, motion.angular_acceleration);
            let linear = motion.velocity - turning.cross(position);
            let second =
                motion.acceleration - change.cross(position) - turning.cross(motion.velocity);
            let write = |numbers: &mut [T], linear: Vec3<T>, angular: Vec3<T>| {
                let numbers = &mut numbers[dofs.clone()];
                numbers[..3].copy_from_slice(&linear.to_array());
                numbers[3..].copy_from_slice(&angular.to_array());
            };
            write(&mut state.rates, linear, turning);
            write(&mut state.accelerations, second, change);
            poses.push((body, pose_in_time(&motion, position)));
        }
        for place in &self.free {
            state.coordinates[*place] = next();
        }
        let parameters = Parameters::<InTime<T>>::new(mechanism);
        let pose = |body| {
            let known = poses.iter().find(|(floating, _)| *floating == body);
            known.map_or_else(Pose::identity, |(_, pose)| *pose)
        };
        self.legs.find(&self.topology, &parameters, pose, |place, found| {
            state.coordinates[place] = found.value.value;
            if let Some(dof) = self.legs.dof(&self.topology, place) {
                state.rates[dof] = found.value.slope[0];
                state.accelerations[dof] = found.slope[0].slope[0];
            }
        });
    }
}

/// Dual number for a function of time with its first two derivatives.
type InTime<T> = Dual<Dual<T, 1>, 1>;

fn in_time<T: Scalar>(value: T, rate: T, acceleration: T) -> InTime<T> {
    Dual {
        value: Dual { value, slope: [rate] },
        slope: [Dual { value: rate, slope: [acceleration] }],
    }
}

/// Pose of a moving body as a function of time, with its first two derivatives at the present time.
/// `position` is the present position of the body's origin.
fn pose_in_time<T: Scalar>(motion: &BodyMotion<T>, position: Vec3<T>) -> Pose<InTime<T>> {
    let join = |value: Vec3<T>, rate: Vec3<T>, second: Vec3<T>| {
        let part =
            |axis| in_time(value.component(axis), rate.component(axis), second.component(axis));
        Vec3::new(part(0), part(1), part(2))
    };
    let column = |axis: usize| {
        let value = motion.orientation.rotation().columns[axis];
        let rate = motion.angular_velocity.cross(value);
        let second = motion.angular_acceleration.cross(value) + motion.angular_velocity.cross(rate);
        join(value, rate, second)
    };
    Pose {
        rotation: Mat3::from_columns(column(0), column(1), column(2)),
        position: join(position, motion.velocity, motion.acceleration),
    }
}
