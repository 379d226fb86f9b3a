//! Functional mock-up units (FMUs): source code of feedforward programs with the interface of the
//! FMI standard.
//!
//! The interface follows the specifications FMI 2.0.5 and 3.0.2 of the Modelica Association. The
//! code contains its own declarations of the interface and needs no other file.

mod description;

pub use description::{
    Causality, Description, Fmi, Kind, Start, Variability, Variable, make_unique,
};

use super::c::C;
use super::tables::kinds;
use super::{Labels, SourceFile, SourceOptions};
use crate::error::RecordError;
use crate::feedforward::Feedforward;
use std::fmt::Write;

const COMMON: &str = include_str!("../templates/fmu/common.c");
const TWO: [&str; 2] =
    [include_str!("../templates/fmu/fmi2.types.c"), include_str!("../templates/fmu/fmi2.c")];
const THREE: [&str; 2] =
    [include_str!("../templates/fmu/fmi3.types.c"), include_str!("../templates/fmu/fmi3.c")];
const THREE_REST: &str = include_str!("../templates/fmu/fmi3.rest.c");
const INDEX: &str = include_str!("../templates/fmu/index.html");
const LICENSE: &str = "The generated source code of this FMU is yours: use, change and distribute it \
without any condition.\nIt comes without any warranty.\n";

impl Feedforward {
    /// Generates the files of an FMU for co-simulation, named by their paths inside the FMU: model
    /// description, source code, documentation. Binaries are not included; the code in `sources/`
    /// compiles without any other file.
    ///
    /// Inputs are the position, rate and acceleration of each prescribed coordinate; outputs are
    /// the actuator efforts. The code uses double precision.
    ///
    /// # Errors
    /// [`RecordError::TooLarge`] if a number in the program is not finite.
    pub fn fmu(
        &self,
        fmi: Fmi,
        labels: &Labels,
        options: &SourceOptions,
    ) -> Result<Vec<SourceFile>, RecordError> {
        let options = SourceOptions {
            precision: super::Precision::Double,
            functions: super::Functions::default(),
            adapters: super::Adapters::default(),
            ..options.clone()
        };
        let code = self.files(super::Language::C, labels, &options, &[])?;
        let name = options.name.as_str();
        let c = C { program: self, labels, options: &options };
        let (number, version) = fmi.names();
        let ([types, functions], rest) = match fmi {
            Fmi::Two => (TWO, ""),
            Fmi::Three => (THREE, THREE_REST),
        };
        let adapter = format!("fmi{number}.c");
        let extra = |token: &str| {
            vec![
                ("FMI", number.to_owned()),
                ("FMI_VERSION", version.to_owned()),
                ("TOKEN", token.to_owned()),
                ("PLACES", self.places(labels)),
                ("SIGNED", self.signed(labels)),
                ("SOURCES", format!("<code>{adapter}</code> and <code>{name}.c</code>")),
                ("TYPES", types.to_owned()),
            ]
        };
        let adapter_text = |token: &str| {
            let pieces = [COMMON, functions, rest].map(|text| c.fill_with(text, &extra(token)));
            pieces.concat()
        };
        let mut description = Description {
            fmi,
            identifier: name.to_owned(),
            model: labels.model.clone(),
            about: "Inverse dynamics with load-dependent joint friction: actuator \
                    efforts for feed-forward"
                .to_owned(),
            version: labels.version.clone(),
            token: String::new(),
            sources: vec![adapter.clone(), format!("{name}.c")],
            categories: vec![
                ("logStatusWarning", "Steps whose efforts do not include friction"),
                ("logStatusDiscard", "Steps for which no efforts exist"),
                ("logStatusError", "Calls that are not allowed"),
            ],
            has_events: false,
            step: 0.001,
            start: 0.0,
            stop: None,
            variables: self.variables(labels),
        };
        let header = |end: &str| code.iter().find(|file| file.name == format!("{name}.{end}"));
        let code: Vec<&SourceFile> = [header("c"), header("h")].into_iter().flatten().collect();
        let all: Vec<&str> = code.iter().map(|file| file.text.as_str()).collect();
        description.token = token(&[&all[..], &[&description.xml(), &adapter_text("")]].concat());
        let file = |name: String, text: String| SourceFile { name, text };
        let mut files = vec![
            file("modelDescription.xml".to_owned(), description.xml()),
            file(format!("sources/{adapter}"), adapter_text(&description.token)),
        ];
        files.extend(code.iter().map(|c| file(format!("sources/{}", c.name), c.text.clone())));
        if fmi == Fmi::Three {
            files.push(file("sources/buildDescription.xml".to_owned(), description.build()));
        }
        files.push(file("documentation/index.html".to_owned(), c.fill_with(INDEX, &extra(""))));
        files.push(file("documentation/licenses/license.txt".to_owned(), LICENSE.to_owned()));
        Ok(files)
    }

