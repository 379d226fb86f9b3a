//! Energy balance since the start.
//!
//! Equation (E4) of the book's theory.

use super::Simulation;

/// Work done and energy dissipated since the start, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// Work of each actuator on the mechanism.
    pub drives: Vec<f64>,
    /// Work of all external loads on the mechanism.
    pub loads: f64,
    /// Energy dissipated in dampers.
    pub dampers: f64,
    /// Energy lost in plastic impacts when bodies pick up parts.
    pub impacts: f64,
    /// Energy of the parts that bodies pick up, minus the energy of the parts that they place.
    pub payloads: f64,
    /// Energy dissipated in each friction interface; for bristle laws including the energy stored in the bristles.
    pub interfaces: Vec<f64>,
    /// Integral of the magnitudes of all powers, including the exchange of kinetic and potential energy: the scale of
    /// the energy error.
    pub turnover: f64,
}

impl Simulation<'_> {
    /// Work and dissipated energy since the start, J.
    pub fn energies(&self) -> &Energies {
        &self.shown().energies
    }

    /// Residual of the energy balance since the start, J: change of kinetic and potential energy, minus work of
    /// actuators and loads, minus energy of payloads, plus dissipated energy. It is zero for an exact solution.
    pub fn energy_error(&self) -> f64 {
        let Self { energies, now, .. } = self.shown();
        let Energies { drives, loads, dampers, impacts, payloads, interfaces, .. } = energies;
        let now = now.account.kinetic + now.account.potential;
        let supplied = drives.iter().sum::<f64>() + loads + payloads;
        now - self.energy_at_start - supplied + dampers + impacts + interfaces.iter().sum::<f64>()
    }
}
