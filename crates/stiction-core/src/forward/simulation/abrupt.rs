//! Detection of impacts: loop constraints, locks or prescribed motions that would stop a motion
//! instantly.
//!
//! At a dead centre a lock permits rates that it does not permit an instant later, because the
//! constraint row of the lock vanishes at the dead centre. The acceleration that the lock requires
//! then contradicts the other constraints, and no finite force satisfies all of them. The
//! simulation refuses such a start. During the motion, the same condition is detected when rates
//! are projected onto the loop constraints after a step: the projection then changes the rates by
//! more than the error of the step.

use super::packing::parts;
use super::{Energies, Simulation};
use crate::forward::Forward;
use crate::forward::constraint_rank::Contradiction;
use crate::forward::data::{Data, FrictionDistribution};
use crate::forward::error::ForwardError;
use crate::forward::inputs::{InputState, Inputs};
use crate::forward::instant::Instant;
use crate::kinematics::State;

/// Fraction of the largest rate above which a change of the rates by the projection onto the
/// constraints counts as an impact. Integration errors are orders of magnitude smaller, at any
/// tolerance that can be met near a singular configuration.
const CHANGE: f64 = 1e-5;
/// Largest residual of the energy balance over a step, as a fraction of the energy exchanged in the
/// step plus the kinetic energy. A step of order eight with rates accurate to 1e-10 leaves a
/// residual about a thousand times smaller.
const WRONG: f64 = 1e-5;
/// Additional residual allowed for round-off, as a fraction of the total energy and the energy
/// exchanged since the start.
const ROUNDING: f64 = 1e-10;

impl Forward {
    /// Checks that some accelerations satisfy the constraints of loops, locks and prescribed
    /// motions. Friction is ignored.
    pub(super) fn check_accelerations(&self, situation: &Data) -> Result<(), ForwardError> {
        // Without constraints there is no contradiction.
        if self.topology.closures() == 0 && self.prescribed.is_empty() {
            return Ok(());
        }
        let Some(found) = self.contradiction(situation) else { return Ok(()) };
        let Contradiction { row, by, translates } = found;
        let what = self.condition(row);
        Err(ForwardError::Blocked { time: situation.time, what, by, translates, at_rest: false })
    }

    /// Checks that a motion that begins from rest can continue over a finite distance. For this
    /// purpose the accelerations are used as rates, and the constraints must allow accelerations
    /// for these rates as well.
    pub(super) fn check_finite_motion(
        &self,
        now: &Instant,
        (input, inputs): (&InputState, &mut dyn Inputs),
    ) -> Result<(), ForwardError> {
        let targets = self.targets(now.time, inputs);
        let prescribed = targets.iter().any(|t| t.rate != 0.0 || t.acceleration != 0.0);
        let State { rates, accelerations, .. } = &now.state;
        if prescribed || rates.iter().any(|v| *v != 0.0) || accelerations.iter().all(|a| *a == 0.0)
        {
            return Ok(());
        }
        let mut state = now.state.clone();
        state.rates.clone_from(accelerations);
        let bristles = vec![[0.0; 3]; now.interfaces.len()];
        let situation = self.data(
            now.time,
            state,
            &bristles,
            &FrictionDistribution::default(),
            (input, inputs),
        );
        self.check_accelerations(&situation).map_err(|error| match error {
            ForwardError::Blocked { time, what, by, translates, .. } => {
                ForwardError::Blocked { time, what, by, translates, at_rest: true }
            }
            other => other,
        })
    }

