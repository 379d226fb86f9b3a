//! Loads of a load case as inputs of a simulation: functions of time, and formulas of the measured state.

use crate::error::Error;
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::View;
use stiction_core::mechanism::Mechanism;
use stiction_format::{LoadCase, LoadLaw};

/// Loads of a load case on the bodies of a mechanism.
#[derive(Clone, Copy, Debug)]
pub(super) struct ActingLoads<'a> {
    pub(super) load: &'a LoadCase,
    pub(super) mechanism: &'a Mechanism,
}

impl ActingLoads<'_> {
    /// Returns the name of a load that a formula defines, for messages.
    fn name(&self, law: &LoadLaw) -> String {
        format!("the load on `{}`", self.mechanism.bodies()[law.body.0].name)
    }

    /// Appends the loads at the time and in the state of `view` to `loads`. `sides` tells for each
    /// switching function of the formulas whether the function is taken as positive. If a formula
    /// has no finite value, NaN is appended. The simulation then repeats the step with a shorter
    /// length, or ends if a shorter step does not help.
    ///
    /// # Errors
    /// [`Error::NoLoad`] for the first formula without a finite value.
    pub(super) fn append(
        &self,
        view: &View<'_>,
        mut sides: &[bool],
        loads: &mut Vec<AppliedLoad<f64>>,
    ) -> Result<(), Error> {
        loads.extend(self.load.at(view.time));
        let mut found = Ok(());
        for law in &self.load.laws {
            let (own, rest) = sides.split_at(law.law.switches().min(sides.len()));
            let value = law.law.at(view.time, |c| view.measure(c), own);
            if !value.is_finite() && found.is_ok() {
                found = Err(Error::NoLoad { load: self.name(law), time: view.time });
            }
            loads.push(law.load(if value.is_finite() { value } else { f64::NAN }));
            sides = rest;
        }
        found
    }

    /// Appends the values of the switching functions of all load formulas to `values`. `sides`
    /// tells for each switching function whether the function is taken as positive.
    pub(super) fn switches(&self, view: &View<'_>, mut sides: &[bool], values: &mut Vec<f64>) {
        for law in &self.load.laws {
            let (own, rest) = sides.split_at(law.law.switches().min(sides.len()));
            law.law.switches_at(view.time, |c| view.measure(c), own, values);
            sides = rest;
        }
    }

    /// Returns the name of a switching function for messages; `place` is the index of the function
    /// among the switching functions of all load formulas.
    pub(super) fn switch_name(&self, mut place: usize) -> Option<String> {
        for law in &self.load.laws {
            if place < law.law.switches() {
                return Some(format!("the formula of {}", self.name(law)));
            }
            place -= law.law.switches();
        }
        None
    }

    /// Returns true if no load depends on time explicitly.
    pub(super) fn are_steady(&self) -> bool {
        let has_time = self.load.laws.iter().any(|law| law.law.has_time());
        !has_time && self.load.signals().all(|signal| signal.is_constant())
    }

    /// Returns the end, s, of the interval from `time` in which a few samples resolve the variation
    /// of all loads with time.
    pub(super) fn seen_until(&self, time: f64) -> f64 {
        let laws = self.load.laws.iter().map(|law| law.law.resolved_until(time));
        let signals = self.load.signals().map(|signal| signal.resolved_until(time));
        laws.chain(signals).fold(f64::INFINITY, f64::min)
    }
}
