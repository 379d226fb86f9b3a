//! Generation of source code in Rust that does not need the standard library, from templates and
//! from the statements of a program.

use super::c::{substitute, table};
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

const RUNTIME: &str = include_str!("templates/runtime.rs");
const SINGULARITY: &str = include_str!("templates/singularity.rs");
const KINEMATICS: &str = include_str!("templates/kinematics.rs");
const REACTIONS: &str = include_str!("templates/reactions.rs");
const LINEARIZE: &str = include_str!("templates/linearize.rs");
const DERIVATIVES: &str = include_str!("templates/derivatives.rs");
const ACCELERATIONS: &str = include_str!("templates/accelerations.rs");
const STD_MATH: &str = include_str!("templates/std_math.rs");
const SELFTEST: &str = include_str!("templates/selftest.rs");
const MAKEFILE: &str = include_str!("templates/rust.Makefile");
const README: &str = include_str!("templates/rust.README.md");

pub(crate) fn files(
    program: &Feedforward,
    labels: &Labels,
    options: &SourceOptions,
    vectors: &[TestVector],
) -> Vec<SourceFile> {
    let rust = Rust { program, labels, options };
    let file = |name: &str, text: String| SourceFile { name: name.to_owned(), text };
    vec![
        file(&format!("{}.rs", options.name), rust.fill(RUNTIME)),
        file("selftest.rs", rust.fill(SELFTEST)),
        file("vectors.csv", table(labels, vectors)),
        file("Makefile", rust.fill(MAKEFILE)),
        file("README.md", rust.fill(README)),
    ]
}

struct Rust<'a> {
    program: &'a Feedforward,
    labels: &'a Labels,
    options: &'a SourceOptions,
}

