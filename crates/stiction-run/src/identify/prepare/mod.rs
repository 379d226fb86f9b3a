//! Preparation of a log for the regression: filtered positions and efforts, and the columns of the model.

mod bias;
mod constants;
mod dwells;
mod effects;
mod efforts;
mod filter;
mod gaps;
mod loads;
mod motion;
mod pieces;
mod reference;
mod reversals;
mod rows;
mod saturation;
mod simulated;
mod spikes;

use super::chosen::{assembled, chosen_coordinates, chosen_efforts, refuse};
use super::options::LogSettings;
use super::run::without_forces;
use super::{IdentifyError as Error, Progress};
use constants::Constant;
use dwells::Standstill;
pub(super) use effects::{ALL as EFFECTS, Effect};
use efforts::Efforts;
use loads::MuColumns;
use motion::{Motion, Used};
use nalgebra::DVector;
pub(super) use rows::write_terms;
pub use simulated::Deviation;
pub(super) use simulated::{Plant, SimulatedEfforts};
use stiction_core::kinematics::{Coordinate, State};
use stiction_core::spatial::Pose;
use stiction_format::{Drives, Log, LogRole, ModelFile};
use stiction_identify::{Block, Choice, Regressor};

/// Measured log with its options.
#[derive(Clone, Debug)]
pub struct MeasuredLog {
    /// Name of the log in results.
    pub name: String,
    /// Content of the log file.
    pub log: Log,
    /// Options that apply to this log.
    pub settings: LogSettings,
    /// Efforts of the simulated closed loop, if the positions of the log are simulated.
    pub(super) simulated: Option<SimulatedEfforts>,
}

impl MeasuredLog {
    /// Returns a copy of the log in which no column is a measured position or rate.
    fn without_motion(&self) -> Self {
        let mut log = self.clone();
        for column in &mut log.log.columns {
            if matches!(column.role, LogRole::Coordinate(_) | LogRole::Rate(_)) {
                column.role = LogRole::Unused;
            }
        }
        log
    }

    /// Creates a log with its options.
    pub fn new(name: impl Into<String>, log: Log, settings: LogSettings) -> Self {
        Self { name: name.into(), log, settings, simulated: None }
    }
}

/// Settings with which all logs are prepared.
#[derive(Clone, Copy)]
pub(super) struct Preparation<'a> {
    pub(super) model: &'a ModelFile,
    /// Cut-off frequency of the filter, Hz; `None` selects one automatically.
    pub(super) filter: Option<f64>,
    pub(super) choice: &'a Choice,
    pub(super) terms: &'a [Drives],
    pub(super) progress: Progress<'a>,
}

/// Largest fraction of the instants of a log at which the computation of forces may fail.
const MAY_FAIL: f64 = 0.05;

