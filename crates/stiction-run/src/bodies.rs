//! Rows of `bodies.csv`: pose, velocity, acceleration and external load of each moving body, in world axes. Velocities,
//! accelerations and moments refer to the origin of the body's frame.

use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::Forward;
use stiction_core::kinematics::Bodies;
use stiction_core::mechanism::{BodyId, Mechanism};
use stiction_core::spatial::{Pose, Quaternion, Vec3, Wrench};

/// Returns the poses of all bodies in the world, the ground first. `origin` is the position in the
/// world, m, of the reference point of `bodies`.
pub(crate) fn poses_in_world(
    bodies: &Bodies<f64>,
    origin: Vec3<f64>,
) -> impl Iterator<Item = Pose<f64>> {
    bodies.pose.iter().map(move |pose| Pose { position: pose.position + origin, ..*pose })
}

/// Returns the pose of each body except the ground, in the frame of the ground.
pub(crate) fn poses_from_ground(
    forward: &Forward,
    bodies: &Bodies<f64>,
) -> Vec<(BodyId, Pose<f64>)> {
    let mechanism = forward.mechanism();
    let (ground, origin) = (mechanism.base().inverse(), forward.parameters().origin);
    let poses = poses_in_world(bodies, origin).take(mechanism.bodies().len());
    poses.enumerate().skip(1).map(|(body, pose)| (BodyId(body), ground * pose)).collect()
}

/// Names of the columns that `bodies.csv` has for each body.
const COLUMNS: [&str; 25] = [
    "x [m]",
    "y [m]",
    "z [m]",
    "qw [-]",
    "qx [-]",
    "qy [-]",
    "qz [-]",
    "wx [rad/s]",
    "wy [rad/s]",
    "wz [rad/s]",
    "vx [m/s]",
    "vy [m/s]",
    "vz [m/s]",
    "alphax [rad/s^2]",
    "alphay [rad/s^2]",
    "alphaz [rad/s^2]",
    "ax [m/s^2]",
    "ay [m/s^2]",
    "az [m/s^2]",
    "fx [N]",
    "fy [N]",
    "fz [N]",
    "mx [N m]",
    "my [N m]",
    "mz [N m]",
];

/// Writer of the rows of `bodies.csv`, without the time column.
#[derive(Clone, Debug)]
pub(crate) struct BodyRow {
    /// Orientation of each moving body in the previous row. The quaternions `q` and `-q` represent
    /// the same orientation; the row contains the one closer to the previous row, so that the
    /// columns do not jump.
    last: Vec<Quaternion<f64>>,
    row: Vec<f64>,
}

impl BodyRow {
    /// Number of columns that `bodies.csv` has for each body.
    pub(crate) const WIDTH: usize = COLUMNS.len();

    /// Reads the pose of a body in the world from the columns of that body in `bodies.csv`.
    pub(crate) fn pose(columns: &[f64]) -> Pose<f64> {
        Pose {
            position: Vec3::new(columns[0], columns[1], columns[2]),
            rotation: Quaternion::from_coordinates(&columns[3..7]).rotation(),
        }
    }

    /// Returns six numbers for the external load on each moving body, in world axes: the force, N,
    /// then the moment about the origin of the body's frame, N m.
    pub(crate) fn loads(
        bodies: &Bodies<f64>,
        loads: &[AppliedLoad<f64>],
    ) -> impl Iterator<Item = f64> {
        let on = |body| load_on(bodies, body, loads).map(Vec3::to_array).concat();
        (1..bodies.pose.len()).flat_map(on)
    }

    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        // The first row is compared with the identity, so the real part of its quaternions is not
        // negative.
        let first = Quaternion::from_coordinates(&[1.0, 0.0, 0.0, 0.0]);
        Self { last: vec![first; mechanism.bodies().len() - 1], row: Vec::new() }
    }

    /// Sets the previous orientations from `row`, which is the last row of an interrupted run, but
    /// without the time column. The quaternions of the resumed run then keep their signs.
    pub(crate) fn follow(&mut self, row: &[f64]) {
        for (last, numbers) in self.last.iter_mut().zip(row.chunks_exact(COLUMNS.len())) {
            *last = Quaternion::from_coordinates(&numbers[3..7]);
        }
    }

    /// Returns the names of all columns of `bodies.csv` except time.
    pub(crate) fn header(mechanism: &Mechanism) -> impl Iterator<Item = String> + '_ {
        let bodies = &mechanism.bodies()[1..];
        bodies.iter().flat_map(|body| COLUMNS.map(|column| format!("{}.{column}", body.name)))
    }

    /// Computes the row for one instant from the motions of the bodies and the external loads on
    /// them. `origin` is the position in the world, m, of the reference point of `bodies`.
    pub(crate) fn of(
        &mut self,
        bodies: &Bodies<f64>,
        origin: Vec3<f64>,
        loads: &[AppliedLoad<f64>],
    ) -> &[f64] {
        let Self { last, row } = self;
        row.clear();
        for (body, last) in (1..bodies.pose.len()).zip(last) {
            let (pose, twist) = (bodies.pose[body], bodies.twist[body]);
            let change = bodies.acceleration[body];
            let at = pose.position;
            let velocity = twist.velocity_at(at);
            // `change.velocity_at(at)` is the rate of change of the velocity at a fixed point in
            // space. The second term turns it into the acceleration of the body's point that passes
            // there.
            let acceleration = change.velocity_at(at) + twist.angular.cross(velocity);
            let load = load_on(bodies, body, loads);
            *last = nearer(Quaternion::from_rotation(pose.rotation), *last);
            let mut orientation = [0.0; 4];
            last.write(&mut orientation);
            let position = (at + origin).to_array();
            let motion = [twist.angular, velocity, change.angular, acceleration];
            let vectors = motion.into_iter().chain(load).flat_map(|vector| vector.to_array());
            row.extend(position.into_iter().chain(orientation).chain(vectors));
        }
        row
    }
}

/// Returns the sum of all external loads on a body: the force, N, and the moment about the origin
/// of the body's frame, N m.
fn load_on(bodies: &Bodies<f64>, body: usize, loads: &[AppliedLoad<f64>]) -> [Vec3<f64>; 2] {
    let mut load = Wrench::zero();
    for applied in loads.iter().filter(|load| load.body.0 == body) {
        load += applied.wrench(bodies);
    }
    [load.force, load.moment_about(bodies.pose[body].position)]
}

/// Returns `q` or `-q`, whichever is closer to `last`; both represent the same rotation.
fn nearer(q: Quaternion<f64>, last: Quaternion<f64>) -> Quaternion<f64> {
    let product = q.w * last.w + q.v.dot(last.v);
    if product < 0.0 { Quaternion { w: -q.w, v: -q.v } } else { q }
}
