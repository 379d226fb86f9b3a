//! Energy balance since the start of the simulation.
//!
//! Equation (E4) of the book's theory.

use super::Simulation;

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

impl Energies {
    /// Distributes the dissipated energy of a velocity jump, if it is positive, such that no interface
    /// supplies energy. In a jump only the sum is determined: frictions that stress the mechanism against itself do no work
    /// together, but may seem to do much work one by one.
    /// `more` is the energy lost to the reactions that the friction of each interface causes, J.
    pub(super) fn share_dissipation(&mut self, more: &[f64]) {
        self.interfaces.iter_mut().zip(more).for_each(|(lost, more)| *lost += more);
        let sum: f64 = self.interfaces.iter().sum();
        let positive: f64 = self.interfaces.iter().map(|lost| lost.max(0.0)).sum();
        if sum > 0.0 && sum < positive {
            self.interfaces.iter_mut().for_each(|lost| *lost = lost.max(0.0) * (sum / positive));
        }
    }
}

impl Simulation<'_> {
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
