//! Derivatives of converged normal loads with respect to parameters, by dual numbers.
//!
//! Equation (I6) of the book's theory.

use crate::parameter::Kind;
use crate::physical::{self, Inertial};
use crate::regressor::Regressor;
use crate::solved::Solved;
use stiction_core::dynamics::{Data, Settings, Status};
use stiction_core::kinematics::Target;
use stiction_core::parameters::Parameters;
use stiction_core::scalar::{Dual, Scalar};
use stiction_core::spatial::Vec3;

/// Number of directions of differentiation in one evaluation of the dynamics.
pub const DIRECTIONS: usize = 8;

type D = Dual<f64, DIRECTIONS>;

/// Derivatives of all normal loads with respect to up to [`DIRECTIONS`] groups of parameters. All
/// parameters of a group have the same value. The preloads, which represent load-independent
/// friction, count as constant.
#[derive(Debug)]
pub struct LoadSlopes<'a> {
    regressor: &'a Regressor,
    groups: &'a [Vec<usize>],
    parameters: Parameters<D>,
    data: Data<D>,
    /// Coefficient of sliding friction and preload, N, of each interface.
    sliding: Vec<[f64; 2]>,
}

impl<'a> LoadSlopes<'a> {
    /// Prepares the derivatives with respect to the first [`DIRECTIONS`] of `groups`, at `values`,
    /// the values of all parameters.
    pub fn new(regressor: &'a Regressor, values: &[f64], groups: &'a [Vec<usize>]) -> Self {
        let engine = regressor.engine_parameters(values);
        // The parameters are those of a mechanism with the same geometry; values that
        // identification changes are copied.
        let mut parameters: Parameters<D> = Parameters::new(regressor.mechanism());
        for (own, from) in parameters.interfaces.iter_mut().zip(&engine.interfaces) {
            own.law = from.law.lift();
            own.backward = from.backward.as_ref().map(|law| law.lift());
            own.load = from.load.lift();
        }
        for body in 0..engine.mass.len() {
            parameters.mass[body] = D::from_f64(engine.mass[body]);
            parameters.com[body] = engine.com[body].lift();
            parameters.inertia[body] = engine.inertia[body].lift();
        }
        let groups = &groups[..groups.len().min(DIRECTIONS)];
        let all = regressor.parameters();
        for (direction, &first) in groups.iter().filter_map(|group| group.first()).enumerate() {
            let Some(body) = all[first].body() else { continue };
            let place = all[..first].iter().filter(|p| p.body() == Some(body)).count();
            let (mass, com, inertia) = (engine.mass[body], engine.com[body], engine.inertia[body]);
            if mass <= 0.0 {
                continue;
            }
            let present: Inertial = physical::about_origin(mass, com, inertia);
            let mut varied = present.map(D::constant);
            varied[place] = D::variable(present[place], direction);
            let slopes = physical::central(&varied);
            // Only this direction is copied, because other directions may also belong to this body.
            parameters.mass[body].slope[direction] = slopes.0.slope[direction];
            let copy = |to: &mut Vec3<D>, from: &Vec3<D>| {
                to.x.slope[direction] = from.x.slope[direction];
                to.y.slope[direction] = from.y.slope[direction];
                to.z.slope[direction] = from.z.slope[direction];
            };
            copy(&mut parameters.com[body], &slopes.1);
            let columns = parameters.inertia[body].columns.iter_mut();
            columns.zip(&slopes.2.columns).for_each(|(to, from)| copy(to, from));
        }
        let model = regressor.model();
        let data = model.data(regressor.state(), Settings::default());
        let sliding = engine.interfaces.iter().map(|own| [own.law.mu, own.load.preload]).collect();
        Self { regressor, groups, parameters, data, sliding }
    }

    /// Computes the derivative of the normal load of each friction interface with respect to each
    /// group. `solved` is the solution of the forces for the same parameter values and for the
    /// motion `[q, v, a]`.
    ///
    /// # Errors
    /// [`Status::FrictionNotConverged`] if a derivative is not finite, for example close to
    /// jamming.
    pub fn at(
        &mut self,
        solved: &Solved,
        [q, v, a]: [&[f64]; 3],
    ) -> Result<impl Iterator<Item = [f64; DIRECTIONS]> + '_, Status> {
        self.set_friction(solved);
        let targets: Vec<Target<D>> = (q.iter().zip(v).zip(a))
            .map(|((&value, &rate), &acceleration)| Target { value, rate, acceleration }.lift())
            .collect();
        self.data.state = solved.state.lift();
        // The loops are already closed in this state. Derivatives converge one step later than the
        // values.
        self.data.settings = Settings {
            position_steps: 0,
            friction_steps: solved.steps + 1,
            friction_tolerance: 0.0,
            ..Settings::default()
        };
        self.regressor.model().evaluate(&self.parameters, &mut self.data, &targets, &[]);
        let loads = || self.data.inverse.interfaces().iter().map(|own| own.load().slope);
        match loads().flatten().all(f64::is_finite) {
            true => Ok(loads()),
            false => Err(Status::FrictionNotConverged { change: f64::INFINITY }),
        }
    }

    /// Sets the derivatives of each interface's friction at the present loads. They are stored as
    /// derivatives of the viscous coefficient: friction per unit of the group, divided by the
    /// speed.
    fn set_friction(&mut self, solved: &Solved) {
        let all = self.regressor.parameters();
        for (i, interface) in self.parameters.interfaces.iter_mut().enumerate() {
            let velocity = solved.velocities[i];
            let speed = velocity.abs();
            let mut slope = [0.0; DIRECTIONS];
            for (slope, group) in slope.iter_mut().zip(self.groups) {
                for kind in group.iter().map(|&k| all[k].kind) {
                    let load = match kind {
                        Kind::Mu(own) if own == i => solved.loads[i],
                        Kind::Coulomb(own) | Kind::Viscous(own) if own == i => 1.0,
                        Kind::StaticExcess(own) if own == i => {
                            let [mu, preload] = self.sliding[i];
                            mu * (solved.loads[i] + preload)
                        }
                        _ => continue,
                    };
                    if speed > Settings::default().rest_speed {
                        *slope +=
                            load * self.regressor.friction_per_unit(kind, i, velocity) / speed;
                    }
                }
            }
            interface.law.viscous.slope = slope;
            if let Some(backward) = &mut interface.backward {
                backward.viscous.slope = slope;
            }
        }
    }
}
