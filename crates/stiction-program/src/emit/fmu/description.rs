//! Model descriptions (`modelDescription.xml`) of functional mock-up units (FMUs).

use std::fmt::Write;

/// Version of the FMI standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fmi {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// Role of a variable in an FMU (FMI attribute `causality`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Independent variable: the time.
    Independent,
    /// Input, which may be set at any time.
    Input,
    /// Result that other FMUs may read.
    Output,
    /// Value that is constant unless the user changes it.
    Parameter,
    /// Result for display only.
    Local,
}

/// Times at which a variable may change (FMI attribute `variability`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// The variable may change only before the end of the initialisation.
    Fixed,
    /// The variable may change only between communication steps.
    Tunable,
    /// The variable may change only at events.
    Discrete,
    /// The variable may change at any time.
    Continuous,
}

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 64-bit floating point.
    Real,
    /// 32-bit integer.
    Integer,
}

/// Value of a variable before the first step (FMI attribute `start`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// Value of a real variable.
    Real(f64),
    /// Value of an integer variable.
    Integer(i32),
}

/// Variable of a functional mock-up unit (FMU). The index of the variable in
/// [`Description::variables`] is its FMI value reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// Type of the value.
    pub kind: Kind,
    /// Role of the variable in the FMU.
    pub causality: Causality,
    /// Times at which the value may change.
    pub variability: Variability,
    /// FMI name of the unit of measurement, `1` for dimensionless values.
    pub unit: String,
    /// Description for the user.
    pub about: String,
    /// Value of an input or parameter before the first step; `None` for other variables.
    pub start: Option<Start>,
    /// Smallest and largest permitted value; `None` for no limit.
    pub range: (Option<f64>, Option<f64>),
}

/// Content of `modelDescription.xml`.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Version of the FMI standard to which the description conforms.
    pub fmi: Fmi,
    /// Name of the binary, which is also the prefix of the functions.
    pub identifier: String,
    /// Name of the model.
    pub model: String,
    /// Description of the model for the user.
    pub about: String,
    /// Version of the software that generates the FMU.
    pub version: String,
    /// Identifier (FMI `guid` or `instantiationToken`) with which an FMU checks that its binary or
    /// source code belongs to this description.
    pub token: String,
    /// Source files to compile; empty for an FMU that contains only a binary.
    pub sources: Vec<String>,
    /// Log categories of messages: name and description of each category.
    pub categories: Vec<(&'static str, &'static str)>,
    /// True if a communication step can end early at an event. Only descriptions for FMI 3.0
    /// contain this declaration.
    pub has_events: bool,
    /// Recommended communication step, s.
    pub step: f64,
    /// Start of the default experiment, s.
    pub start: f64,
    /// End of the default experiment, s; `None` for no fixed end.
    pub stop: Option<f64>,
    /// Variables in the order of their value references.
    pub variables: Vec<Variable>,
}

impl Fmi {
    /// Returns the version number of the FMI standard in two forms: major number, and complete
    /// number.
    pub(crate) fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Two => ("2", "2.0"),
            Self::Three => ("3", "3.0"),
        }
    }

    /// Returns the name of the FMU folder that contains the binaries for a platform; `None` if the
    /// standard defines no name for the platform.
    ///
    /// `system` and `processor` are named as in [`std::env::consts::OS`] and
    /// [`std::env::consts::ARCH`].
    pub fn platform(self, system: &str, processor: &str) -> Option<String> {
        let system = match (self, system) {
            (_, "macos") => "darwin",
            (Self::Two, "windows") => "win",
            (_, "linux" | "windows") => system,
            _ => return None,
        };
        match (self, processor) {
            (Self::Two, "x86_64") => Some(format!("{system}64")),
            (Self::Two, "x86") => Some(format!("{system}32")),
            (Self::Two, _) => None,
            (Self::Three, "x86_64" | "x86" | "aarch64") => Some(format!("{processor}-{system}")),
            (Self::Three, _) => None,
        }
    }
}

impl Variable {
    /// Creates the variable of the time, s.
    pub fn time() -> Self {
        Self::real("time", Causality::Independent, "s", "Time")
    }

    /// Creates a real variable: tunable if it is a parameter, otherwise continuous.
    pub fn real(name: &str, causality: Causality, unit: &str, about: &str) -> Self {
        let variability = match causality {
            Causality::Parameter => Variability::Tunable,
            _ => Variability::Continuous,
        };
        Self {
            name: name.to_owned(),
            kind: Kind::Real,
            causality,
            variability,
            unit: unit.to_owned(),
            about: about.to_owned(),
            start: None,
            range: (None, None),
        }
    }

