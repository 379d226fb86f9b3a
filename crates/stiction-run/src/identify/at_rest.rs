//! Efforts at rest: inequalities that bound the parameters of a fit. Dwells (intervals at
//! standstill) that contradict the fit are left out.

use super::prepare::Prepared;
use super::run::fitted_blocks;
use stiction_identify::{Estimate, Options, Parameter, Problem};

/// Number of standard deviations by which an effort at rest may exceed its static friction limit.
/// If the excess is larger, another force, such as a brake, must act.
const CONTRADICTS: f64 = 4.0;

/// Corrects an estimate so that the efforts at rest lie within the static friction limits. Returns
/// the corrected estimate and cautions. Dwells that contradict the estimate are left out: a brake
/// holds the robot there, or static friction exceeds sliding friction.
pub(super) fn bounded(
    all: &mut [Prepared],
    parameters: &[Parameter],
    options: &Options,
    mut estimate: Estimate,
) -> (Estimate, Vec<String>) {
    let mut cautions = Vec::new();
    for log in all.iter_mut().filter(|log| !log.predict) {
        let [unused, count] = log.set_dwells(&estimate.values);
        if unused > 0 {
            cautions.push(format!(
                "{}: {unused} of {count} dwells (times at rest) give no bounds on static friction: \
                 the forces of the model cannot be computed there, or a formula below [terms] may \
                 have any value at rest",
                log.name
            ));
        }
    }
    let blocks = fitted_blocks(all);
    let problem = Problem { parameters, blocks: &blocks, options };
    let mut acts = false;
    let fits = all.iter_mut().filter(|log| !log.predict);
    for (log, excesses) in fits.zip(problem.excesses(&estimate)) {
        let agrees = |excess: f64| excess <= CONTRADICTS;
        acts |= excesses.iter().any(|&excess| excess > 0.0 && agrees(excess));
        log.block.dwells.iter_mut().for_each(|dwells| dwells.retain(|k| agrees(excesses[k])));
        let beyond = excesses.iter().filter(|excess| !agrees(**excess)).count();
        if beyond > 0 {
            let most = excesses.iter().copied().fold(0.0, f64::max);
            cautions.push(format!(
                "{}: in {beyond} of {} dwells an effort lies beyond the static friction limits, by up to {most:.0} standard \
                 deviations: friction at rest exceeds that of sliding (`mu_static`), or a brake holds the robot; these \
                 dwells are left out",
                log.name,
                excesses.len()
            ));
        }
    }
    if acts {
        let blocks = fitted_blocks(all);
        estimate = Problem { parameters, blocks: &blocks, options }.solve_fixed(&estimate);
    }
    (estimate, cautions)
}
