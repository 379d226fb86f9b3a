//! Friction contributions to the actuator efforts: ranking and plot.

use crate::job::Job;
use crate::names::{Names, listed};
use crate::statistics::Size;
use serde_json::{Value, json};
use std::fmt::{self, Write};
use stiction_core::dynamics::{Contributions, FrictionMode};
use stiction_draw::figure::meaning::{LIMIT, of_leg};
use stiction_draw::figure::{COLOURS, Figure, JumpTrace, Panel};
use stiction_draw::numbers::number;

/// Largest number of actuators whose friction contributions the text summary lists.
const DRIVES_LISTED: usize = 3;
/// Largest number of friction interfaces that the text summary and the plot show for each actuator.
const INTERFACES_LISTED: usize = 4;
/// Contributions below this fraction of the largest contribution are rounding errors and are not
/// listed.
const ROUNDING: f64 = 1e-9;
/// Index of the colour of the total friction contribution.
const ALL: usize = LIMIT;

impl Job<'_> {
    /// Returns true if the run has friction contributions: friction acts, and the mechanism has an
    /// actuator.
    pub fn has_shares(&self) -> bool {
        let mechanism = &self.model.mechanism;
        self.friction != FrictionMode::Off
            && mechanism.actuators().next().is_some()
            && mechanism.joints().iter().any(|joint| !joint.friction.is_empty())
    }
}

/// Statistics of the contribution of each friction interface to the effort of each actuator.
#[derive(Clone, Debug)]
pub(super) struct Ranking(Vec<Vec<Size>>);

impl Ranking {
    pub(super) fn new(drives: usize, interfaces: usize) -> Self {
        Self(vec![vec![Size::default(); interfaces]; drives])
    }

    pub(super) fn add(&mut self, time: f64, shares: &Contributions<f64>) {
        for (drive, sizes) in self.0.iter_mut().enumerate() {
            for (size, share) in sizes.iter_mut().zip(shares.of_actuator(drive)) {
                size.add(time, share);
            }
        }
    }

    /// Returns the indices of the friction interfaces that contribute to an actuator's effort, in
    /// decreasing order of the root mean square of the contribution.
    fn ranked(&self, drive: usize) -> Vec<usize> {
        let sizes = &self.0[drive];
        let largest = sizes.iter().map(Size::rms).fold(0.0, f64::max);
        let mut interfaces: Vec<usize> =
            (0..sizes.len()).filter(|&c| sizes[c].rms() > ROUNDING * largest).collect();
        interfaces.sort_by(|&a, &b| sizes[b].rms().total_cmp(&sizes[a].rms()));
        interfaces
    }

    pub(super) fn json(&self, names: &Names, drive: usize) -> Value {
        let interfaces = self.ranked(drive).into_iter().map(|interface| {
            let mut value = self.0[drive][interface].json();
            value["interface"] = json!(names.interfaces[interface].0);
            value
        });
        interfaces.collect()
    }

    /// Writes one line for each of the actuators whose efforts friction changes most, relative to
    /// the effort. `changes` contains, for each actuator, the root mean squares of the friction
    /// contribution and of the effort.
    pub(super) fn write(
        &self,
        out: &mut impl Write,
        names: &Names,
        changes: &[(f64, f64)],
    ) -> fmt::Result {
        // Changes are relative to the effort, because forces and torques are not comparable.
        let relative = |drive: &usize| changes[*drive].0 / changes[*drive].1;
        let mut drives: Vec<usize> =
            (0..changes.len()).filter(|&drive| changes[drive].0 > 0.0).collect();
        if drives.len() > DRIVES_LISTED {
            drives.sort_by(|a, b| relative(b).total_cmp(&relative(a)));
            drives.truncate(DRIVES_LISTED);
            drives.sort_unstable();
        }
        for drive in drives {
            let (name, unit) = &names.drives[drive];
            let ranked = self.ranked(drive);
            let parts = ranked.iter().map(|&interface| {
                let rms = number(self.0[drive][interface].rms());
                format!("{} {rms}", names.interfaces[interface].0)
            });
            let (parts, change) = (listed(parts, INTERFACES_LISTED), number(changes[drive].0));
            writeln!(out, "friction changes {name} by {change} {unit} rms: {parts}")?;
        }
        Ok(())
    }
}

/// Curves of the friction contributions to all efforts.
#[derive(Clone, Debug)]
pub(super) struct ShareCurves {
    ranking: Ranking,
    all: Vec<JumpTrace>,
    traces: Vec<Vec<JumpTrace>>,
}

impl ShareCurves {
    /// Creates empty curves with room for `count` samples.
    pub(super) fn new(names: &Names, count: usize) -> Self {
        let (drives, interfaces) = (names.drives.len(), names.interfaces.len());
        let trace = JumpTrace::new(count);
        Self {
            ranking: Ranking::new(drives, interfaces),
            all: vec![trace.clone(); drives],
            traces: vec![vec![trace; interfaces]; drives],
        }
    }

