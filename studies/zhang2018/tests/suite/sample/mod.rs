//! An artificial report with all elements, including unusual content.
#![allow(dead_code, reason = "each test uses its part")]

use stiction_draw::figure::{Figure, Line, Panel};
use stiction_zhang2018::report::{Block, Cell, Column, Finding, Report, Section, Table};

/// Text that contains markup of all formats, control characters and right-to-left letters.
pub(crate) const HOSTILE: &str = "</p></style><script>alert(\"1\")</script> 'a' & b | c ]]> <!-- \
     \u{202e}ab\u{202c} \u{05d0}\u{05d1} \u{1f9be} \u{7}\u{0} &nbsp; `x` \\* ** [x](#nowhere y) # _u_ $m$";

fn line(label: &str, colour: usize, dashed: bool, value: impl Fn(f64) -> f64) -> Line {
    let points = (0..=200).map(|k| 0.02 * f64::from(k)).map(|t| (t, value(t))).collect();
    Line { label: label.into(), points, colour, dashed }
}

fn section(id: &str, title: &str, blocks: Vec<Block>) -> Section {
    Section { id: id.into(), title: title.into(), blocks }
}

/// A figure with two panels.
pub(crate) fn drives() -> Figure {
    let legs = |scale: f64| {
        (0..3usize).flat_map(move |k| {
            let wave = move |t: f64| scale * (1.6 * t + 2.1 * k as f64).sin();
            let rough =
                move |t: f64| wave(t) + 0.12 * scale * (1.6 * t + 2.1 * k as f64).cos().signum();
            let name = format!("leg {}", k + 1);
            [line(&name, k, false, rough), line(&format!("{name}, no friction"), k, true, wave)]
        })
    };
    Figure {
        title: "Driving forces".into(),
        x_label: "time [s]".into(),
        panels: vec![
            Panel { y_label: "force [N]".into(), lines: legs(310.0).collect(), ..Panel::default() },
            Panel { y_label: "power [W]".into(), lines: legs(12.0).collect(), ..Panel::default() },
        ],
    }
}

/// A figure with all colours, and with lines that have their own abscissae, a single point, no
/// points or NaN.
pub(crate) fn colours() -> Figure {
    let mut lines: Vec<Line> = (0..8)
        .map(|k| line(&format!("colour {k}"), k, k % 2 == 1, |t| (t + 0.4 * k as f64).sin()))
        .collect();
    let points = vec![(0.0, 1.0), (1.5, f64::NAN), (2.5, f64::INFINITY), (3.5, -0.5)];
    lines.push(Line { label: "gaps".into(), points, colour: 0, dashed: true });
    lines.push(Line { label: "point".into(), points: vec![(2.0, 1.2)], colour: 1, dashed: false });
    lines.push(Line {
        label: "nothing <&\"'\u{7}>".into(),
        points: vec![],
        colour: 2,
        dashed: false,
    });
    Figure {
        title: "All colours <b>".into(),
        x_label: "time [s]".into(),
        panels: vec![Panel { y_label: "ratio & \"more\"".into(), lines, ..Panel::default() }],
    }
}

/// A wide table with both kinds of numbers.
pub(crate) fn wide() -> Table {
    let mut table = Table::new("wide", "A **wide** table of `joints`, see [above](#drives).", []);
    table.columns.push(Column::new("joint", ""));
    for name in [
        "*F*<sub>x</sub>",
        "*F*<sub>y</sub>",
        "*F*<sub>z</sub>",
        "*M*<sub>x</sub>",
        "*M*<sub>y</sub>",
        "*M*<sub>z</sub>",
        "speed",
        "|load|",
    ] {
        table.columns.push(Column::new(name, if name.starts_with("*M*") { "N m" } else { "N" }));
    }
    table.columns.push(Column::new("what it is", ""));
    for k in 0..9 {
        let x = |n: i32| (f64::from(n) * 1.7 + f64::from(k)).tan() * 10f64.powi(n - 2);
        let mut row: Vec<Cell> = vec![format!("leg{}.R", k + 1).into()];
        row.extend((0..6).map(|n| Cell::Number(x(n), 4)));
        row.extend([Cell::Fixed(x(3), 3), Cell::Fixed(-x(4), 1)]);
        row.push("a pin that the legs *turn* about and that carries **all** of the load".into());
        table.rows.push(row);
    }
    table
}

/// A table with NaN, infinite, very large and very small numbers and empty cells.
pub(crate) fn odd() -> Table {
    let columns =
        [("name|pipe", "m/s²"), ("number, *comma*", "N"), ("fixed", ""), ("only words", "")];
    let mut table = Table::new("odd", HOSTILE, columns);
    let cases = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -0.0,
        0.1 + 0.2,
        -1.0 / 3.0,
        1e300,
        -1e-300,
        123_456_789.0,
    ];
    for (k, x) in cases.into_iter().enumerate() {
        table.rows.push(vec![
            format!("**case {k}** \"quoted\", and\nmore").into(),
            Cell::Number(x, 5),
            Cell::Fixed(x, 2),
            HOSTILE.into(),
        ]);
    }
    table.rows.push(vec![Cell::Empty, Cell::Empty, Cell::Empty, Cell::Empty]);
    table
}

