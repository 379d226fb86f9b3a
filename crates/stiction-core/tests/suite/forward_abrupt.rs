//! Locks and prescribed motions that would require an impact.

use crate::common::*;
use stiction_core::forward::{Forward, ForwardError, Inputs, Known, Settings, View};
use stiction_core::kinematics::{Coordinate, Target};

/// Prescribes the motion of one actuator.
struct Leads<F>(F);

impl<F: Fn(f64) -> (f64, f64)> Inputs for Leads<F> {
    fn efforts(&mut self, _view: &View<'_>, _efforts: &mut [f64]) {}
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        let (value, rate) = (self.0)(time);
        targets[0] = Target { value, rate, acceleration: 0.0 };
    }
}

fn known(model: &Forward, joint: &str, value: f64, rate: Option<f64>) -> Known {
    let joint = model.mechanism().joint_id(joint).unwrap();
    Known { coordinate: Coordinate::Joint { joint, dof: 0 }, value: Some(value), rate }
}

/// The slider of a crank (`l = 0.3`, `r = 0.1`) is locked at its dead centre. The crank may have a
/// rate there, but the slider accelerates by `r w^2 (1 + r/l)`. At rest, no finite force of the
/// lock balances the crank's weight.
#[test]
fn a_lock_at_a_dead_centre_is_refused() {
    let mechanism = slider_crank().mechanism;
    let guide = mechanism.joint_id("guide").unwrap();
    let mechanism = mechanism.with_actuator(guide, 0);
    let lock = mechanism.actuators().position(|actuator| actuator.0 == guide).unwrap();
    let model = Forward::new(mechanism, &[lock]);
    let crank_rate = 3.0;
    for (angle, slide, sense) in [(0.0, 0.4, 1.0), (std::f64::consts::PI, 0.2, -1.0)] {
        let state = |rate| {
            let all = [known(&model, "A", angle, Some(rate))];
            model.assemble_from(&[], &all).unwrap()
        };
        let mut holds = Leads(|_| (slide, 0.0));
        let moving = model.start(0.0, state(crank_rate), Settings::default(), &mut holds);
        let error = moving.map(|_| ()).unwrap_err();
        println!("{error}");
        let ForwardError::Blocked { time: 0.0, what, by, translates: true, at_rest: false } = error
        else {
            panic!("{error}")
        };
        assert!(what.contains("`guide`"), "{what}");
        let expected = 0.1 * crank_rate * crank_rate * (1.0 + sense * 0.1 / 0.3);
        // The least-squares accelerations attribute the whole error to the slider.
        assert!((by - expected).abs() < 1e-9, "{by} {expected}");
        // At rest, the crank is also free at first order, and its weight turns it.
        let resting = model.start(0.0, state(0.0), Settings::default(), &mut holds);
        let error = resting.map(|_| ()).unwrap_err();
        println!("{error}");
        assert!(matches!(error, ForwardError::Blocked { at_rest: true, .. }), "{error}");
    }
    // Away from the dead centre, the lock is effective.
    let state = model.assemble_from(&[], &[known(&model, "A", 0.3, Some(0.0))]).unwrap();
    let (sine, cosine) = 0.3_f64.sin_cos();
    let slide = 0.1 * cosine + (0.09 - (0.1 * sine).powi(2)).sqrt();
    let mut holds = Leads(|_| (slide, 0.0));
    let mut simulation = model.start(0.0, state, Settings::default(), &mut holds).unwrap();
    simulation.advance(0.2, &mut holds).unwrap();
    assert!(simulation.instant().drives[lock].abs() < 1e3);
}

/// A jump of a prescribed rate is reported as an impact, not as a row with forces of 1e11 N.
#[test]
fn a_jump_of_a_prescribed_rate_is_an_impact() {
    let mechanism = slider_crank().mechanism;
    let model = Forward::new(mechanism, &[0]);
    let kink = 0.31_f64;
    let mut leads =
        Leads(
            |time| {
                if time < kink { (0.5 + time, 1.0) } else { (0.5 + kink - (time - kink), -1.0) }
            },
        );
    let state = model.assemble_from(&[], &[known(&model, "A", 0.5, Some(1.0))]).unwrap();
    let mut simulation = model.start(0.0, state, Settings::default(), &mut leads).unwrap();
    let error = simulation.advance(1.0, &mut leads).unwrap_err();
    println!("{error}");
    let ForwardError::Impact { time, what, percent, .. } = error else { panic!("{error}") };
    assert!((time - kink).abs() < 1e-9, "{time}");
    assert!(what.contains("`A`") && percent > 100.0, "{what} {percent}");
    assert!(simulation.instant().drives[0].abs() < 1e3);
}
