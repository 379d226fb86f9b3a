//! Efforts of a five-bar along its motion, with friction and without: `cargo run --example inverse`.

use stiction::{Error, FrictionMode, Robot};

fn main() -> Result<(), Error> {
    let robot = Robot::builtin("five-bar")?;
    for sample in robot.inverse().friction(FrictionMode::Converged).step(0.05).samples()? {
        let sample = sample?;
        print!("{:5.2} s", sample.time);
        for actuator in robot.actuators() {
            let (with, without) = (sample.effort(actuator)?, sample.effort_frictionless(actuator)?);
            print!("  {actuator} {with:9.4} N m, {without:9.4} N m without friction");
        }
        println!();
    }
    Ok(())
}
