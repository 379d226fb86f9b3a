//! Control under stiction, formulas over the measured state, stop conditions.

use super::{FRICTION_ARM, GRAVITY, INERTIA, LENGTH, MASS as BOB, pendulum};
use stiction::{EventKind, Robot};

/// A carriage of 2 kg on a horizontal guide with mu = 0.2 and the given static coefficient.
fn axis(mu_static: f64) -> Robot {
    let text = include_str!("../../examples/carriage.toml");
    Robot::parse(text)
        .unwrap()
        .with(&format!("joints.guide.friction.mu_static={mu_static}"))
        .unwrap()
}

const MASS: f64 = 2.0;
const MU: f64 = 0.2;
const KP: f64 = 200.0;
const KI: f64 = 400.0;
const KD: f64 = 20.0;
const START: f64 = 0.01;

/// A stick or slip onset: time, s, and position, m.
type Onset = (f64, f64);

/// State of the axis: position, rate, integral part, and a constant one for inhomogeneous terms.
type State = [f64; 4];

/// Solution of a linear system with constant coefficients after a time, by the Taylor series of its
/// exponential, scaled and squared.
fn flow(matrix: &[[f64; 4]; 4], time: f64, state: State) -> State {
    let times = |a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]| {
        let mut c = [[0.0; 4]; 4];
        for i in 0..4 {
            for j in 0..4 {
                c[i][j] = (0..4).map(|k| a[i][k] * b[k][j]).sum();
            }
        }
        c
    };
    let halvings = 16;
    let scale = time / f64::powi(2.0, halvings);
    let small = matrix.map(|row| row.map(|x| x * scale));
    let mut sum = [[0.0; 4]; 4];
    let mut term = [[0.0; 4]; 4];
    for i in 0..4 {
        (sum[i][i], term[i][i]) = (1.0, 1.0);
    }
    for order in 1..12 {
        term = times(&term, &small).map(|row| row.map(|x| x / f64::from(order)));
        for i in 0..4 {
            for j in 0..4 {
                sum[i][j] += term[i][j];
            }
        }
    }
    for _ in 0..halvings {
        sum = times(&sum, &sum);
    }
    std::array::from_fn(|i| (0..4).map(|k| sum[i][k] * state[k]).sum())
}

/// Onsets of slip and stick of the axis under PID control, computed in closed form piece by piece
/// until `end`, s. The axis starts at rest at [`START`]; the effort is `-KP q + x - KD v` with
/// `dx/dt = -KI q`.
fn exact(mu_static: f64, end: f64) -> Vec<Onset> {
    let (sliding, holding) = (MU * MASS * GRAVITY, mu_static * MASS * GRAVITY);
    let (mut time, mut position, mut integral) = (0.0, START, 0.0);
    let mut onsets = Vec::new();
    loop {
        // At rest, the integral part grows linearly until it exceeds static friction.
        let towards = -position.signum();
        let effort: f64 = towards * (integral - KP * position);
        time += (holding - effort) / (KI * position.abs());
        integral = KP * position + towards * holding;
        if time > end {
            return onsets;
        }
        onsets.push((time, position));
        let matrix = [
            [0.0, 1.0, 0.0, 0.0],
            [-KP / MASS, -KD / MASS, 1.0 / MASS, -towards * sliding / MASS],
            [-KI, 0.0, 0.0, 0.0],
            [0.0; 4],
        ];
        let state = |passed: f64| flow(&matrix, passed, [position, 0.0, integral, 1.0]);
        let rate = |passed: f64| towards * state(passed)[1];
        let piece = 1e-3;
        let mut low = 1e-6;
        while rate(low + piece) > 0.0 {
            low += piece;
            if time + low > end {
                return onsets;
            }
        }
        let mut high = low + piece;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if rate(middle) > 0.0 { low = middle } else { high = middle }
        }
        let [stopped, _, x, _] = state(high);
        (time, position, integral) = (time + high, stopped, x);
        // Static friction holds the axis there.
        assert!((integral - KP * position).abs() < holding);
        if time > end {
            return onsets;
        }
        onsets.push((time, position));
    }
}

