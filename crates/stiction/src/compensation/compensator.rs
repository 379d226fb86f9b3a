//! Control laws that a comparison simulates, and the controller that computes their actuator
//! efforts.

use super::sensors::Sensors;
use super::transition::Transition;
use crate::error::Error;
use std::sync::Arc;
use stiction_core::kinematics::Target;
use stiction_program::{Feedforward, FeedforwardMemory, Shortfall};
use stiction_run::forward::Measured;

/// Control law of an actuator controller, with or without friction compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compensator {
    /// Proportional-derivative control.
    Pd,
    /// Proportional-derivative control with constant Coulomb and viscous friction of each actuator.
    PdCoulomb,
    /// Computed torque without friction.
    ComputedTorque,
    /// Computed torque with constant Coulomb and viscous friction of each actuator.
    ComputedTorqueCoulomb,
    /// Computed torque with the load-dependent friction of the model along the reference.
    ComputedTorqueFriction,
}

impl Compensator {
    /// All control laws.
    pub const ALL: [Self; 5] = [
        Self::Pd,
        Self::PdCoulomb,
        Self::ComputedTorque,
        Self::ComputedTorqueCoulomb,
        Self::ComputedTorqueFriction,
    ];

    /// Name of the control law in options and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pd => "pd",
            Self::PdCoulomb => "pd+coulomb",
            Self::ComputedTorque => "computed-torque",
            Self::ComputedTorqueCoulomb => "computed-torque+coulomb",
            Self::ComputedTorqueFriction => "computed-torque+friction",
        }
    }

    /// True if the law compensates friction.
    pub fn has_friction(self) -> bool {
        !matches!(self, Self::Pd | Self::ComputedTorque)
    }

    fn computes_torque(self) -> bool {
        !matches!(self, Self::Pd | Self::PdCoulomb)
    }
}

/// Largest rate, rad/s or m/s, among the small actuator rates that represent incipient motion of a
/// robot at rest. The value is arbitrary, because only the ratios of the rates determine the
/// direction of friction.
const CREEP: f64 = 1e-9;

/// Splits targets into their values, rates and accelerations.
pub(super) fn split(targets: &[Target<f64>]) -> [Vec<f64>; 3] {
    let of = |f: fn(&Target<f64>) -> f64| targets.iter().map(f).collect();
    [of(|t| t.value), of(|t| t.rate), of(|t| t.acceleration)]
}

/// Feedforward model of a robot: a recorded program and its memory.
#[derive(Clone, Debug)]
pub(super) struct Model {
    program: Arc<Feedforward>,
    memory: FeedforwardMemory,
    /// Friction contribution to the efforts, N or N m, from the last call of [`Self::friction`] in
    /// which friction had a solution.
    last: Vec<f64>,
}

impl Model {
    /// Creates the model and moves it to the actuator positions `q`, in small steps along a
    /// straight line from the home position, so that the loops close in the intended assembly mode.
    pub(super) fn at(program: &Arc<Feedforward>, q: &[f64]) -> Result<Self, Error> {
        const STEPS: u32 = 200;
        let memory = program.memory();
        let count = program.sizes().drives;
        let mut own = Self { program: Arc::clone(program), memory, last: vec![0.0; count] };
        let home = program.home().to_vec();
        let zero = vec![0.0; q.len()];
        for step in 1..=STEPS {
            let part = f64::from(step) / f64::from(STEPS);
            let now: Vec<f64> = home.iter().zip(q).map(|(h, q)| h + (q - h) * part).collect();
            own.ideal(&now, &zero, &zero)?;
        }
        Ok(own)
    }

    /// Sets the friction coefficients, in the order of the tunable parameters of the program.
    pub(super) fn tune(&mut self, values: &[f64]) {
        self.program.tune(&mut self.memory, values);
    }

    fn drives(&self, of: impl Fn(&Feedforward, &FeedforwardMemory, usize) -> f64) -> Vec<f64> {
        (0..self.program.sizes().drives).map(|k| of(&self.program, &self.memory, k)).collect()
    }

