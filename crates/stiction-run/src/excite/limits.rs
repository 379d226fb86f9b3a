//! Limits of a designed motion: travel, speed, acceleration and effort of coordinates, joints and
//! motors, and the distance to singular positions.

use super::coordinates::{Chosen, dof_value};
use super::limit_settings::{add_setting, unknown};
use super::{ExciteError, ExciteSettings};
use crate::names::listed;
use crate::ranges::Measured;
use std::f64::consts::TAU;
use stiction_core::kinematics::{Bodies, Coordinate};
use stiction_core::mechanism::{JointId, Mechanism, MotorMap, RangeOf};
use stiction_core::parameters::Parameters;
use stiction_core::topology::Topology;

/// Moving quantity: a coordinate of the designed motion, or a degree of freedom of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Moving {
    Coordinate(usize),
    Dof(JointId, usize),
}

/// Quantity that a limit bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Of {
    /// Position relative to the middle of its range. The number is the middle of the range, rad or
    /// m.
    Travel(Moving, f64),
    Speed(Moving),
    Acceleration(Moving),
    /// Effort of the actuator with this index.
    Effort(usize),
    /// Tilt of a joint or length of a spring, relative to the middle of its range. The number is
    /// the middle of the range, rad or m.
    Measured(Measured, f64),
    /// Speed of the motor of the drive train with this index.
    MotorSpeed(usize),
    /// Torque of the motor of the drive train with this index, limited at every instant.
    MotorTorque(usize),
    /// Torque of the motor of the drive train with this index. The root mean square of the torque
    /// over a period is limited to the rated torque.
    MotorRated(usize),
    /// Singularity index of the actuation, for which the limit is the least allowed value.
    Singularity,
}

/// Limit on the magnitude of a quantity. `bound` is the largest allowed magnitude in the SI unit
/// `unit`.
#[derive(Clone, Debug)]
pub(super) struct Limit {
    pub(super) name: String,
    pub(super) unit: &'static str,
    pub(super) bound: f64,
    pub(super) of: Of,
}

/// Utilisation of a limit by a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Used {
    /// Name of the limited quantity, such as `leg1.P.speed`.
    pub name: String,
    /// Largest allowed magnitude of the quantity. For a range it is half the width of the range;
    /// for the singularity index it is the least allowed value.
    pub bound: f64,
    /// Unit of `bound`; empty for a singularity index.
    pub unit: &'static str,
    /// Largest magnitude of the quantity along the motion, as a fraction of the limit. The motion
    /// satisfies the limit if the fraction is at most one.
    pub part: f64,
}

/// All limits of a designed motion.
#[derive(Clone, Debug)]
pub(super) struct Limits {
    all: Vec<Limit>,
    motors: Vec<(usize, MotorMap)>,
    cases: usize,
}

/// Motion and efforts of the robot at one instant.
pub(super) struct Snapshot<'a> {
    pub(super) motion: [&'a [f64]; 3],
    pub(super) bodies: &'a Bodies<f64>,
    pub(super) topology: &'a Topology,
    pub(super) parameters: &'a Parameters<f64>,
    /// Efforts of all actuators, N or N m, for each payload.
    pub(super) efforts: &'a [Vec<f64>],
    /// Singularity index of actuation.
    pub(super) index: f64,
}

impl Limits {
    pub(super) fn new(
        mechanism: &Mechanism,
        chosen: &Chosen,
        settings: &ExciteSettings,
        cases: usize,
    ) -> Result<Self, ExciteError> {
        let mut all = Vec::new();
        for setting in &settings.limits {
            let before = all.len();
            add_setting(mechanism, chosen, setting, &mut all)?;
            if all.len() == before {
                return Err(unknown(mechanism, chosen, setting));
            }
        }
        for (index, joint) in mechanism.joints().iter().enumerate() {
            for range in &joint.ranges {
                let RangeOf::Dof(dof) = range.of else { continue };
                let unit = if joint.range_translates(range.of) { "m" } else { "rad" };
                let (low, high) = range.limits;
                let (joint_id, middle) = (JointId(index), 0.5 * (low + high));
                let own = Coordinate::Joint { joint: joint_id, dof };
                // Coordinates of the motion are not reduced to one turn, so the range is shifted by
                // full turns until it contains the first position.
                let of = match chosen.coordinates.iter().position(|known| *known == own) {
                    Some(k) => {
                        let turns = match chosen.is_angle[k] {
                            true => TAU * ((chosen.centre[k] - middle) / TAU).round(),
                            false => 0.0,
                        };
                        Of::Travel(Moving::Coordinate(k), middle + turns)
                    }
                    None => Of::Travel(Moving::Dof(joint_id, dof), middle),
                };
                let name = joint.range_name(range.of);
                all.push(Limit { name, unit, bound: 0.5 * (high - low), of });
            }
        }
        for (of, name, unit, (low, high)) in Measured::all(mechanism) {
            let of = Of::Measured(of, 0.5 * (low + high));
            all.push(Limit { name, unit, bound: 0.5 * (high - low), of });
        }
        for (index, train) in mechanism.drive_trains().iter().enumerate() {
            let limits = [
                ("motor_speed", "rad/s", train.limits.speed, Of::MotorSpeed(index)),
                ("motor_torque", "N m", train.limits.peak, Of::MotorTorque(index)),
                ("rms motor_torque", "N m", train.limits.rated, Of::MotorRated(index)),
            ];
            for (what, unit, bound, of) in limits {
                let Some(bound) = bound else { continue };
                all.push(Limit { name: format!("{}.{what}", train.name), unit, bound, of });
            }
        }
        let motors = mechanism.motor_maps().into_iter().enumerate().collect();
        let limits = Self { all, motors, cases };
        limits.refuse_unbounded(mechanism, chosen)?;
        Ok(limits)
    }

