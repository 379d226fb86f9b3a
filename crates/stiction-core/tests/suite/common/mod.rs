//! Robots of the reference data, and functions that read these data.
#![allow(dead_code, unreachable_pub, reason = "each test uses a part")]

pub mod random;
pub mod simulated;

use std::collections::HashMap;
use stiction_core::dynamics::{AppliedLoad, LoadAxes};
use stiction_core::friction::{JointFriction, Law, NormalLoadMap};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AngleOrder, Coordinate, Target};
use stiction_core::mechanism::{BodyId, BodySpec, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::{Mat3, Pose, Vec3};

pub fn v(x: f64, y: f64, z: f64) -> Vec3<f64> {
    Vec3::new(x, y, z)
}

/// Returns the frame at `position` whose z axis points along `axis`.
pub fn along(position: Vec3<f64>, axis: Vec3<f64>) -> Pose<f64> {
    Pose { rotation: Mat3::between(Vec3::unit(2), axis), position }
}

pub fn diagonal(x: f64, y: f64, z: f64) -> Mat3<f64> {
    Mat3::diagonal(v(x, y, z))
}

/// Creates Coulomb and viscous friction at the first interface, with only the resultant force as
/// normal load.
pub fn friction(mu: f64, viscous: f64, radius: Option<f64>) -> JointFriction {
    JointFriction { radius, ..JointFriction::guide(Law::coulomb_viscous(mu, viscous)) }
}

pub struct Robot {
    pub mechanism: Mechanism,
    pub initial_poses: Vec<(BodyId, Pose<f64>)>,
    pub coordinates: Vec<Coordinate>,
}

/// Adds one RPS leg: its revolute axis is the y axis of the leg frame at `foot`, its ball is at
/// `tip` of the platform.
#[expect(clippy::too_many_arguments)]
fn rps_leg(
    builder: MechanismBuilder,
    n: usize,
    foot: Pose<f64>,
    tip: Pose<f64>,
    masses: [f64; 2],
    inertias: [Mat3<f64>; 2],
    slide_origin: f64,
    start: [f64; 2],
    rub: Option<&[JointFriction; 3]>,
) -> MechanismBuilder {
    let (base, rod) = (format!("leg{n}.base"), format!("leg{n}.rod"));
    let y = Vec3::unit(1);
    let in_leg = along(Vec3::zero(), y);
    let mut r = JointSpec::new(format!("leg{n}.R"), JointType::Revolute, "ground", &base)
        .frames(foot * in_leg, in_leg)
        .start([start[0]]);
    let mut p = JointSpec::new(format!("leg{n}.P"), JointType::Prismatic, &base, &rod)
        .frames(Pose::at(v(0.0, 0.0, slide_origin)), Pose::identity())
        .actuated()
        .start([start[1]]);
    let mut s = JointSpec::new(format!("leg{n}.S"), JointType::Spherical, &rod, "platform")
        .frames(Pose::identity(), tip);
    if let Some([on_r, on_p, on_s]) = rub {
        r = r.friction(on_r.clone());
        p = p.friction(on_p.clone());
        s = s.friction(on_s.clone());
    }
    builder
        .body(BodySpec::new(base).mass(masses[0]).com(v(0.0, 0.0, 0.17465)).inertia(inertias[0]))
        .body(BodySpec::new(rod).mass(masses[1]).com(v(0.0, 0.0, -0.12848)).inertia(inertias[1]))
        .joint(r)
        .joint(p)
        .joint(s)
}

/// Creates the symmetric 3-RPS robot of `reference/3rps_symmetric_*`.
pub fn symmetric_3rps(rub: Option<[JointFriction; 3]>) -> Robot {
    let mut builder = MechanismBuilder::new("3rps")
        .gravity(v(0.0, 0.0, -9.81))
        .body(BodySpec::new("platform").mass(5.83).inertia(diagonal(0.0142, 0.0142, 0.025)));
    for n in 0..3 {
        let turn = Mat3::about_axis(2, (120f64 * n as f64).to_radians().sin_cos());
        let place = |radius: f64| Pose { rotation: turn, position: turn * v(radius, 0.0, 0.0) };
        builder = rps_leg(
            builder,
            n + 1,
            place(0.45),
            place(0.15),
            [5.15, 2.07],
            [diagonal(0.0502, 0.0502, 0.002), diagonal(0.0185, 0.0185, 0.0005)],
            0.0,
            [(-0.3f64).atan2(0.55), 0.3f64.hypot(0.55)],
            rub.as_ref(),
        );
    }
    let mechanism = builder.build().unwrap();
    let platform = mechanism.body_id("platform").unwrap();
    let order = AngleOrder::XYZ;
    Robot {
        initial_poses: vec![(platform, Pose::at(v(0.0, 0.0, 0.55)))],
        coordinates: vec![
            Coordinate::Position { body: platform, axis: 2 },
            Coordinate::Angle { body: platform, order, index: 0 },
            Coordinate::Angle { body: platform, order, index: 1 },
        ],
        mechanism,
    }
}

/// Creates crank, rod and slider of reference R8; the crank turns at 10 rad/s.
pub fn slider_crank() -> Robot {
    let (crank, rod) = (0.1, 0.3);
    let z = Pose::identity();
    let pin = || friction(0.1, 0.0, Some(0.01));
    // Uniform rods; only the moment of inertia about z matters.
    let slim = |mass: f64, length: f64| {
        let j = mass * length * length / 12.0;
        diagonal(0.0, j, j)
    };
    let mechanism = MechanismBuilder::new("slider-crank")
        .gravity(v(0.0, -9.81, 0.0))
        .body(
            BodySpec::new("crank")
                .mass(1.0)
                .com(v(0.5 * crank, 0.0, 0.0))
                .inertia(slim(1.0, crank)),
        )
        .body(BodySpec::new("rod").mass(1.5).com(v(0.5 * rod, 0.0, 0.0)).inertia(slim(1.5, rod)))
        .body(BodySpec::new("slider").mass(2.0))
        .joint(
            JointSpec::new("A", JointType::Revolute, "ground", "crank")
                .frames(z, z)
                .actuated()
                .friction(pin()),
        )
        .joint(
            JointSpec::new("B", JointType::Revolute, "crank", "rod")
                .frames(Pose::at(v(crank, 0.0, 0.0)), z)
                .friction(pin()),
        )
        .joint(
            JointSpec::new("C", JointType::Revolute, "rod", "slider")
                .frames(Pose::at(v(rod, 0.0, 0.0)), z)
                .friction(pin()),
        )
        .joint(
            JointSpec::new("guide", JointType::Prismatic, "ground", "slider")
                .frames(along(Vec3::zero(), Vec3::unit(0)), along(Vec3::zero(), Vec3::unit(0)))
                .start([0.4])
                .friction(friction(0.1, 0.0, None)),
        )
        .build()
        .unwrap();
    let joint = mechanism.joint_id("A").unwrap();
    Robot {
        mechanism,
        initial_poses: vec![],
        coordinates: vec![Coordinate::Joint { joint, dof: 0 }],
    }
}

/// Creates the planar 3-RRR robot of reference R9.
pub fn planar_3rrr() -> Robot {
    let mut builder = MechanismBuilder::new("3rrr").gravity(v(0.0, -9.81, 0.0)).body(
        BodySpec::new("platform")
            .mass(2.5)
            .com(v(0.02, 0.03, 0.0))
            .inertia(diagonal(0.0, 0.0, 0.035)),
    );
    for (n, degrees) in [-150f64, -30.0, 90.0].into_iter().enumerate() {
        let direction = |radius: f64| {
            v(radius * degrees.to_radians().cos(), radius * degrees.to_radians().sin(), 0.0)
        };
        let (upper, lower) = (format!("leg{}.upper", n + 1), format!("leg{}.lower", n + 1));
        let inertia = |j| diagonal(0.0, 0.0, j);
        builder = builder
            .body(BodySpec::new(&upper).mass(1.2).com(v(0.18, 0.01, 0.0)).inertia(inertia(0.021)))
            .body(BodySpec::new(&lower).mass(0.9).com(v(0.22, -0.015, 0.0)).inertia(inertia(0.017)))
            .joint(
                JointSpec::new(format!("leg{}.R1", n + 1), JointType::Revolute, "ground", &upper)
                    .frames(Pose::at(direction(0.60)), Pose::identity())
                    // The direction towards the centre, then rotated to the side of the elbow.
                    .start([(degrees + 180.0 - 40.0).to_radians()])
                    .actuated(),
            )
            .joint(
                JointSpec::new(format!("leg{}.R2", n + 1), JointType::Revolute, &upper, &lower)
                    .frames(Pose::at(v(0.40, 0.0, 0.0)), Pose::identity())
                    .start([80f64.to_radians()]),
            )
            .joint(
                JointSpec::new(format!("leg{}.R3", n + 1), JointType::Revolute, &lower, "platform")
                    .frames(Pose::at(v(0.45, 0.0, 0.0)), Pose::at(direction(0.15))),
            );
    }
    let mechanism = builder.build().unwrap();
    let body = mechanism.body_id("platform").unwrap();
    Robot {
        initial_poses: vec![(body, Pose::identity())],
        coordinates: vec![
            Coordinate::Position { body, axis: 0 },
            Coordinate::Position { body, axis: 1 },
            Coordinate::Angle { body, order: AngleOrder::XYZ, index: 2 },
        ],
        mechanism,
    }
}

/// Returns the sine `mean + amplitude sin(rate t + phase)` with its derivatives.
pub fn sine(mean: f64, amplitude: f64, rate: f64, phase: f64, t: f64) -> Target<f64> {
    let (s, c) = (rate * t + phase).sin_cos();
    Target {
        value: mean + amplitude * s,
        rate: amplitude * rate * c,
        acceleration: -amplitude * rate * rate * s,
    }
}

const TURN: f64 = std::f64::consts::TAU;
const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

/// Returns the reference motion of the symmetric 3-RPS robot at time `t`.
pub fn symmetric_motion(t: f64) -> [Target<f64>; 3] {
    [
        sine(0.55, 0.03, TURN, QUARTER, t),
        sine(0.0, 0.10, TURN, 0.0, t),
        sine(0.0, 0.08, 2.0 * TURN, QUARTER, t),
    ]
}

/// Returns the reference load of the symmetric 3-RPS robot.
pub fn symmetric_load(robot: &Robot) -> AppliedLoad<f64> {
    AppliedLoad {
        body: robot.mechanism.body_id("platform").unwrap(),
        point: Vec3::zero(),
        axes: LoadAxes::World,
        force: v(20.0, -30.0, -100.0),
        moment: v(5.0, 8.0, 3.0),
    }
}

/// Creates the regular variant of the robot of Zhang et al. 2018.
pub fn regular_twin(mu: f64, viscous: f64) -> Robot {
    let mut builder = MechanismBuilder::new("twin")
        .gravity(v(0.0, 0.0, -9.81))
        .body(BodySpec::new("platform").mass(5.83).inertia(diagonal(0.0142, 0.0142, 0.025)));
    let k = 0.15f64;
    let tilt = 0.5 * k / 3f64.sqrt();
    let feet = [v(0.0, 0.225, 0.0), v(0.45, 0.0, 0.0), v(-0.45, 0.0, 0.0)];
    let tips = [v(0.0, k, 2.0 * tilt), v(k, -0.5 * k, -tilt), v(-k, -0.5 * k, -tilt)];
    let rub = [
        friction(mu, viscous, Some(0.0125)),
        friction(mu, viscous, None),
        friction(mu, viscous, Some(0.025)),
    ];
    let starts = [[0.1, 0.25], [-0.4, 0.16], [0.5, 0.3]];
    for n in 0..3 {
        builder = rps_leg(
            builder,
            n + 1,
            Pose::at(feet[n]),
            Pose::at(tips[n]),
            [5.15, 2.07],
            [diagonal(0.0502, 0.0502, 0.002), diagonal(0.0185, 0.0185, 0.0005)],
            0.3493,
            starts[n],
            Some(&rub),
        );
    }
    let mechanism = builder.build().unwrap();
    let platform = mechanism.body_id("platform").unwrap();
    let rotation = Mat3::about_axis(1, 25f64.to_radians().sin_cos());
    Robot {
        initial_poses: vec![(platform, Pose { rotation, position: v(0.06, 0.075, 0.5) })],
        coordinates: vec![
            Coordinate::Position { body: platform, axis: 0 },
            Coordinate::Position { body: platform, axis: 2 },
            Coordinate::Angle { body: platform, order: AngleOrder::XYZ, index: 1 },
        ],
        mechanism,
    }
}

/// Creates the robot of Zhang et al. 2018 as printed: base 900 mm, platform 300 mm. All six
/// coordinates of the platform are prescribed, because at first order nothing constrains the roll.
pub fn printed_robot(rub: bool) -> Robot {
    let mut builder = MechanismBuilder::new("zhang2018")
        .gravity(v(0.0, 0.0, -9.81))
        .body(BodySpec::new("platform").mass(5.83).inertia(diagonal(0.0142, 0.0142, 0.025)));
    let (k, l) = (0.15f64, 0.45);
    let root = 3f64.sqrt();
    let feet = [v(0.0, root * k, 0.0), v(l, 0.0, 0.0), v(-l, 0.0, 0.0)];
    let tips = [v(0.0, 2.0 * k / root, 0.0), v(k, -k / root, 0.0), v(-k, -k / root, 0.0)];
    let interfaces = [
        friction(0.12, 0.02, Some(0.0125)),
        friction(0.12, 0.02, None),
        friction(0.12, 0.02, Some(0.025)),
    ];
    for n in 0..3 {
        builder = rps_leg(
            builder,
            n + 1,
            Pose::at(feet[n]),
            Pose::at(tips[n]),
            [5.15, 2.07],
            [diagonal(0.0502, 0.0502, 0.002), diagonal(0.0185, 0.0185, 0.0005)],
            0.3493,
            [[0.0, 0.16], [-0.53, 0.24], [0.53, 0.24]][n],
            rub.then_some(&interfaces),
        );
    }
    let mechanism = builder.build().unwrap();
    let body = mechanism.body_id("platform").unwrap();
    let order = AngleOrder::XYZ;
    Robot {
        initial_poses: vec![(body, Pose::at(v(0.0, k / root, 0.515)))],
        coordinates: vec![
            Coordinate::Position { body, axis: 0 },
            Coordinate::Position { body, axis: 1 },
            Coordinate::Position { body, axis: 2 },
            Coordinate::Angle { body, order, index: 0 },
            Coordinate::Angle { body, order, index: 1 },
            Coordinate::Angle { body, order, index: 2 },
        ],
        mechanism,
    }
}

/// Returns the motion (29) of Zhang et al. 2018 at time `t`, with the remaining coordinates
/// constant.
pub fn printed_motion(t: f64) -> [Target<f64>; 6] {
    let still = |value| Target { value, rate: 0.0, acceleration: 0.0 };
    [
        sine(0.0, 0.005, TURN, 0.0, t),
        still(0.15 / 3f64.sqrt()),
        sine(0.505, 0.010, TURN, QUARTER, t),
        still(0.0),
        still(0.0),
        still(0.0),
    ]
}

/// Returns the reference motion of the regular variant at time `t`; the pitch angle is 90 deg minus
/// theta.
pub fn twin_motion(t: f64) -> [Target<f64>; 3] {
    [
        sine(0.060, 0.020, TURN, 0.0, t),
        sine(0.500, 0.030, TURN, QUARTER, t),
        sine(25f64.to_radians(), -5f64.to_radians(), TURN, 0.7, t),
    ]
}

/// Reads a reference table: rows of named cells.
pub fn table(name: &str) -> Vec<HashMap<String, String>> {
    let path = format!("{}/../../reference/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            header.iter().map(|h| h.to_string()).zip(line.split(',').map(str::to_owned)).collect()
        })
        .collect()
}

/// Reads a number from a row.
pub fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {}", row[column]))
}