fn controlled(mu_static: f64, controller: &str, end: f64) -> stiction::Run {
    let run = axis(mu_static)
        .forward()
        .controller(controller)
        .unwrap()
        .at("guide", START)
        .unwrap()
        .until(end)
        .run()
        .unwrap();
    run.ended().unwrap();
    run
}

const CONTINUOUS: &str = "type = pid; period = 0; kp = 200 N/m; ki = 400 N/(m s); kd = 20 N s/m";

/// Times of stick and slip onsets.
fn onsets(run: &stiction::Run) -> Vec<f64> {
    let is_onset =
        |kind: &EventKind| matches!(kind, EventKind::Sticks { .. } | EventKind::Slides { .. });
    assert!(!run.events().iter().any(|event| matches!(event.kind, EventKind::Method { .. })));
    run.events().iter().filter(|event| is_onset(&event.kind)).map(|event| event.time).collect()
}

#[test]
fn a_pid_controlled_axis_hunts_as_the_piecewise_exact_solution() {
    let end = 60.0;
    let expected = exact(0.3, end);
    let run = controlled(0.3, CONTINUOUS, end);
    let found = onsets(&run);
    // Hunting: the axis slips back and forth about its goal without end.
    assert!(expected.len() > 20 && expected.len() == found.len());
    let slips = || expected.iter().step_by(2);
    assert!(slips().zip(slips().skip(1)).all(|(a, b)| a.1 * b.1 < 0.0));
    for ((time, _), found) in expected.iter().zip(&found) {
        // Slip begins when the limit is exceeded by a relative 1e-9; the resulting delays
        // accumulate over the cycles.
        assert!((time - found).abs() < 1e-6, "{time} {found}");
    }
    for sample in run.samples() {
        let before = expected.iter().enumerate().rfind(|(_, (time, _))| *time <= sample.time);
        if let Some((index, (_, position))) = before
            && index % 2 == 1
        {
            assert!((sample.position("guide").unwrap() - position).abs() < 1e-8);
        }
    }
    // The energy balance includes the controller's work.
    let last = run.last().unwrap();
    let work = last.work("guide").unwrap() - last.dissipated("guide").unwrap();
    assert!((last.mechanical_energy() - run.samples()[0].mechanical_energy() - work).abs() < 1e-10);
}

#[test]
fn without_excess_static_friction_the_axis_does_not_hunt() {
    let end = 60.0;
    let run = controlled(MU, CONTINUOUS, end);
    let found = onsets(&run);
    // The axis slips once, and approaches its goal from one side.
    assert!((found[0] - exact(MU, 1.0)[0].0).abs() < 1e-8);
    let positions = || run.samples().iter().map(|sample| sample.position("guide").unwrap());
    assert!(positions().all(|position| position > -1e-12));
    assert!(positions().zip(positions().skip(1)).all(|(a, b)| b <= a + 1e-12));
    assert!(run.last().unwrap().position("guide").unwrap().abs() < 1e-9);
}

/// Onsets of slip and stick of the axis under sampled PID control with this period, s, in closed
/// form: the effort is constant between two samples, so the axis slides along parabolas.
fn exact_sampled(mu_static: f64, period: f64, end: f64) -> Vec<Onset> {
    let (sliding, holding) = (MU * MASS * GRAVITY, mu_static * MASS * GRAVITY);
    let (mut position, mut rate, mut integral) = (START, 0.0_f64, 0.0);
    let mut onsets = Vec::new();
    for k in 0..(end / period).round() as usize {
        let (time, error) = (k as f64 * period, -position);
        let effort: f64 = KP * error + integral - KD * rate;
        integral += period * KI * error;
        if rate == 0.0 {
            if effort.abs() < holding {
                continue;
            }
            onsets.push((time, position));
        }
        let towards = if rate == 0.0 { effort.signum() } else { rate.signum() };
        let acceleration = (effort - towards * sliding) / MASS;
        let stop = -rate / acceleration;
        if stop > 0.0 && stop <= period {
            // Static friction holds the axis there.
            assert!(effort.abs() < holding);
            position += 0.5 * rate * stop;
            rate = 0.0;
            onsets.push((time + stop, position));
        } else {
            position += (rate + 0.5 * acceleration * period) * period;
            rate += acceleration * period;
        }
    }
    onsets
}