    /// Adds a limit on the singularity index. The least allowed index is `least`; if it is not
    /// positive, no limit is added.
    pub(super) fn keep_from_singular(&mut self, least: f64) {
        if least > 0.0 {
            let name = "singularity index".to_owned();
            self.all.push(Limit { name, unit: "", bound: least, of: Of::Singularity });
        }
    }

    /// Returns a copy of these limits for `cases` payloads.
    pub(super) fn with_payloads(&self, cases: usize) -> Self {
        Self { cases, ..self.clone() }
    }

    fn travel_of(&self, moving: Moving) -> impl Iterator<Item = (f64, f64)> {
        self.all.iter().filter_map(move |limit| match limit.of {
            Of::Travel(own, middle) if own == moving => Some((middle, limit.bound)),
            _ => None,
        })
    }

    /// Returns an error if a coordinate of the motion has no range. Without a range, the
    /// information would increase without bound with the amplitude.
    fn refuse_unbounded(&self, mechanism: &Mechanism, chosen: &Chosen) -> Result<(), ExciteError> {
        let bounded = |moving: Moving| self.travel_of(moving).next().is_some();
        let actuators = mechanism.actuators().all(|(joint, dof)| bounded(Moving::Dof(joint, dof)));
        let free: Vec<&String> = (0..chosen.names.len())
            .filter(|&k| {
                let own = match chosen.coordinates[k] {
                    Coordinate::Joint { joint, dof } => bounded(Moving::Dof(joint, dof)),
                    _ => actuators,
                };
                !own && !bounded(Moving::Coordinate(k))
            })
            .map(|k| &chosen.names[k])
            .collect();
        let Some(first) = free.first() else { return Ok(()) };
        let unit = if chosen.is_angle[chosen.names.iter().position(|n| n == *first).unwrap_or(0)] {
            "20 deg"
        } else {
            "50 mm"
        };
        Err(ExciteError::input(
            format!("the displacement of {} is not limited", listed(&free, 6)),
            format!(
                "give the greatest displacement, for example --limit \"{first} = {unit}\", or `range` of the \
                 joints in the model"
            ),
        ))
    }

    /// Returns the largest displacement of a coordinate from its first position, m or rad, that the
    /// ranges of this coordinate allow. The result is at most 1 rad for an angle, and at most
    /// `length` for a displacement in m.
    pub(super) fn reach(&self, chosen: &Chosen, index: usize, length: f64) -> f64 {
        let own = match chosen.coordinates[index] {
            Coordinate::Joint { joint, dof } => Some(Moving::Dof(joint, dof)),
            _ => None,
        };
        let all = self
            .travel_of(Moving::Coordinate(index))
            .chain(own.into_iter().flat_map(|moving| self.travel_of(moving)));
        let reach = all.map(|(middle, bound)| bound + (chosen.centre[index] - middle).abs());
        let usual = if chosen.is_angle[index] { 1.0 } else { length };
        reach.fold(usual, f64::min)
    }

