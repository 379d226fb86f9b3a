//! The account of energy since the start.
//!
//! Equation (E4) of the book's theory.

use super::Simulation;

/// Work done since the start, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// By each actuator.
    pub drives: Vec<f64>,
    /// By all loads.
    pub loads: f64,
    /// Dissipated in dampers.
    pub dampers: f64,
    /// Dissipated in each contact; of bristles with what they store.
    pub interfaces: Vec<f64>,
    /// All powers summed as magnitudes, that between kinetic and potential energy among them.
    pub turnover: f64,
}

impl Simulation<'_> {
    /// Work since the start.
    pub fn energies(&self) -> &Energies {
        &self.energies
    }

    /// Kinetic and potential energy less what was put in and plus what was dissipated since the start:
    /// what is lost to errors, J.
    pub fn energy_error(&self) -> f64 {
        let Energies { drives, loads, dampers, interfaces, .. } = &self.energies;
        let now = self.now.account.kinetic + self.now.account.potential;
        let put_in = drives.iter().sum::<f64>() + loads;
        now - self.energy_at_start - put_in + dampers + interfaces.iter().sum::<f64>()
    }
}