#[test]
fn a_sampled_pid_controller_hunts_as_the_exact_solution_between_samples() {
    let end = 40.0;
    for period in [10e-3, 1e-3] {
        let expected = exact_sampled(0.3, period, end);
        let sampled = CONTINUOUS.replace("period = 0", &format!("period = {period} s"));
        let run = controlled(0.3, &sampled, end);
        let found = onsets(&run);
        assert!(expected.len() >= 18 && expected.len() == found.len(), "{}", found.len());
        for ((time, _), found) in expected.iter().zip(&found) {
            // Slip begins at samples. Rounding of positions grows about sevenfold in each half cycle, from 1e-16 to
            // 1e-10 s.
            assert!((time - found).abs() < 1e-8, "{period}: {time} {found}");
        }
        let rests = run.samples().iter().filter_map(|sample| {
            let before = expected.iter().rposition(|(time, _)| *time <= sample.time)?;
            (before % 2 == 1).then_some((sample, expected[before].1))
        });
        for (sample, position) in rests {
            assert!((sample.position("guide").unwrap() - position).abs() < 1e-8);
        }
    }
}

#[test]
fn a_sampled_pid_controller_approaches_the_continuous_one() {
    // The integral part of a sampled controller lags by up to a period. The waiting time is
    // inversely proportional to the distance from the goal at which the axis sticks, so delays of
    // onsets grow.
    let expected = exact(0.3, 12.0);
    for period in [4e-3, 1e-3] {
        let sampled = CONTINUOUS.replace("period = 0", &format!("period = {period} s"));
        let found = onsets(&controlled(0.3, &sampled, 12.0));
        assert_eq!(found.len(), expected.len());
        for ((time, _), found) in expected.iter().zip(&found) {
            assert!((time - found).abs() < 60.0 * period, "{period}: {time} {found}");
        }
    }
}

#[test]
fn back_calculation_bounds_the_integral_part_of_a_saturated_effort() {
    // At rest against friction with a limit below it, the demanded effort tends to the limit plus
    // ki e T: the integral part is the solution of x' = ki e + (limit - kp e - x)/T, with T = kp/ki.
    let limited = format!("{CONTINUOUS}; limit = 4 N");
    let run = controlled(0.3, &limited, 20.0);
    assert!(onsets(&run).is_empty());
    let last = run.last().unwrap();
    // The demand reaches 4 N before it is limited.
    assert!((last.effort("guide").unwrap() + 4.0).abs() < 1e-12);
    let reached = run.samples().iter().find(|s| s.effort("guide").unwrap() <= -4.0 + 1e-9).unwrap();
    // kp e + ki e t = 4 N at t = 0.5 s.
    assert!((reached.time - 0.5).abs() < 0.011, "{}", reached.time);
}

#[test]
fn efforts_as_formulas_over_the_measured_state_act_like_springs_and_dampers() {
    // m q'' = -200 q - 20 q' without friction: damped oscillation in closed form.
    let run = axis(MU)
        .forward()
        .friction(false)
        .drives("guide = -200 N/m*guide - 20 N s/m*d(guide)")
        .unwrap()
        .at("guide", START)
        .unwrap()
        .until(1.0)
        .run()
        .unwrap();
    let (decay, natural) = (KD / (2.0 * MASS), KP / MASS);
    let frequency = (natural - decay * decay).sqrt();
    for sample in run.samples() {
        let t = sample.time;
        let (s, c) = (frequency * t).sin_cos();
        let exact = START * (-decay * t).exp() * (c + decay / frequency * s);
        assert!((sample.position("guide").unwrap() - exact).abs() < 1e-11);
    }
}

