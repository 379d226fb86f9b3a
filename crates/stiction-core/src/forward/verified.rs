//! Verification of accelerations, joint wrenches and friction by the equations that they must
//! satisfy.

use super::Forward;
use super::affine_friction::{InterfaceMode, norm};
use super::data::Data;
use super::instant::Instant;
use super::recorded::ProgramResults;
use crate::dynamics::spring_powers;
use crate::spatial::Wrench;

/// Largest residual of an equation, relative to the largest wrench, acceleration, velocity or
/// power. The solutions of recorded programs are not refined, so the tolerance is close to
/// round-off.
const MET: f64 = 1e-10;

impl Forward {
    /// Returns true if the results of a program, which are also in `instant`, satisfy all
    /// equations: the motion of each body, the efforts and frictions in each joint, the friction
    /// laws, the loops, the velocities and the powers. All interfaces must slide, without gearings
    /// or motor shafts. `sums` is a buffer.
    pub(super) fn satisfies_all_equations(
        &self,
        (data, modes): (&Data, &[InterfaceMode]),
        instant: &Instant,
        results: &ProgramResults<'_>,
        sums: &mut Vec<Wrench<f64>>,
    ) -> bool {
        sums.clear();
        sums.push(Wrench::zero());
        let bodies = 1..instant.bodies.pose.len();
        sums.extend(bodies.map(|body| self.demand_of(data, instant, body)));
        let sizes = instant.wrenches.iter().chain(&*sums).map(|wrench| self.size_of(*wrench));
        let largest = sizes.fold(0.0, f64::max);
        self.moves_bodies(instant, MET * largest, sums)
            && self.transmits_efforts((data, modes), instant, MET * largest, sums)
            && self.closes_loops(instant)
            && self.has_velocities_and_powers(data, instant, results, largest)
    }

    /// Returns true if velocities and powers of the program are those of the moving bodies.
    /// `largest` is the size of the largest wrench, N.
    fn has_velocities_and_powers(
        &self,
        data: &Data,
        instant: &Instant,
        results: &ProgramResults<'_>,
        largest: f64,
    ) -> bool {
        let (topology, length) = (&self.topology, self.parameters.length);
        let least = MET * self.fastest(data) * length;
        let slides = results
            .velocities
            .iter()
            .zip(&data.velocities)
            .all(|(found, velocity)| norm([0, 1, 2].map(|i| found[i] - velocity[i])) <= least);
        let turns = topology.actuators.iter().zip(results.actuator_rates).all(|(own, found)| {
            let dof = &topology.joint_types[own.joint].dofs()[own.dof];
            let arm = if dof.translates() { 1.0 } else { length };
            (found - data.bodies.actuator_rate(topology, *own)).abs() * arm <= least
        });
        let account = &instant.account;
        let powers = [account.loads, account.dampers, account.exchange];
        let mut works = powers.iter().zip(results.powers);
        // Loads and preloads that cancel each other do not appear in any resultant.
        let loads = data.loads.iter().map(|load| self.size_of(load.wrench(&data.bodies)));
        let springs = spring_powers(&self.parameters, &data.bodies).map(|spring| spring.turnover);
        let least = (largest + loads.sum::<f64>()) * least + MET * springs.sum::<f64>();
        slides && turns && works.all(|(power, found)| (found - power).abs() <= least)
    }

    /// Wrench that the joints must exert on a body for its acceleration.
    fn demand_of(&self, data: &Data, instant: &Instant, body: usize) -> Wrench<f64> {
        let bodies = &instant.bodies;
        let change = bodies.acceleration[body] - bodies.bias[body];
        data.masses.bias_wrenches[body] + data.masses.inertia[body].times(change)
    }

    /// Returns true if the joint wrenches cause the accelerations of all bodies. `missing` contains the
    /// wrench that each body requires, and receives the wrench that it lacks.
    fn moves_bodies(&self, instant: &Instant, least: f64, missing: &mut [Wrench<f64>]) -> bool {
        for (wrench, (predecessor, successor)) in instant.wrenches.iter().zip(&self.topology.ends) {
            missing[*successor] -= *wrench;
            missing[*predecessor] += *wrench;
        }
        missing[1..].iter().all(|wrench| self.size_of(*wrench) <= least)
    }

    /// Returns true if each joint exerts, along its degrees of freedom, only its effort and
    /// friction, and if normal loads and frictions satisfy the friction laws.
    fn transmits_efforts(
        &self,
        (data, modes): (&Data, &[InterfaceMode]),
        instant: &Instant,
        least: f64,
        constraint: &mut Vec<Wrench<f64>>,
    ) -> bool {
        let (topology, parameters, bodies) = (&self.topology, &self.parameters, &instant.bodies);
        constraint.clone_from(&instant.wrenches);
        for (joint, wrench) in self.actuator_wrenches(data) {
            constraint[joint] -= wrench;
        }
        for (index, content) in parameters.interfaces.iter().enumerate() {
            let (interface, joint) = (&instant.interfaces[index], content.joint);
            let law = self.friction(data, index, modes[index]);
            let effort = [0, 1, 2].map(|i| -law.constant[i] - law.per_load[i] * interface.load);
            constraint[joint] -= bodies.wrench_of(topology, content, effort);
            let wrench = instant.wrenches[joint];
            let load = self.configuration(data).normal_load(index, wrench, law.own).value;
            let friction = law.at_surface(content.arms(parameters.pitch[joint]), interface.load);
            let apart = norm([0, 1, 2].map(|i| friction[i] - interface.friction[i]));
            if !((load - interface.load).abs() <= least && apart <= least) {
                return false;
            }
        }
        constraint.iter().enumerate().all(|(joint, wrench)| {
            let (j, k) = (&bodies.frame_j[joint], &bodies.frame_k[joint]);
            topology.joint_types[joint].dofs().iter().all(|dof| {
                let effort = dof.twist(j, k, parameters.pitch[joint]).power(*wrench);
                let arm = if dof.translates() { 1.0 } else { parameters.length };
                effort.abs() <= least * arm
            })
        })
    }

    /// Returns true if the accelerations satisfy the constraints of all cut joints.
    fn closes_loops(&self, instant: &Instant) -> bool {
        let (topology, parameters, bodies) = (&self.topology, &self.parameters, &instant.bodies);
        let largest = bodies.acceleration.iter().map(|twist| self.twist_rate(twist));
        let least = MET * largest.fold(0.0, f64::max);
        topology.cuts.iter().all(|cut| {
            let joint = cut.joint;
            let (predecessor, successor) = topology.ends[joint];
            let (j, k) = (&bodies.frame_j[joint], &bodies.frame_k[joint]);
            let relative = bodies.acceleration[successor] - bodies.acceleration[predecessor];
            let error = relative - bodies.joint_bias(topology, parameters, joint);
            topology.joint_types[joint].constraints().iter().all(|constraint| {
                let along = error.power(constraint.wrench(j, k, parameters.pitch[joint]));
                let arm = if constraint.is_moment() { 1.0 } else { parameters.length };
                along.abs() <= least * arm
            })
        })
    }

    /// Returns the size of a wrench about the reference point, N.
    fn size_of(&self, wrench: Wrench<f64>) -> f64 {
        wrench.force.norm().max(wrench.moment.norm() / self.parameters.length)
    }
}
