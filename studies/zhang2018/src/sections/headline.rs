//! Figures of the paper and their assessment.

use super::{note, open, paragraph, section, wrong};
use crate::friction::joint_friction;
use crate::kinematics::joint_rates;
use crate::reactions::{Form, System};
use crate::report::{Block, Section};
use crate::robot::{NO_LOAD, Robot};
use crate::simulation::least_squares;

/// Leg 1 of the printed robot on (29) without load, self-stress or friction coupling: the largest
/// normal force and the largest friction force of its prismatic joint, N. Both follow from the
/// motion of the leg alone.
pub(crate) fn leg_one() -> (f64, f64) {
    let robot = Robot::printed();
    let mut most = (0.0_f64, 0.0_f64);
    for k in 0..400 {
        let motion = Robot::printed_motion(f64::from(k) / 400.0);
        let system = System::new(&robot, &motion, NO_LOAD, Form::Corrected);
        let leg = crate::kinematics::leg_motion(&robot, 0, &motion);
        let (sin, cos) = leg.turn[0].sin_cos();
        let across = system.right[6] * cos - system.right[8] * sin - system.across(0);
        let mut loads = [[0.0; 3]; 3];
        loads[0][0] = across.abs();
        let friction = joint_friction(&robot, &joint_rates(&robot, &motion), &loads, true);
        most = (most.0.max(across.abs()), most.1.max(friction[0][0].abs()));
    }
    most
}

pub(crate) fn write() -> Section {
    let (load, friction) = leg_one();
    let robot = Robot::printed();
    // The equations are solvable at this instant.
    let start = System::new(&robot, &Robot::printed_motion(0.0), NO_LOAD, Form::Corrected);
    let bears = least_squares(&start, 1.0, false).0[0];
    let blocks = vec![
        paragraph(
            "The paper reports relative errors of 18.1, 12.6 and 16.5 % for legs 1, 2 and 3 \
             between driving forces with and without friction, without the formula for these \
             errors, and an agreement within 3.4 % with a commercial multibody program in both \
             cases.",
        ),
        wrong(
            "The printed model has no driving forces to which these figures could belong: \
             frictionless driving forces do not exist along (29) under the printed load, and \
             without load they exist at three instants only ([simulation](#simulation)). A program \
             that agrees with (21) to 3.4 % along this motion has not computed the printed robot.",
        ),
        open(
            "The text of the paper does not show whether another geometry, load or interpretation \
             was used. Figures near 18.1, 12.6 and 16.5 % are no evidence: the table on (28) shows \
             a wrong method that gives percentages of the right size, but curves with errors of \
             more than 100 %. (An independent search through 1.69 million interpretations and 21 \
             metrics came no nearer than 0.37 percentage points, and it came nearer to random \
             numbers.)",
        ),
        paragraph("Some interpretations can be excluded:"),
        Block::List(vec![
            "The reflection x → −x with t → 1 − t maps (29) onto itself, exchanges legs 2 and 3, \
             and reverses friction. If friction follows from the frictionless reactions, as in the \
             paper, and the figures are magnitudes of the difference relative to the frictionless \
             force, then legs 2 and 3 have equal figures under any load that is even in x \
             (F<sub>y</sub>, F<sub>z</sub>, M<sub>x</sub>). Because 12.6 and 16.5 % differ, the \
             load would need F<sub>x</sub> or M<sub>y</sub>, which cannot be balanced along (29), \
             or M<sub>z</sub>, which can ([loads that cannot be balanced](#table-reactions-range))."
                .into(),
            format!(
                "Leg 1 is nearly vertical: without load, self-stress and feedback of friction, the \
                 normal load of its prismatic joint is at most {load:.2} N, and its friction is \
                 {friction:.2} N, whereas the leg carries {bears:.1} N at t = 0. Any further \
                 friction of this joint results from the self-stress, which nothing determines.",
            ),
            "Coulomb and viscous friction do not decrease with increasing speed at constant load. \
             The decrease during the first 0.1 s, which the paper explains by a film of lubricant, \
             is the Stribeck effect, which is not part of the friction law of the paper."
                .into(),
        ]),
        paragraph(
            "For the regular twin, these figures [exist](#table-twin-metrics), but they depend on \
             the metric as much as on the friction: for one leg and one load, they range from a \
             tenth of the frictionless force to many times this force.",
        ),
        note(
            "These figures describe the twin only. The fact that some of them are near those of \
             the paper proves nothing about the paper.",
        ),
    ];
    section("headline", "The headline figures", blocks)
}