#[test]
fn a_jump_of_a_formula_is_located() {
    // A constant force towards zero: parabolas between the zero crossings, with period 4 sqrt(2 m
    // q0/F).
    let run = axis(MU)
        .forward()
        .friction(false)
        .drives("guide = -8 N*sign(guide)")
        .unwrap()
        .at("guide", START)
        .unwrap()
        .until(2.0)
        .run()
        .unwrap();
    let quarter = (2.0 * MASS * START / 8.0).sqrt();
    for sample in run.samples() {
        let phase = sample.time / quarter;
        let (whole, part) =
            ((phase / 2.0 + 0.5).floor(), 2.0 * ((phase / 2.0 + 0.5).fract() - 0.5));
        let sign = if whole.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
        let exact = sign * START * (1.0 - part * part);
        assert!((sample.position("guide").unwrap() - exact).abs() < 1e-9, "{}", sample.time);
    }
}

#[test]
fn a_stop_condition_ends_the_run_at_its_instant() {
    // Frictionless free fall of a pendulum from 60 degrees: energy gives the rate at 10 degrees.
    let run = pendulum()
        .forward()
        .friction(false)
        .at("pivot", 60f64.to_radians())
        .unwrap()
        .stop("pivot < 10 deg")
        .unwrap()
        .run()
        .unwrap();
    let last = run.last().unwrap();
    let event = run.events().last().unwrap();
    assert!(matches!(event.kind, EventKind::Ends { switch: 0 }));
    assert_eq!(event.time, last.time);
    // The interpolation within a step, which locates the instant, keeps the tolerance of 1e-10.
    assert!((last.position("pivot").unwrap() - 10f64.to_radians()).abs() < 1e-9);
    let drop = 10f64.to_radians().cos() - 60f64.to_radians().cos();
    let rate = -(2.0 * BOB * GRAVITY * LENGTH * drop / INERTIA).sqrt();
    assert!((last.rate("pivot").unwrap() - rate).abs() < 1e-8);
    // A turning point between two rows is not missed: the condition holds for 0.2 ms only.
    let turn = pendulum()
        .forward()
        .friction(false)
        .at("pivot", 1e-3)
        .unwrap()
        .step(0.5)
        .stop("pivot < -0.99999999 mrad")
        .unwrap()
        .run()
        .unwrap();
    let half = std::f64::consts::PI * (INERTIA / (BOB * GRAVITY * LENGTH)).sqrt();
    assert!((turn.last().unwrap().time - half).abs() < 1e-3);
}

#[test]
fn an_equilibrium_of_a_pendulum_under_a_torque() {
    let torque: f64 = 3.0;
    let hangs = pendulum().equilibrium().unwrap().from("pivot = 2 rad").unwrap();
    let hangs = hangs.drives("pivot = 3 N m").unwrap().run().unwrap();
    let angle = (torque / (BOB * GRAVITY * LENGTH)).asin();
    assert!((hangs.position("pivot").unwrap() - angle).abs() < 1e-11);
    let natural = BOB * GRAVITY * LENGTH * angle.cos() / INERTIA;
    assert!((hangs.findings().stiffness[0] / natural - 1.0).abs() < 1e-9);
    assert_eq!(hangs.findings().stability.word(), "stable");
    // The equilibrium nearest to 3 rad is the inverted pendulum.
    let upright = pendulum().equilibrium().unwrap().from("pivot = 3 rad").unwrap();
    let upright = upright.nearest().run().unwrap();
    assert!((upright.position("pivot").unwrap() - std::f64::consts::PI).abs() < 1e-11);
    assert_eq!(upright.findings().stability.word(), "unstable");
    // A torque greater than gravity can balance.
    let turns = pendulum().equilibrium().unwrap().drives("pivot = 9 N m").unwrap();
    assert!(turns.run().unwrap_err().to_string().contains("no static equilibrium"));
}

