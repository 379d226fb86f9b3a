//! Mechanisms that several simulation tests use.

use super::*;
use stiction_core::forward::Forward;
use stiction_core::friction::Combine;
use stiction_core::kinematics::State;

/// Creates the symmetric 3-RPS robot at rest with its platform level at 0.55 m. The friction
/// coefficient is 0.12 in guides and pins and `balls` in the balls; all joints have viscous
/// friction.
pub fn rubbing_3rps(balls: f64) -> (Robot, Forward, State<f64>) {
    let robot = symmetric_3rps(Some([
        friction(0.12, 0.4 / 0.0125_f64.powi(2), Some(0.0125)),
        friction(0.12, 30.0, None),
        friction(balls, 0.1 / 0.025_f64.powi(2), Some(0.025)),
    ]));
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let state = model.assemble(&robot.initial_poses, &robot.coordinates, &level()).unwrap();
    (robot, model, state)
}

/// Returns coordinates of the symmetric 3-RPS robot with a level platform.
pub fn level() -> [Target<f64>; 3] {
    [0.55, 0.0, 0.0].map(|value| Target { value, rate: 0.0, acceleration: 0.0 })
}

/// Creates a collar of 1 kg on a guide along x, with two pads 20 mm apart and a friction
/// coefficient of 0.12. Its centre of mass is at the distance `offset` from the guide, m. The
/// collar jams for offsets beyond `span / (2 mu)`. No gravity.
pub fn collar(offset: f64) -> Mechanism {
    let x = along(Vec3::zero(), Vec3::unit(0));
    let interface = JointFriction {
        load: NormalLoadMap {
            bending_span: Some(0.02),
            combine: Combine::Pads,
            ..NormalLoadMap::force_only()
        },
        ..JointFriction::guide(Law::coulomb_viscous(0.12, 0.0))
    };
    MechanismBuilder::new("collar")
        .gravity(v(0.0, 0.0, 0.0))
        .body(
            BodySpec::new("collar")
                .mass(1.0)
                .com(v(0.0, offset, 0.0))
                .inertia(diagonal(1e-3, 1e-3, 1e-3)),
        )
        .joint(
            JointSpec::new("guide", JointType::Prismatic, "ground", "collar")
                .frames(x, x)
                .actuated()
                .friction(interface),
        )
        .build()
        .unwrap()
}
