//! Data of the paper's robot, from section 6 of the paper, and of a regular (non-singular) variant
//! of this robot.
//!
//! The study's formulas use these numbers and not the model files, so that the comparison with the
//! engine also covers the data. Lengths in m, masses in kg.

use core::f64::consts::TAU;
use stiction_core::scalar::Scalar;

/// A 3-RPS robot with parallel R axes whose platform stays parallel to them.
#[derive(Clone, Debug)]
pub(super) struct Robot {
    /// Half of the platform's side S2 S3.
    pub(super) k: f64,
    /// R2 and R3 lie at -l and l from the plane of R1.
    pub(super) l: f64,
    /// The S joints in the platform's frame.
    pub(super) s: [[f64; 3]; 3],
    /// The R joints in the fixed frame.
    pub(super) b: [[f64; 3]; 3],
    /// y of the platform's centre of mass O2 in the fixed frame.
    pub(super) y: f64,
    /// Masses of platform, rod and base of a leg.
    pub(super) mass: [f64; 3],
    /// Moments of inertia of platform, rod and base about y through their centres of mass, kg m^2.
    pub(super) inertia: [f64; 3],
    /// The paper's m: distance from the S joint to the rod's centre of mass.
    pub(super) rod_com: f64,
    /// The paper's p: distance from the R joint to the base's centre of mass.
    pub(super) base_com: f64,
    /// Distance from the R joint to the reference point P of the prismatic joint's reaction.
    pub(super) pad: f64,
    /// Radii of the R and S joints.
    pub(super) radius: [f64; 2],
    /// Coefficient of Coulomb friction.
    pub(super) mu: f64,
    /// Coefficient of viscous friction at the surface, N s/m.
    pub(super) viscous: f64,
    /// Gravity, m/s^2.
    pub(super) gravity: f64,
    /// Leg lengths at zero input.
    pub(super) home: [f64; 3],
}

/// The planar pose (x, z, theta) of the platform, in m and rad; theta is the angle of its normal with
/// the x axis.
pub(super) type Pose<T> = [T; 3];

/// A pose with its first and second derivatives in time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub(super) pose: Pose<f64>,
    pub(super) rate: Pose<f64>,
    pub(super) acceleration: Pose<f64>,
}

/// A wrench on the platform at O2 in fixed axes: force, N, and moment, N m.
pub(super) type Load = [f64; 6];

/// No external load.
pub(super) const NO_LOAD: Load = [0.0; 6];
/// The load of section 6.
pub(super) const PRINTED_LOAD: Load = [100.0, 100.0, 100.0, 80.0, 80.0, 80.0];

impl Robot {
    /// The robot as printed: sides of 900 mm and 300 mm; masses, radii and coefficients of
    /// section 6. The paper does not give the point P.
    pub(super) fn printed() -> Self {
        let (k, l) = (0.150, 0.450);
        let r3 = 3.0_f64.sqrt();
        let level = |y: f64, x: f64| [x, y, 0.0];
        let mut robot = Self {
            k,
            l,
            s: [level(2.0 * k / r3, 0.0), level(-k / r3, k), level(-k / r3, -k)],
            b: [level(r3 * k, 0.0), level(0.0, l), level(0.0, -l)],
            y: k / r3,
            mass: [5.83, 2.07, 5.15],
            inertia: [0.0142, 0.0185, 0.0502],
            rod_com: 0.12848,
            base_com: 0.17465,
            pad: 0.3493,
            radius: [0.0125, 0.025],
            mu: 0.12,
            viscous: 0.02,
            gravity: 9.81,
            home: [0.0; 3],
        };
        robot.home = leg_lengths(&robot, [0.0, 0.505, TAU / 4.0]);
        robot
    }

    /// The regular variant: the platform's triangle is tilted by 30 deg about S2 S3, and the base
    /// is narrower to match.
    pub(super) fn regular() -> Self {
        let mut robot = Self::printed();
        let (k, l, tilt) = (robot.k, robot.l, (TAU / 12.0).tan());
        robot.s =
            [[0.0, k, k * tilt], [k, -k / 2.0, -k / 2.0 * tilt], [-k, -k / 2.0, -k / 2.0 * tilt]];
        robot.b = [[0.0, 0.225, 0.0], [l, 0.0, 0.0], [-l, 0.0, 0.0]];
        robot.y = 0.075;
        robot.home = leg_lengths(&robot, [0.060, 0.500, 65.0_f64.to_radians()]);
        robot
    }

    /// The motion (29) of the printed robot, relative to its home height of 505 mm.
    pub(super) fn printed_motion(time: f64) -> Motion {
        let (sin, cos) = (TAU * time).sin_cos();
        Motion {
            pose: [0.005 * sin, 0.505 + 0.010 * cos, TAU / 4.0],
            rate: [0.005 * TAU * cos, -0.010 * TAU * sin, 0.0],
            acceleration: [-0.005 * TAU * TAU * sin, -0.010 * TAU * TAU * cos, 0.0],
        }
    }

    /// The motion of the regular variant.
    pub(super) fn regular_motion(time: f64) -> Motion {
        let (sin, cos) = (TAU * time).sin_cos();
        let (turn_sin, turn_cos) = (TAU * time + 0.7).sin_cos();
        let swing = 5.0_f64.to_radians();
        Motion {
            pose: [
                0.060 + 0.020 * sin,
                0.500 + 0.030 * cos,
                65.0_f64.to_radians() + swing * turn_sin,
            ],
            rate: [0.020 * TAU * cos, -0.030 * TAU * sin, swing * TAU * turn_cos],
            acceleration: [
                -0.020 * TAU * TAU * sin,
                -0.030 * TAU * TAU * cos,
                -swing * TAU * TAU * turn_sin,
            ],
        }
    }
}

/// Vector O2 S_n between equations (3) and (4), in fixed axes, x and z: R_y(beta) s_n with beta =
/// 90 deg - theta.
pub(super) fn arm<T: Scalar>(robot: &Robot, n: usize, theta: T) -> [T; 2] {
    let (sin, cos) = theta.sin_cos();
    let [sx, _, sz] = robot.s[n].map(T::from_f64);
    [sx * sin + sz * cos, sz * sin - sx * cos]
}

/// Equations (4), (5) and (6): the vector R_n S_n, x and z; its y is zero.
pub(super) fn leg_vector<T: Scalar>(robot: &Robot, n: usize, [x, z, theta]: Pose<T>) -> [T; 2] {
    let [ax, az] = arm(robot, n, theta);
    [x + ax - T::from_f64(robot.b[n][0]), z + az - T::from_f64(robot.b[n][2])]
}

/// Distances R_n S_n at a pose.
pub(super) fn leg_lengths(robot: &Robot, pose: Pose<f64>) -> [f64; 3] {
    core::array::from_fn(|n| {
        let [dx, dz] = leg_vector(robot, n, pose);
        dx.hypot(dz)
    })
}
