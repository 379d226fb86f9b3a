//! Evaluation of the robot at one instant: regressor rows with each payload, efforts, and used
//! fractions of the limits.

use super::coordinates::dof_value;
use super::limits::{Limits, Snapshot};
use nalgebra::DMatrix;
use stiction_core::dynamics::{Data, InverseDynamics, Weighting};
use stiction_core::kinematics::{Bodies, Target};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::parameters::Parameters;
use stiction_core::statics::newton_euler::NewtonEuler;
use stiction_core::statics::{SingularityDistances, Statics};
use stiction_identify::{Kind, LoadSlopes, Parameter, Regressor, Rest};

/// Evaluator of the singularity index of the actuation.
#[derive(Clone, Debug)]
pub(super) struct Index {
    fast: Option<SingularityDistances>,
    spins: usize,
}

impl Index {
    pub(super) fn new(solver: &InverseDynamics) -> Self {
        let spins = solver.constraints().spins().len();
        let is_determined = solver.weighting() == Some(Weighting::Determined) && spins == 0;
        let fast = is_determined.then(|| SingularityDistances::new(solver.mechanism())).flatten();
        Self { fast, spins }
    }

    /// Returns true if evaluating the singularity index takes no longer than computing the efforts.
    pub(super) fn is_fast(&self) -> bool {
        self.fast.is_some()
    }

    pub(super) fn at(
        &mut self,
        mechanism: &Mechanism,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) -> f64 {
        match &mut self.fast {
            Some(fast) => fast.measure(mechanism, parameters, bodies).actuation,
            None => {
                let balance = NewtonEuler::new(mechanism, parameters, bodies);
                let statics = Statics::new(mechanism, balance, bodies.frame_j.clone());
                statics.actuation_distance(self.spins)
            }
        }
    }
}

/// Parameters and buffers for the computation of forces with one payload.
#[derive(Clone, Debug)]
struct Case {
    engine: Parameters<f64>,
    data: Data<f64>,
}

/// Evaluator of the robot at successive instants of a motion.
#[derive(Clone, Debug)]
pub(super) struct Probe {
    regressor: Regressor,
    cases: Vec<Case>,
    /// Regressor column and friction interface of each coefficient of friction.
    mu: Vec<(usize, usize)>,
    /// Parameters of the mechanism without payload, from which positions, joint motions and the
    /// singularity index are computed.
    nominal: Parameters<f64>,
    pub(super) limits: Limits,
    index: Index,
    /// True if [`Reading::rows`] contain the friction by which each parameter acts through the normal
    /// loads.
    pub(super) through_loads: bool,
}

/// Result of an evaluation of the robot at one instant.
#[derive(Clone, Debug)]
pub(super) struct Reading {
    /// Regressor matrix: effort per unit of each parameter. It has one row for each actuator,
    /// payload by payload.
    pub(super) rows: DMatrix<f64>,
    /// Flag for each regressor row. It is true if friction at rest acts on the actuator, so that
    /// the row carries no information.
    pub(super) resting: Vec<bool>,
    /// Efforts of all actuators, N or N m, for each payload.
    pub(super) efforts: Vec<Vec<f64>>,
    /// Used fractions of all limits, see [`Limits::parts`].
    pub(super) parts: Vec<f64>,
    /// Singularity index of the actuation.
    pub(super) index: f64,
}

impl Probe {
    /// Creates the evaluator. `loaded` contains the mechanism with each payload.
    pub(super) fn new(
        regressor: Regressor,
        loaded: &[Mechanism],
        limits: Limits,
        index: Index,
    ) -> Self {
        let parameters = regressor.parameters();
        let priors: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
        let mu = (0..parameters.len())
            .filter_map(|k| match parameters[k].kind {
                Kind::Mu(interface) => Some((k, interface)),
                _ => None,
            })
            .collect();
        let cases = loaded.iter().map(|mechanism| {
            let mut carrier = regressor.clone();
            carrier.carry(mechanism);
            Case { engine: carrier.engine_parameters(&priors), data: carrier.engine_data() }
        });
        let (cases, nominal) = (cases.collect(), regressor.model().parameters().clone());
        Self { cases, mu, nominal, limits, index, through_loads: false, regressor }
    }

