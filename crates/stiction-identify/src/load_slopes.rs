//! Derivatives of converged normal loads with respect to friction parameters.
//!
//! Equations (I6) and (I12) of the book's theory.

use crate::parameter::Kind;
use crate::regressor::Regressor;
use crate::solved::Solved;
use nalgebra::DMatrix;
use stiction_core::dynamics::{Data, LoadSensitivity, Settings, Status};
use stiction_core::parameters::Parameters;

/// Derivatives of all normal loads with respect to groups of friction parameters. All parameters of
/// a group have the same value. The preloads, which represent load-independent friction, count as
/// constant, and so do the inertias of the bodies.
#[derive(Debug)]
pub struct LoadSlopes<'a> {
    regressor: &'a Regressor,
    /// Friction parameters of each group, with the indices of their interfaces.
    groups: Vec<Vec<(Kind, usize)>>,
    sensitivity: LoadSensitivity,
}

impl<'a> LoadSlopes<'a> {
    /// Prepares the derivatives with respect to `groups` of indices of parameters.
    pub fn new(regressor: &'a Regressor, groups: &[Vec<usize>]) -> Self {
        let all = regressor.parameters();
        let of_group = |group: &Vec<usize>| {
            let kinds = group.iter().map(|&k| all[k].kind);
            kinds.filter_map(|kind| Some((kind, kind.interface()?))).collect()
        };
        Self {
            regressor,
            groups: groups.iter().map(of_group).collect(),
            sensitivity: LoadSensitivity::default(),
        }
    }

    /// Computes the derivative of the normal load of each friction interface (rows) with respect to
    /// each group (columns). `solved` is the solution of the forces in `data`, for the parameters
    /// `engine`.
    ///
    /// # Errors
    /// [`Status::FrictionNotConverged`] if a derivative is not finite, for example close to
    /// jamming.
    pub fn at(
        &mut self,
        solved: &Solved,
        (engine, data): (&Parameters<f64>, &Data<f64>),
    ) -> Result<DMatrix<f64>, Status> {
        if self.groups.is_empty() {
            return Ok(DMatrix::zeros(solved.loads.len(), 0));
        }
        let all = self.sensitivity.at(self.regressor.model(), engine, data);
        let all = all.ok_or(Status::FrictionNotConverged { change: f64::INFINITY })?;
        let mut slopes = DMatrix::zeros(all.nrows(), self.groups.len());
        for (group, mut slopes) in self.groups.iter().zip(slopes.column_iter_mut()) {
            for &(kind, interface) in group {
                let friction = self.friction_per_unit(kind, interface, solved, engine);
                slopes.axpy(friction, &all.column(interface), 1.0);
            }
        }
        Ok(slopes)
    }

    /// Returns the friction of an interface per unit of one of its parameters, N, at the present
    /// load.
    fn friction_per_unit(
        &self,
        kind: Kind,
        interface: usize,
        solved: &Solved,
        engine: &Parameters<f64>,
    ) -> f64 {
        let velocity = solved.velocities[interface];
        if velocity.abs() <= Settings::default().rest_speed {
            return 0.0;
        }
        let load = match kind {
            Kind::Mu(_) => solved.loads[interface],
            Kind::StaticExcess(_) => {
                let own = &engine.interfaces[interface];
                own.law.mu * (solved.loads[interface] + own.load.preload)
            }
            _ => 1.0,
        };
        load * self.regressor.friction_per_unit(kind, interface, velocity)
    }
}
