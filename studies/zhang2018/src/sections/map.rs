//! Table of the paper's equations with the function and the test of each.

use super::{paragraph, section, table};
use crate::report::{Cell, Section};
use crate::{friction, kinematics, lagrangian, reactions, robot, screws, sections, simulation};

/// One equation of the paper.
pub(crate) struct Row {
    pub(crate) equation: &'static str,
    pub(crate) what: &'static str,
    pub(crate) verdict: &'static str,
    /// Path of the function in this crate.
    pub(crate) function: String,
    /// Test file of the study and name of the test.
    pub(crate) test: (&'static str, &'static str),
}

/// Path of a function, checked by the compiler.
macro_rules! path {
    ($($path:tt)+) => {{
        let _ = $($path)+;
        let path = stringify!($($path)+).replace(' ', "");
        path.split("::<").next().unwrap_or_default().to_owned()
    }};
}

/// All rows, in the order of the paper.
pub(crate) fn rows() -> Vec<Row> {
    let row = |equation, what, verdict, function, file, test| Row {
        equation,
        what,
        verdict,
        function,
        test: (file, test),
    };
    vec![
        row(
            "(1), (2)",
            "twists of a leg",
            "right",
            path!(screws::leg_twists),
            "structure",
            "screws_of_a_leg",
        ),
        row(
            "(3)",
            "reciprocal wrench",
            "right",
            path!(screws::reciprocal),
            "structure",
            "screws_of_a_leg",
        ),
        row(
            "after (3)",
            "three independent constraints",
            "wrong: rank 2",
            path!(screws::constraint_wrenches),
            "structure",
            "constraints_have_rank_two",
        ),
        row(
            "(4)–(6)",
            "vectors R<sub>n</sub>S<sub>n</sub>",
            "right",
            path!(robot::leg_vector::<f64>),
            "kinematics",
            "leg_vectors_as_printed",
        ),
        row(
            "(7)",
            "inputs q<sub>n</sub>",
            "right",
            path!(kinematics::inputs::<f64>),
            "kinematics",
            "inputs_are_those_of_the_joints",
        ),
        row(
            "J<sup>−1</sup>",
            "velocity Jacobian",
            "right; singular at θ = 90°",
            path!(kinematics::inverse_jacobian),
            "kinematics",
            "determinant_in_closed_form",
        ),
        row(
            "(8)",
            "energy of the platform",
            "wrong: J′<sub>d</sub>",
            path!(lagrangian::platform_energy::<f64>),
            "ideal",
            "errors_of_the_printed_inertias",
        ),
        row(
            "(9)–(12)",
            "centres of the rods",
            "right",
            path!(kinematics::rod_centre::<f64>),
            "kinematics",
            "centres_lie_on_the_legs",
        ),
        row(
            "(13)–(15)",
            "angles φ<sub>n</sub>",
            "right above the base",
            path!(kinematics::leg_angle::<f64>),
            "kinematics",
            "angles_of_the_legs",
        ),
        row(
            "(16)",
            "energy of the rods",
            "wrong: J′<sub>n1</sub>",
            path!(lagrangian::rod_energy::<f64>),
            "ideal",
            "errors_of_the_printed_inertias",
        ),
        row(
            "(17)",
            "energy of the bases",
            "wrong for legs 2 and 3",
            path!(lagrangian::base_energy::<f64>),
            "ideal",
            "errors_of_the_printed_inertias",
        ),
        row(
            "(18)–(20)",
            "potentials",
            "right",
            path!(lagrangian::potential::<f64>),
            "ideal",
            "weights_do_the_work_of_the_potential",
        ),
        row(
            "L, F",
            "Lagrange's equations",
            "right in form",
            path!(lagrangian::generalised_force),
            "ideal",
            "lagrange_is_the_engine",
        ),
        row(
            "(21)",
            "ideal driving forces",
            "right where J exists, with the load",
            path!(lagrangian::driving_forces),
            "ideal",
            "lagrange_is_the_engine",
        ),
        row(
            "(22)–(25)",
            "balance of legs and rods",
            "incomplete",
            path!(reactions::System::new),
            "reactions",
            "printed_equation_of_moments",
        ),
        row(
            "(26)",
            "forces on the platform",
            "right",
            path!(reactions::System::new),
            "reactions",
            "reference_of_all_unknowns",
        ),
        row(
            "(27)",
            "moments on the platform",
            "wrong sign of M<sub>lk</sub>",
            path!(reactions::System::new),
            "reactions",
            "printed_system_is_wrong_by_much",
        ),
        row(
            "“42 independent”",
            "rank",
            "wrong: 41",
            path!(sections::reactions::ranks),
            "reactions",
            "rank_forty_one",
        ),
        row(
            "5.1",
            "friction of P, R and S",
            "wrong: r missing",
            path!(friction::joint_friction),
            "friction",
            "a_zero_radius_gives_no_friction_torque",
        ),
        row(
            "ΣE<sub>f</sub>, L′, (28)",
            "friction as an energy",
            "wrong",
            path!(friction::energy_of_friction),
            "friction",
            "methods_and_their_work",
        ),
        row(
            "for (28)",
            "friction by virtual work",
            "correct method",
            path!(friction::virtual_work),
            "friction",
            "friction_is_that_of_the_engine",
        ),
        row(
            "(29)",
            "motion",
            "singular throughout",
            path!(robot::Robot::printed_motion),
            "simulation",
            "moment_is_missing",
        ),
        row(
            "with (29)",
            "least squares",
            "no valid result",
            path!(simulation::least_squares),
            "simulation",
            "least_squares_depends_on_units",
        ),
    ]
}

pub(crate) fn write() -> Section {
    let rows = rows().into_iter().map(|row| {
        [
            Cell::from(row.equation),
            Cell::from(row.what),
            Cell::from(row.verdict),
            Cell::from(format!("`{}`", row.function)),
            Cell::from(format!("`{}::{}`", row.test.0, row.test.1)),
        ]
    });
    let blocks = vec![
        paragraph(
            "Functions are in the module `stiction_zhang2018`, tests in its module `tests`. If a \
             function or a test of a row no longer exists, the program does not compile, or a test \
             fails.",
        ),
        table(
            "map",
            "Equations of the paper, with the code and the tests that belong to them.",
            [("equation", ""), ("what", ""), ("verdict", ""), ("function", ""), ("test", "")],
            rows,
        ),
    ];
    section("map", "Equations and code", blocks)
}
