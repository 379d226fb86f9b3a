//! Section 4 of the paper: equations (22) to (27), 42 equations for 42 unknowns.
//!
//! Each leg has 14 unknowns in its own axes (t, y, u): u along the leg from R to S, y along the R
//! axis, t = y x u. F_R, M_R: ground on base at R; F_P, M_P: base on rod at P; tau: base on rod
//! along u; F_S: platform on rod at S. Units N and N m.

use super::kinematics::{LegMotion, leg_motion};
use super::robot::{Load, Motion, Robot};
use nalgebra::{DMatrix, DVector, Vector3};

/// Number of equations and of unknowns.
pub(super) const SIZE: usize = 42;
/// Number of unknowns per leg.
pub(super) const OF_LEG: usize = 14;

/// Offsets of the unknowns of a leg.
pub(super) mod unknown {
    pub(crate) const FR: usize = 0;
    pub(crate) const MR: usize = 3;
    pub(crate) const FP: usize = 5;
    pub(crate) const MP: usize = 7;
    pub(crate) const TAU: usize = 10;
    pub(crate) const FS: usize = 11;
}

/// Names of the unknowns of a leg, in order, with units.
pub(super) const NAMES: [(&str, &str); OF_LEG] = [
    ("F<sub>Rt</sub>", "N"),
    ("F<sub>Ry</sub>", "N"),
    ("F<sub>Ru</sub>", "N"),
    ("M<sub>Rt</sub>", "N m"),
    ("M<sub>Ru</sub>", "N m"),
    ("F<sub>Pt</sub>", "N"),
    ("F<sub>Py</sub>", "N"),
    ("M<sub>Pt</sub>", "N m"),
    ("M<sub>Py</sub>", "N m"),
    ("M<sub>Pu</sub>", "N m"),
    ("τ", "N"),
    ("F<sub>St</sub>", "N"),
    ("F<sub>Sy</sub>", "N"),
    ("F<sub>Su</sub>", "N"),
];

/// Variants of the equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// As printed: without F'_R in (22), so that nine unknowns appear in no equation.
    Literal,
    /// The printed equations with minimal repairs: F'_R restored and leg directions corrected. The
    /// rest is as printed: inertia forces include the rods' axial term alone; the arms are L_i / 2
    /// and L_i + L_j / 2 with L_j = 2 m and L_i + L_j the leg's length; moments of inertia forces
    /// have no arms and keep their printed sign.
    Printed,
    /// Complete Newton-Euler equations.
    Corrected,
}

/// A leg's axes t, y, u in the fixed frame.
fn axes(leg: &LegMotion) -> [Vector3<f64>; 3] {
    let (sin, cos) = leg.turn[0].sin_cos();
    [Vector3::new(cos, 0.0, -sin), Vector3::y(), Vector3::new(sin, 0.0, cos)]
}

/// Linear system of the equations at one instant.
pub(super) struct System {
    /// Coefficient matrix. Rows: for each leg (22), (23), (24), (25); then (26), (27); three each,
    /// in fixed axes.
    pub(super) matrix: DMatrix<f64>,
    /// Right-hand side without friction.
    pub(super) right: DVector<f64>,
    legs: [LegMotion; 3],
}

const E_Y: usize = 1;

impl System {
    /// Assembles the equations (22) to (27) for a motion under a load.
    pub(super) fn new(robot: &Robot, motion: &Motion, load: Load, form: Form) -> Self {
        let legs: [LegMotion; 3] = core::array::from_fn(|n| leg_motion(robot, n, motion));
        let mut system =
            Self { matrix: DMatrix::zeros(SIZE, SIZE), right: DVector::zeros(SIZE), legs };
        for n in 0..3 {
            system.leg_rows(robot, n, form);
        }
        system.platform_rows(robot, motion, load, form);
        system
    }

    /// Adds the force, and with an arm the moment, of an unknown to rows.
    fn put(&mut self, row: usize, column: usize, direction: Vector3<f64>, factor: f64) {
        for i in 0..3 {
            self.matrix[(row + i, column)] += factor * direction[i];
        }
    }

    fn set(&mut self, row: usize, value: Vector3<f64>) {
        self.right.rows_mut(row, 3).copy_from(&value);
    }

