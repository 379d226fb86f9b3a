//! A plant with an external controller moves as `forward` does with the same controller inside.

use crate::importer::{Extracted, Importer, Version};
use std::f64::consts::TAU;
use stiction::{EventKind, Robot};

const PERIOD: f64 = 1e-3;
const STEPS: u32 = 600;

/// Relative error of an integration step of `forward`. The states of both simulations may differ by
/// ten times this value.
const TOLERANCE: f64 = 1e-10;

/// Amplitude of the reference, rad or m.
#[derive(Clone, Copy)]
struct Law {
    amplitude: f64,
    proportional: f64,
    derivative: f64,
}

impl Law {
    /// Effort at a time, s, for a position and a rate. The reference moves forth, waits, moves back
    /// and waits, each for a tenth of a second, so that joints come to rest.
    fn effort(&self, time: f64, start: f64, (position, rate): (f64, f64)) -> f64 {
        let phase = (time / 0.1).rem_euclid(4.0);
        let (sine, cosine) = (0.5 * TAU * phase.fract()).sin_cos();
        let (part, change) = match phase as u32 {
            0 => (0.5 * (1.0 - cosine), 0.25 * TAU * sine / 0.1),
            1 => (1.0, 0.0),
            2 => (0.5 * (1.0 + cosine), -0.25 * TAU * sine / 0.1),
            _ => (0.0, 0.0),
        };
        let reference = start + self.amplitude * part;
        let speed = self.amplitude * change;
        self.proportional * (reference - position) + self.derivative * (speed - rate)
    }
}

/// Compares both simulations. The robot starts at rest at the first position of its motion.
fn compare(robot: &str, changes: &[&str], law: Law) {
    let robot = Robot::builtin(robot).unwrap();
    let robot = changes.iter().fold(robot, |robot, change| robot.with(change).unwrap());
    let names: Vec<String> = robot.actuators().map(str::to_owned).collect();
    let mut at_rest = robot.forward().friction(true).from("rest").unwrap().plant().unwrap();
    let at_rest = at_rest.sample().unwrap();
    let start: Vec<f64> = names.iter().map(|name| at_rest.position(name).unwrap()).collect();
    let own = start.clone();
    let run = robot
        .forward()
        .friction(true)
        .from("rest")
        .unwrap()
        .tolerance(TOLERANCE)
        .unwrap()
        .control_law(PERIOD, move |now| {
            let each = own.iter().zip(now.positions.iter().copied().zip(now.rates.iter().copied()));
            Ok(each.map(|(start, at)| law.effort(now.time, *start, at)).collect())
        })
        .unwrap()
        .step(PERIOD)
        .until(PERIOD * f64::from(STEPS))
        .run()
        .unwrap();
    run.ended().unwrap();
    let onsets: Vec<f64> = run
        .events()
        .iter()
        .filter(|event| matches!(event.kind, EventKind::Sticks { .. } | EventKind::Slides { .. }))
        .map(|event| event.time)
        .collect();
    let sticks = run.events().iter().filter(|e| matches!(e.kind, EventKind::Sticks { .. })).count();
    assert!(sticks >= 3 && onsets.len() > sticks, "{:?}", run.events());

    let export = robot.export().plant().friction(true).from("rest").tolerance(TOLERANCE);
    let unit = Extracted::new(&format!("{}-forward", robot.name()), &export);
    for version in [Version::Two, Version::Three { events: false }, Version::Three { events: true }]
    {
        let plant = Importer::new(&unit, version);
        plant.enter(0.0);
        let control = |time: f64| {
            for (name, start) in names.iter().zip(&start) {
                let at =
                    (plant.get(&format!("{name}.position")), plant.get(&format!("{name}.speed")));
                plant.set(&format!("{name}.effort"), law.effort(time, *start, at));
            }
        };
        control(0.0);
        assert_eq!(plant.exit(), 0, "{}", plant.said());
        let mut found = Vec::new();
        let (mut apart, mut moved) = (0.0_f64, 0.0_f64);
        for step in 0..STEPS {
            let (mut time, end) = (PERIOD * f64::from(step), PERIOD * f64::from(step + 1));
            control(time);
            while time < end {
                let (reached, event, early) = plant.step(time, end - time);
                assert_eq!(early, reached < end);
                if event {
                    found.push(plant.get("events.time"));
                    assert!(found.last().is_some_and(|last| *last <= reached));
                    assert_eq!(unsafe { stiction_fmu::fmi3::fmi3EnterEventMode(plant.handle) }, 0);
                    assert_eq!(plant.handle_event(), 0);
                }
                time = reached;
            }
            let sample = &run.samples()[step as usize + 1];
            for (name, start) in names.iter().zip(&start) {
                let motion = sample.joint(name).unwrap();
                let position = plant.get(&format!("{name}.position"));
                let rate = plant.get(&format!("{name}.speed"));
                apart = apart.max((position - motion.position).abs());
                apart = apart.max((rate - motion.rate).abs());
                moved = moved.max((position - start).abs());
            }
        }
        println!("{version:?}: {apart:.1e} apart, moved by {moved:.2e}, {} onsets", onsets.len());
        assert!(apart <= 10.0 * TOLERANCE && moved > 0.5 * law.amplitude, "{apart} {moved}");
        assert_eq!(plant.integer("events.count"), i32::try_from(onsets.len()).unwrap());
        assert!((plant.get("events.time") - onsets[onsets.len() - 1]).abs() < 1e-6);
        if version == (Version::Three { events: true }) {
            // Several interfaces may stick at one instant, which ends one step.
            for onset in &onsets {
                assert!(found.iter().any(|time| (time - onset).abs() < 1e-6), "{onset} {found:?}");
            }
        }
    }
}

#[test]
fn a_five_bar_moves_as_in_forward() {
    let law = Law { amplitude: 0.1, proportional: 600.0, derivative: 8.0 };
    // Dry friction of 0.2 N m in each motor.
    let changes = ["left_motor", "right_motor"].map(|motor| {
        format!("joints.{motor}.friction = {{ mu = 0.1, radius = \"10 mm\", preload = \"200 N\" }}")
    });
    compare("five-bar", &changes.each_ref().map(String::as_str), law);
}

#[test]
fn a_3rps_moves_as_in_forward() {
    let law = Law { amplitude: 0.005, proportional: 2e5, derivative: 4e3 };
    let changes =
        ["legs.R.friction.mu = 0", "legs.S.friction.mu = 0", "legs.P.friction.preload = 500 N"];
    compare("3rps", &changes, law);
}