    /// Adds a sample. `rests` is true for each actuator whose effort is an interval because joints
    /// are at rest. `reversal` is the time, s, of the first velocity reversal of any interface
    /// since the previous sample.
    pub(super) fn add(
        &mut self,
        time: f64,
        shares: &Contributions<f64>,
        rests: &[bool],
        reversal: Option<f64>,
    ) {
        self.ranking.add(time, shares);
        let each = self.all.iter_mut().zip(&mut self.traces).zip(rests);
        for (drive, ((all, traces), rests)) in each.enumerate() {
            all.push(time, 0.0, shares.of_actuator(drive).sum(), *rests, reversal);
            for (trace, share) in traces.iter_mut().zip(shares.of_actuator(drive)) {
                trace.push(time, 0.0, share, *rests, reversal);
            }
        }
    }

    /// Draws a figure with a panel for each actuator and its largest contributions. The curve of an
    /// interface has the colour of its leg, and the second curve of a leg in a panel is dashed. If
    /// a panel contains more than two interfaces of one leg, or interfaces outside the legs, each
    /// curve has the colour that `colours` contains for the interface. If two of these colours are
    /// equal, one of them is replaced by an unused colour.
    pub(super) fn figure(
        self,
        names: &Names,
        (legs, interface_legs): (&[Option<usize>], &[Option<usize>]),
        colours: &[usize],
        title: String,
        x_label: String,
    ) -> Figure {
        let mut panels = Vec::new();
        for (drive, (all, traces)) in self.all.into_iter().zip(self.traces).enumerate() {
            let mut lines = vec![all.line("all friction", ALL, true)];
            let ranked = self.ranking.ranked(drive);
            let ranked = &ranked[..ranked.len().min(INTERFACES_LISTED)];
            let styles = by_leg(ranked, interface_legs).unwrap_or_else(|| {
                distinct(ranked, colours).into_iter().map(|colour| (colour, false)).collect()
            });
            for (&interface, (colour, dashed)) in ranked.iter().zip(styles) {
                let trace = traces[interface].clone();
                lines.push(trace.line(&names.interfaces[interface].0, colour, dashed));
            }
            let (name, unit) = &names.drives[drive];
            let (y_label, leg) = (format!("{name} [{unit}]"), legs[drive]);
            panels.push(Panel { y_label, lines, leg, ..Panel::default() });
        }
        Figure { title, x_label, panels }
    }
}

/// Returns the colour of the leg of each interface, and true for the second interface of a leg,
/// whose curve is dashed. `None` if an interface has no leg, or if a leg has more than two
/// interfaces.
fn by_leg(interfaces: &[usize], legs: &[Option<usize>]) -> Option<Vec<(usize, bool)>> {
    let mut chosen = Vec::new();
    for interface in interfaces {
        let colour = of_leg(legs[*interface]?);
        let style = [(colour, false), (colour, true)];
        chosen.push(style.into_iter().find(|style| !chosen.contains(style))?);
    }
    Some(chosen)
}

/// Returns distinct colours for the given interfaces. Each interface has the colour that `colours`
/// contains for it. If an earlier interface already has this colour, the interface has an unused
/// colour.
fn distinct(interfaces: &[usize], colours: &[usize]) -> Vec<usize> {
    let own = |interface: &usize| colours[*interface] % COLOURS.len();
    let mut taken = vec![ALL];
    let mut chosen: Vec<Option<usize>> = Vec::new();
    for interface in interfaces {
        let free = !taken.contains(&own(interface));
        taken.extend(free.then(|| own(interface)));
        chosen.push(free.then(|| own(interface)));
    }
    let mut others = (0..COLOURS.len()).filter(|colour| !taken.contains(colour));
    chosen.into_iter().map(|colour| colour.or_else(|| others.next()).unwrap_or(ALL)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that interfaces have the colours of their legs only if a panel contains at most two
    /// interfaces of each leg and no interface outside the legs.
    #[test]
    fn contributions_have_the_colours_of_legs() {
        let legs = [Some(0), Some(0), Some(1), None, Some(0)];
        let styles = by_leg(&[1, 2, 0], &legs);
        let expected = vec![(of_leg(0), false), (of_leg(1), false), (of_leg(0), true)];
        assert_eq!(styles, Some(expected));
        assert_eq!(by_leg(&[0, 1, 4], &legs), None);
        assert_eq!(by_leg(&[2, 3], &legs), None);
    }

    /// Checks that each interface has the colour given in `colours` if no earlier interface has
    /// this colour, and that no two interfaces of a panel share a colour.
    #[test]
    fn colours_of_a_panel_are_distinct() {
        assert_eq!(distinct(&[2, 0], &[0, 1, 2]), [2, 0]);
        let shared = distinct(&[0, 1, 2, 3], &[3, 3, 0, ALL]);
        assert_eq!((shared[0], shared[2]), (3, 0));
        assert!(!shared.contains(&ALL));
        assert!((0..4).all(|a| (0..a).all(|b| shared[a] != shared[b])), "{shared:?}");
    }
}
