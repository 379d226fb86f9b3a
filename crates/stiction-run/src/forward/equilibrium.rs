//! Static equilibrium without friction.
//!
//! At an equilibrium, the mechanism at rest has no accelerations: `a(q) = 0`. The derivative
//! `da/dq` is minus the inverse mass matrix times the stiffness matrix. Each step of the search
//! solves `(lambda - da/dq) dq = a`, where `lambda` exceeds all eigenvalues of `da/dq`. This is a
//! damped Newton step; if the forces are conservative, it descends the potential energy.

use super::acting_inputs::Acting;
use super::holding::Holding;
use super::job::Job;
use super::linearize::refusal;
use crate::dofs::dofs_of;
use crate::error::Error;
use crate::names::{Names, heading_of};
use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::fmt;
use stiction_core::forward::{Forward, Inputs as _, Linearisation};
use stiction_core::kinematics::State;
use stiction_draw::numbers::number;

/// Largest number of steps of the search.
const STEPS: usize = 150;
/// Largest change of a coordinate in one step of the search, rad or characteristic lengths.
const LONGEST: f64 = 0.2;
/// Limit of the sum of all step lengths, rad or characteristic lengths. The search fails beyond
/// this limit.
const FAR: f64 = 20.0;
/// The search has converged if a Newton step changes each coordinate by less than this value, rad
/// or characteristic lengths.
const LAST: f64 = 1e-12;
/// An eigenvalue of `da/dq` counts as zero if its magnitude is below this fraction of the largest
/// eigenvalue or of the squared characteristic frequency, whichever is greater.
const NEUTRAL: f64 = 1e-7;
/// The imaginary part of an eigenvalue counts as a rounding error below this fraction of the
/// largest eigenvalue.
const COMPLEX: f64 = 1e-6;

/// Stability of an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// Every small motion about the equilibrium is an oscillation.
    Stable,
    /// Some small motion grows without oscillation.
    Unstable,
    /// Some small oscillation grows, because the inverse mass matrix times the stiffness matrix has
    /// complex eigenvalues.
    Flutter,
    /// There is a motion with neither a restoring nor a repelling force to first order.
    Neutral,
}

impl Stability {
    /// Returns the name of this kind of stability in reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::Flutter => "unstable (flutter)",
            Self::Neutral => "neutral",
        }
    }
}

