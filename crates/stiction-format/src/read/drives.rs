//! Reads actuator efforts.

use super::actuators::Actuators;
use super::context::{Context, Record};
use super::measured::{self, Effort};
use super::names::Names;
use super::path::leaves;
use crate::diagnostic::{Diagnostic, Diagnostics, quoted};
use crate::document::Table;
use crate::expression::Measure;
use crate::fields::tables::DRIVES;
use crate::model_file::Drives;
use crate::source::{Place, Source, Span};
use std::sync::Arc;

/// Reads a table of efforts, whose keys are names of actuators.
pub(crate) fn read(
    context: &Context<'_>,
    (names, actuators): (&Names, &Actuators),
    table: &Table,
) -> Drives {
    let record = Record::open(context, table, DRIVES, "drives");
    let title = record.line("title");
    let (mut efforts, mut laws) = (Vec::new(), Vec::new());
    let mut places: Vec<(usize, Span)> = Vec::new();
    let before = context.out.borrow().len();
    for leaf in &leaves(table, DRIVES) {
        if context.is_full() {
            break;
        }
        let Some(actuator) = actuators.find(&leaf.path) else {
            actuators.report(context, &leaf.path, &leaf.key);
            continue;
        };
        let Some(value) = leaf.value else { continue };
        if let Some((_, first)) = places.iter().find(|(known, _)| *known == actuator) {
            context.push(
                Diagnostic::error("duplicate", "the effort of this actuator is given twice")
                    .at(context.place(&leaf.key), "again here")
                    .also(context.place(first), "first here"),
            );
            continue;
        }
        places.push((actuator, leaf.key.clone()));
        let measure = actuators.measure(actuator, Measure::Force, Measure::Moment);
        match measured::effort(context, names, value, measure) {
            Some(Effort::Signal(signal)) => efforts.push((actuator, signal)),
            Some(Effort::Law(law)) => laws.push((actuator, law)),
            None => {}
        }
    }
    if efforts.is_empty() && laws.is_empty() && context.out.borrow().len() == before {
        let example = actuators.names().next().unwrap_or("leg1.P");
        context.push(
            Diagnostic::error("missing-key", "no actuator has an effort")
                .at(context.place(&(0..0)), "expected efforts")
                .help(format!("write for example `{example} = \"50 N\"`, or use --drives none")),
        );
    }
    Drives { title, efforts, laws, samples: None, interpolation: None }
}

/// Creates the diagnostic for a text that does not specify actuator efforts.
pub(super) fn unknown(source: &Arc<Source>, name: &str) -> Diagnostics {
    let place = Place::new(source, 0..source.text.len());
    Diagnostic::error("unknown-name", format!("{} is not understood", quoted(name)))
        .at(place, "unknown efforts")
        .help(
            "write `none`, `inverse` (efforts of inverse dynamics for the motion), a CSV file, or assignments \
             such as `leg1.P = 50 N`",
        )
        .into()
}