#[test]
fn a_linear_model_of_a_pendulum_is_the_closed_form() {
    let (angle, rate) = (0.7_f64, 2.0);
    let model =
        pendulum().linearize().unwrap().from("pivot = 0.7 rad; d(pivot) = 2 rad/s").unwrap();
    let free = model.clone().friction(false).run().unwrap();
    let stiffness = -BOB * GRAVITY * LENGTH * angle.cos() / INERTIA;
    let a = &free.a;
    assert!((a[1][0] / stiffness - 1.0).abs() < 1e-9 && a[1][1].abs() < 1e-9);
    assert_eq!((a[0][0], a[0][1]), (0.0, 1.0));
    assert!((free.b[1][0] * INERTIA - 1.0).abs() < 1e-9);
    assert_eq!((free.c[0][0], free.c[0][1], free.d[0][0]), (1.0, 0.0, 0.0));
    // Sliding friction: the normal load is the reaction, |R| = m |(g - centripetal - tangential)|.
    let dry = model.drives("none").unwrap().run().unwrap();
    let acceleration = |angle: f64, rate: f64| {
        // Fixed point of the acceleration and the friction moment.
        let mut a = 0.0;
        for _ in 0..200 {
            let radial = BOB * (LENGTH * rate * rate + GRAVITY * angle.cos());
            let tangential = BOB * (LENGTH * a + GRAVITY * angle.sin());
            let moment = FRICTION_ARM * radial.hypot(tangential) * rate.signum();
            a = (-BOB * GRAVITY * LENGTH * angle.sin() - moment) / INERTIA;
        }
        a
    };
    let h = 1e-4;
    let by_angle = (acceleration(angle + h, rate) - acceleration(angle - h, rate)) / (2.0 * h);
    let by_rate = (acceleration(angle, rate + h) - acceleration(angle, rate - h)) / (2.0 * h);
    assert!((dry.drift[1] - acceleration(angle, rate)).abs() < 1e-9);
    assert!((dry.a[1][0] - by_angle).abs() < 1e-6 * by_angle.abs());
    assert!((dry.a[1][1] - by_rate).abs() < 1e-6);
    assert_eq!(dry.interfaces[0].1.word(), "sliding");
    // At rest, friction holds the pendulum, so the linear model has no motion.
    let held = pendulum().linearize().unwrap().from("pivot = 0 rad").unwrap().run();
    assert!(held.unwrap_err().to_string().contains("stick"));
}