impl Rust<'_> {
    /// Fills a template: replaces each name between two `@` signs by its value for this program.
    fn fill(&self, template: &str) -> String {
        let sizes = self.program.sizes();
        let functions = self.options.functions;
        let Listings { position, forces, kinematics, derivatives } =
            Listings::new(self.program, functions);
        let is_double = self.options.precision == Precision::Double;
        let pick = |double: f64, float: f64| self.number(if is_double { double } else { float });
        let head = lines(self.program, self.labels, self.options);
        let rubbing = self.program.derivatives.as_ref().map_or(&[][..], |own| &own.joints);
        let of_derivatives =
            |k: usize| derivatives.as_ref().map_or(String::new(), |own| self.body(own, k));
        let values: &[(&str, String)] = &[
            ("NAME", self.options.name.clone()),
            ("STD_MATH", STD_MATH.to_owned()),
            ("REAL", if is_double { "f64" } else { "f32" }.to_owned()),
            (
                "LINES",
                head.iter().map(|l| format!("// {l}").trim_end().to_owned() + "\n").collect(),
            ),
            ("COORDINATES", sizes.prescribed.to_string()),
            ("DRIVES", sizes.drives.to_string()),
            ("JOINTS", sizes.joints.to_string()),
            ("BODIES", sizes.bodies.to_string()),
            ("WRENCH", if functions.need_wrenches() { "6" } else { "3" }.to_owned()),
            ("ANSWERS", super::answers(sizes, functions).to_string()),
            ("TREE", sizes.coordinates.to_string()),
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
            ("FIELDS", self.fields()),
            ("DEFAULTS", self.defaults()),
            ("TUNE", self.tune()),
            ("HOME", self.numbers(self.program.home_coordinates())),
            ("HOME_VALUES", self.numbers(self.program.home())),
            ("STRIDES", self.strides()),
            ("ERRORS", self.body(&position, 0)),
            ("CORRECTION", self.body(&position, 1)),
            ("PREPARATION", self.body(&forces, 0)),
            ("STEP", self.body(&forces, 1)),
            ("FORCES", self.body(&forces, 2)),
            ("FINGERPRINT", format!("0x{:016x}", self.program.fingerprint())),
            ("TOLERANCE", if is_double { "1e-11" } else { "1e-4" }.to_owned()),
            ("MAGNIFIED", if is_double { "1.0" } else { "10.0" }.to_owned()),
            ("MODEL", harmless(&self.labels.model)),
            ("VERSION", harmless(&self.labels.version)),
        ];
        let bodies = |k: usize| kinematics.get(k).map_or(String::new(), |own| self.body(own, 0));
        let size = |k: usize| kinematics.get(k).map_or(0, |own| own.work).to_string();
        let more: &[(&str, String)] = &[
            ("POSES", bodies(0)),
            ("TWISTS", bodies(1)),
            ("POSE_WORK", size(0)),
            ("TWIST_WORK", size(1)),
        ];
        let index =
            super::index::values(self.program, self.options, &|x| self.number(x), ["[", "]"]);
        let all = [more, values, &index].concat();
        let optional = |is_included: bool, text: &str| match is_included {
            true => substitute(text, &all),
            false => String::new(),
        };
        let functions: &[(&str, String)] = &[
            ("SINGULARITY", substitute(SINGULARITY, &all)),
            ("KINEMATICS", optional(functions.kinematics, KINEMATICS)),
            ("REACTIONS", optional(functions.reactions, REACTIONS)),
            ("LINEARIZE", optional(functions.need_derivatives(), LINEARIZE)),
            ("DERIVATIVES", optional(functions.derivatives, DERIVATIVES)),
            ("ACCELERATIONS", optional(functions.accelerations, ACCELERATIONS)),
        ];
        substitute(template, &[functions, &all].concat())
    }

    fn number(&self, number: f64) -> String {
        literal(number, self.options.precision)
    }

    fn numbers(&self, numbers: &[f64]) -> String {
        numbers.iter().map(|number| format!("    {},\n", self.number(*number))).collect()
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
            let (first, rest) = about.split_at(1);
            let about = first.to_uppercase() + rest;
            let _ = writeln!(text, "    /// {about}, {unit}.");
            let _ = writeln!(text, "    pub {field}: [Real; {}],", values.len());
        }
        text
    }

    fn defaults(&self) -> String {
        let mut text = String::new();
        for Kind { field, values, .. } in kinds(self.program, self.labels) {
            let numbers: Vec<String> = values.iter().map(|(_, x)| self.number(*x)).collect();
            let _ = writeln!(text, "            {field}: [{}],", numbers.join(", "));
        }
        text
    }

    fn tune(&self) -> String {
        let mut text = String::new();
        let mut all = 0;
        for Kind { field, values, .. } in kinds(self.program, self.labels) {
            for k in 0..values.len() {
                let _ = writeln!(text, "    w[TREE + {all}] = params.{field}[{k}];");
                all += 1;
            }
        }
        text
    }

    fn body(&self, listing: &Listing, routine: usize) -> String {
        let statements = listing.routines[routine].iter();
        statements.map(|statement| format!("    {}\n", self.statement(statement))).collect()
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
        match *statement {
            Statement::Step { to, step, operands } => {
                let [a, b, c] = operands.map(|operand| self.operand(operand));
                let value = match step {
                    Step::Add(..) => format!("{a} + {b}"),
                    Step::Sub(..) => format!("{a} - {b}"),
                    Step::Mul(..) => format!("{a} * {b}"),
                    Step::Div(..) => format!("{a} / {b}"),
                    Step::Neg(_) => format!("-{a}"),
                    Step::Sqrt(_) => format!("M::sqrt({a})"),
                    Step::Select { .. } => format!("if {a} > 0.0 {{ {b} }} else {{ {c} }}"),
                    Step::Fused(Fused::Add, _) => format!("{a} * {b} + {c}"),
                    Step::Fused(Fused::Sub, _) => format!("{a} * {b} - {c}"),
                    Step::Fused(Fused::From, _) => format!("{c} - {a} * {b}"),
                };
                format!("let t{to}: Real = {value};")
            }
            Statement::Call { to, function, arguments } => {
                let [a, b] = arguments.map(|operand| self.operand(operand));
                let value = match function {
                    Function::Exp => format!("M::exp({a})"),
                    Function::Ln => format!("M::ln({a})"),
                    Function::Atan2 => format!("M::atan2({a}, {b})"),
                    Function::Sin => format!("M::sin_cos({a}).0"),
                    Function::Cos => format!("M::sin_cos({a}).1"),
                };
                format!("let t{to}: Real = {value};")
            }
            Statement::SineCosine { sine, cosine, angle, uses } => {
                let name = |used: bool, k: usize| if used { format!("t{k}") } else { "_".into() };
                let (sine, cosine) = (name(uses[0], sine), name(uses[1], cosine));
                format!("let ({sine}, {cosine}) = M::sin_cos({});", self.operand(angle))
            }
            Statement::Keep { to, from } => format!("w[{to}] = {};", self.operand(from)),
            Statement::Result { to, from } => format!("r[{to}] = {};", self.operand(from)),
        }
    }
}
