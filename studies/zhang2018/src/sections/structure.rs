//! Section 1 of the paper: mobility of the robot.

use super::{count_range, digits, equation, fixed, paragraph, right, section, table, wrong};
use crate::report::{Block, Section};
use crate::robot::{Pose, Robot};
use crate::screws::{
    actuation_wrenches, constraint_wrenches, gap_of_roll, leg_twists, power, rank, reciprocal,
    roll_within, self_stress,
};
use crate::{Error, even};
use nalgebra::DMatrix;
use stiction_draw::drawing::Surface;
use stiction_run::Job;
use stiction_run::Portrait;
use stiction_run::check::Findings;

/// Poses of the rank tests, spread evenly over a box around the workspace.
pub(crate) fn poses(count: usize) -> impl Iterator<Item = Pose<f64>> {
    (0..count).map(|k| {
        let [a, b, c] = even(k);
        [-0.15 + 0.3 * a, 0.35 + 0.3 * b, (35.0 + 110.0 * c).to_radians()]
    })
}

/// Ranks of the screw systems and checks of equations (1) to (3).
pub(crate) struct Ranks {
    /// Minimum and maximum rank of a leg's five twists over legs and poses.
    pub(crate) leg: (usize, usize),
    /// Minimum and maximum rank of the three constraint wrenches.
    pub(crate) constraints: (usize, usize),
    /// Minimum and maximum rank of constraint and actuation wrenches together.
    pub(crate) all: (usize, usize),
    /// Largest power of the wrench (3) on the twists (1).
    pub(crate) reciprocity: f64,
    /// Largest deviation of the self-stress from (-2, 1, 1).
    pub(crate) stress: f64,
}

/// Computes the ranks over many poses.
pub(crate) fn ranks(robot: &Robot, count: usize) -> Ranks {
    let widen = |known: &mut (usize, usize), rank: usize| {
        *known = (known.0.min(rank), known.1.max(rank));
    };
    let none = (usize::MAX, 0);
    let mut found =
        Ranks { leg: none, constraints: none, all: none, reciprocity: 0.0, stress: 0.0 };
    for pose in poses(count) {
        for n in 0..3 {
            let twists = leg_twists(robot, n, pose);
            let wrench = reciprocal(robot, n, pose);
            widen(&mut found.leg, rank(&DMatrix::from_fn(6, 5, |i, j| twists[j][i])));
            let most = super::greatest(twists.iter().map(|twist| power(&wrench, twist)));
            found.reciprocity = found.reciprocity.max(most);
        }
        let constraints = constraint_wrenches(robot, pose);
        let drives = actuation_wrenches(robot, pose);
        widen(&mut found.constraints, rank(&constraints));
        let both =
            DMatrix::from_fn(
                6,
                6,
                |i, j| if j < 3 { constraints[(i, j)] } else { drives[(i, j - 3)] },
            );
        widen(&mut found.all, rank(&both));
        let stress = self_stress(robot, pose).unwrap_or([0.0; 3]);
        let misfit = super::greatest([stress[0] + 2.0, stress[1] - 1.0, stress[2] - 1.0]);
        found.stress = found.stress.max(misfit);
    }
    found
}

fn picture(job: &Job<'_>, caption: &str) -> Result<Block, Error> {
    let svg = Portrait::of(job)?.svg(Surface::Inline);
    Ok(Block::Picture { svg, caption: caption.into() })
}

const COUNT: usize = 2000;

