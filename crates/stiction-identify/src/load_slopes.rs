//! Derivatives of converged normal loads with respect to parameters.
//!
//! Equations (I6) and (I12) of the book's theory.

use crate::parameter::Kind;
use crate::regressor::Regressor;
use crate::solved::Solved;
use nalgebra::DMatrix;
use stiction_core::dynamics::{Data, LoadSensitivity, Settings, Status};
use stiction_core::parameters::Parameters;

/// Derivatives of all normal loads with respect to groups of parameters. All parameters of a group
/// have the same value. The preloads, which represent load-independent friction, count as constant.
#[derive(Debug)]
pub struct LoadSlopes<'a> {
    regressor: &'a Regressor,
    /// Parameters of each group.
    groups: Vec<Vec<Kind>>,
    /// Bodies whose required wrenches depend on parameters of the groups.
    bodies: Vec<usize>,
    sensitivity: LoadSensitivity,
}

impl<'a> LoadSlopes<'a> {
    /// Prepares the derivatives with respect to `groups` of indices of parameters.
    pub fn new(regressor: &'a Regressor, groups: &[Vec<usize>]) -> Self {
        let all = regressor.parameters();
        let of_group = |group: &Vec<usize>| group.iter().map(|&k| all[k].kind).collect();
        let groups: Vec<Vec<Kind>> = groups.iter().map(of_group).collect();
        let mut bodies: Vec<usize> =
            groups.iter().flatten().flat_map(|kind| regressor.loaded_bodies(*kind)).collect();
        bodies.sort_unstable();
        bodies.dedup();
        Self { regressor, groups, bodies, sensitivity: LoadSensitivity::default() }
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
        let changes = self.sensitivity.at(self.regressor.model(), engine, data, &self.bodies);
        let changes = changes.ok_or(Status::FrictionNotConverged { change: f64::INFINITY })?;
        let mut slopes = DMatrix::zeros(changes.by_friction.nrows(), self.groups.len());
        for (group, mut slopes) in self.groups.iter().zip(slopes.column_iter_mut()) {
            for &kind in group {
                if let Some(interface) = kind.interface() {
                    let friction = self.friction_per_unit(kind, interface, solved, engine);
                    slopes.axpy(friction, &changes.by_friction.column(interface), 1.0);
                }
                for (body, wrench) in self.regressor.unit_demands(kind, &data.kinematics.bodies) {
                    let Ok(place) = self.bodies.binary_search(&body) else { continue };
                    let components = [wrench.force.to_array(), wrench.moment.to_array()];
                    for (k, component) in components.as_flattened().iter().enumerate() {
                        let column = components.as_flattened().len() * place + k;
                        slopes.axpy(*component, &changes.by_demand.column(column), 1.0);
                    }
                }
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
