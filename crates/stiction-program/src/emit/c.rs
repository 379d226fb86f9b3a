//! Generation of source code in C99, from templates and from the statements of a program.

use super::literal::literal;
use super::names::harmless;
use super::tables::{Kind, kinds, lines};
use super::walk::{Listing, Operand, Statement};
use super::{Labels, Listings, Precision, SourceFile, SourceOptions, TestVector};
use crate::code::{Fused, Step};
use crate::feedforward::{CLOSED, CORRECTIONS, DONE, Feedforward};
use crate::graph::Function;
use crate::inverse::{COARSE, ROUNDING, SETTLED, STEPS};
use std::fmt::Write;

const HEADER: &str = include_str!("templates/header.h");
const RUNTIME: &str = include_str!("templates/runtime.c");
const SINGULARITY: &str = include_str!("templates/singularity.c");
const OWN_MATH: &str = include_str!("templates/own_math.c");
const KINEMATICS: &str = include_str!("templates/kinematics.c");
const KINEMATICS_HEAD: &str = include_str!("templates/kinematics.h");
const REACTIONS: &str = include_str!("templates/reactions.c");
const REACTIONS_HEAD: &str = include_str!("templates/reactions.h");
const LINEARIZE: &str = include_str!("templates/linearize.c");
const DERIVATIVES: &str = include_str!("templates/derivatives.c");
const DERIVATIVES_HEAD: &str = include_str!("templates/derivatives.h");
const ACCELERATIONS: &str = include_str!("templates/accelerations.c");
const ACCELERATIONS_HEAD: &str = include_str!("templates/accelerations.h");
const SELFTEST: &str = include_str!("templates/selftest.c");
const MAKEFILE: &str = include_str!("templates/Makefile");
const CMAKE: &str = include_str!("templates/CMakeLists.txt");
const README: &str = include_str!("templates/README.md");

/// Maximum length of a line of array items, characters.
const WIDTH: usize = 96;

pub(crate) fn files(
    program: &Feedforward,
    labels: &Labels,
    options: &SourceOptions,
    vectors: &[TestVector],
) -> Vec<SourceFile> {
    let c = C { program, labels, options };
    let name = &options.name;
    let file = |name: String, text: String| SourceFile { name, text };
    let mut files = vec![
        file(format!("{name}.h"), c.fill(HEADER)),
        file(format!("{name}.c"), c.fill(RUNTIME)),
        file("selftest.c".to_owned(), c.fill(SELFTEST)),
        file("vectors.csv".to_owned(), table(labels, vectors)),
        file("Makefile".to_owned(), c.fill_with(MAKEFILE, &[("ADAPTER_RULES", c.adapter_rules())])),
        file("CMakeLists.txt".to_owned(), c.fill(CMAKE)),
        file("README.md".to_owned(), c.fill(README)),
    ];
    let adapters = c.adapters(&files);
    files.extend(adapters);
    files
}

/// Formats test vectors as comma-separated values with a header line.
pub(crate) fn table(labels: &Labels, vectors: &[TestVector]) -> String {
    let mut heads = Vec::new();
    for (before, after) in [("", ""), ("d(", ")"), ("d(d(", "))")] {
        let names = labels.coordinates.iter();
        heads.extend(names.map(|(name, _)| format!("{before}{}{after}", harmless(name))));
    }
    heads.extend(labels.actuators.iter().map(|(name, _)| format!("{}.effort", harmless(name))));
    let mut text = heads.join(",") + "\n";
    for TestVector { positions, rates, accelerations, efforts } in vectors {
        let all = [&positions[..], rates, accelerations, efforts].concat();
        let numbers: Vec<String> = all.iter().map(|x| format!("{x:?}")).collect();
        text += &numbers.join(",");
        text.push('\n');
    }
    text
}

pub(crate) struct C<'a> {
    pub(crate) program: &'a Feedforward,
    pub(crate) labels: &'a Labels,
    pub(crate) options: &'a SourceOptions,
}