    /// Returns the name of a constraint row for messages.
    fn condition(&self, row: usize) -> String {
        let topology = &self.topology;
        let mut first = 0;
        for cut in &topology.cuts {
            first += topology.joint_types[cut.joint].constraints().len();
            if row < first {
                return format!("the loop through joint `{}`", self.joint_name(cut.joint));
            }
        }
        let row = row - first;
        if let Some(own) = topology.gearings.get(row) {
            return format!("gearing `{}`", self.simulated().gearings()[own.gearing].name);
        }
        match self.prescribed.get(row - topology.gearings.len()) {
            Some(&actuator) => {
                let at = topology.actuators[actuator];
                let name = self.joint_name(at.joint);
                match topology.joint_types[at.joint].dofs() {
                    [_] => format!("joint `{name}`, which is locked or prescribed,"),
                    all => {
                        let own = all[at.dof].name;
                        format!("joint `{name}.{own}`, which is locked or prescribed,")
                    }
                }
            }
            None => "a joint held by friction".to_owned(),
        }
    }
}

impl Simulation<'_> {
    /// Checks that the last step was regular: the projection onto the loop constraints changed the
    /// rates only slightly, and the energy of the step is balanced. `y` is the state vector at the
    /// end of the step before the projection.
    ///
    /// # Errors
    /// [`ForwardError::Impact`] or [`ForwardError::Stiff`]; a shorter step may succeed.
    pub(super) fn check_step(
        &self,
        y: &[f64],
        arrived: &Instant,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let (model, time) = (self.model, arrived.time);
        let allowed = |part: f64| part.max(1e3 * self.attainable_tolerance());
        let (_, free, rest) = parts(&self.now, y);
        let size = |of: &dyn Fn(usize) -> f64| {
            let each = model.columns.iter().enumerate();
            each.map(|(k, column)| (of(k) / column).abs()).fold(0.0, f64::max)
        };
        let changed = size(&|k| arrived.state.rates[k] - free[k]);
        let largest = size(&|k| free[k]).max(self.fastest_rate);
        // The absolute term covers mechanisms at rest, whose rates and changes of rates are
        // round-off.
        if changed > allowed(CHANGE) * largest + 1e3 * self.settings.absolute {
            let targets = model.targets(time, inputs);
            let rows = model.constraint_rows(&arrived.bodies, &targets, &[]);
            let n = model.topology.dofs();
            let first = model.topology.closures();
            let missed = |row: usize| {
                let entries = &rows.matrix[row * n..(row + 1) * n];
                let has: f64 = entries.iter().zip(free).map(|(a, b)| a * b).sum();
                let wanted = row.checked_sub(first).map_or(0.0, |k| targets[k].rate);
                rows.rows[row].scale * (has - wanted).abs()
            };
            let worst = (0..rows.rows.len()).max_by(|a, b| missed(*a).total_cmp(&missed(*b)));
            let worst = worst.unwrap_or(rows.rows.len());
            let (what, by_loop) = (model.condition(worst), worst < first);
            let percent = 100.0 * changed / largest;
            return Err(ForwardError::Impact { time, what, percent, by_loop });
        }
        let Energies { loads, dampers, turnover, .. } = self.energies;
        let energies = &rest[3 * self.modes.len()..];
        let (drives, energies) = energies.split_at(self.energies.drives.len());
        let supplied = drives.iter().sum::<f64>() - self.energies.drives.iter().sum::<f64>()
            + (energies[0] - loads);
        let interfaces = &energies[3..3 + self.modes.len()];
        let lost = energies[1] - dampers + interfaces.iter().sum::<f64>()
            - self.energies.interfaces.iter().sum::<f64>();
        let (was, is) = (&self.now.account, &arrived.account);
        let gained = (is.kinetic - was.kinetic) + (is.potential - was.potential);
        let step = energies[2] - turnover + is.kinetic.max(was.kinetic);
        let all = is.kinetic + is.potential.abs() + energies[2];
        if (gained - supplied + lost).abs() > allowed(WRONG) * step + ROUNDING * all {
            return Err(ForwardError::Stiff {
                time,
                step: time - self.now.time,
                tolerance: self.settings.relative,
                around: " (the energy balance of the step does not close)".to_owned(),
            });
        }
        Ok(())
    }
}
