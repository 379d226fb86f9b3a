//! Keeping loops closed and held freedoms in place, at position and velocity level.

use super::Forward;
use super::balance::DEPENDENT;
use super::error::ForwardError;
use super::inputs::joint_coordinate;
use super::rows::{Held, Rows};
use crate::joint::Motion;
use crate::kinematics::{Bodies, State, Target};
use crate::linalg::RowSpace;
use crate::spatial::{Pose, Quaternion, Twist};
use crate::topology::{Link, Role};

/// Loops count as closed below this (rad, or m over the characteristic length).
const CLOSED: f64 = 1e-14;
/// Beyond this they are not.
const OPEN: f64 = 1e-9;
const STEPS: usize = 10;

/// A freedom held by friction, and where.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    pub(super) joint: usize,
    pub(super) freedom: usize,
    /// `X_JK` where it was when it began to stick.
    pub(super) pose: Pose<f64>,
}

impl Forward {
    /// The rows of all held freedoms and loops at a state, and the errors of position.
    fn closure(
        &self,
        state: &State<f64>,
        held: &[Held],
        errors_of_held: impl Fn(&Bodies<f64>, usize) -> f64,
    ) -> (Bodies<f64>, Rows, Vec<f64>) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        let rows = Rows::new(topology, parameters, &bodies, held);
        let mut errors = Vec::with_capacity(rows.rows.len());
        for cut in &topology.cuts {
            let (j, k) = (bodies.frame_j[cut.joint], bodies.frame_k[cut.joint]);
            let joint_type = topology.joint_types[cut.joint];
            let (misfit, _) = joint_type.misfit(j.inverse() * k, parameters.pitch[cut.joint]);
            errors.extend(&misfit[..joint_type.constraints().len()]);
        }
        errors.extend((0..held.len()).map(|index| errors_of_held(&bodies, index)));
        (bodies, rows, errors)
    }

    fn space(&self, rows: &Rows) -> RowSpace {
        let n = self.topology.freedoms();
        let mut scaled = rows.matrix.clone();
        for (row, entries) in rows.rows.iter().zip(scaled.chunks_exact_mut(n.max(1))) {
            entries.iter_mut().zip(&self.columns).for_each(|(e, c)| *e *= row.scale * c);
        }
        let mut space = RowSpace::default();
        space.decompose(&scaled, rows.rows.len(), n, DEPENDENT);
        space
    }

    fn shortest(&self, rows: &Rows, space: &RowSpace, values: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> = values.iter().zip(&rows.rows).map(|(v, r)| v * r.scale).collect();
        let mut step = space.shortest(&scaled);
        step.iter_mut().zip(&self.columns).for_each(|(s, c)| *s *= c);
        step
    }

    /// Moves a state to where loops are closed and held freedoms are in place, and takes from its rates
    /// what opens them. `frozen` freedoms of the tree keep their coordinates and have no rates.
    pub(super) fn project(
        &self,
        time: f64,
        state: &mut State<f64>,
        targets: &[Target<f64>],
        anchors: &[Anchor],
        frozen: &[bool],
    ) -> Result<(), ForwardError> {
        self.normalise(state);
        let (mut held, _) = self.held(targets, &[], &[], &[]);
        let anchored =
            anchors.iter().filter(|a| matches!(self.topology.role[a.joint], Role::Cut { .. }));
        let anchored: Vec<&Anchor> = anchored.collect();
        held.extend(anchored.iter().map(|a| Held {
            joint: a.joint,
            freedom: a.freedom,
            acceleration: 0.0,
            drives: false,
            grip: 1.0,
            share: 0.0,
        }));
        let error_of =
            |state: &State<f64>, bodies: &Bodies<f64>, index: usize| match targets.get(index) {
                Some(target) => {
                    let Held { joint, freedom, .. } = held[index];
                    let (topology, role) = (&self.topology, self.topology.role[joint]);
                    let pitch = &self.parameters.pitch;
                    let at = (joint, freedom);
                    let found = joint_coordinate((topology, pitch), state, bodies, at);
                    let turns = topology.joint_types[joint].freedoms()[freedom].motion
                        == Motion::Rotation
                        && matches!(role, Role::Cut { .. });
                    let apart = found - target.value;
                    if turns { apart.sin().atan2(apart.cos()) } else { apart }
                }
                None => self.displacement(bodies, anchored[index - targets.len()]),
            };
        let n = self.topology.freedoms();
        let mut best = f64::INFINITY;
        for step in 0..=STEPS {
            let now = state.clone();
            let (bodies, mut rows, errors) =
                self.closure(&now, &held, |bodies, index| error_of(&now, bodies, index));
            self.freeze(&mut rows, frozen);
            let sizes = errors.iter().zip(&rows.rows).map(|(e, row)| (e * row.scale).abs());
            let (mut worst, mut at) = (0.0, 0);
            for (row, size) in sizes.enumerate() {
                if size > worst || size.is_nan() {
                    (worst, at) = (size, row);
                }
            }
            let round_off = state.coordinates.iter().fold(0.0_f64, |m, q| m.max(q.abs()));
            let closed = worst <= CLOSED.max(4.0 * f64::EPSILON * round_off);
            if closed
                || step == STEPS
                || (worst < 1e-12 && worst > 0.5 * best)
                || !worst.is_finite()
            {
                if worst >= OPEN || worst.is_nan() {
                    let joint = self.joint_name(rows.rows[at].joint);
                    return Err(ForwardError::Open { time, joint, gap: errors[at].abs() });
                }
                let space = self.space(&rows);
                self.project_rates(&rows, &space, state, targets, frozen);
                let _ = bodies;
                return Ok(());
            }
            best = worst;
            let space = self.space(&rows);
            let mut step = self.shortest(&rows, &space, &errors);
            step.iter_mut().for_each(|s| *s = -*s);
            for (step, frozen) in step.iter_mut().zip(frozen) {
                if *frozen {
                    *step = 0.0;
                }
            }
            debug_assert!(step.len() == n);
            state.advance(&self.topology, &step);
        }
        Ok(())
    }

    fn freeze(&self, rows: &mut Rows, frozen: &[bool]) {
        let n = self.topology.freedoms();
        for entries in rows.matrix.chunks_exact_mut(n.max(1)) {
            for (entry, frozen) in entries.iter_mut().zip(frozen) {
                if *frozen {
                    *entry = 0.0;
                }
            }
        }
    }

    fn project_rates(
        &self,
        rows: &Rows,
        space: &RowSpace,
        state: &mut State<f64>,
        targets: &[Target<f64>],
        frozen: &[bool],
    ) {
        let n = self.topology.freedoms();
        for (rate, frozen) in state.rates.iter_mut().zip(frozen) {
            if *frozen {
                *rate = 0.0;
            }
        }
        let first = self.topology.constraints;
        let mut values: Vec<f64> = rows
            .matrix
            .chunks_exact(n.max(1))
            .map(|row| -row.iter().zip(&state.rates).map(|(a, b)| a * b).sum::<f64>())
            .collect();
        for (value, target) in values[first..].iter_mut().zip(targets) {
            *value += target.rate;
        }
        let step = self.shortest(rows, space, &values);
        for ((rate, step), frozen) in state.rates.iter_mut().zip(&step).zip(frozen) {
            if !frozen {
                *rate += step;
            }
        }
    }

    /// How far a held freedom of a joint that closes a loop is from where it was.
    fn displacement(&self, bodies: &Bodies<f64>, anchor: &Anchor) -> f64 {
        let (j, k) = (bodies.frame_j[anchor.joint], bodies.frame_k[anchor.joint]);
        let relative = j.inverse() * k;
        let turn = relative.rotation * anchor.pose.rotation.transpose();
        let angular = j.rotation * turn.rotation_vector();
        let at_j = j.rotation * (relative.position - turn * anchor.pose.position);
        let twist = Twist { angular, linear: at_j - angular.cross(j.position) };
        let freedom = &self.topology.joint_types[anchor.joint].freedoms()[anchor.freedom];
        twist.power(bodies.effort(freedom, anchor.joint))
    }

    /// Quaternions of length one.
    fn normalise(&self, state: &mut State<f64>) {
        for node in &self.topology.nodes {
            let q = &mut state.coordinates[node.coordinates.clone()];
            if let Some(at) = quaternion_at(&self.topology, &node.link) {
                let unit = Quaternion::from_coordinates(&q[at..]).normalised();
                unit.write(&mut q[at..]);
            }
        }
    }

    /// The time derivative of the tree's coordinates.
    pub(super) fn coordinate_rates(&self, coordinates: &[f64], rates: &[f64], out: &mut [f64]) {
        use crate::spatial::Vec3;
        for node in &self.topology.nodes {
            let q = &coordinates[node.coordinates.clone()];
            let v = &rates[node.dofs.clone()];
            let out = &mut out[node.coordinates.clone()];
            let Some(at) = quaternion_at(&self.topology, &node.link) else {
                out.copy_from_slice(v);
                continue;
            };
            let omega = Vec3::new(v[at], v[at + 1], v[at + 2]);
            let pure = Quaternion { w: 0.0, v: omega * 0.5 };
            let now = Quaternion::from_coordinates(&q[at..]);
            // A floating body's angular velocity is in world axes, a joint's in the successor's.
            let change = match node.link {
                Link::Floating => pure.compose(now),
                Link::Joint { .. } => now.compose(pure),
            };
            change.write(&mut out[at..]);
            if at == 3 {
                let linear = Vec3::new(v[0], v[1], v[2]);
                let linear = match node.link {
                    Link::Floating => linear + omega.cross(Vec3::new(q[0], q[1], q[2])),
                    Link::Joint { .. } => linear,
                };
                out[..3].copy_from_slice(&linear.to_array());
            }
        }
    }
}

/// Where a quaternion begins among a node's coordinates.
fn quaternion_at(topology: &crate::topology::Topology, link: &Link) -> Option<usize> {
    use crate::joint::JointType;
    match *link {
        Link::Floating => Some(3),
        Link::Joint { joint, .. } => match topology.joint_types[joint] {
            JointType::Spherical => Some(0),
            JointType::Free => Some(3),
            _ => None,
        },
    }
}
