//! Sections of the report on masses of bodies, and on ranges of joints, legs and bodies.

use crate::Job;
use crate::check::{Findings, Range};
use crate::report::html::{Column, note, paragraph, section, table};
use stiction_core::dynamics::InverseDynamics;
use stiction_core::spatial::Vec3;
use stiction_draw::numbers::number;

/// Returns the section with mass, centre of mass and principal moments of inertia of each body.
/// `start` is the mechanism at the first pose of the motion.
pub(super) fn masses(job: &Job<'_>, findings: &Findings, start: &InverseDynamics) -> String {
    let length = job.model.mechanism.characteristic_length();
    let point = |p: Vec3<f64>| {
        // Coordinates smaller than the rounding error of a length as large as the robot become
        // zero.
        let [x, y, z] = p.to_array().map(|c| if c.abs() < 1e-12 * length { 0.0 } else { c });
        format!("{}, {}, {}", millimetres(x), millimetres(y), millimetres(z))
    };
    let bodies = job.model.mechanism.bodies().iter().zip(&start.bodies().pose).skip(1);
    let rows: Vec<Vec<String>> = bodies
        .map(|(body, pose)| {
            if body.mass == 0.0 && body.principal_moments()[2] == 0.0 {
                return vec![body.name.clone(), "none".to_owned()];
            }
            let [a, b, c] = body.principal_moments().map(|moment| number(moment.max(0.0)));
            vec![
                body.name.clone(),
                number(body.mass),
                point(body.com),
                point(pose.apply(body.com) + start.parameters().origin),
                format!("{a}, {b}, {c}"),
            ]
        })
        .collect();
    let head = [
        ("body", Column::Text),
        ("mass [kg]", Column::Number),
        ("centre in the body [mm]", Column::Number),
        ("centre in the world [mm]", Column::Number),
        ("principal inertias [kg m²]", Column::Number),
    ];
    let inner = paragraph(&format!(
        "Total mass {} kg, centre of mass at {} mm.",
        number(findings.sizes.mass),
        point(findings.sizes.centre)
    )) + &table(&head, &rows)
        + &note("At the beginning of the motion; inertias about each body's centre of mass.");
    section("Masses", &inner)
}

fn millimetres(x: f64) -> String {
    let millimetres = 1e3 * x;
    if millimetres.abs() >= 1e7 {
        return format!("{millimetres:.4e}");
    }
    let text = format!("{millimetres:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Returns the section with the ranges of bodies, legs and joints along the motion.
pub(super) fn ranges(findings: &Findings) -> String {
    let sizes = &findings.sizes;
    let mut inner = String::new();
    for (title, ranges) in [("leg length", &sizes.legs), ("joint", &sizes.joints)] {
        let rows: Vec<Vec<String>> = ranges.iter().map(row).collect();
        let head = [
            (title, Column::Text),
            ("least", Column::Number),
            ("greatest", Column::Number),
            ("by", Column::Number),
            ("unit", Column::Text),
        ];
        inner += &table(&head, &rows);
    }
    let corner = |p: Vec3<f64>| {
        let [x, y, z] = p.to_array().map(millimetres);
        format!("{x}, {y}, {z}")
    };
    let reach: Vec<Vec<String>> = sizes
        .reach
        .iter()
        .map(|(body, least, greatest)| vec![body.clone(), corner(*least), corner(*greatest)])
        .collect();
    let head = [
        ("centre of mass of", Column::Text),
        ("least x, y, z [mm]", Column::Number),
        ("greatest x, y, z [mm]", Column::Number),
    ];
    inner += &table(&head, &reach);
    if inner.is_empty() { inner } else { section("Along the motion", &inner) }
}

fn row(range: &Range) -> Vec<String> {
    let ([least, greatest, by], unit) = range.in_words();
    vec![range.name.clone(), least, greatest, by, unit.to_owned()]
}
