//! Solution along a path from friction with which everything sticks.
//!
//! With a large multiple of the friction coefficients everything sticks, and this solution is known.
//! Surfaces creep here, in proportion to their friction. For given friction limits the frictions are
//! therefore unique, and they are bounded however large the limits are, so that a solution exists at
//! every multiple (Brouwer's fixed-point theorem), and a path of solutions leads from the known one to
//! full friction. On its way the path may turn back. The multiple is therefore an unknown like the
//! frictions, and the parameter is the length of the path (pseudo-arclength continuation, Keller
//! 1977).
//!
//! The path consists of pieces on each of which the same interfaces stick. A piece ends where an
//! interface begins to slide or stops, and the next piece begins with the changed mode. The
//! direction follows from the determinant of the extended system, whose sign changes neither at
//! turning points nor between pieces.
//!
//! At the end, the creep is removed if the residual rates exceed their tolerance.
//!
//! Equation (D10) of the book's theory.

use super::laws::MemberLaw;
use super::newton::STAGNATED;
use super::problem::Complementarity;
use nalgebra::{DMatrix, DVector};

/// Multiple of the friction coefficients at the start of the path.
const STUCK: f64 = 1e9;
/// Creep rate per friction force, relative to the largest change of rate that a friction force causes
/// at its own surface.
const CREEP: f64 = 1e-7;
/// Relative difference between the creep of the first and the last unknown. Without this difference,
/// several interfaces of a symmetric mechanism would change their modes at the same point.
const UNEVEN: f64 = 0.5;
/// First step along the path. Lengths are in units of the largest friction, and of the logarithm of the
/// multiple.
const FIRST: f64 = 0.5;
/// Longest step along the path.
const LONGEST: f64 = 2.0;
/// Step below which the continuation fails.
const SHORTEST: f64 = 1e-10;
/// Factor by which a step is longer than a successful previous one.
const GROWTH: f64 = 1.5;
/// Largest number of points of the path that are computed, failed ones and those of searches included.
const TRIALS: usize = 1500;
/// Largest number of Newton steps of a correction.
const CORRECTIONS: usize = 12;
/// Residual, relative to the largest friction, at which a correction ends.
const EXACT: f64 = 1e-14;
/// Residual, relative to the largest friction, at which a correction succeeds if it no longer decreases.
const ON_PATH: f64 = 1e-11;
/// Largest distance between consecutive points, in steps. Farther points belong to other paths.
const FARTHEST: f64 = 1.1;
/// Largest number of steps with which the end of a piece is located.
const SEARCHES: usize = 60;
/// Excess of friction over its limit at which an interface no longer sticks, relative to the largest
/// friction.
const VIOLATED: f64 = 1e-9;
/// Rate against the friction at which an interface no longer slides, relative to the creep under the
/// largest friction.
const BACKWARD: f64 = 1e-3;
/// Relative uncertainty of the end of a piece below which the search for it fails.
const LOCATABLE: f64 = 1e-12;
/// Margin down to which the end of a piece is located.
const LOCATED: f64 = -10.0;

impl Complementarity<'_> {
    /// Computes a solution by continuation along a path from [`STUCK`] times the friction coefficients
    /// to full friction. If the solution branch from zero friction ends before full friction
    /// (jamming), the friction that stops the motion lies on this path. Returns `None` if a friction
    /// law is not dry, because its interface sticks at no multiple, or if the continuation fails.
    pub(super) fn follow_path(&self) -> Option<Vec<f64>> {
        if !self.members.iter().all(|member| matches!(member.law, MemberLaw::Dry(_))) {
            return None;
        }
        let n = self.count();
        let most = (0..n).fold(0.0_f64, |m, i| m.max(-self.compliance[i * n + i]));
        let mut creeping = self.clone();
        creeping.slack = f64::INFINITY;
        for i in 0..n {
            let uneven = 1.0 + UNEVEN * i as f64 / n as f64;
            creeping.compliance[i * n + i] -= CREEP * most * uneven;
        }
        let reached = Path::start(&creeping, CREEP * most)?.end()?;
        if self.residual(&reached, 1.0, None).relative() <= STAGNATED {
            // Without creep, nearly indeterminate frictions would become large.
            return Some(reached);
        }
        let mut exact = reached;
        self.newton(&mut exact, 1.0).then_some(exact)
    }
}

