//! The paper's figures, and what can be said of them.

use super::twin::{Runs, metric_table};
use super::{note, open, paragraph, section, wrong};
use crate::report::{Block, Section};
use crate::zhang2018::friction::joint_friction;
use crate::zhang2018::reactions::{Form, System, unknown};
use crate::zhang2018::robot::{NO_LOAD, Robot};

/// Leg 1 of the printed robot on (29) without load: the largest load of its prismatic joint, N, and the
/// largest friction of that joint, N. Both follow from the leg's own motion.
pub(in crate::zhang2018) fn leg_one() -> (f64, f64) {
    let robot = Robot::printed();
    let mut most = (0.0_f64, 0.0_f64);
    for k in 0..400 {
        let motion = Robot::printed_motion(f64::from(k) / 400.0);
        let system = System::new(&robot, &motion, NO_LOAD, Form::Corrected);
        let (row, column) = (4, unknown::FS);
        let at_ball = system.right[row] / system.matrix[(row, column)];
        let leg = crate::zhang2018::kinematics::leg_motion(&robot, 0, &motion);
        let (sin, cos) = leg.turn[0].sin_cos();
        let across = system.right[6] * cos - system.right[8] * sin - at_ball;
        let mut loads = [[0.0; 3]; 3];
        loads[0][0] = across.abs();
        let friction = joint_friction(&robot, &system.rates(&motion), &loads, true);
        most = (most.0.max(across.abs()), most.1.max(friction[0][0].abs()));
    }
    most
}

pub(in crate::zhang2018) fn write(runs: &Runs<'_>) -> Section {
    let (load, friction) = leg_one();
    let blocks = vec![
        paragraph(
            "The paper reports relative errors of 18.1, 12.6 and 16.5 % for legs 1, 2 and 3 between driving forces with \
             and without friction, does not say by which formula, and an agreement of 3.4 % with a commercial multibody \
             program in both cases.",
        ),
        wrong(
            "For the printed model there are no driving forces that these figures could be of: along (29) none exists \
             under the printed load, nor without load but at three instants (section on the simulation). A program that \
             agrees with (21) to 3.4 % there has not computed the printed robot.",
        ),
        open(
            "Whether some other geometry, load or reading was used cannot be told from the text. A figure near 18.1, 12.6 and \
             16.5 % is no evidence: the table on (28) shows a wrong method that gives percentages of the right size with \
             curves that are wrong by more than 100 %, and among many readings some come near any three numbers.",
        ),
        paragraph("Some readings can be excluded by argument:"),
        Block::List(vec![
            "The mirror x → −x with t → 1 − t takes (29) to itself and changes legs 2 and 3 for each other. A load that is \
             even in x gives them equal figures; 12.6 and 16.5 % differ, so F~x~, M~y~ or M~z~ would have to act, and just those \
             cannot be balanced on (29)."
                .into(),
            format!(
                "Without load leg 1 stands nearly upright: its prismatic joint is pressed by {load:.2} N at most and rubs with \
                 {friction:.2} N, of a driving force of some 40 N. That is not 18.1 %.",
            ),
            "Friction of Coulomb and viscous kind does not fall as speed grows at constant load. The decrease during the \
             first 0.1 s that the paper explains by a film of lubricant is Stribeck's effect, which its law does not have."
                .into(),
        ]),
        metric_table(
            "headline-metrics",
            "The same question asked of the regular twin, where it has an answer. Which metric is meant matters as much \
             as the friction.",
            &[("none", runs.none), ("L1", runs.moderate), ("the paper's", runs.printed)],
        ),
        note(
            "The twin's figures are those of the twin. That some of them lie near the paper's says nothing about the \
             paper.",
        ),
    ];
    section("headline", "The headline figures", blocks)
}
