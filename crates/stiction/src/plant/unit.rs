//! A plant whose inputs and results are the variables of a functional mock-up unit (FMU).

use super::quantities::{Part, Quantity, Table};
use super::resources::{self, PlantOptions};
use super::state_bytes::{Reader, Writer};
use super::{Plant, finite};
use crate::error::Error;
use crate::forward::{Event, Sample};
use crate::names::find;
use crate::robot::Robot;
use std::path::Path;
use std::sync::Arc;
use stiction_core::kinematics::Target;
use stiction_core::spatial::{Mat3, Quaternion, Vec3};
use stiction_program::emit::fmu::{Kind, Variable, token};

/// A [`Plant`] whose inputs, parameters and results are numbered variables, as in a functional
/// mock-up unit. Several units are independent of one another.
#[derive(Clone, Debug)]
pub struct Unit {
    table: Arc<Table>,
    /// Identifier computed from the model, the options, the names of the variables and the version
    /// of the library.
    token: Arc<str>,
    state: UnitState,
}

/// Complete state of a [`Unit`].
#[derive(Clone, Debug)]
pub struct UnitState {
    plant: Plant,
    starts: Vec<Target<f64>>,
    events: i32,
    event_time: Option<f64>,
    /// True after the end of the initialisation; the initial state can then no longer be changed.
    runs: bool,
}

impl Unit {
    /// Creates a unit that has not started yet.
    pub(crate) fn new(robot: &Robot, options: &PlantOptions) -> Result<Self, Error> {
        let plant = options.plant(robot)?;
        let names = plant.setup.plan.names();
        let mut forced = Vec::new();
        for name in &options.forces_on {
            let body = find("body", name, &names.bodies)?;
            if body == 0 {
                return Err(Error::input("a force on the ground has no effect")
                    .with_help("choose a body that moves"));
            }
            if !forced.contains(&body) {
                forced.push(body);
            }
        }
        let table = Table::new(&plant, &forced);
        let files = resources::write(robot, options)?;
        let mut texts: Vec<&str> = files.iter().map(|file| file.text.as_str()).collect();
        texts.push(env!("CARGO_PKG_VERSION"));
        // The token depends on the names of the variables, so that a library version with other
        // variables rejects states written by this one.
        texts.extend(table.variables.iter().map(|variable| variable.name.as_str()));
        let starts = plant.setup.initial.clone();
        let state = UnitState { plant, starts, events: 0, event_time: None, runs: false };
        let token = token(&texts).into();
        Ok(Self { table: Arc::new(table), token, state })
    }

    /// Reads a unit from the folder `resources` of an extracted FMU.
    ///
    /// # Errors
    /// The folder does not contain a plant, or the robot cannot be assembled.
    pub fn load(resources: &Path) -> Result<Self, Error> {
        resources::read(resources)
    }

    /// Identifier computed from the model, the options, the names of the variables and the version
    /// of the library.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// Variables in the order of their value references.
    pub fn variables(&self) -> &[Variable] {
        &self.table.variables
    }

    /// Present time of the unit, s.
    pub fn time(&self) -> f64 {
        self.state.plant.time()
    }

    /// Sets the time of the start, s.
    ///
    /// # Errors
    /// The unit has started, or the time is not finite.
    pub fn set_start_time(&mut self, time: f64) -> Result<(), Error> {
        self.refuse_running("the start time")?;
        let starts = self.state.plant.starts.clone();
        self.state.plant.begin(time, starts)
    }

    /// Ends the initialisation, and starts the robot with the present inputs and parameters.
    ///
    /// # Errors
    /// The robot cannot start with these inputs and parameters.
    pub fn run(&mut self) -> Result<(), Error> {
        self.state.plant.sample()?;
        self.state.runs = true;
        Ok(())
    }

    fn refuse_running(&self, what: &str) -> Result<(), Error> {
        match self.state.runs {
            false => Ok(()),
            true => Err(Error::input(format!("{what} can be set only before the start"))
                .with_help("set it before the initialisation ends")),
        }
    }

    fn name(&self, reference: u32) -> &str {
        let variable = self.table.variables.get(reference as usize);
        variable.map_or("", |variable| variable.name.as_str())
    }

