//! Kinds of quantities that the model file expects.

use super::{Dimension, Fault};
use crate::source::Span;

/// Kind of a quantity, which determines its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    Length,
    Mass,
    Time,
    Angle,
    Inertia,
    Force,
    Moment,
    Acceleration,
    Viscous,
    Stiffness,
    Damping,
    Pitch,
    /// Displacement per force, m/N.
    Compliance,
    /// Damping that couples translation and rotation: force per angular speed or moment per speed,
    /// N s.
    Impulse,
    /// Angle per moment, rad/(N m).
    AngularCompliance,
    Speed,
    /// Bristle stiffness per newton of normal load, 1/m.
    PerLength,
    /// Bristle damping per newton of normal load, s/m.
    PerSpeed,
    /// Moment per angle, N m/rad.
    AngularStiffness,
    /// Moment per angular rate, N m s/rad.
    AngularDamping,
    /// Force per displacement and time, N/(m s).
    IntegralGain,
    /// Moment per angle and time, N m/(rad s).
    AngularIntegralGain,
    /// Travel per revolution of a screw or pulley, m.
    Lead,
    TorquePerCurrent,
    /// Cycles per time, Hz.
    Frequency,
    Jerk,
    AngularSpeed,
    AngularAcceleration,
    AngularJerk,
    Number,
    /// Quantity of any dimension, such as the value of a parameter.
    Any,
}

/// Phrases that describe a kind of quantity.
pub(crate) struct Words {
    /// Noun phrase such as `a length`.
    pub(crate) noun: &'static str,
    /// Example of a value with a unit.
    pub(crate) example: &'static str,
    /// SI unit assumed for bare numbers.
    pub(crate) unit: &'static str,
}

impl Measure {
    /// Dimension of quantities of this kind.
    pub(crate) fn dimension(self) -> Dimension {
        match self {
            Self::Length => Dimension::LENGTH,
            Self::Mass => Dimension::MASS,
            Self::Time => Dimension::TIME,
            Self::Angle => Dimension::ANGLE,
            Self::Inertia => Dimension::of(2, 1, 0),
            Self::Force => Dimension::of(1, 1, -2),
            Self::Moment => Dimension::of(2, 1, -2),
            Self::Acceleration => Dimension::of(1, 0, -2),
            Self::Viscous | Self::Damping => Dimension::of(0, 1, -1),
            Self::Impulse => Dimension::of(1, 1, -1),
            Self::Stiffness => Dimension::of(0, 1, -2),
            Self::Pitch => Dimension::LENGTH.with_angle(-1),
            Self::Compliance => Dimension::of(0, -1, 2),
            Self::AngularCompliance => Dimension::of(-2, -1, 2).with_angle(1),
            Self::Speed => Dimension::of(1, 0, -1),
            Self::PerLength => Dimension::of(-1, 0, 0),
            Self::PerSpeed => Dimension::of(-1, 0, 1),
            Self::AngularStiffness => Dimension::of(2, 1, -2).with_angle(-1),
            Self::AngularDamping => Dimension::of(2, 1, -1).with_angle(-1),
            Self::IntegralGain => Dimension::of(0, 1, -3),
            Self::AngularIntegralGain => Dimension::of(2, 1, -3).with_angle(-1),
            Self::Lead => Dimension::LENGTH,
            Self::TorquePerCurrent => Dimension::of(2, 1, -2).with_current(-1),
            Self::Frequency => Dimension::of(0, 0, -1),
            Self::Jerk => Dimension::of(1, 0, -3),
            Self::AngularSpeed => Dimension::of(0, 0, -1).with_angle(1),
            Self::AngularAcceleration => Dimension::of(0, 0, -2).with_angle(1),
            Self::AngularJerk => Dimension::of(0, 0, -3).with_angle(1),
            Self::Number | Self::Any => Dimension::NONE,
        }
    }

