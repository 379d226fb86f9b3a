//! Initial state of a simulation from incomplete start values.
//!
//! Equation (D8) of the book's theory.

use super::Forward;
use super::balance::{factor, solve_factored};
use super::error::ForwardError;
use super::mass_matrix::MassMatrix;
use crate::kinematics::{Bodies, Coordinate, Missed, RateRows, State, What, assemble_partly};
use crate::linalg::RowSpace;
use crate::mechanism::BodyId;
use crate::spatial::Pose;

/// Given value and given rate of one coordinate at the start of a simulation. Either may be absent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// The coordinate.
    pub coordinate: Coordinate,
    /// Value, rad or m, if given.
    pub value: Option<f64>,
    /// Rate, rad/s or m/s, if given. For a component of a rotation vector, the rate is the same
    /// component of the angular velocity, in the axes of the ground frame.
    pub rate: Option<f64>,
}

/// A rate constraint counts as satisfied if its residual is below this fraction of the largest
/// given rate.
const MET: f64 = 1e-9;
/// A constraint row counts as linearly dependent if its component orthogonal to the span of the
/// other rows is below this fraction of its norm.
const DEPENDENT: f64 = 1e-10;

impl Forward {
    /// Assembles a state from known values and rates of any joint coordinates and body poses.
    ///
    /// The search starts from the start coordinates of the joints and from the guesses
    /// `initial_poses` of body poses in the ground frame. Each Newton step is the minimum-norm step
    /// that closes the loops and satisfies the known values. Rates that remain undetermined
    /// minimise the kinetic energy.
    ///
    /// # Errors
    /// [`ForwardError::Contradiction`] names the value or rate that cannot be satisfied.
    pub fn assemble_from(
        &self,
        initial_poses: &[(BodyId, Pose<f64>)],
        known: &[Known],
    ) -> Result<State<f64>, ForwardError> {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let pick = |of: fn(&Known) -> Option<f64>| {
            let each = known.iter().enumerate();
            let each = each.filter_map(|(k, known)| Some((k, known.coordinate, of(known)?)));
            let mut picked = (Vec::new(), Vec::new(), Vec::new());
            for (k, coordinate, number) in each {
                picked.0.push(k);
                picked.1.push(coordinate);
                picked.2.push(number);
            }
            picked
        };
        let (places, coordinates, values) = pick(|known| known.value);
        let contradiction = |missed: &Missed, places: &[usize], rates: bool| {
            let what = match missed.what {
                What::Joint(joint) => format!("joint `{}` stays open", self.joint_name(joint)),
                What::Gearing(k) => {
                    format!("gearing `{}` is not met", self.simulated().gearings()[k].name)
                }
                What::Given(k) => self.in_words(&known[places[k]].coordinate),
            };
            let unit = match (missed.is_angle, rates) {
                (false, false) => "m",
                (true, false) => "rad",
                (false, true) => "m/s",
                (true, true) => "rad/s",
            };
            ForwardError::Contradiction { what, by: missed.by, unit, rates }
        };
        if let Some(bad) = known
            .iter()
            .find(|k| [k.value, k.rate].into_iter().flatten().any(|number| !number.is_finite()))
        {
            let what = self.in_words(&bad.coordinate);
            let (by, unit) = (f64::INFINITY, "m or rad");
            return Err(ForwardError::Contradiction { what, by, unit, rates: false });
        }
        let mut state = assemble_partly(
            self.simulated(),
            topology,
            parameters,
            initial_poses,
            (&coordinates, &values),
        )
        .map_err(|missed| contradiction(&missed, &places, false))?;
        let (places, coordinates, rates) = pick(|known| known.rate);
        let rows = RateRows::new(topology, parameters, &state, (&coordinates, &rates));
        let n = topology.dofs();
        let mut space = RowSpace::default();
        space.decompose(&rows.matrix, rows.rights.len(), n, DEPENDENT);
        // Minimum-norm scaled rates that satisfy the rows. The kinetic energy is minimised below.
        let mut found = space.shortest(&rows.rights);
        let largest = rows.rights.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (row, right) in rows.matrix.chunks_exact(n.max(1)).zip(&rows.rights).enumerate() {
            let (entries, right) = right;
            let rate: f64 = entries.iter().zip(&found).map(|(a, b)| a * b).sum();
            if (rate - right).abs() > MET * largest.max(f64::MIN_POSITIVE) {
                let missed = Missed {
                    what: RateRows::what(topology, row),
                    by: (rate - right).abs() / rows.scales[row],
                    is_angle: rows.are_angles[row],
                };
                return Err(contradiction(&missed, &places, true));
            }
        }
        found.iter_mut().zip(&self.columns).for_each(|(rate, column)| *rate *= column);
        let mut basis = space.null_space();
        for vector in basis.chunks_exact_mut(n.max(1)) {
            vector.iter_mut().zip(&self.columns).for_each(|(x, column)| *x *= column);
        }
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        let masses = MassMatrix::new(topology, (parameters, &self.rotors), &mut bodies, &[]);
        let mut matrix = Vec::new();
        masses.matrix_into(topology, &bodies, &mut matrix);
        let free = basis.len() / n.max(1);
        // If a motion has no inertia, the kinetic energy has no unique minimum. The minimum-norm
        // rates then remain unchanged.
        if free > 0
            && largest > 0.0
            && let Ok(factored) = factor(&matrix, &mut basis, n, &|_| false, &mut Vec::new())
        {
            let momentum: Vec<f64> = matrix
                .chunks_exact(n)
                .map(|row| row.iter().zip(&found).map(|(m, v)| m * v).sum())
                .collect();
            let mut amounts: Vec<f64> = basis
                .chunks_exact(n)
                .map(|z| -z.iter().zip(&momentum).map(|(z, p)| z * p).sum::<f64>())
                .collect();
            solve_factored(&factored, &mut amounts);
            for (vector, amount) in basis.chunks_exact(n).zip(&amounts) {
                found.iter_mut().zip(vector).for_each(|(v, z)| *v += amount * z);
            }
        }
        state.rates = found;
        Ok(state)
    }

    /// Returns the name of a coordinate for messages, which includes the names of its joint or
    /// bodies.
    fn in_words(&self, coordinate: &Coordinate) -> String {
        let body = |body: &BodyId| &self.simulated().bodies()[body.0].name;
        let axis = |axis: &usize| ["x", "y", "z"].get(*axis).copied().unwrap_or("?");
        match coordinate {
            Coordinate::Joint { joint, dof } => {
                let name = self.joint_name(joint.0);
                let count = self.topology.joint_types[joint.0].dofs().len();
                if count > 1 {
                    format!("coordinate {} of joint `{name}`", dof + 1)
                } else {
                    format!("the coordinate of joint `{name}`")
                }
            }
            Coordinate::Position { body: b, axis: a } => {
                format!("position {} of body `{}`", axis(a), body(b))
            }
            Coordinate::Angle { body: b, index, .. } => {
                format!("angle {} of body `{}`", index + 1, body(b))
            }
            Coordinate::RotationVector { body: b, axis: a } => {
                format!("rotation {} of body `{}`", axis(a), body(b))
            }
        }
    }
}
