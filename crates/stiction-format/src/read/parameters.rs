//! Reads the parameters of a model.

use super::context::Context;
use crate::diagnostic::{Diagnostic, Diagnostics, quoted};
use crate::document::{Node, Table, Value};
use crate::expression::{self, Dimension, Program, Quantity, Scope};
use crate::parameters::{Parameters, complaint};
use crate::source::{Source, Span};
use std::sync::Arc;

/// Reads the table of parameters, which can refer to each other in any order.
pub(crate) fn read_parameters(
    table: &Table,
    source: &Arc<Source>,
    broken: &[Span],
    out: &mut Diagnostics,
) -> Parameters {
    let mut all = Parameters::named(table.entries.iter().map(|(key, _)| key.name.clone()));

    // Definitions are parsed first, then evaluated in the order of their dependences.
    let mut programs = Vec::new();
    {
        let context = Context::new(source, &all, broken);
        for (key, value) in &table.entries {
            check_name(&context, &key.name, &key.span);
            programs.push(define(&context, value));
        }
        out.append(context.out.into_inner());
    }
    let order = Order::of(&programs, &all);
    for index in order.sorted {
        if let Some(Some(Definition::Formula(program))) = programs.get(index) {
            let value = expression::constant(program, &all);
            let context = Context::new(source, &all, broken);
            if let (Err(fault), Some((_, value))) = (&value, table.entries.get(index))
                && let Node::Text(text) = &value.node
            {
                context.fault(&value.span, text, fault.clone());
            }
            out.append(context.out.into_inner());
            all.set(index, value.ok());
        } else if let Some(Some(Definition::Number(value))) = programs.get(index) {
            let plain = Quantity { value: *value, dimension: Dimension::NONE };
            all.set(index, Some(plain));
        }
    }
    for cycle in order.cycles {
        out.push(describe_cycle(&all, table, source, &cycle));
    }
    all
}

enum Definition {
    Number(f64),
    Formula(Program),
}

fn check_name(context: &Context<'_>, name: &str, span: &Span) {
    let Some(problem) = complaint(name) else { return };
    context.push(
        Diagnostic::error("name", problem)
            .at(context.place(span), "invalid name")
            .help(format!("choose another name, for example {}", quoted(&possible(name, context)))),
    );
}

/// Suggests a similar name that is valid and not in use.
fn possible(name: &str, context: &Context<'_>) -> String {
    let allowed = |c: char| if c.is_alphanumeric() || c == '_' { c } else { '_' };
    let mut near: String = name.chars().map(allowed).collect();
    if !near.starts_with(|c: char| c.is_alphabetic() || c == '_') {
        near.insert(0, '_');
    }
    let is_free =
        |name: &String| complaint(name).is_none() && context.parameters.find(name).is_none();
    let numbered = (1..100).map(|number| format!("{near}{number}"));
    std::iter::once(near.clone()).chain(numbered).find(is_free).unwrap_or_default()
}

fn define(context: &Context<'_>, value: &Value) -> Option<Definition> {
    match &value.node {
        Node::Text(_) if context.is_full() => None,
        Node::Text(text) => match expression::parse(&text.content, context.parameters, false) {
            Ok(program) => Some(Definition::Formula(program)),
            Err(fault) => {
                context.fault(&value.span, text, fault);
                None
            }
        },
        _ => context.quantity(value, crate::expression::Measure::Any).map(Definition::Number),
    }
}

/// Order in which definitions are evaluated, and cycles of definitions.
struct Order {
    sorted: Vec<usize>,
    cycles: Vec<Vec<usize>>,
}

impl Order {
    fn of(programs: &[Option<Definition>], all: &Parameters) -> Self {
        // A parameter with an invalid name has no value, so no definition waits for it.
        let needs: Vec<Vec<usize>> = programs
            .iter()
            .map(|definition| match definition {
                Some(Definition::Formula(program)) => {
                    program.parameters().filter(|&index| !all.is_misnamed(index)).collect()
                }
                _ => Vec::new(),
            })
            .collect();
        // Kahn's algorithm: takes any definition whose dependences have been resolved.
        let mut waiting: Vec<usize> = needs.iter().map(Vec::len).collect();
        let mut users: Vec<Vec<usize>> = vec![Vec::new(); needs.len()];
        for (user, needs) in needs.iter().enumerate() {
            for &need in needs {
                if let Some(users) = users.get_mut(need) {
                    users.push(user);
                }
            }
        }
        let mut sorted: Vec<usize> =
            (0..needs.len()).filter(|&i| waiting.get(i) == Some(&0)).collect();
        let mut next = 0;
        while let Some(&done) = sorted.get(next) {
            next += 1;
            for &user in users.get(done).into_iter().flatten() {
                if let Some(count) = waiting.get_mut(user) {
                    *count -= 1;
                    if *count == 0 {
                        sorted.push(user);
                    }
                }
            }
        }
        Self { sorted, cycles: cycles(&needs, &waiting) }
    }
}

/// Finds cycles among the definitions with unresolved dependences, which `waiting` counts.
fn cycles(needs: &[Vec<usize>], waiting: &[usize]) -> Vec<Vec<usize>> {
    let waits = |i: usize| waiting.get(i).is_some_and(|&count| count > 0);
    let mut seen = vec![0usize; needs.len()];
    let mut found = Vec::new();
    for start in 0..needs.len() {
        let mut path = Vec::new();
        let mut at = start;
        while waits(at) && seen.get(at) == Some(&0) {
            if let Some(seen) = seen.get_mut(at) {
                *seen = start + 1;
            }
            path.push(at);
            let Some(&next) = needs.get(at).into_iter().flatten().find(|&&need| waits(need)) else {
                break;
            };
            at = next;
        }
        if let Some(from) = path.iter().position(|&i| i == at)
            && seen.get(at) == Some(&(start + 1))
        {
            found.push(path.split_off(from));
        }
    }
    found
}

fn describe_cycle(
    all: &Parameters,
    table: &Table,
    source: &Arc<Source>,
    cycle: &[usize],
) -> Diagnostic {
    const MOST: usize = 8;
    let name = |i: &usize| quoted(all.name(*i));
    let mut names: Vec<_> = cycle.iter().take(MOST).map(name).collect();
    if cycle.len() > MOST {
        names.push("…".to_owned());
    }
    names.extend(cycle.first().map(name));
    let place = |i: &usize| {
        let span = table.entries.get(*i).map_or(0..0, |(_, value)| value.span.clone());
        crate::source::Place::new(source, span)
    };
    let message = match cycle {
        [only] => format!("parameter {} depends on itself", name(only)),
        _ => format!("parameters depend on each other in a cycle: {}", names.join(" → ")),
    };
    let mut diagnostic = Diagnostic::error("cycle", message);
    if let Some(first) = cycle.first() {
        diagnostic = diagnostic.at(place(first), "depends on itself");
    }
    for other in cycle.iter().skip(1).take(MOST) {
        diagnostic = diagnostic.also(place(other), "by way of this");
    }
    diagnostic.help("give one of them a value")
}