    /// Variables of the FMU in the order of their value references.
    fn variables(&self, labels: &Labels) -> Vec<Variable> {
        let mut variables = vec![Variable::time()];
        let kinds_of_input = [
            ("position", "", "Position of the reference motion"),
            ("speed", "/s", "Rate of the reference motion"),
            ("acceleration", "/s2", "Acceleration of the reference motion"),
        ];
        for (k, (what, per, about)) in kinds_of_input.into_iter().enumerate() {
            for ((name, unit), start) in labels.coordinates.iter().zip(self.home()) {
                let start = if k == 0 { *start } else { 0.0 };
                let name = format!("{name}.{what}");
                let unit = format!("{unit}{per}");
                let mut input = Variable::real(&name, Causality::Input, &unit, about);
                input.start = Some(Start::Real(start));
                variables.push(input);
            }
        }
        for (name, unit) in &labels.actuators {
            let about = "Effort of the actuator at the joint, with friction";
            let name = format!("{name}.effort");
            variables.push(Variable::real(
                &name,
                Causality::Output,
                &unit.replace(' ', "."),
                about,
            ));
        }
        for (name, unit, about) in [
            (
                "loops.residual",
                "1",
                "Closure error of the loops, relative to the characteristic \
                length",
            ),
            (
                "singularity.index",
                "1",
                "Singularity index: 0 if some motion is resisted by no actuator",
            ),
            (
                "singularity.determinant",
                "1",
                "Determinant of the equations relative to that at the home position: 0 at singular \
                 positions",
            ),
            (
                "friction.coupling",
                "1",
                "Determinant of the equations with friction relative to that without: 0 if \
                 friction locks the mechanism",
            ),
            ("joints.reaction", "N", "Largest reaction force of all joints"),
        ] {
            variables.push(Variable::real(name, Causality::Local, unit, about));
        }
        let about = "Outcome: 0 success, 1 friction at rest chosen by a rule, or iteration not \
            converged, 2 efforts without friction, negative: efforts of the last valid step";
        variables.push(Variable::integer("status", Causality::Output, about));
        let about = "Friction at rest: 0 as in the last motion, 1 fading to zero, 2 none";
        let mut rest = Variable::integer("friction.rest", Causality::Parameter, about);
        (rest.start, rest.range) = (Some(Start::Integer(0)), (Some(0.0), Some(2.0)));
        variables.push(rest);
        let mut parameter = |name: &str, unit: &str, about: &str, start, range| {
            let mut own = Variable::real(name, Causality::Parameter, unit, about);
            (own.start, own.range) = (Some(Start::Real(start)), range);
            variables.push(own);
        };
        let size = (Some(0.0), None);
        let about = "Rates and accelerations up to this magnitude count as zero [SI units]";
        parameter("friction.rest_rate", "1", about, 1e-9, size);
        let about = "Factor by which fading friction is multiplied in every step at rest";
        parameter("friction.fade", "1", about, 0.99, (Some(0.0), Some(1.0)));
        for kind in kinds(self, labels) {
            for (k, (of, value)) in kind.values.iter().enumerate() {
                let part = ["mass", "x", "y", "z"][k % 4];
                let (name, unit, range) = match kind.field {
                    "payload" => {
                        let body = of.split(", ").next().unwrap_or_default();
                        let unit = if part == "mass" { "kg" } else { "m" };
                        let range = if part == "mass" { size } else { (None, None) };
                        (format!("{body}.payload.{part}"), unit, range)
                    }
                    "wrench" => {
                        let (body, component) = of.split_once(", ").unwrap_or((of, ""));
                        let unit = if component.starts_with('f') { "N" } else { "N.m" };
                        (format!("{body}.{component}"), unit, (None, None))
                    }
                    field => {
                        let unit = match kind.unit {
                            "-" => "1",
                            "N s/m" => "N.s/m",
                            unit => unit,
                        };
                        (format!("{of}.{field}"), unit, size)
                    }
                };
                let about = match (kind.field, part) {
                    ("mu", _) => "Coefficient of sliding friction",
                    ("viscous", _) => "Viscous coefficient at the sliding surface",
                    ("mass", _) => "Mass of the body",
                    ("wrench", _) => "Load on the body at its origin, in world axes",
                    (_, "mass") => "Mass of a point mass on the body",
                    _ => "Position of the point mass in the frame of the body",
                };
                parameter(&name, unit, about, *value, range);
            }
        }
        description::make_unique(&mut variables);
        variables
    }

    /// Generates C `switch` cases that map the value references of parameters to their addresses.
    fn places(&self, labels: &Labels) -> String {
        let mut text = "    case REST_RATE:\n        return &content->params.rest_rate;\n    case FADE:\n        \
                        return &content->params.fade;\n"
            .to_owned();
        let mut all = 0;
        for kind in kinds(self, labels) {
            for k in 0..kind.values.len() {
                let field = kind.field;
                let _ = writeln!(
                    text,
                    "    case TUNABLES + {all}:\n        return &content->params.{field}[{k}];"
                );
                all += 1;
            }
        }
        text
    }

    /// Generates C `switch` cases for the value references of those parameters that may be
    /// negative.
    fn signed(&self, labels: &Labels) -> String {
        let mut text = String::new();
        let mut all = 0;
        for kind in kinds(self, labels) {
            for k in 0..kind.values.len() {
                if kind.field == "wrench" || (kind.field == "payload" && k % 4 > 0) {
                    let _ = writeln!(text, "    case TUNABLES + {all}:");
                }
                all += 1;
            }
        }
        if !text.is_empty() {
            text += "        return 0;\n";
        }
        text
    }
}

/// Computes an identifier in the form of a GUID from the hash of `texts`.
pub fn token(texts: &[&str]) -> String {
    // FNV-1a (Fowler, Noll, Vo), 64 bits, from two offsets.
    let hash = |offset: u64| {
        let bytes = texts.iter().flat_map(|text| text.bytes().chain([0]));
        bytes.fold(offset, |hash, b| (hash ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
    };
    let (a, b) = (hash(0xcbf2_9ce4_8422_2325), hash(0x6c62_272e_07bb_0142));
    let text = format!("{a:016x}{b:016x}");
    format!(
        "{{{}-{}-{}-{}-{}}}",
        &text[..8],
        &text[8..12],
        &text[12..16],
        &text[16..20],
        &text[20..]
    )
}