    /// Value of a real variable. Results are computed with the inputs that act up to the present instant.
    ///
    /// # Errors
    /// There is no such real variable, or the robot cannot start.
    pub fn real(&mut self, reference: u32) -> Result<f64, Error> {
        let quantity = self.table.quantity(reference)?;
        if self.table.variables[reference as usize].kind != Kind::Real {
            return Err(self.wrong_type(reference, "an integer"));
        }
        let state = &mut self.state;
        let plant = &mut state.plant;
        let held = &plant.set.held;
        match quantity {
            Quantity::Time => return Ok(plant.time()),
            Quantity::Effort(k) => return Ok(held.efforts[k]),
            Quantity::Force(body, k) => {
                let load = held.loads.iter().find(|load| load.body.0 == body);
                return Ok(
                    load.map_or(0.0, |load| [load.force, load.moment][k / 3].to_array()[k % 3])
                );
            }
            Quantity::StartPosition(k) => return Ok(state.starts[k].value),
            Quantity::StartRate(k) => return Ok(state.starts[k].rate),
            Quantity::Parameter(k) => return Ok(plant.set.values[k]),
            Quantity::EventTime => return Ok(state.event_time.unwrap_or(plant.from)),
            _ => {}
        }
        let signed = Arc::clone(&self.table);
        Ok(result(plant.sample()?, quantity, &signed.signed))
    }

    /// Value of an integer variable.
    ///
    /// # Errors
    /// There is no such integer variable, or the robot cannot start.
    pub fn integer(&mut self, reference: u32) -> Result<i32, Error> {
        match self.table.quantity(reference)? {
            Quantity::Sticks(k) => {
                Ok(i32::from(self.state.plant.sample()?.all_interfaces()[k].sticks))
            }
            Quantity::Events => Ok(self.state.events),
            _ => Err(self.wrong_type(reference, "a real variable")),
        }
    }

    fn wrong_type(&self, reference: u32, is: &str) -> Error {
        Error::input(format!("the variable `{}` is {is}", self.name(reference)))
            .with_help("call the function for its type, see modelDescription.xml")
    }

    /// Sets the inputs and parameters with the given value references from now on. If one of them
    /// cannot be set, all keep their values.
    ///
    /// # Errors
    /// See [`Self::set_real`].
    pub fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        let state = &self.state;
        let (set, starts, from) = (state.plant.set.clone(), state.starts.clone(), state.plant.from);
        let mut each = references.iter().zip(values);
        let done = each.try_for_each(|(reference, value)| self.set_real(*reference, *value));
        if done.is_err() {
            self.state.plant.set = set;
            if self.state.starts != starts {
                let changed = starts != self.state.plant.setup.initial;
                self.state.starts.clone_from(&starts);
                self.state.plant.begin(from, changed.then_some(starts))?;
            }
        }
        done
    }

    /// Sets an input or a parameter from now on.
    ///
    /// # Errors
    /// There is no such variable, the variable cannot be set now, or the value is not valid.
    pub fn set_real(&mut self, reference: u32, value: f64) -> Result<(), Error> {
        let quantity = self.table.quantity(reference)?;
        let name = self.name(reference).to_owned();
        finite(value, || format!("the variable `{name}`"))?;
        let state = &mut self.state;
        match quantity {
            Quantity::Effort(k) if state.plant.set.held.efforts[k] != value => {
                state.plant.set.held.efforts[k] = value;
                state.plant.forget_start();
            }
            Quantity::Effort(_) => {}
            Quantity::Force(body, k) => {
                let loads = &state.plant.set.held.loads;
                let load = loads.iter().find(|load| load.body.0 == body);
                let zero = ([0.0; 3], [0.0; 3]);
                let (mut force, mut moment) =
                    load.map_or(zero, |load| (load.force.to_array(), load.moment.to_array()));
                let component = if k < 3 { &mut force[k] } else { &mut moment[k - 3] };
                if *component != value {
                    *component = value;
                    state.plant.put_force(body, force, moment);
                }
            }
            Quantity::StartPosition(k) | Quantity::StartRate(k) => {
                self.refuse_running(&format!("the variable `{name}`"))?;
                let start = &mut self.state.starts[k];
                if quantity == Quantity::StartPosition(k) {
                    start.value = value;
                } else {
                    start.rate = value;
                }
                let starts = self.state.starts.clone();
                let changed = starts != self.state.plant.setup.initial;
                let from = self.state.plant.from;
                self.state.plant.begin(from, changed.then_some(starts))?;
            }
            Quantity::Parameter(k) if state.plant.set.values[k] != value => {
                state.plant.put_parameter(k, value)?;
            }
            Quantity::Parameter(_) => {}
            _ => {
                return Err(Error::input(format!("the variable `{name}` is a result"))
                    .with_help("set only inputs and parameters"));
            }
        }
        Ok(())
    }

    /// Returns an error for every integer variable, because all integer variables are results.
    ///
    /// # Errors
    /// Always.
    pub fn set_integer(&mut self, reference: u32) -> Result<(), Error> {
        self.table.quantity(reference)?;
        Err(Error::input(format!("the integer `{}` cannot be set", self.name(reference)))
            .with_help("integer variables are results"))
    }

    /// Advances to a time, s, or, if `to_event`, to the first event before this time. Returns the events.
    ///
    /// # Errors
    /// The robot cannot continue; the state of the unit is then unchanged.
    pub fn advance(&mut self, until: f64, to_event: bool) -> Result<Vec<Event>, Error> {
        let events = self.state.plant.go(until, to_event)?;
        for event in events.iter().filter(|event| event.kind.changes_motion()) {
            self.state.events = self.state.events.saturating_add(1);
            self.state.event_time = Some(event.time);
        }
        Ok(events)
    }

    /// Copy of the present state.
    pub fn state(&self) -> UnitState {
        self.state.clone()
    }

    /// Continues from a state of this unit or of another unit with the same [token](Self::token).
    pub fn set_state(&mut self, state: &UnitState) {
        self.state.clone_from(state);
    }

    /// Converts a state to bytes. [`Self::read_state`] of a unit with the same [token](Self::token)
    /// reads the bytes on any platform.
    pub fn write_state(&self, state: &UnitState) -> Vec<u8> {
        let mut writer = Writer::new(&self.token);
        state.plant.write(&mut writer);
        for start in &state.starts {
            writer.numbers([start.value, start.rate]);
        }
        writer.numbers([f64::from(state.events), f64::from(u8::from(state.runs))]);
        writer.option(state.event_time);
        writer.bytes()
    }

    /// Reads a state from bytes.
    ///
    /// # Errors
    /// The bytes are not a state of a unit with the same token.
    pub fn read_state(&self, bytes: &[u8]) -> Result<UnitState, Error> {
        let wrong = || {
            Error::input("these bytes are not a state of this model").with_help(
                "a state belongs to the model, the options and the version that wrote it",
            )
        };
        let mut reader = Reader::new(&self.token, bytes).ok_or_else(wrong)?;
        let mut state = self.state.clone();
        state.plant.read(&mut reader)?.ok_or_else(wrong)?;
        let mut rest = || -> Option<()> {
            for start in &mut state.starts {
                (start.value, start.rate) = (reader.number()?, reader.number()?);
            }
            state.events = reader.number()? as i32;
            state.runs = reader.number()? != 0.0;
            state.event_time = reader.option()?;
            reader.is_empty().then_some(())
        };
        rest().ok_or_else(wrong)?;
        Ok(state)
    }
}

