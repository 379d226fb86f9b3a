//! Reaction to events: decides which interfaces at rest stick and which slip.

use super::locate::Ending;
use super::{Event, EventKind, REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::data::{Data, KnownForces};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::project::Anchor;
use crate::forward::stick::Choice;
use crate::kinematics::State;

/// Largest number of decisions between stick and slip since the last step without an event. If it
/// is exceeded, the simulation fails with [`ForwardError::Stiff`].
const EVENTS_AT_ONCE: usize = 200;

impl Simulation<'_> {
    /// Reacts to the event that ended a step. `since` is the start of the step, s.
    pub(super) fn follow_up(
        &mut self,
        ending: Ending,
        since: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let leaves = self.leaves_its_limit(since);
        match ending {
            Ending::Smooth => {
                self.stalled = 0;
                self.look_for_others(inputs)?;
                let changes = leaves || self.rests_as_prescribed(inputs);
                if changes { self.reconsider(inputs, None) } else { Ok(()) }
            }
            // Where the prescribed motion comes to rest, the sliding velocity may change its sign
            // by round-off alone. Friction has then not stopped the interface.
            Ending::Stops(_) if self.rests_as_prescribed(inputs) => self.reconsider(inputs, None),
            Ending::Stops(interface) => self.reconsider(inputs, Some(interface)),
            Ending::SlipOnset | Ending::Passes(_) => self.reconsider(inputs, None),
        }
    }

    /// Returns true if an interface that was at its friction limit during the last step slips or
    /// begins to slip. Records the slip onset as an event at the start of this step, `since`, s,
    /// because the friction that prevented the slip reached its limit at that time.
    fn leaves_its_limit(&mut self, since: f64) -> bool {
        let mut leaves = false;
        for interface in 0..self.modes.len() {
            let InterfaceMode::AtLimit(direction) = self.modes[interface] else { continue };
            let along = |v: [f64; 3]| v.iter().zip(direction).map(|(v, d)| v * d).sum::<f64>();
            let velocity = self.now.interfaces[interface].velocity;
            let moves = norm(velocity) > REST * self.fastest;
            let begins = self.model.surface_acceleration(&self.now.bodies, interface);
            let accelerations = &self.now.state.accelerations;
            let rounding = self.model.rounding_of_onset(accelerations, interface);
            leaves |= moves || norm(begins) > rounding;
            if moves && along(velocity) > 0.0 || !moves && along(begins) > rounding {
                let joint = self.model.reported_joint(interface);
                let kind = EventKind::Slides { interface, joint, direction };
                // An event for a singular configuration may already have been recorded after
                // `since`.
                let place = self.events.partition_point(|event| event.time <= since);
                self.events.insert(place, Event { time: since, kind });
                self.modes[interface] = InterfaceMode::Slides(direction);
            }
        }
        leaves
    }

    /// Decides which interfaces at rest stick and which slip. `stopped` is the interface whose slip
    /// has just stopped, if any.
    pub(super) fn reconsider(
        &mut self,
        inputs: &mut dyn Inputs,
        stopped: Option<usize>,
    ) -> Result<(), ForwardError> {
        self.decide(inputs, stopped, None)
    }

    /// Like [`Self::reconsider`], and first tries whether the forces `known` hold the mechanism if
    /// they are given.
    pub(super) fn decide(
        &mut self,
        inputs: &mut dyn Inputs,
        stopped: Option<usize>,
        known: Option<KnownForces>,
    ) -> Result<(), ForwardError> {
        if self.stepping.is_none() && self.is_dense() {
            self.wait_longer();
            self.begin_stepping();
            return Ok(());
        }
        self.stalled += 1;
        let model = self.model;
        let time = self.now.time;
        if self.stalled > EVENTS_AT_ONCE {
            return Err(ForwardError::Stiff {
                time,
                step: 0.0,
                tolerance: self.settings.relative,
                around: match stopped {
                    Some(interface) => {
                        let joint = model.joint_name(model.parameters.interfaces[interface].joint);
                        format!(" (joint `{joint}` alternates endlessly between stick and slip)")
                    }
                    None => String::new(),
                },
            });
        }
        let mut state = self.now.state.clone();
        let targets = model.targets(time, inputs);
        if let Some(interface) = stopped {
            // Sets the velocity of this interface, and of all DOFs that the interface locks, to
            // exactly zero.
            let (anchors, frozen) = self.holds_of(&[interface]);
            let frozen: Vec<bool> =
                frozen.iter().zip(&self.frozen).map(|(a, b)| *a || *b).collect();
            let anchors: Vec<Anchor> = self.anchors.iter().copied().chain(anchors).collect();
            model.project(time, &mut state, &targets, &anchors, &frozen)?;
            if self.moves_on(&state) {
                return self.reverse(interface, inputs);
            }
        }
        let mut situation = self.situation_of(state, inputs);
        let velocities = situation.velocities.iter().copied();
        if (stopped.is_some() || known.is_some())
            && self.is_at_rest(&situation.state.rates, velocities)
        {
            // Centripetal accelerations of round-off must not decide between stick and slip.
            let mut state = situation.state.clone();
            state.rates.fill(0.0);
            situation = self.situation_of(state, inputs);
        }
        if let Some(interface) = stopped
            && !self.takes_dof(&situation, interface)
        {
            return self.reverse(interface, inputs);
        }
        let before = self.modes.clone();
        let mut modes = self.modes.clone();
        let mut resting = Vec::new();
        for (index, mode) in modes.iter_mut().enumerate() {
            let speed = norm(situation.velocities[index]);
            if *mode == InterfaceMode::Smooth {
                continue;
            }
            if speed <= REST * self.fastest
                || stopped == Some(index)
                || *mode == InterfaceMode::Sticks
            {
                match model.prescribed_mode(index, (time, self.fastest), inputs) {
                    Some(prescribed) => *mode = prescribed,
                    None => resting.push(index),
                }
            } else if matches!(mode, InterfaceMode::AtLimit(_)) {
                *mode = InterfaceMode::Slides(situation.velocities[index].map(|v| v / speed));
            }
        }
        let Choice { modes, solved } = model.choose(&mut situation, &modes, &resting, known)?;
        self.distribution.clone_from(&situation.distribution);
        self.limit_factor = situation.limit_factor;
        self.modes = modes;
        self.now = model.instant(&situation, &self.modes, &solved);
        self.restart_bound();
        self.record_mode_changes(&before, &[]);
        self.hold(inputs)?;
        self.look_for_others(inputs)?;
        // The first step after a change of modes is short.
        self.step = (0.1 * self.step).max(1e3 * self.settings.shortest_step);
        Ok(())
    }

    /// Returns true if all rates and sliding velocities are zero except for round-off.
    pub(super) fn is_at_rest(
        &self,
        rates: &[f64],
        mut velocities: impl Iterator<Item = [f64; 3]>,
    ) -> bool {
        let mut rates = rates.iter().zip(&self.model.columns);
        rates.all(|(rate, column)| (rate / column).abs() <= REST * self.fastest_rate)
            && velocities.all(|v| norm(v) <= REST * self.fastest)
    }

    /// Returns true if the mechanism keeps moving when an interface stops sliding. `stopped` is the
    /// state in which the sliding velocity of the interface is zero. The mechanism keeps moving at
    /// a dead centre, where the sliding velocity is zero only for an instant.
    pub(super) fn moves_on(&self, stopped: &State<f64>) -> bool {
        const OTHER: f64 = 1e-6;
        let columns = &self.model.columns;
        let size = |x: &dyn Fn(usize) -> f64| {
            columns.iter().enumerate().map(|(k, c)| (x(k) / c).abs()).fold(0.0, f64::max)
        };
        let rates = &self.now.state.rates;
        let change = size(&|k| stopped.rates[k] - rates[k]);
        change > OTHER * size(&|k| rates[k]) && change > OTHER * self.fastest_rate
    }

    /// Returns true if the mobility decreases when the interface sticks. At a dead centre, sticking
    /// does not reduce the mobility, because the interface is at rest only for an instant while the
    /// mechanism moves.
    pub(super) fn takes_dof(&self, situation: &Data, interface: usize) -> bool {
        let model = self.model;
        let mut sticks = self.modes.clone();
        sticks[interface] = InterfaceMode::Sticks;
        let mobility = |modes: &[InterfaceMode]| {
            model.mobility(situation, modes).map_or(0, |(mobility, _)| mobility)
        };
        mobility(&sticks) < mobility(&self.modes)
    }

    /// Reverses the direction of slip of an interface.
    pub(super) fn reverse(
        &mut self,
        interface: usize,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let before = self.modes.clone();
        if let InterfaceMode::Slides(direction) = self.modes[interface] {
            self.modes[interface] = InterfaceMode::Slides(direction.map(|d| -d));
        }
        let y = self.pack();
        self.now = self.evaluate(self.now.time, &y, inputs, self.settings.look_for_others)?;
        self.record_mode_changes(&before, &[]);
        self.step *= 0.1;
        Ok(())
    }

    /// Records an event for each interface that began to stick or to slip, or that reversed, since
    /// its modes were `before`. `stops` gives the interfaces that stopped or reversed before the
    /// present time, each with this time, s.
    pub(super) fn record_mode_changes(&mut self, before: &[InterfaceMode], stops: &[(usize, f64)]) {
        let first = self.events.len();
        for interface in 0..self.modes.len() {
            let joint = self.model.reported_joint(interface);
            let kind = match (before[interface], self.modes[interface]) {
                (
                    InterfaceMode::Sticks | InterfaceMode::AtLimit(_),
                    InterfaceMode::Sticks | InterfaceMode::AtLimit(_),
                ) => {
                    continue;
                }
                (_, InterfaceMode::Sticks | InterfaceMode::AtLimit(_)) => {
                    EventKind::Sticks { interface, joint }
                }
                // A gradual change of the direction of slip is not an event, but a reversal is.
                (InterfaceMode::Slides(a), InterfaceMode::Slides(b))
                    if a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() > 0.0 =>
                {
                    continue;
                }
                (_, InterfaceMode::Slides(direction)) => {
                    EventKind::Slides { interface, joint, direction }
                }
                _ => continue,
            };
            let stop = stops.iter().find(|(stops, _)| *stops == interface);
            let time = stop.map_or(self.now.time, |(_, time)| *time);
            self.events.push(Event { time, kind });
        }
        self.events[first..].sort_by(|a, b| a.time.total_cmp(&b.time));
    }
}