    fn leg_rows(&mut self, robot: &Robot, n: usize, form: Form) {
        use unknown::{FP, FR, FS, MP, MR, TAU};
        let leg = self.legs[n];
        let [t, y, u] = axes(&leg);
        let local = [t, y, u];
        let length = leg.length[0];
        let (row, first) = (12 * n, OF_LEG * n);
        // Distance of P from R: fixed in the base, or at the lower end of the rod, L_j = 2 m below
        // the ball.
        let pad = if form == Form::Corrected { robot.pad } else { length - 2.0 * robot.rod_com };
        for (i, axis) in local.into_iter().enumerate() {
            // (22) and (24): forces on leg and rod.
            if form != Form::Literal {
                self.put(row, first + FR + i, axis, 1.0);
            }
            self.put(row, first + FS + i, axis, 1.0);
            self.put(row + 6, first + FS + i, axis, 1.0);
            // (23) about R and (25) about P: moments.
            self.put(row + 3, first + FS + i, u.cross(&axis), length);
            self.put(row + 9, first + FS + i, u.cross(&axis), length - pad);
            self.put(row + 9, first + MP + i, axis, 1.0);
        }
        for (i, axis) in [t, y].into_iter().enumerate() {
            self.put(row + 6, first + FP + i, axis, 1.0);
        }
        for (i, axis) in [t, u].into_iter().enumerate() {
            self.put(row + 3, first + MR + i, axis, 1.0);
        }
        self.put(row + 6, first + TAU, u, 1.0);

        let weight = |mass: f64| Vector3::new(0.0, 0.0, -mass * robot.gravity);
        let [_, rod, base] = robot.mass;
        let [_, rod_inertia, base_inertia] = robot.inertia;
        let turning = leg.turn[2];
        match form {
            Form::Corrected => {
                let at = |c: [[f64; 3]; 2]| Vector3::new(c[0][2], 0.0, c[1][2]);
                // Inertia force less weight.
                let of_rod = at(leg.rod) * rod - weight(rod);
                let of_base = at(leg.base) * base - weight(base);
                let rod_arm = length - robot.rod_com;
                self.set(row, of_rod + of_base);
                let moment = u.cross(&of_rod) * rod_arm
                    + u.cross(&of_base) * robot.base_com
                    + y * ((rod_inertia + base_inertia) * turning);
                self.set(row + 3, moment);
                self.set(row + 6, of_rod);
                self.set(row + 9, u.cross(&of_rod) * (rod_arm - pad) + y * (rod_inertia * turning));
            }
            Form::Printed | Form::Literal => {
                let rod_length = 2.0 * robot.rod_com;
                let base_length = length - rod_length;
                let axial = leg.length[2] - (length - robot.rod_com) * leg.turn[1] * leg.turn[1];
                let inertia = u * (-rod * axial);
                let inertia_moment = |about: f64| y * (about * turning);
                self.set(row, -(weight(rod) + weight(base) + inertia));
                let moment = u.cross(&weight(rod)) * (base_length + rod_length / 2.0)
                    + u.cross(&weight(base)) * (base_length / 2.0)
                    + inertia_moment(rod_inertia + base_inertia);
                self.set(row + 3, -moment);
                self.set(row + 6, -(weight(rod) + inertia));
                let moment =
                    u.cross(&weight(rod)) * (rod_length / 2.0) + inertia_moment(rod_inertia);
                self.set(row + 9, -moment);
            }
        }
    }

    fn platform_rows(&mut self, robot: &Robot, motion: &Motion, load: Load, form: Form) {
        let row = 36;
        for n in 0..3 {
            let leg = self.legs[n];
            let [t, y, u] = axes(&leg);
            // S_n from O2; the y component is the difference of fixed points.
            let [ax, az] = super::robot::arm(robot, n, motion.pose[2]);
            let arm = Vector3::new(ax, robot.s[n][1], az);
            for (i, axis) in [t, y, u].into_iter().enumerate() {
                let column = OF_LEG * n + unknown::FS + i;
                self.put(row, column, axis, -1.0);
                self.put(row + 3, column, arm.cross(&axis), -1.0);
            }
        }
        let [mass, ..] = robot.mass;
        let [ax, az, turning] = motion.acceleration;
        let force = Vector3::new(load[0], load[1], load[2]);
        let moment = Vector3::new(load[3], load[4], load[5]);
        let needed = Vector3::new(mass * ax, 0.0, mass * (az + robot.gravity));
        self.set(row, needed - force);
        // beta = 90 deg - theta; the printed sign of M_lk is reversed.
        let sign = if form == Form::Corrected { 1.0 } else { -1.0 };
        let inertia = Vector3::new(0.0, -sign * robot.inertia[0] * turning, 0.0);
        self.set(row + 3, inertia - moment);
    }

