//! Joints named in the limits of motions through waypoints.

use crate::document::Table;
use crate::expression::Measure;
use crate::fields::tables::WAYPOINT;
use crate::read::context::Record;
use crate::read::motion::Reader;
use crate::read::path::{Meaning, resolve};
use crate::signal::law::Law;
use crate::source::Span;
use stiction_core::mechanism::JointId;

/// Name, in the limits of a motion, that stands for all actuators.
const ACTUATORS: &str = "actuators";

/// Degree of freedom of a joint: its full name, the joint with the index of the degree of freedom,
/// and its kind of quantity.
pub(super) type Named = (String, (JointId, usize), Measure);

/// Returns the degrees of freedom to which a limit named `path` applies, all of the same kind of
/// quantity. The list is empty for an unknown name, and for `actuators` if some of them translate
/// and others rotate. Returns `None` if the mechanism has defects.
pub(super) fn named(reader: &Reader<'_>, path: &str) -> Option<Vec<Named>> {
    if let Ok(Meaning::Joint(joint, joint_type, dof)) = resolve(reader.names, path) {
        let translates = joint_type.dofs().get(dof).is_some_and(|dof| dof.translates());
        let measure = if translates { Measure::Length } else { Measure::Angle };
        return Some(vec![(path.to_owned(), (joint, dof), measure)]);
    }
    if path != ACTUATORS {
        return Some(Vec::new());
    }
    // Without an assembly, the mechanism has defects, which have been reported.
    let mechanism = reader.assembly?.mechanism;
    let each = mechanism.actuators().map(|(joint, dof)| {
        let own = &mechanism.joints()[joint.0];
        let translates = own.joint_type.dofs()[dof].translates();
        let measure = if translates { Measure::Length } else { Measure::Angle };
        (own.dof_name(dof), (joint, dof), measure)
    });
    let all: Vec<Named> = each.collect();
    // A limit for translations and rotations together would have no unit.
    let same = all.iter().all(|(.., measure)| Some(measure) == all.first().map(|(.., m)| m));
    Some(if same { all } else { Vec::new() })
}

/// Returns the place of a motion law that a move uses and that does not limit the jerk; `None` if
/// the laws of all moves limit it.
pub(super) fn unlimited_jerk(motion: &Record<'_>, tables: &[&Table]) -> Option<Span> {
    let trapezoid = |record: &Record<'_>| {
        record.value("law")?;
        let name = record.choice("law")?;
        (Law::from_name(name) == Some(Law::Trapezoid)).then(|| record.span("law"))
    };
    let context = motion.context;
    let own = |table: &&&Table| Record::open(context, table, WAYPOINT, "").value("law").is_some();
    let all_have_their_own = tables.iter().skip(1).all(|table| own(&table));
    let general = if all_have_their_own { None } else { trapezoid(motion) };
    let each = tables.iter().skip(1);
    general.or_else(|| {
        each.filter(own).find_map(|table| trapezoid(&Record::open(context, table, WAYPOINT, "")))
    })
}