/// A linear model agrees with differences of short simulations of a five-bar.
#[test]
fn a_linear_model_agrees_with_differences_of_simulations() {
    let robot = Robot::builtin("five-bar").unwrap();
    let model = robot.linearize().unwrap().at(0.13).unwrap().friction(false).run().unwrap();
    let efforts: Vec<String> =
        model.inputs.iter().map(|u| format!("{} = {:?} N m", u.name, u.value)).collect();
    let names: Vec<String> = model.states[..2].iter().map(|x| x.name.clone()).collect();
    let origin: Vec<f64> = model.states.iter().map(|x| x.value).collect();
    // The state after 1, 2, 4 and 8 ms.
    let times = [1e-3, 2e-3, 4e-3, 8e-3];
    let ends = |state: &[f64]| -> Vec<Vec<f64>> {
        let mut start: Vec<String> =
            names.iter().zip(state).map(|(name, x)| format!("{name} = {x:?} rad")).collect();
        start.extend(names.iter().zip(&state[2..]).map(|(n, x)| format!("d({n}) = {x:?} rad/s")));
        let run = robot
            .forward()
            .friction(false)
            .controller("none")
            .unwrap()
            .drives(&efforts.join(";"))
            .unwrap()
            .from(&start.join(";"))
            .unwrap()
            .until(times[3])
            .step(times[0])
            .tolerance(1e-13)
            .unwrap()
            .run()
            .unwrap();
        let at = |k: usize| {
            let sample = &run.samples()[k];
            let each = names.iter().map(|n| sample.position(n).unwrap());
            each.chain(names.iter().map(|n| sample.rate(n).unwrap())).collect()
        };
        [1, 2, 4, 8].map(at).to_vec()
    };
    let size = model.a.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let h = 1e-3;
    for k in 0..4 {
        let shifted = |amount: f64| {
            let mut state = origin.clone();
            state[k] += amount;
            ends(&state)
        };
        // Differences of order four of the final state with respect to the initial state: the
        // transition matrix Phi(t).
        let [a, b, c, d] = [shifted(h), shifted(-h), shifted(2.0 * h), shifted(-2.0 * h)];
        for i in 0..4 {
            // (Phi(t) - I)/t is A at t = 0 and analytic in t: extrapolation by Neville's scheme.
            let unit = f64::from(u8::from(i == k));
            let mut row: Vec<f64> = (0..4)
                .map(|n| {
                    let slope = (8.0 * (a[n][i] - b[n][i]) - (c[n][i] - d[n][i])) / (12.0 * h);
                    (slope - unit) / times[n]
                })
                .collect();
            for level in 1..4 {
                for n in 0..4 - level {
                    let (near, far) = (times[n], times[n + level]);
                    row[n] = (far * row[n] - near * row[n + 1]) / (far - near);
                }
            }
            let error = (row[0] - model.a[i][k]).abs();
            assert!(error < 1e-6 * size, "{i} {k}: {} {}", row[0], model.a[i][k]);
        }
    }
}

/// A pendulum with a torsion spring and a bushing: its equilibrium balances weight and springs, and the linear model
/// has the closed form.
#[test]
fn equilibrium_and_linear_model_with_springs() {
    let text = "gravity = [0, 0, -9.81]\n\
        [bodies.arm]\nmass = 2\ncom = [0.3, 0, 0]\ninertia = [0, 0.05, 0]\n\
        [joints.pivot]\ntype = \"R\"\nfrom = \"ground\"\nto = \"arm\"\naxis = \"-y\"\nactuated = true\n\
        [springs.coil]\njoint = \"pivot\"\nstiffness = \"20 N m/rad\"\nrest = \"30 deg\"\npreload = \"1 N m\"\n\
        damping = \"0.4 N m s/rad\"\n\
        [bushings.pad]\nfrom = \"ground\"\nto = \"arm\"\nstiffness = [0, 0, 0, 0, 5, 0]\n\
        [loads.none]\n";
    let robot = Robot::parse(text).unwrap();
    let rests = robot.equilibrium().unwrap().from("pivot = 0.1 rad").unwrap().run().unwrap();
    let angle = rests.position("pivot").unwrap();
    let weight: f64 = 2.0 * 9.81 * 0.3;
    let torque: f64 =
        1.0 - 20.0 * (angle - 30f64.to_radians()) - 5.0 * angle - weight * angle.cos();
    assert!(torque.abs() < 1e-9, "{angle}: {torque:e}");
    let inertia = 0.05 + 2.0 * 0.09;
    let at = format!("pivot = {angle:?} rad");
    let model = robot.linearize().unwrap().from(&at).unwrap().run().unwrap();
    let stiffness = -(20.0 + 5.0 - weight * angle.sin()) / inertia;
    assert!((model.a[1][0] / stiffness - 1.0).abs() < 1e-8, "{:?}", model.a);
    assert!((model.a[1][1] * inertia + 0.4).abs() < 1e-8, "{:?}", model.a);
}

