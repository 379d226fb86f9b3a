//! Control laws that the caller provides as functions.

use crate::SinkError;
use std::fmt;
use std::sync::Arc;
use stiction_core::forward::View;
use stiction_core::kinematics::Target;

/// Measured state that a control law receives at a sample.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// Time of the sample, s.
    pub time: f64,
    /// Positions of all actuators, m or rad. Angles are not wrapped to one turn.
    pub positions: &'a [f64],
    /// Rates of all actuators, m/s or rad/s.
    pub rates: &'a [f64],
    /// Reference position, rate and acceleration of each actuator; empty if the job has no motion.
    pub reference: &'a [Target<f64>],
}

/// Returns the positions, m or rad, and the rates, m/s or rad/s, of all actuators of a simulation.
pub(super) fn actuator_motion(view: &View<'_>, actuators: usize) -> (Vec<f64>, Vec<f64>) {
    (0..actuators).map(|k| (view.actuator_coordinate(k), view.actuator_rate(k))).unzip()
}

type Compute = dyn Fn(&Measured<'_>) -> Result<Vec<f64>, SinkError> + Send + Sync;

/// Control law that the caller provides. It is evaluated at each sample, and its efforts remain
/// constant until the next sample.
#[derive(Clone)]
pub struct ControlLaw {
    /// Time between samples, s.
    pub period: f64,
    compute: Arc<Compute>,
}

impl ControlLaw {
    /// Creates a control law that is evaluated every `period` seconds. The function `compute`
    /// returns the efforts of all actuators, N or N m.
    pub fn new(
        period: f64,
        compute: impl Fn(&Measured<'_>) -> Result<Vec<f64>, SinkError> + Send + Sync + 'static,
    ) -> Self {
        Self { period, compute: Arc::new(compute) }
    }

    /// Evaluates the control law at a sample and returns the efforts of all actuators, N or N m.
    /// Fails if their number is not the number of actuators, or if an effort is not finite.
    pub(super) fn efforts(&self, measured: &Measured<'_>) -> Result<Vec<f64>, SinkError> {
        let efforts = (self.compute)(measured)?;
        let (found, count, time) = (efforts.len(), measured.positions.len(), measured.time);
        if found != count {
            return Err(format!(
                "at t = {time} s the control law returned {found} efforts for {count} actuators"
            )
            .into());
        }
        match efforts.iter().position(|effort| !effort.is_finite()) {
            Some(index) => Err(format!(
                "at t = {time} s the control law returned {} for actuator {}",
                efforts[index],
                index + 1
            )
            .into()),
            None => Ok(efforts),
        }
    }
}

impl fmt::Debug for ControlLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ControlLaw").field("period", &self.period).finish_non_exhaustive()
    }
}