    /// Writes the used fraction of each limit at an instant to `out`. Each fraction has the sign of
    /// the limited quantity. A limit on an effort or on a motor torque has one fraction for each
    /// payload.
    pub(super) fn parts(&self, mechanism: &Mechanism, at: &Snapshot<'_>, out: &mut Vec<f64>) {
        out.clear();
        let motors = self.motors_at(mechanism, at);
        for limit in &self.all {
            let over = 1.0 / limit.bound;
            match limit.of {
                Of::Travel(Moving::Coordinate(k), middle) => {
                    out.push((at.motion[0][k] - middle) * over);
                }
                Of::Travel(Moving::Dof(joint, dof), middle) => {
                    let value = dof_value(mechanism, at.bodies, joint, dof) - middle;
                    let turns =
                        match mechanism.joints()[joint.0].joint_type.dofs()[dof].translates() {
                            true => 0.0,
                            false => TAU * (value / TAU).round(),
                        };
                    out.push((value - turns) * over);
                }
                Of::Speed(moving) => out.push(rate(moving, at)[0] * over),
                Of::Acceleration(moving) => out.push(rate(moving, at)[1] * over),
                Of::Measured(of, middle) => out.push((of.value(at.bodies) - middle) * over),
                Of::Effort(k) => out.extend(at.efforts.iter().map(|efforts| efforts[k] * over)),
                Of::MotorSpeed(k) => out.push(motors[k].1 * over),
                Of::MotorTorque(k) | Of::MotorRated(k) => {
                    out.extend(motors[k].0.iter().map(|torque| torque * over));
                }
                Of::Singularity => out.push(limit.bound / at.index),
            }
        }
    }

    /// Returns, for every motor, its torque with each payload, N m, and its speed, rad/s.
    fn motors_at(&self, mechanism: &Mechanism, at: &Snapshot<'_>) -> Vec<(Vec<f64>, f64)> {
        let actuators: Vec<(JointId, usize)> = mechanism.actuators().collect();
        let motion = |actuator: usize| {
            let (joint, dof) = actuators[actuator];
            rate(Moving::Dof(joint, dof), at)
        };
        let each = self.motors.iter().map(|(train, map)| {
            let train = &mechanism.drive_trains()[*train];
            let speed = map.output(|actuator| motion(actuator)[0]);
            let acceleration = map.output(|actuator| motion(actuator)[1]);
            let carrier = train.acceleration_of_carrier(&at.bodies.pose, &at.bodies.acceleration);
            let torque = |efforts: &Vec<f64>| {
                let effort = map.effort(efforts);
                train.motor(effort, (effort, effort), Some(speed), acceleration, carrier).torque
            };
            (at.efforts.iter().map(torque).collect(), train.transmission() * speed)
        });
        each.collect()
    }

    /// Returns the layout of the used fractions that [`Self::parts`] writes. For each fraction it
    /// contains the index of the limit, and a flag that is true if only the root mean square of the
    /// fraction is limited.
    fn layout(&self) -> Vec<(usize, bool)> {
        let mut out = Vec::new();
        for (index, limit) in self.all.iter().enumerate() {
            let count = match limit.of {
                Of::Effort(_) | Of::MotorTorque(_) | Of::MotorRated(_) => self.cases,
                _ => 1,
            };
            out.extend(std::iter::repeat_n((index, matches!(limit.of, Of::MotorRated(_))), count));
        }
        out
    }

    /// Returns a flag for each used fraction that [`Self::parts`] writes. The flag is true if only
    /// the root mean square of the fraction is limited.
    pub(super) fn rated(&self) -> Vec<bool> {
        self.layout().into_iter().map(|(_, rated)| rated).collect()
    }

    /// Returns the utilisation of every limit. `greatest` contains the largest magnitude of each
    /// used fraction that [`Self::parts`] writes.
    pub(super) fn used(&self, greatest: &[f64]) -> Vec<Used> {
        let mut all: Vec<Used> = self
            .all
            .iter()
            .map(|limit| Used {
                name: limit.name.clone(),
                bound: limit.bound,
                unit: limit.unit,
                part: 0.0,
            })
            .collect();
        for ((index, _), part) in self.layout().into_iter().zip(greatest) {
            all[index].part = all[index].part.max(*part);
        }
        all
    }

    /// Returns true if any limit applies to a quantity other than positions and the singularity
    /// index, such as a speed or an effort.
    pub(super) fn has_dynamic(&self) -> bool {
        let is_dynamic = |limit: &Limit| {
            !matches!(limit.of, Of::Travel(..) | Of::Measured(..) | Of::Singularity)
        };
        self.all.iter().any(is_dynamic)
    }
}

/// Returns the rate and the acceleration of a moving quantity, in SI units.
fn rate(moving: Moving, at: &Snapshot<'_>) -> [f64; 2] {
    match moving {
        Moving::Coordinate(k) => [at.motion[1][k], at.motion[2][k]],
        Moving::Dof(joint, dof) => {
            let found = at.bodies.joint_motion(at.topology, at.parameters, (joint.0, dof), 0.0);
            [found.rate, found.acceleration]
        }
    }
}