/// Log prepared for the regression.
pub(super) struct Prepared {
    pub(super) name: String,
    pub(super) predict: bool,
    pub(super) block: Block,
    pub(super) regressor: Regressor,
    /// Instants at which the regressor is evaluated: time, s, and positions, rates and
    /// accelerations of the coordinates.
    pub(super) instants: Vec<(f64, [Vec<f64>; 3])>,
    /// Times of the rows of the regression, s.
    pub(super) times: Vec<f64>,
    /// Number of rows of all actuators that are left out because a joint is at rest.
    pub(super) at_rest: usize,
    /// Data for the regression columns of the friction coefficients.
    mu: MuColumns,
    /// Filtered direction of motion and filtered rate, m/s or rad/s, in the regression rows of each
    /// actuator. Before filtering, the direction is 1 or -1, or zero at rest.
    pub(super) directions: Vec<Vec<[f64; 2]>>,
    /// Efforts of the model without friction in the regression rows of each actuator, N or N m.
    pub(super) known: Vec<Vec<f64>>,
    /// Time between samples of the recording, s.
    pub(super) sample: f64,
    /// Cut-off frequency of the filter, Hz; `None` for steady motions.
    pub(super) cutoff: Option<f64>,
    /// Standard deviation of the white noise that remains in each filtered effort, N or N m; `None` for steady motions.
    pub(super) effort_noise: Option<Vec<f64>>,
    pub(super) cautions: Vec<String>,
    /// Times, s, and states of the mechanism at some instants; see [`pieces::starting`].
    starts: Vec<(f64, State<f64>)>,
    /// Poses of all bodies in the world at some instants of a recorded motion; empty for steady
    /// motions.
    pub(super) poses: Vec<(f64, Vec<Pose<f64>>)>,
    /// Efforts of the recording before filtering; `None` for steady motions.
    efforts: Option<Efforts>,
    /// Unknown torque constant of each actuator whose current is measured; `None` for other
    /// actuators.
    constants: Vec<Option<Constant>>,
    /// This log prepared with its commanded motion instead of the measured one; `None` if the fit
    /// uses no instrumental variables.
    reference: Option<Box<Self>>,
    /// Dwells: intervals in which the mechanism is at standstill.
    standstills: Vec<Standstill>,
    /// Time, s, and state of the mechanism at the beginning of each interval in which all actuators
    /// may be at rest.
    rests: Vec<(f64, State<f64>)>,
    /// Filtered signals of effects that the model may lack, for the regression rows of each
    /// actuator.
    effects: Vec<Vec<Vec<f64>>>,
    /// Efforts predicted by the original model in the regression rows of each actuator, N or N m;
    /// see [`Self::keep_prior`].
    pub(super) by_model: Vec<DVector<f64>>,
    /// True if the motion is simulated.
    is_simulated: bool,
}

impl Prepared {
    /// Predicts the efforts in the regression rows of each actuator for the parameter values `at`.
    pub(super) fn predicted(&self, at: &DVector<f64>) -> Vec<DVector<f64>> {
        self.block.channels.iter().map(|rows| rows.predicted(at)).collect()
    }