/// Point on the path, with the direction in which the path continues.
struct Path<'a> {
    problem: &'a Complementarity<'a>,
    /// Creep rate per friction force, m/s or m/s^2 per newton.
    creep: f64,
    /// Friction forces, N, and the logarithm of the multiple of the friction coefficients.
    x: DVector<f64>,
    /// True for each member that sticks on this piece of the path.
    sticks: Vec<bool>,
    /// Largest friction, N, the unit of forces in lengths.
    unit: f64,
    /// Unit tangent; frictions are in units of `unit`.
    tangent: DVector<f64>,
    /// Sign of the determinant of the extended system along the path; zero at the start.
    sign: f64,
    /// Number of points computed so far.
    trials: usize,
}

/// Point on the path or on the continuation of its present piece.
struct Candidate {
    x: DVector<f64>,
    /// Member with the least margin to the end of its mode.
    member: usize,
    /// This margin, see [`Path::least_margin`].
    margin: f64,
}

impl<'a> Path<'a> {
    /// Computes the start of the path. Returns `None` if something slides there.
    fn start(problem: &'a Complementarity<'a>, creep: f64) -> Option<Self> {
        let n = problem.count();
        let compliance = DMatrix::from_row_slice(n, n, &problem.compliance);
        let stuck = compliance.lu().solve(&-DVector::from_column_slice(&problem.free))?;
        let sticks = vec![true; problem.members.len()];
        let x = stuck.push(STUCK.ln());
        let mut tangent = DVector::zeros(n + 1);
        tangent[n] = -1.0;
        let mut path = Self { problem, creep, x, sticks, unit: 0.0, tangent, sign: 0.0, trials: 0 };
        path.turn()?;
        (path.least_margin(&path.x).1 >= -1.0).then_some(path)
    }

    /// Computes the residual of the friction laws in units of [`Self::unit`], and its derivatives with
    /// the tangent as last row (the extended system).
    fn extended(&self, x: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.problem.count();
        let (multiple, mut rows) = (x[n].exp(), Vec::new());
        let modes = (multiple, Some(&self.sticks[..]));
        let residual = self.problem.residual_in_modes(&x.as_slice()[..n], modes, Some(&mut rows));
        let values = DVector::from_column_slice(&residual.values) / self.unit;
        let by_multiple = DVector::from_column_slice(&residual.by_part) * (multiple / self.unit);
        let mut matrix = DMatrix::zeros(n + 1, n + 1);
        matrix.view_mut((0, 0), (n, n)).copy_from(&DMatrix::from_row_slice(n, n, &rows));
        matrix.view_mut((0, n), (n, 1)).copy_from(&by_multiple);
        matrix.row_mut(n).copy_from(&self.tangent.transpose());
        (values, matrix)
    }

    /// Returns the member with the least margin at a point, and the margin. Below -1 its mode has ended:
    /// margins are in units of [`VIOLATED`] times the largest friction for interfaces that stick, and
    /// of [`BACKWARD`] times the creep for those that slide.
    fn least_margin(&self, x: &DVector<f64>) -> (usize, f64) {
        let n = self.problem.count();
        let modes = (x[n].exp(), Some(&self.sticks[..]));
        let residual = self.problem.residual_in_modes(&x.as_slice()[..n], modes, None);
        let margin = |member: usize| {
            let excess = residual.excess[member];
            if self.sticks[member] {
                return -excess / (VIOLATED * self.unit);
            }
            let factor = self.problem.rate_factor(&self.problem.members[member].places);
            excess / (BACKWARD * factor * self.creep * self.unit)
        };
        let each = (0..self.sticks.len()).map(|member| (member, margin(member)));
        each.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
    }

    /// Updates the unit of forces and the direction of the path at the present point.
    fn turn(&mut self) -> Option<()> {
        let n = self.problem.count();
        self.unit = self.x.rows(0, n).amax().max(f64::MIN_POSITIVE);
        let (_, matrix) = self.extended(&self.x);
        let mut right = DVector::zeros(n + 1);
        right[n] = 1.0;
        let factors = matrix.lu();
        let along = factors.solve(&right)?.normalize();
        // The product of the pivots may be too small for a number. The determinant with the new
        // tangent as last row has the same sign, because the tangents form an acute angle.
        let signs = factors.u().diagonal().map(f64::signum);
        let sign = signs.product() * factors.p().determinant::<f64>();
        if self.sign == 0.0 {
            self.sign = sign;
        }
        self.tangent = if sign == self.sign { along } else { -along };
        self.tangent.iter().all(|t| t.is_finite()).then_some(())
    }

