//! Summary of the motors along a motion: torque, speed, power, losses and limits.

use crate::job::Job;
use crate::motor_load::MotorLoad;
use crate::names::{Names, width};
use crate::power_off::{self, PowerOff};
use crate::statistics::{Integral, Size};
use serde_json::{Map, Value, json};
use std::fmt::{self, Write};
use stiction_core::dynamics::Forces;
use stiction_core::mechanism::{DriveTrain, Motor, MotorMap, SharedMotors};
use stiction_draw::numbers::{number, percent};

/// Statistics of all motors along a motion.
#[derive(Clone, Debug)]
pub(super) struct MotorSummary {
    motors: Vec<OneMotor>,
    trains: Vec<DriveTrain>,
    maps: Vec<MotorMap>,
    shared: Vec<SharedMotors>,
    /// Time, s, of the last sample at rest, and for each motor whether friction or a brake holds
    /// the motor at this sample with power off.
    power_off: Option<(f64, Vec<PowerOff>)>,
    residual: Size,
}

/// Statistics of one motor along a motion.
#[derive(Clone, Debug, Default)]
struct OneMotor {
    load: MotorLoad,
    rotor: Integral,
    friction: Integral,
    gear: Integral,
    /// Time, s, of the widest interval of the motor torque at rest, and the ends of this interval,
    /// N m.
    widest: Option<(f64, (f64, f64))>,
}

/// Angular acceleration below which a motor counts as not accelerating, rad/s^2.
const STILL: f64 = 1e-9;

impl MotorSummary {
    pub(super) fn new(job: &Job<'_>) -> Self {
        let mechanism = &job.model.mechanism;
        let trains = mechanism.drive_trains().to_vec();
        Self {
            motors: vec![OneMotor::default(); trains.len()],
            trains,
            maps: mechanism.motor_maps(),
            shared: mechanism.shared_motors(),
            power_off: None,
            residual: Size::default(),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.motors.is_empty()
    }

    pub(super) fn add(&mut self, time: f64, motors: &[Motor], forces: &Forces) {
        if motors.is_empty() {
            return;
        }
        for (one, motor) in self.motors.iter_mut().zip(motors) {
            one.load.add(time, motor.torque, motor.speed);
            one.rotor.add(time, motor.rotor_power);
            one.friction.add(time, motor.friction_power);
            one.gear.add(time, motor.gear_loss);
            let (low, high) = motor.torque_bounds;
            let wider = one.widest.is_none_or(|(_, (a, b))| high - low > b - a);
            if motor.speed == 0.0 && wider {
                one.widest = Some((time, motor.torque_bounds));
            }
        }
        self.residual.add(time, residual(motors, forces));
        if motors.iter().all(|motor| motor.speed == 0.0 && motor.acceleration.abs() < STILL) {
            let found = power_off::of((&self.trains, &self.maps, &self.shared), forces);
            self.power_off = Some((time, found));
        }
    }

    /// Returns the drive trains, each with the statistics of its motor and the energy dissipated in
    /// motor and gear, J.
    pub(super) fn loads(&self) -> impl Iterator<Item = (&DriveTrain, &MotorLoad, f64)> {
        // Without losses, the sum is a rounding error of either sign.
        let lost = |motor: &OneMotor| (motor.friction.value + motor.gear.value).max(0.0);
        let each = self.trains.iter().zip(&self.motors);
        each.map(move |(train, motor)| (train, &motor.load, lost(motor)))
    }

    /// Returns a caution for each motor limit that is exceeded.
    pub(super) fn cautions(&self) -> Vec<String> {
        let each = self.trains.iter().zip(&self.motors);
        each.flat_map(|(train, motor)| motor.load.cautions(train)).collect()
    }

    pub(super) fn json(&self, names: &Names) -> Value {
        let mut all = Map::new();
        for (k, (train, motor)) in self.trains.iter().zip(&self.motors).enumerate() {
            let mut value = motor.load.json(train);
            let moved = self.maps[k].terms.iter().filter(|term| term.part != 0.0);
            let moved: Vec<&str> =
                moved.map(|term| names.drives[term.actuator].0.as_str()).collect();
            let more = json!({
                "actuated": moved.join(", "),
                "transmission": train.transmission(),
                "share": train.share,
                "rotor_energy": motor.rotor.value,
                "friction_loss": motor.friction.value,
                "gear_loss": motor.gear.value,
                "interval_at_rest": motor.widest.map(|(time, (low, high))| json!({ "time": time, "low": low, "high": high })),
                "power_off": self.power_off.as_ref().map(|(time, found)| {
                    let mut value = found[k].json();
                    value["time"] = json!(time);
                    value
                }),
            });
            value.extend(more.as_object().cloned().unwrap_or_default());
            let value = Value::Object(value);
            all.insert(train.name.clone(), value);
        }
        Value::Object(all)
    }

    /// Returns the largest residual of the power balance that includes motors, gears and rotors, W.
    pub(super) fn residual(&self) -> f64 {
        self.residual.peak.abs()
    }

    pub(super) fn write(&self, out: &mut impl Write) -> fmt::Result {
        if self.is_empty() {
            return Ok(());
        }
        let wide = width(self.trains.iter().map(|train| train.name.as_str()), 13);
        writeln!(
            out,
            "{:wide$}  {:>10} {:>10}  {:>10}  {:>10}  {:>10}  {:>7} {:>7}",
            "motor", "peak N m", "rms N m", "peak rad/s", "peak W", "work J", "losses", "turns"
        )?;
        for (train, load, losses) in self.loads() {
            let ratio = losses / load.supplied.value;
            writeln!(
                out,
                "{:wide$}  {:>10} {:>10}  {:>10}  {:>10}  {:>10}  {:>7} {:>7}",
                train.name,
                number(load.torque.peak),
                number(load.rms()),
                number(load.speed.peak),
                number(load.power.peak),
                number(load.work.value),
                percent(Some(ratio).filter(|ratio| ratio.is_finite())),
                percent(Some(load.duty())),
            )?;
        }
        writeln!(
            out,
            "losses: energy lost in motor and gear, relative to the work supplied; turns: part of \
             the time in which the motor turns"
        )?;
        if let Some((time, found)) = &self.power_off {
            writeln!(out, "with power off, at rest at t = {} s:", number(*time))?;
            power_off::write(out, &self.trains, found)?;
        }
        writeln!(out)
    }
}

/// Returns the residual of the power balance, W. In this balance, the powers of the motors replace
/// the powers of the joint efforts, and the powers of the rotors and the losses in motors and gears
/// are included.
pub(super) fn residual(motors: &[Motor], forces: &Forces) -> f64 {
    let of = |motor: &Motor| {
        motor.power - motor.output - motor.rotor_power - motor.friction_power - motor.gear_loss
    };
    forces.power.residual() + motors.iter().map(of).sum::<f64>()
}