/// Turning points on either side of the end of a step are found: windows of 20 us to 2 ms around
/// the smallest angle, for many phases of the steps.
#[test]
fn short_windows_of_stop_conditions_are_found() {
    let amplitude: f64 = 1e-3;
    let frequency = (BOB * GRAVITY * LENGTH / INERTIA).sqrt();
    let half = std::f64::consts::PI / frequency;
    for window in [2e-3, 4e-4, 1e-4, 2e-5] {
        // The condition holds below this value, for the given time around the turning point.
        let part = (0.5 * window * frequency).cos();
        for k in 0..6 {
            let step = 0.1 + 0.013 * f64::from(k);
            let run = pendulum()
                .forward()
                .friction(false)
                .at("pivot", amplitude)
                .unwrap()
                .step(step)
                .stop(&format!("pivot < {:?} mrad", -1e3 * amplitude * part))
                .unwrap()
                .until(1.9 * half)
                .run()
                .unwrap();
            let end = run.last().unwrap().time;
            assert!((end - half).abs() < window, "window {window}, step {step}: {end} {half}");
        }
    }
}

/// `<=` and `>=` hold at equality, `<` and `>` do not.
#[test]
fn conditions_with_equality_hold_at_equality() {
    let end = |condition: &str| {
        let run = pendulum().forward().friction(false).at("pivot", 0.0).unwrap();
        let run = run.stop(condition).unwrap().until(0.2).run().unwrap();
        run.last().unwrap().time
    };
    // The pendulum hangs at rest at zero.
    assert_eq!(end("pivot >= 0 deg"), 0.0);
    assert_eq!(end("pivot <= 0 deg"), 0.0);
    assert_eq!(end("pivot > 0 deg"), 0.2);
    assert_eq!(end("pivot < 0 deg"), 0.2);
}

/// An effort that jumps against the rate holds the mechanism at zero rate: the run ends early, and
/// the message states the cause and a remedy.
#[test]
fn chattering_formulas_are_named() {
    let run = pendulum()
        .forward()
        .friction(false)
        .at("pivot", 0.5)
        .unwrap()
        .drives("pivot = -20 N m*sign(d(pivot))")
        .unwrap()
        .until(3.0)
        .run()
        .unwrap();
    let error = run.ended().unwrap_err().to_string();
    assert!(error.contains("the formula of the effort of `pivot`"), "{error}");
    assert!(error.contains("tanh"), "{error}");
    // With the continuous formula, the simulation runs to its end.
    let smooth = pendulum()
        .forward()
        .friction(false)
        .at("pivot", 0.5)
        .unwrap()
        .drives("pivot = -20 N m*tanh(d(pivot)/(0.01 rad/s))")
        .unwrap()
        .until(0.5)
        .run();
    assert!(smooth.is_ok());
}

#[test]
fn a_rate_given_twice_is_refused() {
    let twice =
        |state: &str| pendulum().forward().from(state).map(|_| ()).map_err(|e| e.to_string());
    let error = twice("d(pivot) = 1 rad/s; d(pivot) = 2 rad/s").unwrap_err();
    assert!(error.contains("`d(pivot)` is given twice"), "{error}");
    assert!(twice("pivot = 0.1 rad; d(pivot) = 2 rad/s").is_ok());
}

/// At the kink of a formula, a linear model is rejected; beside the kink it exists.
#[test]
fn kinks_of_formulas_have_no_linear_model() {
    let at = |angle: &str| {
        let model = pendulum().linearize().unwrap().friction(false);
        let model = model.drives("pivot = -20 N m/rad*abs(pivot)").unwrap();
        model.from(&format!("pivot = {angle}")).unwrap().run()
    };
    let error = at("0 rad").unwrap_err().to_string();
    assert!(error.contains("the formula of the effort of `pivot` has a kink"), "{error}");
    let model = at("0.1 rad").unwrap();
    let stiffness = (-20.0 - BOB * GRAVITY * LENGTH * 0.1f64.cos()) / INERTIA;
    assert!((model.a[1][0] / stiffness - 1.0).abs() < 1e-8);
}

