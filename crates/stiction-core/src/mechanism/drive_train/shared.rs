//! Motors that share the efforts of joints. The motor torques are in a constant ratio, but the
//! losses of the gears differ.
//!
//! In a simulation, each motor produces a fixed share of the actuator efforts. Motor friction, gear
//! losses and rotor inertia then determine the effort that each gear transmits. This module solves
//! the inverse problem, in motion and at rest: it computes the efforts of the actuators from given
//! efforts at the joints.
//!
//! Equations (G15) and (G16) of the book's theory.

use super::DriveTrain;
use super::sharing::Group;
use crate::mechanism::Mechanism;
use nalgebra::{DMatrix, DVector};
use std::collections::HashSet;

/// Largest number of motors for which all combinations of power directions in the gears are tried.
const COMBINED: usize = 12;
/// Relative round-off error. Gear efforts below this fraction of the largest one, and relative
/// differences between motors below this value, count as zero.
const ROUNDING: f64 = 1e-12;

/// Group of motors that share the efforts of fewer degrees of freedom than there are motors. The
/// efforts that their gears transmit are not in the ratio of the motors' shares, for example
/// because the losses of the gears differ.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedMotors {
    /// Indices of the drive trains of the group.
    pub trains: Vec<usize>,
    /// Indices of the actuators on which the motors act, in the order of [`Mechanism::actuators`].
    pub actuators: Vec<usize>,
    /// Derivatives of the gears' output coordinates (one row per motor) with respect to the
    /// coordinates of the degrees of freedom (one column each).
    parts: DMatrix<f64>,
    /// Efforts of the motors (rows) per unit actuator effort on each degree of freedom (columns).
    shares: DMatrix<f64>,
}

/// Effort at the input of a gear (motor torque times transmission) as a function of the effort at
/// its output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearInput {
    /// Input effort at zero output effort. This effort accelerates the rotor and overcomes the
    /// friction of the motor.
    resistance: f64,
    /// Ratios of input effort to output effort: the first applies while the motor drives the load,
    /// the second while the load drives the motor.
    factors: [f64; 2],
    /// Direction of motion of the output coordinate, 1 or -1; zero at rest.
    sense: f64,
}

impl GearInput {
    /// Returns `true` if the motor drives the load at the nonzero output effort `output`, and
    /// `false` if the load drives the motor.
    fn drives(&self, output: f64) -> bool {
        output * self.sense > 0.0
    }
}

impl DriveTrain {
    /// Returns the input effort of the gear as a function of its output effort. The arguments are
    /// the rate and acceleration of the output coordinate, and the angular acceleration `carrier`
    /// of the body that carries the rotor, see [`Self::motor`]. At rest (rate `None`), neither
    /// friction nor gear loss acts.
    pub fn gear_input(&self, rate: Option<f64>, acceleration: f64, carrier: f64) -> GearInput {
        let motor = self.motor(0.0, (0.0, 0.0), rate, acceleration, carrier);
        let (forward, backward) = self.gear.efficiencies();
        GearInput {
            resistance: self.transmission() * motor.torque,
            factors: rate.map_or([1.0; 2], |_| [forward.recip(), backward]),
            sense: rate.map_or(0.0, f64::signum),
        }
    }
}

impl Mechanism {
    /// Lists the groups of motors that share efforts and whose gears transmit these efforts in a
    /// ratio other than that of the motors' shares.
    pub fn shared_motors(&self) -> Vec<SharedMotors> {
        let (trains, actuators) = (self.drive_trains(), self.actuators().collect::<Vec<_>>());
        let groups = Group::all(trains).into_iter();
        let shared = groups.filter(|group| group.shares_vary(trains)).filter_map(|group| {
            let index = |dof| actuators.iter().position(|known| known == dof);
            Some(SharedMotors {
                actuators: group.dofs.iter().map(index).collect::<Option<_>>()?,
                parts: group.parts(trains),
                shares: group.shares(trains)?,
                trains: group.trains,
            })
        });
        shared.collect()
    }
}

