//! A slider-crank built by code, its mobility and its singularities: `cargo run --example check`.

use stiction::core::joint::JointType::{Prismatic, Revolute};
use stiction::core::spatial::{Mat3, Pose, Vec3};
use stiction::{BodySpec, Error, JointSpec, Robot};

fn main() -> Result<(), Error> {
    let at = |x| Pose::at(Vec3::new(x, 0.0, 0.0));
    // The slider moves along z of its joint frame, which points along x of the world.
    let along_x = Pose {
        rotation: Mat3::rotation(Vec3::new(0.0, 1.0, 0.0), std::f64::consts::FRAC_PI_2),
        position: Vec3::new(0.0, 0.0, 0.0),
    };
    let robot = Robot::builder("slider-crank")
        .gravity([0.0, -9.81, 0.0])
        .body(BodySpec::new("crank").mass(1.0).com(Vec3::new(0.05, 0.0, 0.0)))
        .body(BodySpec::new("rod").mass(1.0).com(Vec3::new(0.15, 0.0, 0.0)))
        .body(BodySpec::new("slider").mass(2.0))
        .joint(JointSpec::new("shaft", Revolute, "ground", "crank").actuated().start([1.0]))
        .joint(JointSpec::new("crankpin", Revolute, "crank", "rod").frames(at(0.1), at(0.0)))
        .joint(JointSpec::new("wristpin", Revolute, "rod", "slider").frames(at(0.3), at(0.0)))
        .joint(
            JointSpec::new("guide", Prismatic, "ground", "slider")
                .frames(along_x, along_x)
                .start([0.3]),
        )
        .motion("turn", "shaft = 1 rad + 1 rad/s*t; duration = 1 s")
        .build()?;
    let report = robot.check()?;
    println!("{report}");
    println!("redundant constraints: {}", report.redundant_constraints());
    Ok(())
}
