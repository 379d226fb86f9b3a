//! Tables of a model file that describe springs and bushings.

use super::{pose, vector};
use stiction_core::mechanism::{Bushing, JointSpring, Mechanism, SixBySix, Spring};
use toml::{Table, Value};

fn table(entries: impl IntoIterator<Item = (&'static str, Value)>) -> Table {
    entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Lists the name and the table of each spring, between points or on a joint.
pub(in crate::exchange) fn tables(mechanism: &Mechanism) -> Vec<(String, Table)> {
    let name = |body: stiction_core::mechanism::BodyId| {
        Value::from(mechanism.bodies()[body.0].name.as_str())
    };
    let straight = |spring: &Spring| {
        let mut own = table([
            ("from", name(spring.ends[0])),
            ("at", vector(spring.points[0])),
            ("to", name(spring.ends[1])),
            ("to_at", vector(spring.points[1])),
            ("damping", spring.damping.into()),
        ]);
        own.extend(match spring.lengths {
            // A spring with a range of lengths is a gas spring. Its stiffness is
            // `extension_force * (progression - 1) / stroke`.
            Some((shortest, extended)) => {
                let (stroke, force) = (extended - shortest, spring.preload);
                let progression =
                    if force > 0.0 { 1.0 + spring.stiffness * stroke / force } else { 1.0 };
                table([
                    ("extension_force", force.into()),
                    ("progression", progression.into()),
                    ("extended_length", extended.into()),
                    ("stroke", stroke.into()),
                ])
            }
            None => table([
                ("stiffness", spring.stiffness.into()),
                ("free_length", spring.free_length.into()),
            ]),
        });
        if spring.lengths.is_none() && spring.preload != 0.0 {
            own.insert("preload".to_owned(), spring.preload.into());
        }
        (spring.name.clone(), own)
    };
    let on_joint = |spring: &JointSpring| {
        let joint = mechanism.joints()[spring.joint.0].dof_name(spring.dof);
        let own = table([
            ("joint", joint.into()),
            ("stiffness", spring.stiffness.into()),
            ("rest", spring.rest.into()),
            ("preload", spring.preload.into()),
            ("damping", spring.damping.into()),
        ]);
        (spring.name.clone(), own)
    };
    let springs = mechanism.springs().iter().map(straight);
    springs.chain(mechanism.joint_springs().iter().map(on_joint)).collect()
}

/// Lists the name and the table of each bushing.
pub(in crate::exchange) fn bushing_tables(mechanism: &Mechanism) -> Vec<(String, Table)> {
    let matrix = |matrix: &SixBySix| {
        let row = |row: &[f64; 6]| Value::Array(row.map(Value::from).into());
        Value::Array(matrix.iter().map(row).collect())
    };
    let of_bushing = |bushing: &Bushing| {
        let name = |end: usize| Value::from(mechanism.bodies()[bushing.ends[end].0].name.as_str());
        let own = table([
            ("from", name(0)),
            ("frame", pose(bushing.frames[0])),
            ("to", name(1)),
            ("to_frame", pose(bushing.frames[1])),
            ("stiffness", matrix(&bushing.stiffness)),
            ("damping", matrix(&bushing.damping)),
        ]);
        (bushing.name.clone(), own)
    };
    mechanism.bushings().iter().map(of_bushing).collect()
}
