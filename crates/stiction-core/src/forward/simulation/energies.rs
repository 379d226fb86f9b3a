//! Energy balance since the start.
//!
//! Equation (E4) of the book's theory.

use super::Simulation;

/// Work done since the start, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// Work of each actuator.
    pub drives: Vec<f64>,
    /// Work of all external loads.
    pub loads: f64,
    /// Energy dissipated in dampers.
    pub dampers: f64,
    /// Energy lost in plastic impacts with parts that bodies pick up.
    pub impacts: f64,
    /// Energy that parts bring when bodies pick them up, less the energy of parts that are placed.
    pub payloads: f64,
    /// Energy dissipated in each friction interface; for bristle laws including stored energy.
    pub interfaces: Vec<f64>,
    /// Integral of the magnitudes of all powers, including the exchange of kinetic and potential energy.
    pub turnover: f64,
}

impl Simulation<'_> {
    /// Work and dissipated energy since the start, J.
    pub fn energies(&self) -> &Energies {
        &self.shown().energies
    }

    /// Residual of the energy balance since the start, J: change of kinetic and potential energy, minus work
    /// of actuators and loads, minus energy of payloads, plus dissipated energy.
    pub fn energy_error(&self) -> f64 {
        let Self { energies, now, .. } = self.shown();
        let Energies { drives, loads, dampers, impacts, payloads, interfaces, .. } = energies;
        let now = now.account.kinetic + now.account.potential;
        let supplied = drives.iter().sum::<f64>() + loads + payloads;
        now - self.energy_at_start - supplied + dampers + impacts + interfaces.iter().sum::<f64>()
    }
}