    /// Creates an integer variable: tunable if it is a parameter, otherwise discrete.
    pub fn integer(name: &str, causality: Causality, about: &str) -> Self {
        let variability = match causality {
            Causality::Parameter => Variability::Tunable,
            _ => Variability::Discrete,
        };
        Self { kind: Kind::Integer, variability, ..Self::real(name, causality, "1", about) }
    }

    fn attributes(&self, reference: usize) -> [String; 2] {
        let causality = match self.causality {
            Causality::Independent => "independent",
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Parameter => "parameter",
            Causality::Local => "local",
        };
        let variability = match self.variability {
            Variability::Fixed => "fixed",
            Variability::Tunable => "tunable",
            Variability::Discrete => "discrete",
            Variability::Continuous => "continuous",
        };
        let general = format!(
            "name=\"{}\" valueReference=\"{reference}\" description=\"{}\" causality=\"{causality}\" \
             variability=\"{variability}\"",
            escaped(&self.name),
            escaped(&self.about)
        );
        let mut typed = String::new();
        if self.kind == Kind::Real && self.unit != "1" {
            let _ = write!(typed, " unit=\"{}\"", escaped(&self.unit));
        }
        for (what, bound) in [("min", self.range.0), ("max", self.range.1)] {
            let Some(bound) = bound else { continue };
            let _ = match self.kind {
                Kind::Real => write!(typed, " {what}=\"{bound:?}\""),
                Kind::Integer => write!(typed, " {what}=\"{bound:.0}\""),
            };
        }
        let _ = match self.start {
            Some(Start::Real(start)) => write!(typed, " start=\"{start:?}\""),
            Some(Start::Integer(start)) => write!(typed, " start=\"{start}\""),
            None => Ok(()),
        };
        [general, typed]
    }
}

impl Description {
    /// Text of `modelDescription.xml`.
    pub fn xml(&self) -> String {
        let (_, version) = self.fmi.names();
        let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned();
        let token = match self.fmi {
            Fmi::Two => "guid",
            Fmi::Three => "instantiationToken",
        };
        let _ = writeln!(
            text,
            "<fmiModelDescription fmiVersion=\"{version}\" modelName=\"{}\" {token}=\"{}\" description=\"{}\" \
             generationTool=\"stiction {}\" variableNamingConvention=\"flat\">",
            escaped(&self.model),
            self.token,
            escaped(&self.about),
            escaped(&self.version)
        );
        self.interface(&mut text);
        self.units(&mut text);
        text += "  <LogCategories>\n";
        for (name, about) in &self.categories {
            let _ = writeln!(text, "    <Category name=\"{name}\" description=\"{about}\"/>");
        }
        text += "  </LogCategories>\n";
        let stop = self.stop.map_or(String::new(), |stop| format!(" stopTime=\"{stop:?}\""));
        let _ = writeln!(
            text,
            "  <DefaultExperiment startTime=\"{}\"{stop} stepSize=\"{:?}\"/>",
            self.start, self.step
        );
        text += "  <ModelVariables>\n";
        for (reference, variable) in self.variables.iter().enumerate() {
            let [general, typed] = variable.attributes(reference);
            let _ = match (self.fmi, variable.kind) {
                (Fmi::Two, Kind::Real) => {
                    writeln!(text, "    <ScalarVariable {general}><Real{typed}/></ScalarVariable>")
                }
                (Fmi::Two, Kind::Integer) => writeln!(
                    text,
                    "    <ScalarVariable {general}><Integer{typed}/></ScalarVariable>"
                ),
                (Fmi::Three, Kind::Real) => writeln!(text, "    <Float64 {general}{typed}/>"),
                (Fmi::Three, Kind::Integer) => writeln!(text, "    <Int32 {general}{typed}/>"),
            };
        }
        text += "  </ModelVariables>\n  <ModelStructure>\n";
        self.structure(&mut text);
        text += "  </ModelStructure>\n</fmiModelDescription>\n";
        text
    }

    fn interface(&self, text: &mut String) {
        let state = match self.fmi {
            Fmi::Two => {
                "canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\" \
                 canSerializeFMUstate=\"true\""
            }
            Fmi::Three if self.has_events => {
                "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" hasEventMode=\"true\""
            }
            Fmi::Three => "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"",
        };
        let _ = write!(
            text,
            "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" {state}",
            self.identifier
        );
        if self.fmi == Fmi::Three || self.sources.is_empty() {
            *text += "/>\n";
            return;
        }
        *text += ">\n    <SourceFiles>\n";
        for name in &self.sources {
            let _ = writeln!(text, "      <File name=\"{name}\"/>");
        }
        *text += "    </SourceFiles>\n  </CoSimulation>\n";
    }