/// Value of a quantity in a sample of a plant, in SI units; zero for quantities that the sample
/// does not contain. `signed` states for each friction interface whether its friction and sliding
/// speed have a sign, or are magnitudes.
fn result(sample: &Sample, quantity: Quantity, signed: &[bool]) -> f64 {
    let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let along = |k: usize, v: [f64; 3]| if signed[k] { v[0] } else { size(v) };
    let (joints, interfaces) = (sample.all_joints(), sample.all_interfaces());
    match quantity {
        Quantity::Position(k) => joints[k].position,
        Quantity::Rate(k) => joints[k].rate,
        Quantity::Acceleration(k) => joints[k].acceleration,
        Quantity::Body(body, part) => {
            let (poses, velocities) = sample.all_bodies();
            match part {
                Part::Position(k) => poses[body].position[k],
                Part::Velocity(k) => velocities[body].linear[k],
                Part::AngularVelocity(k) => velocities[body].angular[k],
                Part::Orientation(k) => {
                    let rows = poses[body].rotation.map(|[x, y, z]| Vec3::new(x, y, z));
                    let rotation = Mat3::from_columns(rows[0], rows[1], rows[2]).transpose();
                    let Quaternion { w, v } = Quaternion::from_rotation(rotation);
                    [w, v.x, v.y, v.z][k]
                }
            }
        }
        Quantity::Friction(k) => along(k, interfaces[k].force),
        Quantity::SlidingSpeed(k) => along(k, interfaces[k].velocity),
        Quantity::NormalLoad(k) => interfaces[k].load,
        Quantity::Kinetic => sample.kinetic_energy,
        Quantity::Potential => sample.potential_energy,
        Quantity::Dissipated => sample.friction_dissipation(),
        Quantity::EnergyError => sample.energy_error,
        _ => 0.0,
    }
}
