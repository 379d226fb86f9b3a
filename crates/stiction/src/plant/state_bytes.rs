//! Conversion of the states of plants to bytes and back. The bytes are the identifier of the FMU,
//! followed by 64-bit floating-point numbers in little-endian order.

use super::{Choice, Plant, force_on};
use crate::error::Error;
use crate::forward::Sample;
use std::sync::Arc;
use stiction_core::kinematics::Target;
use stiction_core::spatial::Vec3;
use stiction_run::forward::{Held, Plant as Engine, PlantState, Sample as Record};

/// Limit on the length of a list, and on the number of payload changes, in a state that is read.
const COUNTABLE: f64 = 1e7;

/// Sequence of bytes to which the numbers of a state are appended.
pub(super) struct Writer(Vec<u8>);

/// Remaining bytes of a state, which are read as numbers.
pub(super) struct Reader<'a>(&'a [u8]);

impl Writer {
    pub(super) fn new(token: &str) -> Self {
        Self(token.as_bytes().to_vec())
    }

    pub(super) fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        numbers.into_iter().for_each(|x| self.0.extend_from_slice(&x.to_le_bytes()));
    }

    fn list(&mut self, numbers: &[f64]) {
        self.numbers([numbers.len() as f64]);
        self.numbers(numbers.iter().copied());
    }

    pub(super) fn option(&mut self, number: Option<f64>) {
        self.numbers([f64::from(u8::from(number.is_some())), number.unwrap_or(0.0)]);
    }

    pub(super) fn bytes(self) -> Vec<u8> {
        self.0
    }
}

impl<'a> Reader<'a> {
    pub(super) fn new(token: &str, bytes: &'a [u8]) -> Option<Self> {
        bytes.strip_prefix(token.as_bytes()).map(Self)
    }

    pub(super) fn number(&mut self) -> Option<f64> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(f64::from_le_bytes(*first)).filter(|number| number.is_finite())
    }

    fn list(&mut self) -> Option<Vec<f64>> {
        let count = self.number().filter(|count| (0.0..=COUNTABLE).contains(count))? as usize;
        (0..count).map(|_| self.number()).collect()
    }

    pub(super) fn option(&mut self) -> Option<Option<f64>> {
        let some = self.number()? != 0.0;
        let number = self.number()?;
        Some(some.then_some(number))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Plant {
    /// Writes the complete state of the plant: start, inputs, parameters and simulation state.
    pub(super) fn write(&self, writer: &mut Writer) {
        writer.numbers([self.from]);
        let starts = self.starts.iter().flatten().flat_map(|start| [start.value, start.rate]);
        writer.list(&starts.collect::<Vec<f64>>());
        for Choice { values, held } in [&self.set, &self.acting] {
            writer.list(values);
            writer.list(&held.efforts);
            let loads = held.loads.iter().flat_map(|load| {
                let [force, moment] = [load.force, load.moment].map(Vec3::to_array);
                [&[load.body.0 as f64][..], &force, &moment].concat()
            });
            writer.list(&loads.collect::<Vec<f64>>());
        }
        let (numbers, changes) = match &self.state {
            Some(PlantState { simulation, changes }) => (&simulation[..], *changes as f64),
            None => (&[][..], 0.0),
        };
        writer.numbers([changes]);
        writer.list(numbers);
    }

    /// Reads the state that [`Self::write`] wrote, and recomputes the results. Returns `None` if
    /// the numbers belong to another plant.
    ///
    /// # Errors
    /// The parameters are not valid.
    pub(super) fn read(&mut self, reader: &mut Reader<'_>) -> Result<Option<()>, Error> {
        let Some(Parts { from, starts, choices, state }) = self.parts(reader) else {
            return Ok(None);
        };
        self.state = None;
        self.sample = None;
        (self.from, self.starts, [self.set, self.acting]) = (from, starts, choices);
        let Some(state) = state else { return Ok(Some(())) };
        let (model, known) = self.arranged(&self.acting.values)?;
        let engine = Engine::new(&self.job(&model, &known));
        let mut sample = None;
        let names = self.setup.plan.names();
        let mut receive = |now: &Record<'_>| sample = Some(Sample::new(Arc::clone(names), now));
        if engine.restore(&state, &self.acting.held, &mut receive).is_err() {
            return Ok(None);
        }
        (self.state, self.sample, self.engine) = (Some(state), sample, Arc::new(engine));
        Ok(Some(()))
    }

    fn parts(&self, reader: &mut Reader<'_>) -> Option<Parts> {
        let from = reader.number()?;
        let starts = reader.list()?;
        let actuators = self.setup.initial.len();
        let target = |pair: &[f64]| Target { value: pair[0], rate: pair[1], acceleration: 0.0 };
        let starts = match starts.len() {
            0 => None,
            count if count == 2 * actuators => Some(starts.chunks(2).map(target).collect()),
            _ => return None,
        };
        let mut choice = || self.choice(reader);
        let choices = [choice()?, choice()?];
        let changes = reader.number().filter(|count| (0.0..=COUNTABLE).contains(count))?;
        let simulation = reader.list()?;
        let state = (!simulation.is_empty())
            .then_some(PlantState { simulation, changes: changes as usize });
        Some(Parts { from, starts, choices, state })
    }

    fn choice(&self, reader: &mut Reader<'_>) -> Option<Choice> {
        let (values, efforts, loads) = (reader.list()?, reader.list()?, reader.list()?);
        let bodies = self.setup.plan.names().bodies.len();
        let load = |load: &[f64]| {
            let &[body, fx, fy, fz, mx, my, mz] = load else { return None };
            let is_body = (1.0..bodies as f64).contains(&body);
            is_body.then(|| force_on(body as usize, [fx, fy, fz], [mx, my, mz]))
        };
        let loads = loads.chunks(7).map(load).collect::<Option<_>>()?;
        let fits = values.len() == self.setup.tunables.len()
            && values.iter().all(|value| *value >= 0.0)
            && efforts.len() == self.setup.initial.len();
        fits.then_some(Choice { values, held: Held { efforts, loads } })
    }
}

/// State of a plant that was decoded from bytes but is not yet applied to the plant.
struct Parts {
    from: f64,
    starts: Option<Vec<Target<f64>>>,
    choices: [Choice; 2],
    state: Option<PlantState>,
}
