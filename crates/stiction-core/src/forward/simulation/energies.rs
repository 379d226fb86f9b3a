//! Energy balance since the start of the simulation.
//!
//! Equation (E4) of the book's theory.

use super::Simulation;
use super::stepping::StepResult;
use crate::forward::affine_friction::norm;

/// Work done and energy dissipated since the start of the simulation, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// Work of each actuator on the mechanism, J.
    pub drives: Vec<f64>,
    /// Work of all external loads on the mechanism, J.
    pub loads: f64,
    /// Energy dissipated in the dampers of springs, J.
    pub dampers: f64,
    /// Energy lost in plastic impacts when bodies pick up parts, J.
    pub impacts: f64,
    /// Energy of the parts that bodies pick up, minus the energy of the parts that bodies place, J.
    pub payloads: f64,
    /// Energy dissipated in each friction interface, J. For bristle laws, this value includes the
    /// energy stored in the bristles.
    pub interfaces: Vec<f64>,
    /// Time integral of the absolute values of all powers, including the exchange of kinetic and
    /// potential energy, J. The energy error is relative to this value.
    pub turnover: f64,
}

impl Simulation<'_> {
    /// Sets the energy that friction dissipates in a velocity jump to the energy that the mechanism
    /// loses, and distributes it such that no interface supplies energy. The jump consists of two
    /// halves of a step. If the mechanism gains energy, nothing is dissipated, and the residual of
    /// the energy balance is this gain.
    ///
    /// Only the sum is determined: frictions that stress the mechanism against itself do no work
    /// together, but may seem to do much work one by one. If an interface reverses in the jump, its
    /// work is the product of a very large impulse and a velocity near 0, and round-off leaves no
    /// correct digit in the sum of the works.
    pub(super) fn account_for_jump(&self, first: &mut StepResult, second: &mut StepResult) {
        let works = [&first.time_step.work, &second.time_step.work];
        let supplied: f64 = works
            .iter()
            .map(|work| work.drives.iter().sum::<f64>() + work.loads - work.dampers)
            .sum();
        let before = self.now.account.kinetic + self.now.account.potential;
        let lost = (before + supplied - self.model.energy(&second.state)).max(0.0);
        let interfaces = works[0].interfaces.iter().zip(&works[1].interfaces);
        let mut shares: Vec<f64> = interfaces.map(|(a, b)| a.max(0.0) + b.max(0.0)).collect();
        if shares.iter().all(|share| *share == 0.0) {
            let impulses = first.time_step.frictions.iter().zip(&second.time_step.frictions);
            shares = impulses.map(|(a, b)| norm(*a) + norm(*b)).collect();
        }
        let all: f64 = shares.iter().sum();
        let scale = if all > 0.0 { lost / all } else { 0.0 };
        shares.iter_mut().for_each(|share| *share *= scale);
        first.time_step.work.interfaces = shares;
        second.time_step.work.interfaces.fill(0.0);
    }

    /// Returns the work and dissipated energy since the start, J.
    pub fn energies(&self) -> &Energies {
        &self.shown().energies
    }

    /// Returns the residual of the energy balance since the start, J: change of kinetic and
    /// potential energy, minus work of actuators and loads, minus energy of payloads, plus
    /// dissipated energy. The residual is zero for an exact solution.
    pub fn energy_error(&self) -> f64 {
        let Self { energies, now, .. } = self.shown();
        let Energies { drives, loads, dampers, impacts, payloads, interfaces, .. } = energies;
        let now = now.account.kinetic + now.account.potential;
        let supplied = drives.iter().sum::<f64>() + loads + payloads;
        now - self.energy_at_start - supplied + dampers + impacts + interfaces.iter().sum::<f64>()
    }
}