    fn units(&self, text: &mut String) {
        let mut used: Vec<&str> = self.variables.iter().map(|v| v.unit.as_str()).collect();
        used.sort_unstable();
        used.dedup();
        *text += "  <UnitDefinitions>\n";
        for unit in used {
            let Some(base) = base_unit(unit) else { continue };
            let _ = writeln!(text, "    <Unit name=\"{unit}\"><BaseUnit {base}/></Unit>");
        }
        *text += "  </UnitDefinitions>\n";
    }

    fn structure(&self, text: &mut String) {
        let all = self.variables.iter().enumerate();
        let outputs = || all.clone().filter(|(_, v)| v.causality == Causality::Output);
        match self.fmi {
            Fmi::Two => {
                for list in ["Outputs", "InitialUnknowns"] {
                    let _ = writeln!(text, "    <{list}>");
                    for (k, _) in outputs() {
                        let _ = writeln!(text, "      <Unknown index=\"{}\"/>", k + 1);
                    }
                    let _ = writeln!(text, "    </{list}>");
                }
            }
            Fmi::Three => {
                for list in ["Output", "InitialUnknown"] {
                    for (k, _) in outputs() {
                        let _ = writeln!(text, "    <{list} valueReference=\"{k}\"/>");
                    }
                }
            }
        }
    }

    /// Text of `sources/buildDescription.xml` of FMI 3.0.
    pub fn build(&self) -> String {
        let mut text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  \
             <BuildConfiguration modelIdentifier=\"{}\">\n    <SourceFileSet language=\"C99\">\n",
            self.identifier
        );
        for name in &self.sources {
            let _ = writeln!(text, "      <SourceFile name=\"{name}\"/>");
        }
        text += "    </SourceFileSet>\n  </BuildConfiguration>\n</fmiBuildDescription>\n";
        text
    }
}

/// XML attributes with the exponents of the SI base units in a unit of measurement; `None` for a
/// dimensionless or unknown unit.
fn base_unit(unit: &str) -> Option<&'static str> {
    Some(match unit {
        "s" => "s=\"1\"",
        "m" => "m=\"1\"",
        "m/s" => "m=\"1\" s=\"-1\"",
        "m/s2" => "m=\"1\" s=\"-2\"",
        "rad" => "rad=\"1\"",
        "rad/s" => "rad=\"1\" s=\"-1\"",
        "rad/s2" => "rad=\"1\" s=\"-2\"",
        "kg" => "kg=\"1\"",
        "N" => "kg=\"1\" m=\"1\" s=\"-2\"",
        "N.m" => "kg=\"1\" m=\"2\" s=\"-2\"",
        "N.s/m" => "kg=\"1\" s=\"-1\"",
        "J" => "kg=\"1\" m=\"2\" s=\"-2\"",
        _ => return None,
    })
}

/// Makes the names of variables unique by appending numbers to repeated names.
pub fn make_unique(variables: &mut [Variable]) {
    let mut seen = std::collections::HashSet::new();
    for variable in variables {
        let plain = variable.name.clone();
        let mut count = 1;
        while !seen.insert(escaped(&variable.name)) {
            count += 1;
            variable.name = format!("{plain} {count}");
        }
    }
}

/// Escapes text for an XML attribute, because model names may contain any character. Characters
/// that XML does not allow, and white space other than blanks, are written as their code points in
/// braces.
pub(super) fn escaped(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => plain.push_str("&amp;"),
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '"' => plain.push_str("&quot;"),
            '\'' => plain.push_str("&apos;"),
            c if c.is_control()
                || matches!(c, '\u{fffe}' | '\u{ffff}' | '\u{2028}' | '\u{2029}') =>
            {
                let _ = write!(plain, "{{{:X}}}", u32::from(c));
            }
            c => plain.push(c),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_text_stays_inside_its_attribute() {
        assert_eq!(escaped("a\"/><x y='&\n\u{0}"), "a&quot;/&gt;&lt;x y=&apos;&amp;{A}{0}");
    }

    #[test]
    fn names_become_unique() {
        let variable = |name: &str| Variable::real(name, Causality::Local, "1", "");
        let mut variables = vec![variable("a"), variable("a"), variable("a 2"), variable("a")];
        make_unique(&mut variables);
        let names: Vec<&str> = variables.iter().map(|v| v.name.as_str()).collect();
        assert_eq!(names, ["a", "a 2", "a 2 2", "a 3"]);
    }

    #[test]
    fn platforms_have_the_names_of_the_standard() {
        assert_eq!(Fmi::Two.platform("linux", "x86_64").as_deref(), Some("linux64"));
        assert_eq!(Fmi::Two.platform("windows", "x86_64").as_deref(), Some("win64"));
        assert_eq!(Fmi::Two.platform("linux", "aarch64"), None);
        assert_eq!(Fmi::Three.platform("macos", "aarch64").as_deref(), Some("aarch64-darwin"));
        assert_eq!(Fmi::Three.platform("linux", "riscv64"), None);
    }
}