    /// Returns a copy of this evaluator for the mechanism with each payload in `loaded`.
    pub(super) fn with_payloads(&self, loaded: &[Mechanism]) -> Self {
        let limits = self.limits.with_payloads(loaded.len());
        Self::new(self.regressor.clone(), loaded, limits, self.index.clone())
    }

    pub(super) fn parameters(&self) -> &[Parameter] {
        self.regressor.parameters()
    }

    pub(super) fn mechanism(&self) -> &Mechanism {
        self.regressor.mechanism()
    }

    /// Returns the motion of all bodies at the most recently evaluated instant.
    pub(super) fn bodies(&self) -> &Bodies<f64> {
        self.regressor.bodies()
    }

    /// Returns the motion of a joint's degree of freedom at the most recently evaluated instant.
    pub(super) fn dof_at(&self, joint: JointId, dof: usize) -> Target<f64> {
        let bodies = self.bodies();
        let value = dof_value(self.mechanism(), bodies, joint, dof);
        let topology = self.regressor.model().topology();
        bodies.joint_motion(topology, &self.nominal, (joint.0, dof), value)
    }

    /// Returns the number of payloads and the number of actuators.
    pub(super) fn shape(&self) -> (usize, usize) {
        (self.cases.len(), self.mechanism().actuators().count())
    }

    /// Evaluates the robot at positions, rates and accelerations near those of the previous
    /// evaluation. `None` if the evaluation fails or a result is not finite. If `known_index` is
    /// given, it is used as the singularity index, which depends on positions only, instead of a
    /// new evaluation.
    pub(super) fn at(&mut self, motion: [&[f64]; 3], known_index: Option<f64>) -> Option<Reading> {
        let [q, v, a] = motion;
        let columns = self.regressor.at(q, v, a).ok()?;
        let (cases, actuators) = self.shape();
        let mut rows = DMatrix::zeros(cases * actuators, columns.matrix.ncols());
        let mut efforts = Vec::with_capacity(cases);
        for (index, case) in self.cases.iter_mut().enumerate() {
            let solved = self.regressor.loads(&case.engine, &mut case.data, motion).ok()?;
            let mut own = rows.rows_mut(index * actuators, actuators);
            own.copy_from(&columns.matrix);
            for &(column, interface) in &self.mu {
                own.column_mut(column).scale_mut(solved.loads[interface]);
            }
            if self.through_loads {
                let groups: Vec<Vec<usize>> = (0..own.ncols()).map(|k| vec![k]).collect();
                let mut slopes = LoadSlopes::new(&self.regressor, &groups);
                // Close to jamming, normal loads have no derivatives.
                if let Ok(slopes) = slopes.at(&solved, (&case.engine, &case.data)) {
                    for &(column, interface) in &self.mu {
                        let coefficient = self.regressor.parameters()[column].prior;
                        let friction = columns.matrix.column(column) * coefficient;
                        own.ger(1.0, &friction, &slopes.row(interface).transpose(), 1.0);
                    }
                }
            }
            efforts.push(case.data.efforts().to_vec());
        }
        let (mechanism, bodies) = (self.regressor.mechanism(), self.regressor.bodies());
        let index = match known_index {
            Some(index) => index,
            None => self.index.at(mechanism, &self.nominal, bodies),
        };
        let topology = self.regressor.model().topology();
        let parameters = &self.nominal;
        let at = Snapshot { motion, bodies, topology, parameters, efforts: &efforts, index };
        let mut parts = Vec::new();
        self.limits.parts(mechanism, &at, &mut parts);
        let finite = rows.iter().chain(&parts).all(|x| x.is_finite()) && index.is_finite();
        let resting: Vec<bool> = columns.rest.iter().map(|rest| *rest != Rest::Sliding).collect();
        let resting = resting.repeat(cases);
        finite.then_some(Reading { rows, resting, efforts, parts, index })
    }
}