/// Configuration in which a mechanism remains at rest without friction.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    heading: String,
    /// Name, unit (m or rad) and value of every joint coordinate.
    pub coordinates: Vec<(String, &'static str, f64)>,
    /// Stability of the equilibrium.
    pub stability: Stability,
    /// Eigenvalues of the inverse mass matrix times the stiffness matrix, 1/s^2, in ascending
    /// order. At a stable equilibrium they are the squares of the natural angular frequencies.
    pub stiffness: Vec<f64>,
    /// Largest remaining acceleration, relative to the characteristic acceleration.
    pub residual: f64,
    /// Name, unit (N or N m) and value of the effort of every actuator, including actuators that
    /// lock a joint.
    pub efforts: Vec<(String, &'static str, f64)>,
    /// Number of steps that the search required.
    pub steps: usize,
    /// Effect of static friction at the equilibrium, if requested.
    pub holding: Option<Holding>,
    /// Notes for the user, for example that loads change with time.
    pub notes: Vec<String>,
    /// Magnitude, 1/s^2, up to which an eigenvalue in [`Self::stiffness`] counts as zero.
    zero: f64,
    /// State of the mechanism at the equilibrium.
    pub(super) state: State<f64>,
}

impl Job<'_> {
    /// Finds a static equilibrium without friction, starting from the initial configuration of the
    /// job. If `nearest` is false, the search descends the potential energy to a stable
    /// equilibrium. If `nearest` is true, the search returns the equilibrium to which Newton's
    /// method converges, stable or not.
    ///
    /// # Errors
    /// [`Error::NoEquilibrium`] if the search does not converge, moves the mechanism without bound,
    /// or reaches a configuration in which the stiffness matrix is singular or the loops cannot be
    /// closed. Also fails if the mechanism cannot be assembled in its initial configuration.
    pub fn equilibrium(&self, nearest: bool) -> Result<Equilibrium, Error> {
        if !self.load.payloads.is_empty() {
            let (model, load) = self.with_payloads()?;
            let job = Job { model: &model, load: &load, ..self.clone() };
            return job.equilibrium(nearest);
        }
        let point = self.operating_point(false)?;
        let forward = point.forward;
        let mut state = point.state;
        state.rates.fill(0.0);
        let going = || false;
        let mut acting = Acting::new(self, &forward, &state, &going)?;
        let names = Names::with_shafts(&self.model.mechanism);
        let mut way = 0.0;
        for step in 0..STEPS {
            let (found, linear) = self.examine(&forward, state.clone(), &mut acting, &names)?;
            let mut simulation = found;
            let m = linear.coordinates.len();
            let translates = |k: usize| {
                let (joint, dof) = linear.coordinates[k];
                self.model.mechanism.joints()[joint.0].joint_type.dofs()[dof].translates()
            };
            let length = forward.parameters().length;
            let unit: Vec<f64> = (0..m).map(|k| if translates(k) { length } else { 1.0 }).collect();
            let a = DVector::from_fn(m, |k, _| linear.motion[k].acceleration / unit[k]);
            let slope = DMatrix::from_fn(m, m, |i, k| linear.by_position[i][k] * unit[k] / unit[i]);
            let complex = slope.complex_eigenvalues();
            let eigenvalues: Vec<f64> = complex.iter().map(|z| z.re).collect();
            let largest = eigenvalues.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let natural = (forward.parameters().gravity.norm() / length).max(1e-3);
            let zero = NEUTRAL * largest.max(natural);
            let highest = eigenvalues.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let is_unstable = highest > zero;
            let newton = solve(&slope, &a, 0.0);
            let last = newton.as_ref().is_some_and(|dq| dq.amax() < LAST);
            let rests = a.amax() < 1e-11 * largest.max(natural);
            if (last || rests) && (nearest || !is_unstable) {
                let now = simulation.instant();
                let size = complex.iter().fold(natural, |m, z| m.max(z.norm()));
                let flutters = complex.iter().any(|z| z.im.abs() > COMPLEX * size);
                let report = Report {
                    flutters,
                    eigenvalues,
                    zero,
                    residual: a.amax() / natural,
                    steps: step,
                };
                let motion = |at: (stiction_core::mechanism::JointId, usize)| {
                    forward.joint_coordinate(&now.state, &now.bodies, at.0, at.1)
                };
                let found = self.equilibrium_at(report, motion, (&now.drives, &now.state));
                let changes = acting.steady_until(self.from).is_finite();
                let note = || {
                    let time = number(self.from);
                    format!(
                        "loads and efforts change with time: the search uses those at t = \
                        {time} s"
                    )
                };
                return Ok(Equilibrium {
                    notes: changes.then(note).into_iter().collect(),
                    ..found
                });
            }
            let mut change = if nearest {
                newton
            } else if (last || rests) && is_unstable {
                // The search leaves an unstable equilibrium in the direction of its fastest-growing
                // motion.
                Some(least_stable(&slope, highest) * 1e-3)
            } else {
                let lambda = if highest > -zero {
                    highest.max(0.0) + 0.1 * largest.max(natural)
                } else {
                    0.0
                };
                solve(&slope, &a, lambda)
            }
            .ok_or_else(|| {
                Error::NoEquilibrium(
                    "the stiffness becomes singular during the search, so that Newton's method has \
                 no next step; leave out --nearest, or begin elsewhere (--from)"
                        .to_owned(),
                )
            })?;
            let size = change.amax();
            if size > LONGEST {
                change *= LONGEST / size;
            }
            way += change.amax();
            if way > FAR || !way.is_finite() {
                let most = change.iamax();
                let (joint, dof) = linear.coordinates[most];
                let name = self.model.mechanism.joints()[joint.0].dof_name(dof);
                return Err(Error::NoEquilibrium(format!(
                    "the mechanism moves by more than {FAR} rad or characteristic lengths, mainly \
                     in `{name}`: no spring or load stops it; lock that joint (--hold), or give \
                     an effort that balances it (--drives)"
                )));
            }
            let change: Vec<f64> = change.iter().zip(&unit).map(|(x, unit)| x * unit).collect();
            let mut part = 1.0;
            state = loop {
                let shorter: Vec<f64> = change.iter().map(|x| x * part).collect();
                match simulation.displaced(&linear, &shorter, &mut acting) {
                    Ok(state) => break state,
                    Err(error) if part < 1e-6 => {
                        return Err(Error::NoEquilibrium(format!(
                            "the search reaches a position in which the loops cannot be closed: {error}"
                        )));
                    }
                    Err(_) => part *= 0.25,
                }
            };
        }
        Err(Error::NoEquilibrium(format!(
            "the search does not converge within {STEPS} steps; begin nearer to an equilibrium \
             (--from), and give efforts without jumps"
        )))
    }

    fn examine<'f>(
        &self,
        forward: &'f Forward,
        state: State<f64>,
        acting: &mut Acting<'_>,
        names: &Names,
    ) -> Result<(stiction_core::forward::Simulation<'f>, Linearisation), Error> {
        let started = forward.start(self.from, state, self.settings, acting);
        let mut simulation = started.map_err(Error::Forward)?;
        let linear =
            simulation.linearise_statics(acting).map_err(|error| match refusal(error, names) {
                Error::NoLinearModel(text) => Error::NoEquilibrium(text),
                other => other,
            })?;
        Ok((simulation, linear))
    }

    fn equilibrium_at(
        &self,
        report: Report,
        motion: impl Fn((stiction_core::mechanism::JointId, usize)) -> f64,
        (drives, state): (&[f64], &State<f64>),
    ) -> Equilibrium {
        let mechanism = &self.model.mechanism;
        let dofs = dofs_of(mechanism);
        let mut stiffness: Vec<f64> = report.eigenvalues.iter().map(|x| 0.0 - x).collect();
        stiffness.sort_by(f64::total_cmp);
        let least = stiffness.first().copied().unwrap_or(0.0);
        let stability = match least {
            _ if report.flutters => Stability::Flutter,
            x if x > report.zero => Stability::Stable,
            x if x < -report.zero => Stability::Unstable,
            _ => Stability::Neutral,
        };
        let each = dofs.iter();
        Equilibrium {
            heading: heading_of(self.model),
            coordinates: each
                .map(|dof| (dof.name.clone(), dof.units()[0], motion((dof.joint, dof.index))))
                .collect(),
            stability,
            stiffness,
            residual: report.residual,
            efforts: dofs
                .iter()
                .filter_map(|dof| {
                    let unit = if dof.translates { "N" } else { "N m" };
                    Some((dof.name.clone(), unit, drives[dof.actuator?]))
                })
                .collect(),
            steps: report.steps,
            holding: None,
            notes: Vec::new(),
            zero: report.zero,
            state: state.clone(),
        }
    }
}