/// The complete report.
pub(crate) fn report() -> Report {
    let picture = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-10 -10 120 60\">\
                   <circle cx=\"50\" cy=\"20\" r=\"18\" fill=\"var(--tint)\" stroke=\"var(--ink)\"/></svg>";
    let prose = "A *moving platform* on three legs has a mass of 12 kg, so that `m` = 12 kg and \
                 *F*<sub>i,max</sub> = 3·10<sup>2</sup> N; see [the drives](#drives), [equation 12a](#eq-12a) and \
                 [the wide table](#table-wide). Nothing here is true of any robot.";
    let text = |text: &str| Block::Paragraph(text.into());
    let finding = |finding, text: &str| Block::Finding(finding, text.into());
    let equation = |number: &str, formula: &str| Block::Equation {
        number: number.into(),
        formula: formula.into(),
    };
    let curves = |id: &str, figure, caption: &str| Block::Curves {
        id: id.into(),
        figure,
        caption: caption.into(),
    };
    Report {
        title: "A made-up study, recomputed".into(),
        lead: vec![
            "What a report looks like with *everything* that one can have. **No number here means \
             anything.**"
                .into(),
            prose.into(),
        ],
        sections: vec![
            section(
                "claims",
                "Claims and what became of them",
                vec![
                    text(prose),
                    finding(
                        Finding::Right,
                        "The legs **do** carry the load of 12 kg; see [the drives](#drives).",
                    ),
                    finding(
                        Finding::Wrong,
                        "The peak is 310 N and not 301 N, which is a slip of two digits that \
                     later equations inherit: everything after [equation 12a](#eq-12a) is too small by 3 %.",
                    ),
                    finding(
                        Finding::Open,
                        "Which of *r*<sub>1</sub> and *r*<sub>2</sub> is meant by `r` cannot be said.",
                    ),
                    finding(Finding::Note, "Angles are in radians."),
                    Block::List(vec!["first".into(), "**second** of `three`".into(), prose.into()]),
                    Block::List(vec![]),
                ],
            ),
            section(
                "equations",
                "Equations",
                vec![
                    equation("1", "*F* = *m* *a*"),
                    equation(
                        "12a",
                        "*τ*<sub>i</sub> = **J**<sup>T</sup>(*q*) *F*<sub>i</sub> + ½ *ρ* *v*<sup>2</sup> *A* − μ |*N*<sub>i</sub>| sgn(*v*<sub>i</sub>) + \
                     Σ<sub>k</sub> *m*<sub>k</sub> (*a*<sub>k</sub> − *g*) · ∂*v*<sub>k</sub>/∂*q̇*<sub>i</sub> + **ω** × **I** **ω**",
                    ),
                    equation("12a", "the same once more"),
                    equation("", "*N*<sub>i</sub> ≥ 0"),
                    equation(HOSTILE, HOSTILE),
                ],
            ),
            section(
                "drives",
                "Driving forces",
                vec![
                    curves(
                        "drives",
                        drives(),
                        "Driving forces and powers, with friction and without; *t* = 0 is rest.",
                    ),
                    text(prose),
                    curves("colours", colours(), "Every colour that a line can have."),
                    Block::Picture { svg: picture.into(), caption: "A ball, **drawn**.".into() },
                    Block::Picture { svg: picture.into(), caption: HOSTILE.into() },
                ],
            ),
            section(
                "numbers",
                "Numbers",
                vec![
                    Block::Table(wide()),
                    Block::Table(odd()),
                    Block::Table(Table::new("empty", "No rows.", [("a", "m"), ("b", "")])),
                    Block::Table(Table::new("nothing", "No columns either.", [])),
                ],
            ),
            section(
                "odd",
                HOSTILE,
                vec![
                    text(HOSTILE),
                    finding(Finding::Note, HOSTILE),
                    Block::List(vec![HOSTILE.into(), "1. no list".into(), "- none either".into()]),
                    curves(
                        "no-panels",
                        Figure { title: "none".into(), x_label: "x".into(), panels: vec![] },
                        HOSTILE,
                    ),
                    curves(
                        "no-lines",
                        Figure {
                            title: HOSTILE.into(),
                            x_label: HOSTILE.into(),
                            panels: vec![Panel {
                                y_label: HOSTILE.into(),
                                lines: vec![],
                                ..Panel::default()
                            }],
                        },
                        "No lines.",
                    ),
                    text(&"long".repeat(100)),
                ],
            ),
            section("empty", "Nothing", vec![]),
        ],
        footer: vec![
            "A source, J. of Sources 1 (2000) 1–2, https://example.org/a.".into(),
            HOSTILE.into(),
        ],
    }
}
