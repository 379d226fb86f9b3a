//! Summary of the motors along a motion: torque, speed, power, losses, limits.

use crate::job::Job;
use crate::names::{Names, width};
use crate::power_off::{self, PowerOff, actuators_of};
use crate::statistics::{Integral, Size};
use serde_json::{Map, Value, json};
use std::fmt::{self, Write};
use stiction_core::dynamics::Forces;
use stiction_core::mechanism::{DriveTrain, Motor};
use stiction_draw::numbers::{number, percent};

/// Motors along a motion.
#[derive(Clone, Debug)]
pub(super) struct MotorSummary {
    motors: Vec<OneMotor>,
    trains: Vec<DriveTrain>,
    actuators: Vec<usize>,
    /// First and last time, s.
    span: Option<(f64, f64)>,
    /// Holding of the last pose at rest with power off, by friction or a brake, and the time of that pose, s.
    power_off: Option<(f64, Vec<PowerOff>)>,
    residual: Size,
}

/// One motor along a motion.
#[derive(Clone, Debug, Default)]
struct OneMotor {
    torque: Size,
    speed: Size,
    power: Size,
    squares: Integral,
    work: Integral,
    supplied: Integral,
    rotor: Integral,
    friction: Integral,
    gear: Integral,
    /// Time in motion, s.
    turning: Integral,
    /// Greatest interval of the torque at rest, N m.
    widest: Option<(f64, (f64, f64))>,
}

/// Angular acceleration of a motor below which it stands still, rad/s^2: rounding of zero.
const STILL: f64 = 1e-9;
/// Factor by which rounding may exceed a limit.
const WITHIN: f64 = 1.0 + 1e-9;