    /// Moves a point onto the path: perpendicularly to the tangent or, if `at_end`, at its multiple.
    /// Returns `None` if this fails.
    fn corrected(&self, mut x: DVector<f64>, at_end: bool) -> Option<DVector<f64>> {
        let n = self.problem.count();
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            let (values, mut matrix) = self.extended(&x);
            let relative = values.amax();
            if relative <= EXACT || (relative <= ON_PATH && relative >= before) {
                return Some(x);
            }
            before = relative;
            if at_end {
                matrix.row_mut(n).fill(0.0);
                matrix[(n, n)] = 1.0;
            }
            let change = matrix.lu().solve(&values.push(0.0))?;
            x -= self.newtons(change);
            if !x.iter().all(|x| x.is_finite()) {
                return None;
            }
        }
        None
    }

    /// Returns the point of the path at the distance `length` along the tangent, if it is found.
    fn ahead(&mut self, length: f64) -> Option<Candidate> {
        self.trials += 1;
        let x = self.corrected(&self.x + self.newtons(&self.tangent * length), false)?;
        let (member, margin) = self.least_margin(&x);
        (self.distance(&x) <= FARTHEST * length).then_some(Candidate { x, member, margin })
    }

    /// Returns the end of the present piece of the path, if it is before the point `high` at the
    /// distance `length`; otherwise returns `high`.
    fn end_of_piece(&mut self, mut high: Candidate, mut length: f64) -> Option<Candidate> {
        let (mut low, mut above) = (0.0, self.least_margin(&self.x).1);
        for search in 0..SEARCHES {
            if high.margin >= LOCATED {
                return Some(high);
            }
            // Secant steps, alternating with bisection.
            let aim = 0.5 * (LOCATED - 1.0);
            let secant = low + (length - low) * (above - aim) / (above - high.margin);
            let is_inside = secant > low && secant < length;
            let middle = if search % 2 == 0 && is_inside { secant } else { 0.5 * (low + length) };
            if length - low < LOCATABLE * length {
                break;
            }
            let found = self.ahead(middle)?;
            if found.margin < -1.0 {
                (high, length) = (found, middle);
            } else {
                (low, above) = (middle, found.margin);
            }
        }
        // The margin jumps: the correction has found another path.
        None
    }

    /// Converts the frictions of a change from [`Self::unit`] to newtons.
    fn newtons(&self, mut change: DVector<f64>) -> DVector<f64> {
        let n = self.problem.count();
        change.rows_mut(0, n).scale_mut(self.unit);
        change
    }

    /// Distance of a point from the present one.
    fn distance(&self, x: &DVector<f64>) -> f64 {
        let n = self.problem.count();
        let change = x - &self.x;
        (change.rows(0, n).norm() / self.unit).hypot(change[n])
    }

    /// Follows the path to full friction, and returns the frictions there.
    fn end(mut self) -> Option<Vec<f64>> {
        let n = self.problem.count();
        let mut step = FIRST;
        while self.trials < TRIALS && step > SHORTEST {
            // Several modes may end at the same point.
            let (member, margin) = self.least_margin(&self.x);
            if margin < LOCATED {
                self.change_mode(member)?;
                continue;
            }
            let found = self.ahead(step).and_then(|found| self.end_of_piece(found, step));
            let Some(Candidate { x, member, margin }) = found else {
                step *= 0.5;
                continue;
            };
            if x[n] <= 0.0 {
                // Full friction is between both points.
                let mut between = self.x.lerp(&x, self.x[n] / (self.x[n] - x[n]));
                between[n] = 0.0;
                match self.corrected(between, true) {
                    Some(end) if self.least_margin(&end).1 >= LOCATED => {
                        return Some(Vec::from(&end.as_slice()[..n]));
                    }
                    _ => step *= 0.5,
                }
                continue;
            }
            self.x = x;
            if margin < -1.0 {
                self.change_mode(member)?;
            } else {
                step = (GROWTH * step).min(LONGEST);
                self.turn()?;
            }
        }
        None
    }

    /// Begins the next piece of the path at the present point, where the mode of `member` ends.
    fn change_mode(&mut self, member: usize) -> Option<()> {
        self.trials += 1;
        self.sticks[member] = !self.sticks[member];
        self.turn()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{JointFriction, Law};
    use crate::friction_problem::complementarity::{DryFriction, Member};
    use crate::friction_problem::influence::Influence;
    use crate::friction_problem::normal_load::Configuration;
    use crate::joint::JointType;
    use crate::kinematics::{Bodies, State};
    use crate::mechanism::{BodySpec, JointSpec, MechanismBuilder};
    use crate::parameters::Parameters;
    use crate::random::Random;
    use crate::spatial::Wrench;
    use crate::topology::Topology;

    const MEMBERS: usize = 7;

    struct Wrenches(Vec<Wrench<f64>>);

    impl Influence for Wrenches {
        fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
            for (k, wrench) in self.0.iter().enumerate() {
                put(k / MEMBERS, k % MEMBERS, *wrench);
            }
        }
    }

    /// Solves random time steps of seven joints and `mobility` degrees of freedom, in which a friction
    /// force changes the joints' forces by `influence` times itself on average. Returns how many
    /// solutions are found by all methods together, and by the path alone.
    fn found(mobility: usize, influence: f64, count: usize) -> (usize, usize) {
        let mut builder = MechanismBuilder::new("joints");
        for k in 0..MEMBERS {
            let body = format!("body{k}");
            let pin =
                JointSpec::new(format!("pin{k}"), JointType::Revolute, "ground", body.as_str());
            let friction = JointFriction {
                radius: Some(0.01),
                ..JointFriction::guide(Law::coulomb_viscous(0.3, 0.0))
            };
            builder = builder.body(BodySpec::new(body).mass(1.0)).joint(pin.friction(friction));
        }
        let mechanism = builder.build().unwrap();
        let topology = Topology::new(&mechanism);
        let parameters = Parameters::new(&mechanism);
        let mut bodies = Bodies::new(&topology);
        bodies.place(&topology, &parameters, &State::new(&topology).coordinates);
        let at = Configuration { parameters: &parameters, bodies: &bodies };
        let law = DryFriction { forward: 0.3, backward: 0.3, viscous: 0.0 };
        let members = (0..MEMBERS)
            .map(|k| Member { interface: k, places: k..k + 1, law: MemberLaw::Dry(law) })
            .collect::<Vec<_>>();
        let mut random = Random::new(3);
        let (mut all, mut by_path) = (0, 0);
        for _ in 0..count {
            let modes = DMatrix::from_fn(MEMBERS, mobility, |_, _| random.number());
            let compliance = -(&modes * modes.transpose());
            let free = &modes * DVector::from_fn(mobility, |_, _| 10.0 * random.number());
            let mut wrench = |size: f64| Wrench { force: random.vector() * size, ..Wrench::zero() };
            let base = (0..MEMBERS).map(|_| wrench(1.0)).collect();
            let mut own = Wrenches((0..MEMBERS * MEMBERS).map(|_| wrench(influence)).collect());
            let linear = (free.as_slice().to_vec(), compliance.as_slice().to_vec());
            let mut problem = Complementarity::new(at, members.clone(), linear, base, &mut own);
            problem.slack = 1e-3;
            let is_solution = |x: &Vec<f64>| problem.residual(x, 1.0, None).relative() <= STAGNATED;
            by_path += usize::from(problem.follow_path().as_ref().is_some_and(is_solution));
            let solution = problem.solve(&[0.0; MEMBERS]);
            all += usize::from(solution.is_some_and(|found| found.residual <= STAGNATED));
        }
        (all, by_path)
    }

    /// Time steps of any mechanism with dry friction have solutions, also if friction increases the
    /// normal loads without bound, and if more joints stick than there are degrees of freedom.
    #[test]
    fn time_steps_have_solutions() {
        const COUNT: usize = 100;
        for mobility in [1, 2, 3, 7] {
            for influence in [0.3, 3.0, 30.0] {
                let (all, by_path) = found(mobility, influence, COUNT);
                assert_eq!(all, COUNT, "{mobility} {influence}");
                // The path alone fails where its pieces are too short for the least step.
                assert!(by_path >= COUNT - 3, "{mobility} {influence}: {by_path}");
            }
        }
    }
}