    fn run(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> Result<bool, Error> {
        let why = match self.program.run(&mut self.memory, q, v, a).shortfall {
            None => return Ok(true),
            Some(Shortfall::Friction) => return Ok(false),
            Some(Shortfall::Open) => "the positions are out of reach",
            Some(Shortfall::Singular) => "the positions are singular",
        };
        Err(Error::no_answer(format!("the controller cannot compute efforts: {why}")))
    }

    /// Efforts without friction, N or N m.
    pub(super) fn ideal(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> Result<Vec<f64>, Error> {
        self.run(q, v, a)?;
        Ok(self.drives(Feedforward::ideal_drive))
    }

    /// Contribution of friction to the efforts of a reference motion, N or N m. If friction has no
    /// solution, for example because joints are at rest, friction is evaluated for incipient motion
    /// in the direction of the accelerations. If this is not possible either, the result is the
    /// contribution of the last call in which friction had a solution.
    pub(super) fn friction(&mut self, reference: &[Target<f64>]) -> Result<Vec<f64>, Error> {
        let [q, v, a] = split(reference);
        let mut found = self.run(&q, &v, &a)?;
        if !found {
            let largest = a.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
            if largest > 0.0 {
                let moved: Vec<f64> =
                    v.iter().zip(&a).map(|(v, a)| v + CREEP * a / largest).collect();
                found = self.run(&q, &moved, &a)?;
            }
        }
        if found {
            let with = self.drives(Feedforward::drive);
            let without = self.drives(Feedforward::ideal_drive);
            self.last = with.iter().zip(&without).map(|(a, b)| a - b).collect();
        }
        Ok(self.last.clone())
    }
}

/// Reference motions of the actuators at one instant, and the contributions of friction to the
/// actuator efforts.
pub(super) type Instant = (Vec<Target<f64>>, Vec<f64>);

/// Direction of a reference motion: the sign of its rate or, if the rate is zero, of its
/// acceleration.
fn direction(reference: &Target<f64>) -> f64 {
    let sign = |x: f64| if x == 0.0 { 0.0 } else { x.signum() };
    if reference.rate == 0.0 { sign(reference.acceleration) } else { sign(reference.rate) }
}

/// Fits constant friction `c sgn(rate) + d rate` of each actuator by least squares; returns
/// `[c, d]` for each.
pub(super) fn best_constants(samples: &[Instant], count: usize) -> Vec<[f64; 2]> {
    (0..count)
        .map(|k| {
            let (mut ss, mut sv, mut vv, mut fs, mut fv) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (reference, friction) in samples {
                let (s, v, f) = (direction(&reference[k]), reference[k].rate, friction[k]);
                ss += s * s;
                sv += s * v;
                vv += v * v;
                fs += f * s;
                fv += f * v;
            }
            let determinant = ss * vv - sv * sv;
            // With only one speed, Coulomb and viscous friction cannot be distinguished, so all
            // friction is attributed to Coulomb friction.
            match determinant > 1e-9 * ss * vv {
                true => [(fs * vv - fv * sv) / determinant, (ss * fv - sv * fs) / determinant],
                false if ss > 0.0 => [fs / ss, 0.0],
                false => [0.0, 0.0],
            }
        })
        .collect()
}

/// Controller with its models, its sensors and the recorded samples.
#[derive(Clone, Debug)]
pub(super) struct Controller {
    pub(super) law: Compensator,
    pub(super) transition: Transition,
    /// Largest rate of each actuator along the reference, rad/s or m/s.
    pub(super) fastest: Vec<f64>,
    /// Factor that multiplies the friction contribution while the reference rests, see
    /// [`Transition`].
    pub(super) held: f64,
    /// Position gain ω², 1/s^2, and rate gain 2 ζ ω, 1/s, per effective mass; ω is the natural frequency, ζ the
    /// damping ratio.
    pub(super) gains: [f64; 2],
    /// Effective masses of the actuators, kg or kg m^2.
    pub(super) masses: Vec<f64>,
    /// Constant friction of each actuator: Coulomb friction, N or N m, and viscous coefficient, N
    /// s/m or N m s/rad.
    pub(super) constants: Vec<[f64; 2]>,
    /// Model evaluated at measured positions.
    pub(super) measured: Model,
    /// Model evaluated along the reference, with the coefficients that the controller knows.
    pub(super) reference: Model,
    pub(super) sensors: Sensors,
    pub(super) records: Vec<Record>,
}

/// True tracking errors and rates of the actuators, and their commanded efforts, at one sampling
/// instant of the controller.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub(super) time: f64,
    /// Tracking error of each actuator: reference minus position, m or rad.
    pub(super) errors: Vec<f64>,
    /// True rates of the actuators, and rates of the reference, m/s or rad/s.
    pub(super) rates: [Vec<f64>; 2],
    pub(super) efforts: Vec<f64>,
}

impl Controller {
    /// Computes the actuator efforts at one sampling instant.
    pub(super) fn efforts(&mut self, at: &Measured<'_>) -> Result<Vec<f64>, Error> {
        let [q, v, a] = split(at.reference);
        let (position, rate) = self.sensors.measure(at.positions, at.rates);
        let [proportional, derivative] = self.gains;
        let corrections: Vec<f64> = (0..q.len())
            .map(|k| proportional * (q[k] - position[k]) + derivative * (v[k] - rate[k]))
            .collect();
        let mut efforts = match self.law.computes_torque() {
            true => {
                let wanted: Vec<f64> = a.iter().zip(&corrections).map(|(a, c)| a + c).collect();
                self.measured.ideal(&position, &rate, &wanted)?
            }
            false => corrections.iter().zip(&self.masses).map(|(c, m)| c * m).collect(),
        };
        let more = match self.law {
            Compensator::Pd | Compensator::ComputedTorque => vec![0.0; q.len()],
            Compensator::PdCoulomb | Compensator::ComputedTorqueCoulomb => {
                let each = at.reference.iter().zip(&self.constants);
                each.map(|(t, [coulomb, viscous])| coulomb * direction(t) + viscous * t.rate)
                    .collect()
            }
            Compensator::ComputedTorqueFriction => self.reference.friction(at.reference)?,
        };
        let rests = v.iter().chain(&a).all(|x| *x == 0.0);
        self.held = self.transition.next_held(self.held, rests);
        for (k, more) in more.into_iter().enumerate() {
            efforts[k] += more * self.transition.factor(v[k], self.fastest[k], self.held);
        }
        self.records.push(Record {
            time: at.time,
            errors: q.iter().zip(at.positions).map(|(q, p)| q - p).collect(),
            rates: [at.rates.to_vec(), v],
            efforts: efforts.clone(),
        });
        Ok(efforts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_of_friction_are_found() {
        let target = |rate: f64| Target { value: 0.0, rate, acceleration: 0.0 };
        let friction = |v: f64| 3.0 * v.signum() + 0.5 * v;
        let rates = [-2.0, -1.0, 0.5, 1.5];
        let samples: Vec<_> =
            rates.iter().map(|v| (vec![target(*v)], vec![friction(*v)])).collect();
        let [found] = best_constants(&samples, 1)[..] else { panic!("one actuator") };
        assert!((found[0] - 3.0).abs() < 1e-12 && (found[1] - 0.5).abs() < 1e-12, "{found:?}");
        // With only one speed, Coulomb and viscous friction cannot be distinguished.
        let samples = [(vec![target(1.0)], vec![2.0]), (vec![target(-1.0)], vec![-2.0])];
        assert_eq!(best_constants(&samples, 1), [[2.0, 0.0]]);
        assert_eq!(best_constants(&[], 1), [[0.0, 0.0]]);
    }
}