/// The error for a linear model with sticking friction names the interfaces that begin to slide,
/// and options that avoid the error.
#[test]
fn refusals_of_linear_models_name_interfaces() {
    let model = || {
        let model = pendulum().linearize().unwrap().drives("pivot = 5 N m").unwrap();
        model.from("pivot = 0.5 rad").unwrap()
    };
    let error = model().run().unwrap_err().to_string();
    assert!(error.contains("begin to slide") && error.contains("`pivot`"), "{error}");
    assert!(error.contains("--at") && error.contains("--friction off"), "{error}");
    model().friction(false).run().unwrap();
    model().from("pivot = 0.5 rad; d(pivot) = 1 rad/s").unwrap().run().unwrap();
}

/// Pendulum at 30 degrees: static friction widens the range of the holding torque by r mu_s |R| on
/// both sides. At 1 degree, friction alone holds the pendulum.
#[test]
fn equilibrium_with_static_friction() {
    let rests = pendulum().equilibrium().unwrap().from("pivot = 0.1 deg").unwrap();
    let rests = rests.run().unwrap();
    let holding = rests.findings().holding.clone().unwrap();
    assert_eq!(holding.rests_at_start, Some(true));
    let [range] = holding.ranges.as_slice() else { panic!("{holding:?}") };
    // At the bottom, the reaction is the weight: the range is symmetric.
    let half = FRICTION_ARM * BOB * GRAVITY;
    assert!((range.range.0 + half).abs() < 1e-9 * half, "{range:?} {half}");
    assert!((range.range.1 - half).abs() < 1e-9 * half, "{range:?} {half}");
    assert!(rests.to_string().contains("static friction holds the mechanism"), "{rests}");
    let moves = pendulum().equilibrium().unwrap().from("pivot = 60 deg").unwrap().run().unwrap();
    assert_eq!(moves.findings().holding.as_ref().unwrap().rests_at_start, Some(false));
    assert!(moves.findings().notes.is_empty());
    let frozen = pendulum().equilibrium().unwrap().from("pivot = 10 deg").unwrap();
    let frozen = frozen.drives("pivot = 1 N m*cos(t/1 s)").unwrap().run().unwrap();
    assert!(frozen.findings().notes[0].contains("change with time"), "{frozen}");
}

/// A hanging double pendulum whose two motors move both joints, with constant friction c of each motor: the greatest
/// efforts 25 c of the motors act together on both joints.
#[test]
fn equilibrium_with_motors_of_several_joints() {
    let text = r#"
gravity = [0, 0, -9.81]
[bodies.upper]
mass = 2
com = [0, 0, -0.2]
inertia = [0.02, 0.02, 0.002]
[bodies.lower]
mass = 1
com = [0, 0, -0.1]
inertia = [0.005, 0.005, 0.001]
[joints.pitch]
type = "R"
from = "ground"
to = "upper"
axis = "y"
[joints.roll]
type = "R"
from = "upper"
to = "lower"
at = [0, 0, -0.4]
axis = "y"
[actuators.left]
joints = { pitch = 1, roll = 1 }
ratio = 25
motor_friction = { constant = 0.01 }
[actuators.right]
joints = { pitch = 1, roll = -1 }
ratio = 25
motor_friction = { constant = 0.01 }
"#;
    let robot = Robot::parse(text).unwrap();
    let rests = robot.equilibrium().unwrap().from("pitch = 0.5 rad; roll = -0.2 rad").unwrap();
    let rests = rests.run().unwrap();
    assert!(rests.position("pitch").unwrap().abs() < 1e-9);
    let holding = rests.findings().holding.as_ref().unwrap();
    assert_eq!((holding.rests_at_start, holding.ranges.len()), (Some(false), 2), "{holding:?}");
    for range in &holding.ranges {
        let (low, high) = range.range;
        assert!((low + 0.5).abs() < 1e-9 && (high - 0.5).abs() < 1e-9, "{range:?}");
    }
}
