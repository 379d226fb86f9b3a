//! Loads inside a plant: payloads that are picked up and released, and formulas over the measured
//! state.

use crate::importer::{Extracted, Importer, Version};
use stiction::{Robot, gallery};

const PERIOD: f64 = 1e-3;
const STEPS: u32 = 300;
const TOLERANCE: f64 = 1e-10;

/// Payloads change between and at communication points; the force has a kink where the tool turns around.
const LOAD: &str = r#"
[loads.pick]
tool.fx = "-20 N s/m*max(0 m/s, d(tool.x))"

[[loads.pick.payload]]
body = "tool"
mass = "0.4 kg"
from = "0.1003 s"
until = "0.2 s"
"#;

/// A barrier whose force has no value beyond 100 mm, and a block that turns back just before:
/// integration steps that would pass the barrier are repeated with a shorter step. With more energy
/// the block leaves the domain, which is an error.
#[test]
fn trial_steps_may_leave_the_domain_of_a_formula() {
    let text = "gravity = [0, 0, -9.81]\n[bodies.block]\nmass = 2\ncom = [0, 0, 0]\ninertia = [1, 1, 1]\n\
                [joints.X]\ntype = \"P\"\nfrom = \"ground\"\nto = \"block\"\naxis = \"x\"\nactuated = true\n\
                [loads.barrier.block]\nfx = \"1000 N*log(1 - X/(100 mm))\"\n";
    let robot = Robot::parse(text).unwrap();
    let export = robot.export().plant().load("barrier").from("X = 0; d(X) = 0").tolerance(1e-4);
    let unit = Extracted::new("barrier", &export);
    // The barrier absorbs up to 100 J.
    for (speed, returns) in [(9.9, true), (10.1, false)] {
        let plant = Importer::new(&unit, Version::Three { events: false });
        plant.set("start.X.speed", speed);
        plant.enter(0.0);
        assert_eq!(plant.exit(), 0, "{}", plant.said());
        let (mut most, mut back) = (0.0_f64, 0.0_f64);
        let outcome = (0..100_u32).try_for_each(|step| {
            plant.try_step(PERIOD * f64::from(step), PERIOD)?;
            most = most.max(plant.get("X.position"));
            back = back.max(-plant.get("X.speed"));
            Ok::<_, i32>(())
        });
        assert!(most < 0.1, "{most}");
        match returns {
            true => {
                assert!(outcome.is_ok(), "{}", plant.said());
                // The speed changes by 0.01 m/s between the steps about the start.
                assert!(most > 0.08 && (back - speed).abs() < 0.02, "{most} {back}");
            }
            false => {
                assert!(outcome.is_err());
                assert!(
                    plant.said().contains("the load on `block` cannot be evaluated"),
                    "{}",
                    plant.said()
                );
            }
        }
    }
}

fn effort(time: f64, position: f64, rate: f64, start: f64) -> f64 {
    let reference = start + 0.2 * (1.0 - (20.0 * time).cos());
    60.0 * (reference - position) - 2.0 * rate
}

#[test]
fn loads_act_as_in_forward() {
    let text = format!("{}{LOAD}", gallery::get("five-bar").unwrap());
    let robot = Robot::parse(&text).unwrap();
    let names: Vec<String> = robot.actuators().map(str::to_owned).collect();
    let mut at_rest = robot.forward().from("rest").unwrap().plant().unwrap();
    let at_rest = at_rest.sample().unwrap();
    let start: Vec<f64> = names.iter().map(|name| at_rest.position(name).unwrap()).collect();
    let own = start.clone();
    let run = robot
        .forward()
        .load("pick")
        .unwrap()
        .from("rest")
        .unwrap()
        .control_law(PERIOD, move |now| {
            let each = own.iter().zip(now.positions.iter().zip(now.rates));
            Ok(each.map(|(start, (q, v))| effort(now.time, *q, *v, *start)).collect())
        })
        .unwrap()
        .step(PERIOD)
        .until(PERIOD * f64::from(STEPS))
        .run()
        .unwrap();
    run.ended().unwrap();

    let unit = Extracted::new("loads", &robot.export().plant().load("pick").from("rest"));
    let plant = Importer::new(&unit, Version::Three { events: false });
    plant.enter(0.0);
    let mut apart = 0.0_f64;
    for step in 0..=STEPS {
        let time = PERIOD * f64::from(step);
        for (name, start) in names.iter().zip(&start) {
            let (position, rate) =
                (plant.get(&format!("{name}.position")), plant.get(&format!("{name}.speed")));
            let sample = &run.samples()[step as usize];
            let motion = sample.joint(name).unwrap();
            apart = apart.max((position - motion.position).abs()).max((rate - motion.rate).abs());
            plant.set(&format!("{name}.effort"), effort(time, position, rate, *start));
        }
        if step == 0 {
            assert_eq!(plant.exit(), 0, "{}", plant.said());
        }
        // A state that is saved while the part is carried includes the payload.
        if step == 150 {
            let state = plant.get_state();
            let read = plant.deserialize(&plant.serialize(state)).unwrap();
            assert_eq!(plant.set_state(read), 0);
            plant.free_state(read);
            plant.free_state(state);
        }
        if step < STEPS {
            plant.step(time, PERIOD);
        }
    }
    println!("{apart:.1e} apart");
    assert!(apart <= 10.0 * TOLERANCE, "{apart:.1e}");
}