struct Report {
    flutters: bool,
    eigenvalues: Vec<f64>,
    zero: f64,
    residual: f64,
    steps: usize,
}

fn solve(slope: &DMatrix<f64>, a: &DVector<f64>, lambda: f64) -> Option<DVector<f64>> {
    let m = a.len();
    let matrix = DMatrix::from_fn(m, m, |i, k| (if i == k { lambda } else { 0.0 }) - slope[(i, k)]);
    matrix.lu().solve(a).filter(|x| x.iter().all(|x| x.is_finite()))
}

/// Returns the direction of the fastest-growing motion: the eigenvector of the highest eigenvalue
/// `highest`, by inverse iteration, scaled to a largest component of one.
fn least_stable(slope: &DMatrix<f64>, highest: f64) -> DVector<f64> {
    let m = slope.nrows();
    // A start vector with unequal components is unlikely to be orthogonal to the eigenvector.
    let mut vector = DVector::from_fn(m, |k, _| 1.0 + 0.1 * k as f64);
    for _ in 0..20 {
        let Some(next) = solve(slope, &vector, highest * (1.0 + 1e-6) + 1e-12) else { break };
        vector = next.normalize();
    }
    let largest = vector.amax().max(f64::MIN_POSITIVE);
    vector / largest
}

impl Equilibrium {
    /// Returns the value of a coordinate at the equilibrium, m or rad; `None` if no coordinate has
    /// this name.
    pub fn coordinate(&self, name: &str) -> Option<f64> {
        self.coordinates.iter().find(|(own, ..)| own == name).map(|(.., value)| *value)
    }

    /// Returns all results as JSON.
    pub fn json(&self) -> Value {
        let named = |all: &[(String, &'static str, f64)]| -> serde_json::Map<String, Value> {
            let each = all.iter();
            each.map(|(name, unit, x)| (name.clone(), json!({ "value": x, "unit": unit })))
                .collect()
        };
        json!({
            "stability": self.stability.word(),
            "coordinates": named(&self.coordinates),
            "efforts": named(&self.efforts),
            "stiffness_over_mass": self.stiffness,
            "residual": self.residual,
            "steps": self.steps,
            "static_friction": self.holding.as_ref().map(Holding::json),
            "notes": self.notes,
        })
    }
}

impl fmt::Display for Equilibrium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.heading)?;
        writeln!(f, "{} equilibrium without friction", self.stability.word())?;
        writeln!(f)?;
        for (name, unit, value) in &self.coordinates {
            writeln!(f, "  {name:24} {:>13} {unit}", number(*value))?;
        }
        if !self.efforts.is_empty() {
            writeln!(f, "\nefforts")?;
        }
        for (name, unit, value) in &self.efforts {
            writeln!(f, "  {name:24} {:>13} {unit}", number(*value))?;
        }
        writeln!(f, "\nsmall motions")?;
        if self.stability == Stability::Flutter {
            writeln!(f, "  complex eigenvalues: an oscillation grows; see `stiction linearize`")?;
        }
        for k in &self.stiffness {
            match k {
                _ if self.stability == Stability::Flutter => continue,
                k if k.abs() <= self.zero => writeln!(f, "  neutral (zero frequency)")?,
                k if *k > 0.0 => writeln!(f, "  oscillates at {} Hz", number(k.sqrt() / TAU))?,
                k => {
                    writeln!(f, "  grows with the time constant {} s", number((-k).sqrt().recip()))?
                }
            }
        }
        if let Some(holding) = &self.holding {
            holding.write(f)?;
        }
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        Ok(())
    }
}