    /// Adds joint friction to the right-hand side: for each leg P in N, R and S in N m, with the
    /// signs of the rates.
    pub(super) fn add_friction(&self, friction: &[[f64; 3]; 3], right: &mut DVector<f64>) {
        for (n, &[of_p, of_r, of_s]) in friction.iter().enumerate() {
            let row = 12 * n;
            let [_, _, u] = axes(&self.legs[n]);
            // Friction opposes the rate on the successor and has the opposite sign on the
            // predecessor: rod and base, base and ground, platform and rod.
            right[row + 3 + E_Y] += of_r - of_s;
            for i in 0..3 {
                right[row + 6 + i] += of_p * u[i];
            }
            right[row + 9 + E_Y] -= of_s;
            right[36 + 3 + E_Y] += of_s;
        }
    }

    /// The unknowns of leg n.
    pub(super) fn of_leg(unknowns: &DVector<f64>, n: usize) -> [f64; OF_LEG] {
        core::array::from_fn(|i| unknowns[OF_LEG * n + i])
    }

    /// Normal loads of the nine joints: lateral force of P, radial force of R, resultant of S.
    pub(super) fn loads(unknowns: &DVector<f64>) -> [[f64; 3]; 3] {
        use unknown::{FP, FR, FS};
        core::array::from_fn(|n| {
            let leg = Self::of_leg(unknowns, n);
            [
                leg[FP].hypot(leg[FP + 1]),
                leg[FR].hypot(leg[FR + 2]),
                leg[FS].hypot(leg[FS + 1]).hypot(leg[FS + 2]),
            ]
        })
    }

    /// Actuator forces, N.
    pub(super) fn drives(unknowns: &DVector<f64>) -> [f64; 3] {
        core::array::from_fn(|n| unknowns[OF_LEG * n + unknown::TAU])
    }
}

impl System {
    /// Equivalent equations for single bodies, the rod about P and the base about R: other linear
    /// combinations of the corrected equations. The solutions are identical; the least-squares
    /// result of an unsolvable system differs.
    pub(super) fn of_single_bodies(&self, robot: &Robot) -> Self {
        let mut rows = DMatrix::zeros(SIZE, SIZE + 1);
        rows.columns_mut(0, SIZE).copy_from(&self.matrix);
        rows.column_mut(SIZE).copy_from(&self.right);
        for n in 0..3 {
            let first = 12 * n;
            let [_, _, u] = axes(&self.legs[n]);
            let block = |at: usize| rows.fixed_rows::<3>(first + at).into_owned();
            let (rod, rod_moment) = (block(6), block(9));
            let base = block(0) - &rod;
            let base_moment = block(3) - rod_moment - u.cross_matrix() * rod * robot.pad;
            rows.fixed_rows_mut::<3>(first).copy_from(&base);
            rows.fixed_rows_mut::<3>(first + 3).copy_from(&base_moment);
        }
        Self {
            matrix: rows.columns(0, SIZE).into_owned(),
            right: rows.column(SIZE).into_owned(),
            legs: self.legs,
        }
    }

    /// Transverse force of leg n at its ball, F_S,t, N. It is the only unknown in the y component
    /// of (23), so it follows from the motion of the leg.
    pub(super) fn across(&self, n: usize) -> f64 {
        let (row, column) = (12 * n + 3 + E_Y, OF_LEG * n + unknown::FS);
        self.right[row] / self.matrix[(row, column)]
    }

    /// Replaces the platform's moment equation about y, which may be unsolvable, by the prescribed
    /// self-stress (-2, 1, 1) f of the printed robot.
    pub(super) fn with_self_stress(&self, f: f64) -> Self {
        let mut system =
            Self { matrix: self.matrix.clone(), right: self.right.clone(), legs: self.legs };
        system.matrix.row_mut(PITCH).fill(0.0);
        // Without friction the three forces along y equal (-2, 1, 1) f; their weighted sum is f.
        for (n, part) in [-2.0, 1.0, 1.0].into_iter().enumerate() {
            system.matrix[(PITCH, OF_LEG * n + unknown::FS + 1)] = part / 6.0;
        }
        system.right[PITCH] = f;
        system
    }

    /// Residual of the platform's moment equation about y, N m.
    pub(super) fn missing_pitch(&self, unknowns: &DVector<f64>, right: &DVector<f64>) -> f64 {
        right[PITCH] - (self.matrix.row(PITCH) * unknowns)[0]
    }
}

/// Row of the platform's moment equation about y.
pub(super) const PITCH: usize = 36 + 3 + E_Y;