pub(crate) fn write(
    findings: [&Findings; 2],
    [of_printed, of_regular]: [&Job<'_>; 2],
) -> Result<Section, Error> {
    let (printed, regular) = (Robot::printed(), Robot::regular());
    let (ranks, of_twin) = (ranks(&printed, COUNT), ranks(&regular, COUNT));
    let [mobility, of_this] = findings.map(|found| &found.mobility);
    let play = |clearance: f64| -> f64 {
        let by_engine = findings[0].play().first().map(|play| play.with(clearance).to_degrees());
        by_engine.unwrap_or(f64::NAN)
    };
    let blocks = vec![
        picture(of_printed, "The robot as printed, along (29).")?,
        paragraph(
            "Each leg is R, P, S from the ground to the platform; all three R axes are parallel to \
             y. With r = R<sub>3</sub>S<sub>3</sub> and its direction u, the five twists of leg 3 \
             about R<sub>3</sub> (similarly those of legs 1 and 2 about R<sub>1</sub> and \
             R<sub>2</sub>) are, in the order (angular; linear):",
        ),
        equation(
            "1",
            "$<sub>1</sub> = (e<sub>y</sub>; 0),  $<sub>2</sub> = (0; u),  $<sub>3</sub> = (e<sub>x</sub>; r × e<sub>x</sub>),  $<sub>4</sub> = (e<sub>y</sub>; r × e<sub>y</sub>),  $<sub>5</sub> = (e<sub>z</sub>; r × e<sub>z</sub>)",
        ),
        equation(
            "2",
            "$<sub>R3P3</sub> = { $<sub>1</sub>  $<sub>2</sub>  $<sub>3</sub>  $<sub>4</sub>  $<sub>5</sub> }",
        ),
        equation(
            "3",
            "$<sup>r</sup><sub>R3P3</sub> = (e<sub>y</sub>; r × e<sub>y</sub>) = {0 1 0; −b<sub>3</sub> 0 −b<sub>5</sub>}",
        ),
        right(format!(
            "(1) to (3) are right: the rank is {} for every leg in {COUNT} poses, and the force \
             along y through the ball joint does no work on any of the five twists (largest power \
             {}). Two misprints: (a<sub>2</sub>, c<sub>2</sub>) in (1) is the sliding direction u \
             and not r × s; the r of (2), which denotes reciprocal, belongs to (3) only.",
            count_range(ranks.leg),
            super::rounding(ranks.reciprocity),
        )),
        wrong(format!(
            "“The three reciprocal screws are linearly independent”: they are not. The three \
             forces are parallel to the R axes, and the plane of the three ball joints is also \
             parallel to these axes. Therefore the three forces lie in one plane: their rank is {} \
             in each of {COUNT} poses, never 3. The forces (−2, 1, 1) f in the three legs balance \
             each other for any f (largest deviation {}).",
            count_range(ranks.constraints),
            super::rounding(ranks.stress),
        )),
        table(
            "structure-mobility",
            "Values of the paper and computed values. The ranks are computed at 2000 uniformly \
             distributed poses; the values of the engine are those of `stiction check`.",
            [("", ""), ("paper", ""), ("robot as printed", ""), ("regular twin", "")],
            [
                [
                    "independent constraints".into(),
                    "3".into(),
                    count_range(ranks.constraints).into(),
                    count_range(of_twin.constraints).into(),
                ],
                [
                    "rank of constraints and drives".into(),
                    "6".into(),
                    count_range(ranks.all).into(),
                    count_range(of_twin.all).into(),
                ],
                [
                    "instantaneous degrees of freedom".into(),
                    "3".into(),
                    mobility.instantaneous.to_string().into(),
                    of_this.instantaneous.to_string().into(),
                ],
                [
                    "finite degrees of freedom".into(),
                    "3".into(),
                    mobility.finite.to_string().into(),
                    of_this.finite.to_string().into(),
                ],
                [
                    "Grübler's count".into(),
                    "–".into(),
                    mobility.gruebler.to_string().into(),
                    of_this.gruebler.to_string().into(),
                ],
                [
                    "redundant constraints".into(),
                    "0".into(),
                    mobility.redundant_constraints.to_string().into(),
                    of_this.redundant_constraints.to_string().into(),
                ],
            ],
        ),
        paragraph(
            "The constraints prevent the translation along y and the rotation about the platform's \
             normal. The roll about the line S<sub>2</sub>S<sub>3</sub> is possible to first \
             order: the closure along y contains √3 k cos(roll), whose maximum is at the working \
             position, so that its gradient vanishes. The roll is blocked at second order only, by \
             a gap of (√3/2) k roll<sup>2</sup>. A small clearance in the joints therefore permits \
             a large roll of the platform:",
        ),
        table(
            "structure-play",
            "Roll of the printed platform (k = 150 mm) within the clearance of its joints: by the \
             closed form, and by the general engine from second derivatives of the loop equations.",
            [
                ("clearance", "µm"),
                ("roll, closed form", "deg"),
                ("roll, engine", "deg"),
                ("gap at that roll", "µm"),
            ],
            [1e-6, 1e-5, 1e-4].map(|clearance| {
                let roll = roll_within(&printed, clearance);
                [
                    fixed(clearance * 1e6, 0),
                    fixed(roll.to_degrees(), 3),
                    fixed(play(clearance), 3),
                    digits(gap_of_roll(&printed, roll) * 1e6, 4),
                ]
            }),
        ),
        paragraph(
            "The twin differs in its geometry: the triangle of its platform is tilted by 30° about \
             S<sub>2</sub>S<sub>3</sub>, and the base is correspondingly narrower. The plane of \
             the ball joints is then not parallel to the forces, and the rank is 3.",
        ),
        picture(of_regular, "The regular twin along its motion.")?,
    ];
    Ok(section("structure", "Structure: equations (1) to (3)", blocks))
}