    /// Phrases that describe this kind of quantity.
    pub(crate) fn words(self) -> Words {
        let (noun, example, unit) = match self {
            Self::Length => ("a length", "128.48 mm", "m"),
            Self::Mass => ("a mass", "1.5 kg", "kg"),
            Self::Time => ("a time", "0.5 s", "s"),
            Self::Angle => ("an angle", "30 deg", "rad"),
            Self::Inertia => ("a moment of inertia", "1.42e4 kg mm^2", "kg m^2"),
            Self::Force => ("a force", "-100 N", "N"),
            Self::Moment => ("a moment", "5 N m", "N m"),
            Self::Acceleration => ("an acceleration", "-9.81 m/s^2", "m/s^2"),
            Self::Viscous => ("a viscous coefficient", "0.02 N s/m", "N s/m"),
            Self::Stiffness => ("a stiffness", "4.5 N/mm", "N/m"),
            Self::Damping => ("a damping coefficient", "20 N s/m", "N s/m"),
            Self::Impulse => ("a damping coupling", "2 N s", "N s"),
            Self::Pitch => ("a pitch", "5 mm/rev", "m/rad"),
            Self::Compliance => ("a compliance", "5 um/kN", "m/N"),
            Self::AngularCompliance => ("an angular compliance", "20 mrad/(kN m)", "rad/(N m)"),
            Self::Speed => ("a speed", "10 mm/s", "m/s"),
            Self::PerLength => ("a stiffness per load", "20 N/um / 100 N", "1/m"),
            Self::PerSpeed => ("a damping per load", "300 N s/m / 100 N", "s/m"),
            Self::AngularStiffness => ("an angular stiffness", "500 N m/rad", "N m/rad"),
            Self::AngularDamping => ("an angular damping", "5 N m s/rad", "N m s/rad"),
            Self::IntegralGain => ("an integral gain", "2 kN/(m s)", "N/(m s)"),
            Self::AngularIntegralGain => {
                ("an angular integral gain", "50 N m/(rad s)", "N m/(rad s)")
            }
            Self::Lead => ("a lead", "10 mm/rev", "m/rev"),
            Self::TorquePerCurrent => ("a torque constant", "0.06 N m/A", "N m/A"),
            Self::Frequency => ("a frequency", "10 Hz", "Hz"),
            Self::Jerk => ("a jerk", "200 m/s^3", "m/s^3"),
            Self::AngularSpeed => ("an angular speed", "90 deg/s", "rad/s"),
            Self::AngularAcceleration => ("an angular acceleration", "20 rad/s^2", "rad/s^2"),
            Self::AngularJerk => ("an angular jerk", "400 rad/s^3", "rad/s^3"),
            Self::Number => ("a plain number", "0.12", ""),
            Self::Any => ("a quantity", "200 mm", ""),
        };
        Words { noun, example, unit }
    }

    /// Phrase for the expected value, such as `a length such as "128.48 mm" or a bare number in m`.
    pub(crate) fn expected(self) -> String {
        let Words { noun, example, unit } = self.words();
        match self {
            Self::Number => format!("{noun} such as {example}"),
            Self::Any => format!("{noun} such as \"{example}\" or a number"),
            _ => format!("{noun} such as \"{example}\" or a bare number in {unit}"),
        }
    }

    /// Returns advice if the dimension `found` is that of a quantity often given by mistake, such
    /// as a stiffness instead of a compliance.
    fn advice(self, found: Dimension) -> Option<String> {
        // Data sheets state friction moments per angular rate.
        let turning = self == Self::Viscous && found.same(Dimension::of(2, 1, -1));
        // Data sheets also state stiffnesses instead of compliances.
        let inverse = match self {
            Self::Compliance => found.same(Dimension::of(0, 1, -2)),
            Self::AngularCompliance => found.same(Dimension::of(2, 1, -2)),
            _ => false,
        };
        if inverse {
            return Some("this is a stiffness; write its inverse: \"1/(200 N/um)\"".to_owned());
        }
        if self == Self::Frequency && found.has_angle() {
            return Some(
                "a frequency is in cycles per second: divide an angular frequency by 2*pi rad"
                    .to_owned(),
            );
        }
        if self == Self::AngularSpeed && !found.has_angle() {
            return Some("write the unit of the angle: \"50 rev/s\" or \"300 rad/s\"".to_owned());
        }
        turning.then(|| {
            "this surface does not turn: give the force divided by the sliding speed, in N s/m"
                .to_owned()
        })
    }

    /// Returns `None` if a quantity of dimension `found` is acceptable, otherwise a function that
    /// creates the error message for a place in the text. A plain number is accepted and read in SI
    /// units. An angle is not accepted as a length. A number in percent is accepted only as a plain
    /// number, for example as an efficiency.
    pub(crate) fn complaint(self, found: Dimension) -> Option<impl FnOnce(Span) -> Fault> {
        let expected = self.dimension();
        let bare = found.is_none() && (found.is_bare() || expected.is_none());
        let number_from_angle = self == Self::Number && found.is_angle();
        let percent = !matches!(self, Self::Number | Self::Any) && found.is_ratio();
        let fine = self == Self::Any || expected.same(found) || bare;
        // An angular frequency differs from the frequency by 2 pi.
        let turns = self == Self::Frequency && found.has_angle();
        let cycles = self == Self::AngularSpeed && !bare && !found.has_angle();
        (!fine || number_from_angle || percent || turns || cycles).then_some(move |span| {
            Fault::new(
                span,
                format!("expected {}, found {}", self.expected(), found.describe()),
                format!("this is {}", found.describe()),
            )
            .code("dimension")
            .maybe_help(self.advice(found))
        })
    }
}