impl Group {
    /// Returns `true` if the gears transmit the efforts of the joints in a ratio other than that of
    /// the motors' shares. This requires more motors than degrees of freedom and a gear with
    /// losses. In addition, the group must have several degrees of freedom, or the rotors, friction
    /// or losses of its motors must not be in the ratio of the shares.
    fn shares_vary(&self, trains: &[DriveTrain]) -> bool {
        let mut all = self.trains.iter().map(|&train| &trains[train]);
        // Compare all motors with the one that has the largest share, because a motor with zero
        // share defines no ratio.
        let main = all.clone().max_by(|a, b| a.share.total_cmp(&b.share));
        self.trains.len() > self.dofs.len()
            && all.clone().any(|train| train.losses().is_some())
            && (self.dofs.len() > 1
                || !all.all(|train| main.is_some_and(|main| is_proportional(main, train))))
    }

    /// Returns `true` if a simulation must model the shaft of each motor of the group separately.
    /// This is necessary if the friction of a motor acts on several joints, or if the loss of a
    /// gear depends on the part of the effort that the gear transmits.
    pub(in crate::mechanism) fn needs_shafts(&self, trains: &[DriveTrain]) -> bool {
        let mut all = self.trains.iter().map(|&train| &trains[train]);
        let acts_on_several = |train: &DriveTrain| {
            train.losses().is_some() || (train.only_dof().is_none() && train.has_friction())
        };
        self.shares_vary(trains) || (self.dofs.len() > 1 && all.any(acts_on_several))
    }
}

