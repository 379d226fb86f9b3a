//! Loads inside a plant: payloads that are picked up and placed, and formulas over the measured state.

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
        // A state that is saved while the part is carried continues with it.
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