impl MotorSummary {
    pub(super) fn new(job: &Job<'_>) -> Self {
        let mechanism = &job.model.mechanism;
        let trains = mechanism.drive_trains().to_vec();
        Self {
            motors: vec![OneMotor::default(); trains.len()],
            trains,
            actuators: actuators_of(mechanism),
            span: None,
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
        self.span = Some((self.span.map_or(time, |(start, _)| start), time));
        for (one, motor) in self.motors.iter_mut().zip(motors) {
            one.torque.add(time, motor.torque);
            one.speed.add(time, motor.speed);
            one.power.add(time, motor.power);
            one.squares.add(time, motor.torque * motor.torque);
            one.work.add(time, motor.power);
            one.supplied.add(time, motor.power.max(0.0));
            one.rotor.add(time, motor.rotor_power);
            one.friction.add(time, motor.friction_power);
            one.gear.add(time, motor.gear_loss);
            one.turning.add(time, if motor.speed == 0.0 { 0.0 } else { 1.0 });
            let (low, high) = motor.torque_bounds;
            let wider = one.widest.is_none_or(|(_, (a, b))| high - low > b - a);
            if motor.speed == 0.0 && wider {
                one.widest = Some((time, motor.torque_bounds));
            }
        }
        self.residual.add(time, residual(motors, forces));
        if motors.iter().all(|motor| motor.speed == 0.0 && motor.acceleration.abs() < STILL) {
            let found = power_off::of(&self.trains, &self.actuators, forces);
            self.power_off = Some((time, found));
        }
    }

    /// Root mean square over time of a motor's torque, N m.
    fn rms(&self, motor: &OneMotor) -> f64 {
        let duration = self.span.map_or(0.0, |(start, end)| end - start);
        if duration > 0.0 {
            (motor.squares.value / duration).sqrt()
        } else {
            motor.squares.last().sqrt()
        }
    }

    /// Fraction of the time in which a motor turns.
    fn duty(&self, motor: &OneMotor) -> f64 {
        let duration = self.span.map_or(0.0, |(start, end)| end - start);
        if duration > 0.0 { motor.turning.value / duration } else { motor.turning.last() }
    }

    /// Limits of a motor with what is reached of them: key, words, unit.
    fn reached(&self, k: usize) -> Vec<(&'static str, &'static str, &'static str, f64, f64)> {
        let (motor, limits) = (&self.motors[k], self.trains[k].limits);
        let all = [
            ("rated", "rated rms torque", "N m", limits.rated, self.rms(motor)),
            ("peak", "peak torque", "N m", limits.peak, motor.torque.peak.abs()),
            ("speed", "speed limit", "rad/s", limits.speed, motor.speed.peak.abs()),
        ];
        let given = |(key, words, unit, limit, value)| Some((key, words, unit, limit?, value));
        all.into_iter().filter_map(given).collect()
    }

    /// A line for each limit that is exceeded.
    pub(super) fn cautions(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (k, train) in self.trains.iter().enumerate() {
            for (_, words, unit, limit, value) in self.reached(k) {
                if value > limit * WITHIN {
                    lines.push(format!(
                        "{}: {} of {words} ({} of {} {unit})",
                        train.name,
                        excess(value / limit),
                        number(value),
                        number(limit)
                    ));
                }
            }
        }
        lines
    }

    pub(super) fn json(&self, names: &Names) -> Value {
        let mut all = Map::new();
        for (k, (train, motor)) in self.trains.iter().zip(&self.motors).enumerate() {
            let size = |size: &Size, unit: &str, rms: f64| json!({ "unit": unit, "peak": size.peak, "peak_time": size.peak_time, "rms": rms });
            let rms = self.rms(motor);
            let current = train.torque_constant.map(|constant| {
                json!({
                    "unit": "A",
                    "peak": motor.torque.peak / constant,
                    "peak_time": motor.torque.peak_time,
                    "rms": rms / constant,
                })
            });
            let reached = self.reached(k).into_iter();
            let limits: Map<String, Value> = reached
                .map(|(key, _, unit, limit, value)| {
                    let entry = json!({ "unit": unit, "limit": limit, "reached": value, "exceeded": value > limit * WITHIN });
                    (key.to_owned(), entry)
                })
                .collect();
            let value = json!({
                "actuated": names.drives[self.actuators[k]].0,
                "transmission": train.transmission(),
                "share": train.share,
                "motor_torque": size(&motor.torque, "N m", rms),
                "motor_speed": size(&motor.speed, "rad/s", motor.speed.rms()),
                "current": current,
                "motor_power": size(&motor.power, "W", motor.power.rms()),
                "work": motor.work.value,
                "work_supplied": motor.supplied.value,
                "work_returned": motor.supplied.value - motor.work.value,
                "rotor_energy": motor.rotor.value,
                "friction_loss": motor.friction.value,
                "gear_loss": motor.gear.value,
                "duty": self.duty(motor),
                "interval_at_rest": motor.widest.map(|(time, (low, high))| json!({ "time": time, "low": low, "high": high })),
                "limits": limits,
                "power_off": self.power_off.as_ref().map(|(time, found)| {
                    let mut value = found[k].json();
                    value["time"] = json!(time);
                    value
                }),
            });
            all.insert(train.name.clone(), value);
        }
        Value::Object(all)
    }

    /// Greatest residual of the power balance with motors, gears and rotors, W.
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
        for (train, motor) in self.trains.iter().zip(&self.motors) {
            // Without losses their sum is rounding of either sign.
            let losses = (motor.friction.value + motor.gear.value).max(0.0);
            let ratio = losses / motor.supplied.value;
            writeln!(
                out,
                "{:wide$}  {:>10} {:>10}  {:>10}  {:>10}  {:>10}  {:>7} {:>7}",
                train.name,
                number(motor.torque.peak),
                number(self.rms(motor)),
                number(motor.speed.peak),
                number(motor.power.peak),
                number(motor.work.value),
                percent(Some(ratio).filter(|ratio| ratio.is_finite())),
                percent(Some(self.duty(motor))),
            )?;
        }
        writeln!(
            out,
            "losses of motor and gear per work supplied; turns: part of the time in motion"
        )?;
        if let Some((time, found)) = &self.power_off {
            writeln!(out, "with power off, at rest at t = {} s:", number(*time))?;
            power_off::write(out, &self.trains, found)?;
        }
        writeln!(out)
    }
}

/// Residual of the power balance with the motors in place of the efforts of their joints, W.
pub(super) fn residual(motors: &[Motor], forces: &Forces) -> f64 {
    let of = |motor: &Motor| {
        motor.power - motor.output - motor.rotor_power - motor.friction_power - motor.gear_loss
    };
    forces.power.residual() + motors.iter().map(of).sum::<f64>()
}

/// A ratio above one in percent, with as many decimals as show it above 100.
fn excess(ratio: f64) -> String {
    let shown = |digits: usize| format!("{:.digits$}", ratio * 100.0);
    let clear = |text: &String| text.parse::<f64>().is_ok_and(|shown| shown > 100.0);
    format!("{} %", (0..6).map(shown).find(clear).unwrap_or_else(|| shown(6)))
}

#[cfg(test)]
mod tests {
    use super::excess;

    #[test]
    fn exceeded_limits_are_above_100_percent() {
        assert_eq!(excess(1.1238), "112 %");
        assert_eq!(excess(1.0004), "100.04 %");
    }
}