impl C<'_> {
    /// Fills a template: replaces each name between two `@` signs by its value for this program.
    pub(super) fn fill(&self, template: &str) -> String {
        self.fill_with(template, &[])
    }

    /// Fills a template as [`Self::fill`] does, with the additional names and values in `more`.
    pub(crate) fn fill_with(&self, template: &str, more: &[(&str, String)]) -> String {
        let sizes = self.program.sizes();
        let functions = self.options.functions;
        let Listings { position, forces, kinematics, derivatives } =
            Listings::new(self.program, functions);
        let real = self.options.precision;
        let [errors, correction, preparation, step, last] =
            self.program.operations_with(functions.need_wrenches());
        let closing = (CORRECTIONS + 1) * errors + CORRECTIONS * correction;
        let friction = preparation + STEPS * step + last;
        let name = self.options.name.as_str();
        let (double, suffix) = match real {
            Precision::Double => ("double", ""),
            Precision::Float => ("float", "f"),
        };
        let pick =
            |double: f64, float: f64| self.number(if suffix.is_empty() { double } else { float });
        let has_exp = self.calls(Function::Exp) || self.calls(Function::Ln);
        let own_math =
            if self.options.own_math && self.turns() { self.fill_math() } else { String::new() };
        let uses_library = if self.options.own_math && !has_exp && !self.calls(Function::Atan2) {
            "only sqrt and fabs"
        } else {
            "only functions"
        };
        let bytes = if suffix.is_empty() { 8 } else { 4 };
        let work = position.work + forces.work + position.results + forces.results;
        let rubbing = self.program.derivatives.as_ref().map_or(&[][..], |own| &own.joints);
        let of_derivatives =
            |k: usize| derivatives.as_ref().map_or(String::new(), |own| self.body(own, k));
        let values: &[(&str, String)] = &[
            ("NAME", name.to_owned()),
            ("GUARD", name.to_uppercase()),
            ("REAL", double.to_owned()),
            ("F", suffix.to_owned()),
            (
                "LINES",
                lines(self.program, self.labels, self.options)
                    .iter()
                    .map(|line| format!(" * {line}").trim_end().to_owned() + "\n")
                    .collect(),
            ),
            ("COORDINATES", sizes.prescribed.to_string()),
            ("FINGERPRINT_LOW", format!("0x{:08x}u", self.program.fingerprint() as u32)),
            ("FINGERPRINT_HIGH", format!("0x{:08x}u", (self.program.fingerprint() >> 32) as u32)),
            ("FADE", self.number(0.99)),
            ("DRIVES", sizes.drives.to_string()),
            ("JOINTS", sizes.joints.to_string()),
            ("BODIES", sizes.bodies.to_string()),
            ("WRENCH", if functions.need_wrenches() { "6" } else { "3" }.to_owned()),
            ("ANSWERS", super::answers(sizes, functions).to_string()),
            ("TREE", sizes.coordinates.to_string()),
            ("BOUNDED", u8::from(self.program.is_bounded()).to_string()),
            ("TUNABLES", sizes.tunables.to_string()),
            ("UNKNOWNS", sizes.unknowns.to_string()),
            ("POSITION_WORK", position.work.to_string()),
            ("POSITION_RESULTS", position.results.to_string()),
            ("FORCE_WORK", forces.work.to_string()),
            ("FORCE_RESULTS", forces.results.to_string()),
            ("CORRECTIONS", CORRECTIONS.to_string()),
            ("STEPS", STEPS.to_string()),
            ("DONE", pick(DONE, 2e-7)),
            ("CLOSED", pick(CLOSED, 1e-4)),
            ("SETTLED", pick(SETTLED * SETTLED, 1e-8)),
            ("COARSE", pick(COARSE * COARSE, 1e-4)),
            ("ROUNDING", pick(ROUNDING * ROUNDING, 1e-14)),
            ("REST", pick(1e-9, 1e-6)),
            ("SETTLED_STEP", pick(SETTLED, 1e-4)),
            ("RESIDUAL", pick(1e-14, 2e-6)),
            ("RUBBING_JOINTS", rubbing.len().to_string()),
            ("RUBBING", super::list_with_zero(rubbing)),
            ("SLOPE_WORK", derivatives.as_ref().map_or(0, |own| own.work).to_string()),
            ("SLOPE_PREPARATION", of_derivatives(0)),
            ("SLOPES", of_derivatives(1)),
            ("STRIDE", self.number(0.05)),
            ("HUGE", pick(f64::MAX, f64::from(f32::MAX))),
            ("FIELDS", self.fields()),
            ("DEFAULTS", self.defaults()),
            ("TUNE", self.tune()),
            ("HOME", self.numbers(self.program.home_coordinates())),
            ("HOME_VALUES", self.numbers(self.program.home())),
            ("STRIDES", self.strides()),
            ("OWN_MATH", own_math),
            ("ERRORS", self.body(&position, 0)),
            ("CORRECTION", self.body(&position, 1)),
            ("PREPARATION", self.body(&forces, 0)),
            ("STEP", self.body(&forces, 1)),
            ("FORCES", self.body(&forces, 2)),
            ("TOLERANCE", if suffix.is_empty() { "1e-11" } else { "1e-4" }.to_owned()),
            ("MAGNIFIED", if suffix.is_empty() { "1.0" } else { "10.0" }.to_owned()),
            ("OPERATIONS", format!("{errors}, {correction}, {preparation}, {step}, {last}")),
            ("WORST", (closing + 2 * friction).to_string()),
            ("USUAL", (4 * errors + 3 * correction + preparation + 3 * step + last).to_string()),
            ("BYTES", (bytes * (work + self.program.index.numbers())).to_string()),
            ("LIBRARY", uses_library.to_owned()),
            ("MODEL", harmless(&self.labels.model)),
            ("VERSION", harmless(&self.labels.version)),
        ];
        let index =
            super::index::values(self.program, self.options, &|x| self.number(x), ["{ ", " }"]);
        let all = [more, values, &index].concat();
        let singularity = substitute(SINGULARITY, &all);
        let optional = |is_included: bool, text: &str| match is_included {
            true => substitute(text, &all),
            false => String::new(),
        };
        let bodies = |k: usize| kinematics.get(k).map_or(String::new(), |own| self.body(own, 0));
        let size = |k: usize| kinematics.get(k).map_or(0, |own| own.work).to_string();
        let text = substitute(
            KINEMATICS,
            &[
                &[
                    ("POSES", bodies(0)),
                    ("TWISTS", bodies(1)),
                    ("POSE_WORK", size(0)),
                    ("TWIST_WORK", size(1)),
                ],
                &all[..],
            ]
            .concat(),
        );
        let more = &[
            ("SINGULARITY", singularity),
            ("KINEMATICS_HEAD", optional(functions.kinematics, KINEMATICS_HEAD)),
            ("REACTIONS_HEAD", optional(functions.reactions, REACTIONS_HEAD)),
            ("KINEMATICS", if functions.kinematics { text } else { String::new() }),
            ("REACTIONS", optional(functions.reactions, REACTIONS)),
            ("LINEARIZE", optional(functions.need_derivatives(), LINEARIZE)),
            ("DERIVATIVES_HEAD", optional(functions.derivatives, DERIVATIVES_HEAD)),
            ("DERIVATIVES", optional(functions.derivatives, DERIVATIVES)),
            ("ACCELERATIONS_HEAD", optional(functions.accelerations, ACCELERATIONS_HEAD)),
            ("ACCELERATIONS", optional(functions.accelerations, ACCELERATIONS)),
        ];
        substitute(template, &[more, &all[..]].concat())
    }

    fn fill_math(&self) -> String {
        let mut values = vec![("NAME", self.options.name.clone())];
        values.extend(super::own_math::values());
        substitute(OWN_MATH, &values)
    }

    /// Returns true if the code contains a sine or a cosine.
    fn turns(&self) -> bool {
        let is = |s: &Statement| matches!(s, Statement::SineCosine { .. });
        let listings = Listings::new(self.program, self.options.functions);
        listings.all().flat_map(|l| &l.routines).flatten().any(is)
    }

    fn calls(&self, function: Function) -> bool {
        let is = |s: &Statement| matches!(s, Statement::Call { function: f, .. } if *f == function);
        let listings = Listings::new(self.program, self.options.functions);
        listings.all().flat_map(|l| &l.routines).flatten().any(is)
    }

    /// Formats a number as a C literal, with the suffix `f` for single precision.
    fn number(&self, number: f64) -> String {
        let suffix = if self.options.precision == Precision::Double { "" } else { "f" };
        literal(number, self.options.precision) + suffix
    }

    /// Formats numbers as items of an array initialiser, broken into lines of at most [`WIDTH`]
    /// characters.
    fn numbers(&self, numbers: &[f64]) -> String {
        let mut text = String::from("   ");
        let mut length = 3;
        for (k, number) in numbers.iter().enumerate() {
            let number = self.number(*number) + if k + 1 < numbers.len() { "," } else { "" };
            if length + number.len() + 1 > WIDTH {
                text += "\n   ";
                length = 3;
            }
            length += number.len() + 1;
            text = text + " " + &number;
        }
        text
    }

    /// Formats array items: for each coordinate, the largest change, m or rad, in one step of the
    /// path from the home position to the first position of a control loop.
    fn strides(&self) -> String {
        let length = self.program.length();
        let stride = |unit: &str| if unit == "m" { 0.05 * length } else { 0.05 };
        let units = self.labels.coordinates.iter().map(|(_, unit)| stride(unit));
        self.numbers(&units.collect::<Vec<_>>())
    }

    fn fields(&self) -> String {
        let mut text = String::new();
        for Kind { field, unit, about, values } in kinds(self.program, self.labels) {
            let name = &self.options.name;
            let count = values.len();
            let _ = writeln!(text, "    {name}_real {field}[{count}]; /* {about} [{unit}] */");
        }
        text
    }

    fn each_tunable(&self, write: impl Fn(&str, usize, usize, f64) -> String) -> String {
        let mut text = String::new();
        let mut all = 0;
        for Kind { field, values, .. } in kinds(self.program, self.labels) {
            for (k, (_, value)) in values.iter().enumerate() {
                text += &write(field, k, all, *value);
                all += 1;
            }
        }
        text
    }

    fn defaults(&self) -> String {
        self.each_tunable(|field, k, _, value| {
            format!("    params->{field}[{k}] = {};\n", self.number(value))
        })
    }

    fn tune(&self) -> String {
        self.each_tunable(|field, k, all, _| format!("    w[{all}] = params->{field}[{k}];\n"))
    }

    /// Formats the statements of one routine of `listing`, one statement on each line.
    fn body(&self, listing: &Listing, routine: usize) -> String {
        let mut text = String::new();
        for statement in &listing.routines[routine] {
            text += "    ";
            text += &self.statement(statement);
            text.push('\n');
        }
        text
    }

    fn operand(&self, operand: Operand) -> String {
        match operand {
            Operand::Local(k) => format!("t{k}"),
            Operand::Work(k) => format!("w[{k}]"),
            Operand::Number(x) if x < 0.0 => format!("({})", self.number(x)),
            Operand::Number(x) => self.number(x),
        }
    }

    fn statement(&self, statement: &Statement) -> String {
        let suffix = if self.options.precision == Precision::Double { "" } else { "f" };
        match *statement {
            Statement::Step { to, step, operands } => {
                let [a, b, c] = operands.map(|operand| self.operand(operand));
                let value = match step {
                    Step::Add(..) => format!("{a} + {b}"),
                    Step::Sub(..) => format!("{a} - {b}"),
                    Step::Mul(..) => format!("{a} * {b}"),
                    Step::Div(..) => format!("{a} / {b}"),
                    Step::Neg(_) => format!("-{a}"),
                    Step::Sqrt(_) => format!("sqrt{suffix}({a})"),
                    Step::Select { .. } => format!("{a} > 0 ? {b} : {c}"),
                    Step::Fused(Fused::Add, _) => format!("{a} * {b} + {c}"),
                    Step::Fused(Fused::Sub, _) => format!("{a} * {b} - {c}"),
                    Step::Fused(Fused::From, _) => format!("{c} - {a} * {b}"),
                };
                format!("const real t{to} = {value};")
            }
            Statement::Call { to, function, arguments } => {
                let [a, b] = arguments.map(|operand| self.operand(operand));
                let value = match function {
                    Function::Exp => format!("exp{suffix}({a})"),
                    Function::Ln => format!("log{suffix}({a})"),
                    Function::Atan2 => format!("atan2{suffix}({a}, {b})"),
                    Function::Sin => format!("sin{suffix}({a})"),
                    Function::Cos => format!("cos{suffix}({a})"),
                };
                format!("const real t{to} = {value};")
            }
            Statement::SineCosine { sine, cosine, angle, uses } => {
                let angle = self.operand(angle);
                let name = &self.options.name;
                match self.options.own_math {
                    true => format!(
                        "real t{sine}, t{cosine}; {name}_sin_cos({angle}, &t{sine}, &t{cosine});"
                    ),
                    false => {
                        let sine = format!("const real t{sine} = sin{suffix}({angle});");
                        let cosine = format!("const real t{cosine} = cos{suffix}({angle});");
                        match uses {
                            [true, true] => format!("{sine}\n    {cosine}"),
                            [true, false] => sine,
                            _ => cosine,
                        }
                    }
                }
            }
            Statement::Keep { to, from } => format!("w[{to}] = {};", self.operand(from)),
            Statement::Result { to, from } => format!("r[{to}] = {};", self.operand(from)),
        }
    }
}

/// Replaces each name between two `@` signs in `template` by its value in `values`.
pub(crate) fn substitute(template: &str, values: &[(&str, String)]) -> String {
    let mut text = String::with_capacity(template.len());
    for (k, piece) in template.split('@').enumerate() {
        if k % 2 == 0 {
            text += piece;
        } else {
            let found = values.iter().find(|(name, _)| *name == piece);
            text += found.map_or("", |(_, value)| value);
        }
    }
    text
}
