//! A pendulum with a dry pivot is released and comes to rest: `cargo run --example forward`.

use stiction::{Error, EventKind, Robot};

fn main() -> Result<(), Error> {
    let robot = Robot::parse(include_str!("pendulum.toml"))?;
    let run = robot.forward().at("pivot", 0.05)?.drives("none")?.until(20.0).run()?;
    for event in run.events() {
        match event.kind {
            EventKind::Sticks { .. } => println!("{:7.4} s: {} sticks", event.time, event.at),
            EventKind::Slides { .. } => println!("{:7.4} s: {} slips", event.time, event.at),
            _ => {}
        }
    }
    let last = run.last()?;
    println!("at rest at {:.4} rad", last.position("pivot")?);
    println!("friction dissipated {:.4} J", last.dissipated("pivot")?);
    Ok(())
}