    /// Returns the largest range of a coordinate in the log, divided by two pi. For an angle in
    /// rad, this is a number of turns.
    pub(super) fn turns(&self) -> f64 {
        let count = self.instants.first().map_or(0, |(_, [q, ..])| q.len());
        let range = |k: usize| {
            let all = self.instants.iter().map(|(_, [q, ..])| q[k]);
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| {
                (low.min(q), high.max(q))
            });
            (high - low) / std::f64::consts::TAU
        };
        (0..count).map(range).fold(0.0, f64::max)
    }

    /// Stores the efforts that the original model with the parameter values `at` predicts, before a
    /// fit changes the friction columns.
    pub(super) fn keep_prior(&mut self, at: &DVector<f64>) {
        self.by_model = self.predicted(at);
    }

    /// Prepares a log for the regression. `delays` contains the delay of each effort relative to the
    /// positions, s. The delays determine between which two samples of an effort the friction
    /// reverses. `delays` is `None` if they are not yet estimated.
    pub(super) fn new(
        preparation: Preparation<'_>,
        log: &MeasuredLog,
        delays: Option<&[f64]>,
    ) -> Result<Self, Error> {
        let Preparation { model, choice, terms, progress, .. } = preparation;
        let filter = log.simulated.as_ref().map(|own| own.cutoff).or(preparation.filter);
        let chosen = chosen_coordinates(model, log)?;
        let (efforts, _) = chosen_efforts(&model.mechanism, log)?;
        let used = Used::of(log)?;
        let mut cautions = Vec::new();
        for chosen in &chosen {
            let name = &log.log.columns[chosen.column()].name;
            let values = used.pick(chosen.column());
            let is_still = match chosen.position {
                Some(_) => !log.log.is_steady && values.iter().all(|x| *x == values[0]),
                None => values.iter().all(|x| *x == 0.0),
            };
            if is_still {
                cautions.push(format!(
                    "{}: `{name}` is constant: parameters that need its motion cannot be identified",
                    log.name
                ));
            } else if chosen.position.is_none() && !log.log.is_steady {
                cautions.push(format!(
                    "{}: `{name}` is a rate; positions are its integral, starting at the position of the model",
                    log.name
                ));
            }
        }
        let joints = model.mechanism.joints();
        let mut motion = match log.log.is_steady {
            true => motion::steady(&used, &chosen),
            false => {
                let types: Vec<_> = joints.iter().map(|joint| joint.joint_type).collect();
                let is_angle: Vec<bool> =
                    chosen.iter().map(|chosen| chosen.coordinate.is_angle(&types)).collect();
                motion::filtered(&used, &chosen, (filter, &is_angle), &mut cautions)?
            }
        };
        let only: Vec<Coordinate> = chosen.iter().map(|chosen| chosen.coordinate).collect();
        let first: Vec<f64> = motion.targets[0].iter().map(|target| target.value).collect();
        let solver = assembled(model, log, &only, &first)?;
        let origin = solver.parameters().origin;
        let mut regressor = Regressor::new(solver, choice).map_err(|unsuitable| {
            refuse(
                format!("{}: {unsuitable}", log.name),
                "robots with redundant actuation cannot be identified yet",
            )
        })?;
        regressor.carry(&log.carrying(model).mechanism);
        regressor.set_rate_noise(&motion.rate_noise);
        let delay = reversals::common_delay(delays, used.rate);
        let starts = reversals::refine(&regressor, &mut motion, (&used.times, delay));
        let motion_from = (&motion, &starts[..]);
        let mut computed = rows::computed(
            &mut regressor,
            motion_from,
            (&only, terms),
            origin,
            (&log.name, progress),
        )?;
        if let Some(caution) = &computed.caution {
            cautions.push(caution.clone());
            let reached: Vec<f64> = computed.instants.iter().map(|(time, _)| *time).collect();
            motion.keep(&reached);
        }
        let measured = rows::measured(&used, &efforts, &motion, &mut cautions)?;
        let assembled =
            rows::assembled(&computed, &measured, &motion, &mut cautions, (&log.name, model));
        computed.release_signals();
        let Motion { filter, cutoff, .. } = motion;
        let recorded = cutoff.map(|cutoff| Efforts {
            times: used.times.clone(),
            delays: vec![0.0; measured.raw.len()],
            raw: measured.raw,
            filter: filter.clone(),
            cutoff,
        });
        let mu = MuColumns::new(&regressor, &computed, &assembled, filter);
        let constants = Constant::of_columns(&efforts, regressor.parameters());
        if log.log.bad_rows.count > 0 {
            cautions.push(bad_rows(log));
        }
        let mut own = Self {
            name: log.name.clone(),
            predict: log.settings.predict,
            times: assembled.at,
            at_rest: assembled.at_rest,
            directions: assembled.directions,
            known: assembled.known,
            block: assembled.block,
            regressor,
            instants: computed.instants,
            starts: computed.starts,
            poses: if log.log.is_steady { Vec::new() } else { computed.poses },
            mu,
            sample: used.rate.recip(),
            cutoff,
            effort_noise: measured.noise,
            cautions,
            constants,
            reference: None,
            efforts: recorded,
            standstills: assembled.standstills,
            rests: computed.rests,
            effects: assembled.effects,
            by_model: Vec::new(),
            is_simulated: log.simulated.is_some(),
        };
        if let Some(simulated) = &log.simulated {
            own.use_simulated(simulated, &used.rows)
                .map_err(|why| without_forces(&own.name, &why))?;
        }
        Ok(own)
    }
}

fn bad_rows(log: &MeasuredLog) -> String {
    let rows = &log.log.bad_rows;
    let named: Vec<String> =
        rows.named.iter().map(|(line, why)| format!("line {line}: {why}")).collect();
    format!("{}: {} bad rows are left out: {}", log.name, rows.count, named.join("; "))
}