/// Returns `true` if two motors on one degree of freedom, with torques in the ratio of their
/// shares, transmit efforts in this ratio in every motion. This requires that rotor inertia and
/// motor friction are in the same ratio, and that the gears have the same losses.
fn is_proportional(one: &DriveTrain, other: &DriveTrain) -> bool {
    let sizes = |train: &DriveTrain| {
        let (n, friction) = (train.transmission(), train.motor_friction);
        let momentum = train.rotor_axis.map_or(0.0, |_| n * train.rotor_inertia);
        [train.reflected_inertia(), n.abs() * friction.constant, n * n * friction.viscous, momentum]
    };
    let mut pairs = sizes(one).into_iter().zip(sizes(other));
    one.losses() == other.losses()
        && one.rotor_axis == other.rotor_axis
        && pairs.all(|(a, b)| {
            let (a, b) = (a * other.share, b * one.share);
            (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
        })
}

impl SharedMotors {
    /// Computes the efforts of the actuators (motor torques times transmissions) for which the
    /// gears exert the efforts `outputs` on the degrees of freedom. `inputs` contains one gear
    /// function for each motor of the group.
    ///
    /// Returns `None` if the numbers of motors or degrees of freedom differ from those of the
    /// group, or if no motor torques in the ratio of the shares produce the outputs. The latter may
    /// happen with self-locking gears. With such gears, several solutions may exist; one of them is
    /// returned.
    pub fn efforts(&self, inputs: &[GearInput], outputs: &[f64]) -> Option<Vec<f64>> {
        if (inputs.len(), outputs.len()) != self.parts.shape() {
            return None;
        }
        let outputs = DVector::from_column_slice(outputs);
        let even = &self.shares * &outputs;
        let each = inputs.iter().zip(even.iter());
        let mut driving: Vec<bool> = each.map(|(input, output)| input.drives(*output)).collect();
        let mut seen = HashSet::new();
        // For gears that are not self-locking, the power directions found in one solution are the
        // ones to try next.
        while seen.insert(driving.clone()) {
            match self.with_directions(inputs, &outputs, &driving) {
                Some((efforts, None)) => return Some(efforts),
                Some((_, Some(next))) => driving = next,
                None => break,
            }
        }
        let count = u32::try_from(inputs.len()).ok().filter(|_| inputs.len() <= COMBINED)?;
        (0..2_usize.pow(count)).find_map(|pattern| {
            let driving: Vec<bool> = (0..inputs.len()).map(|k| pattern >> k & 1 == 1).collect();
            match self.with_directions(inputs, &outputs, &driving)? {
                (efforts, None) => Some(efforts),
                _ => None,
            }
        })
    }

    /// Solves for given directions of power in the gears: `driving` is true for each gear whose
    /// motor drives the load. Returns the efforts of the actuators. If the solution contradicts
    /// `driving`, also returns the directions of power found in the solution. `None` if the
    /// equations are singular.
    fn with_directions(
        &self,
        inputs: &[GearInput],
        outputs: &DVector<f64>,
        driving: &[bool],
    ) -> Option<(Vec<f64>, Option<Vec<bool>>)> {
        let (motors, dofs) = self.parts.shape();
        // The unknowns are the output efforts of the gears, followed by the efforts of the
        // actuators.
        let mut matrix = DMatrix::zeros(motors + dofs, motors + dofs);
        let mut right = DVector::zeros(motors + dofs);
        for (k, (input, driving)) in inputs.iter().zip(driving).enumerate() {
            matrix[(k, k)] = input.factors[usize::from(!driving)];
            right[k] = -input.resistance;
        }
        matrix.view_mut((0, motors), (motors, dofs)).copy_from(&-&self.shares);
        matrix.view_mut((motors, 0), (dofs, motors)).copy_from(&self.parts.transpose());
        right.rows_mut(motors, dofs).copy_from(outputs);
        let solution = matrix.lu().solve(&right)?;
        let transmitted = solution.rows(0, motors);
        let rounding = ROUNDING * transmitted.amax();
        let each = inputs.iter().zip(transmitted.iter()).zip(driving);
        let next: Vec<bool> = each
            .map(|((input, output), driving)| match output.abs() > rounding {
                true => input.sense == 0.0 && *driving || input.drives(*output),
                false => *driving,
            })
            .collect();
        let efforts = solution.rows(motors, dofs).iter().copied().collect();
        Some((efforts, (next != driving).then_some(next)))
    }

    /// Computes the interval of the actuator's effort in which static friction of motors and gears
    /// keeps a single degree of freedom at rest, while the gears exert efforts within `bounds` on
    /// it. A self-locking gear exerts any effort, as long as its motor does not turn the gear
    /// against this effort. For gears that jam ([`Self::may_jam`]), the interval is an inner bound.
    /// Returns `None` for several degrees of freedom, or if `trains` are not those of the
    /// mechanism.
    pub fn holding(&self, trains: &[DriveTrain], (low, high): (f64, f64)) -> Option<(f64, f64)> {
        if self.actuators.len() != 1 {
            return None;
        }
        let motors = self.trains.iter().map(|&k| trains.get(k).map(Holding::of));
        let motors: Vec<Holding> = motors.collect::<Option<_>>()?;
        Some((-greatest(&motors, -low), greatest(&motors, high)))
    }

    /// Returns `true` if a gear has a negative efficiency while the load drives its motor. A load
    /// in the direction of motion then jams the gear, even if the motor pushes in that direction.
    pub fn may_jam(&self, trains: &[DriveTrain]) -> bool {
        let mut own = self.trains.iter().filter_map(|&k| trains.get(k));
        own.any(|train| train.gear.efficiencies().1 < 0.0)
    }
}

/// Static friction of a motor and its gear; the motor shares the effort of a single degree of
/// freedom with other motors.
struct Holding {
    share: f64,
    /// Constant friction torque of the motor, multiplied by the transmission.
    friction: f64,
    efficiencies: (f64, f64),
}

impl Holding {
    fn of(train: &DriveTrain) -> Self {
        let friction = train.transmission().abs() * train.motor_friction.constant;
        Self { share: train.share, friction, efficiencies: train.gear.efficiencies() }
    }

    /// Returns the actuator effort at which the motor overcomes its friction; infinite for a motor
    /// with zero share.
    fn onset(&self) -> f64 {
        if self.share > 0.0 { self.friction / self.share } else { f64::INFINITY }
    }
}

/// Computes the greatest actuator effort at which the gears, on the verge of forward motion,
/// together exert at most the effort `output`. The exerted effort increases with the actuator
/// effort, linearly between the efforts at which the individual motors overcome their friction.
fn greatest(motors: &[Holding], output: f64) -> f64 {
    let mut starts: Vec<f64> = motors.iter().map(Holding::onset).collect();
    starts.retain(|start| start.is_finite());
    starts.push(f64::NEG_INFINITY);
    starts.sort_by(|a, b| b.total_cmp(a));
    let mut end = f64::INFINITY;
    for start in starts {
        let (mut slope, mut lost) = (0.0, 0.0);
        for motor in motors {
            let (forward, backward) = motor.efficiencies;
            let factor = if motor.onset() <= start {
                forward
            } else if backward > 0.0 {
                backward.recip()
            } else if motor.share == 0.0 && motor.friction == 0.0 {
                0.0
            } else {
                // Below its onset, this motor does not turn its self-locking gear, which withstands
                // any output. The joint stays at rest up to the actuator effort `end`.
                return end;
            };
            slope += factor * motor.share;
            lost += factor * motor.friction;
        }
        let effort = (output + lost) / slope;
        if effort >= start {
            return effort.min(end);
        }
        end = start;
    }
    end
}
