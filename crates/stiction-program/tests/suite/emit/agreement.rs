//! Agreement of the source code with the general solver at many random states, in double and single precision.

use super::compiler::{Code, rust_program};
use super::{ROBOTS, labels, variant};
use crate::common::{Loop, gallery_loop};
use std::collections::BTreeMap;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, InverseError};
use stiction_core::kinematics::Target;
use stiction_core::random::Random;
use stiction_core::statics::Constraints;
use stiction_program::emit::{Language, Precision};
use stiction_program::{Feedforward, Tunable};

/// Smallest singularity index of a compared state, because rounding errors grow near singular
/// positions. If half of the index at the home position is smaller, that value is the limit
/// instead.
const CLEAR: f64 = 0.05;
/// Smallest sliding speed of a compared state, relative to the largest speed, because the sign of a
/// speed near zero is uncertain.
const SLIDES: f64 = 1e-3;
/// Sliding speed, relative to the largest speed, below which the speed is a rounding error and the
/// interface never slides.
const NEVER: f64 = 1e-12;
/// Smallest determinant of a compared state with friction relative to that without, as computed by
/// the code in double precision: rounding errors grow where friction is about to lock the
/// mechanism.
const FREE: f64 = 0.05;
/// Smallest value for the largest effort of a compared state, relative to the median: efforts that
/// cancel each other provide no scale for rounding errors.
const NOTABLE: f64 = 0.05;
/// Fraction of all states in which code and solver may disagree, near the limits of what either can
/// compute.
const DIFFERING: f64 = 0.01;
/// Largest difference of an effort, relative to the largest effort of the state, in double and in single precision.
const LIMITS: [f64; 2] = [1e-11, 1e-4];
/// Unit roundoff in double and in single precision.
const ROUNDOFF: [f64; 2] = [f64::EPSILON / 2.0, f32::EPSILON as f64 / 2.0];
/// Smallest fraction of the error limit that rounding of the inputs alone may cause before a state
/// counts as ill-conditioned. The code also rounds intermediate numbers; in a backward stable
/// computation they add some units to each input, independently of the state. Beyond this fraction,
/// no computation in this precision observes the limit, and the error is compared with rounding of
/// the inputs instead.
const OF_INPUTS: f64 = 0.1;
/// Fraction of the compared states at which the code may report that friction has not converged, or
/// at which an effort may differ by more than the limit, but by less than [`MAGNIFIED`] times the
/// limit: the code's pivots are those of the recording, which magnify rounding at other states.
const BADLY_PIVOTED: [f64; 2] = [0.0, 1e-4];
/// Largest difference in such a badly pivoted state, as a multiple of the limit. In the worst known
/// state (`6sps`, single precision), the difference varies from 1 to 6 limits with the rounding of
/// the position.
const MAGNIFIED: f64 = 10.0;
/// Largest relative error of the singularity index, except in the fraction [`RARE`] of the states:
/// the error of the iteration, and rounding errors relative to an index of 0.01.
const OF_INDEX: [f64; 2] = [1e-6, 1e-3];
/// Fraction of the states at which the smallest and the third singular value may be so close that
/// no pass of the iteration separates their vectors.
const RARE: f64 = 1e-3;
/// Largest relative error of the index in these rare states. If the two values differ by a small
/// fraction `d` and the iterate contains the fraction `c` of the third vector, a pass turns the
/// iterate by `2 d c`, and the index is too large by a fraction of `d c²`, at most half of the
/// turn; the last pass turns by at most 1e-4 or 1e-3.
const OF_RARE_INDEX: [f64; 2] = [5e-5, 1e-3];
/// Default rates up to which the code counts the motion as rest, m/s or rad/s; the limit of the
/// solver differs.
const REST: [f64; 2] = [1e-9, 1e-6];
const PRECISIONS: [Precision; 2] = [Precision::Double, Precision::Float];

/// Result of the solver at a state.
enum Engine {
    /// Efforts and, if the state is not compared, the reason.
    Solved(Vec<f64>, Option<&'static str>),
    /// Reason why the solver has no efforts.
    Refused(&'static str),
}

/// Random state whose numbers are exact in single precision, and the result of the solver there.
struct State {
    numbers: Vec<f64>,
    engine: Engine,
    /// Singularity index of the actuation at the position, if the solver reaches the position.
    index: f64,
}

impl State {
    /// True if no rate exceeds the limit.
    fn rests(&self, limit: f64) -> bool {
        let third = self.numbers.len() / 3;
        self.numbers[third..2 * third].iter().all(|rate| rate.abs() <= limit)
    }
}

/// Type 2 singularity index.
fn actuation(solver: &InverseDynamics) -> f64 {
    solver.statics().actuation_distance(solver.idle_axes().len())
}

/// Smaller one of the type 1 and type 2 singularity indices.
fn index(solver: &InverseDynamics) -> f64 {
    let of_legs = Constraints::new(&solver.statics()).leg_distance(solver.idle_axes().len());
    actuation(solver).min(of_legs.unwrap_or(1.0))
}

/// Moves from the home position along a straight line, as the code does; `None` if that fails.
fn reach(home: &InverseDynamics, start: &[Target<f64>], at: &[f64]) -> Option<InverseDynamics> {
    let mut solver = home.clone();
    let on_the_line = |part: f64, line: &mut [Target<f64>]| {
        for ((now, at), start) in line.iter_mut().zip(at).zip(start) {
            now.value = start.value + (at - start.value) * part;
            (now.rate, now.acceleration) = (at - start.value, 0.0);
        }
    };
    solver.follow(0.0, 1.0, on_the_line).ok()?;
    Some(solver)
}

/// Solves at a state of the current position. `is_clear` is true if the position is far from
/// singular ones.
fn solve(solver: &mut InverseDynamics, targets: &[Target<f64>], is_clear: bool) -> Engine {
    if solver.move_to(targets).is_err() {
        return Engine::Refused(UNREACHABLE);
    }
    let rest_speed = solver.settings().rest_speed;
    let forces = match solver.solve(&[]) {
        Ok(forces) => forces,
        Err(InverseError::Locked { .. }) => return Engine::Refused("locked by friction"),
        Err(_) => return Engine::Refused("no finite forces"),
    };
    let mut speeds = forces.interfaces.iter().map(|interface| interface.velocity.abs());
    let fastest = speeds.clone().fold(0.0, f64::max);
    let is_slow =
        fastest > 0.0 && speeds.clone().any(|v| (NEVER..=SLIDES).contains(&(v / fastest)));
    let efforts = forces.efforts.clone();
    // The solver compares the speed of each interface with its limit of rest, the code only the
    // rates of the coordinates.
    let rests = speeds.any(|v| v <= rest_speed && v > NEVER * fastest);
    let why = if rests {
        Some("an interface at rest for the solver")
    } else if is_slow {
        Some("an interface almost at rest")
    } else if !is_clear {
        Some("near a singular position")
    } else {
        None
    };
    Engine::Solved(efforts, why)
}

/// Random states around the default motion, alternately near it and far from it, with [`MOTIONS`]
/// states at each position.
fn states(robot: &Loop, count: usize) -> Vec<State> {
    let mut random = Random::new(25);
    let start = &robot.signal[0];
    let mut home = robot.solver.clone();
    home.move_to(start).unwrap();
    home.settings_mut().friction = FrictionMode::Converged;
    let at_home = index(&home);
    let clear = if at_home > CLEAR { CLEAR } else { 0.5 * at_home };
    println!("singularity index {at_home:.3} at home, compared above {clear:.3}");
    let length = home.mechanism().characteristic_length().min(1.0);
    let exact = |x: f64| f64::from(x as f32);
    let mut states = Vec::with_capacity(count);
    for k in 0..count / MOTIONS {
        let width = if k % 2 == 0 { 0.05 } else { 0.25 } * length;
        let near = robot.signal[k % robot.signal.len()].iter();
        let at: Vec<f64> =
            near.map(|target| exact(target.value + width * random.number())).collect();
        let mut solver = reach(&home, start, &at);
        let is_clear = solver.as_ref().is_some_and(|solver| index(solver) > clear);
        for _ in 0..MOTIONS {
            let moving = |value: &f64| Target {
                value: *value,
                rate: exact(random.number()),
                acceleration: exact(10.0 * random.number()),
            };
            let targets: Vec<_> = at.iter().map(moving).collect();
            let of = |f: fn(&Target<f64>) -> f64| targets.iter().map(f).collect::<Vec<_>>();
            let numbers = [of(|t| t.value), of(|t| t.rate), of(|t| t.acceleration)].concat();
            let engine = match &mut solver {
                Some(solver) => solve(solver, &targets, is_clear),
                None => Engine::Refused(UNREACHABLE),
            };
            let index = solver.as_ref().map_or(f64::NAN, actuation);
            states.push(State { numbers, engine, index });
        }
    }
    let largest = |efforts: &[f64]| efforts.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let mut sizes: Vec<f64> = states
        .iter()
        .filter_map(|state| match &state.engine {
            Engine::Solved(efforts, None) => Some(largest(efforts)),
            _ => None,
        })
        .collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    for state in &mut states {
        if let Engine::Solved(efforts, why @ None) = &mut state.engine
            && largest(efforts) < NOTABLE * median
        {
            *why = Some("efforts that cancel each other");
        }
    }
    states
}

/// Results of the comparison in one precision.
#[derive(Default)]
struct Figures {
    compared: usize,
    /// Largest difference of an effort, where the code has efforts with friction.
    worst: f64,
    /// Number of compared states beyond the limit, and of ill-conditioned states whose error
    /// exceeds that of their inputs.
    failures: usize,
    /// Number of compared states at which the code reports that friction has not converged.
    not_converged: usize,
    /// Number of compared states at which an effort exceeds the limit by less than the factor
    /// [`MAGNIFIED`].
    magnified: usize,
    /// Numbers of states that are not compared, by reason: all such states, and those where code
    /// and solver disagree about whether efforts with friction exist, or differ in the efforts by
    /// more than a fraction of 1e-3.
    others: BTreeMap<&'static str, [usize; 2]>,
    /// Relative errors of the singularity index where code and solver agree on the efforts up to a
    /// fraction of 1e-3.
    indices: Vec<f64>,
}

/// Reason for a state that the solver does not reach.
const UNREACHABLE: &str = "unreachable on a straight line";
/// Random motions at each position.
const MOTIONS: usize = 10;
const ILL_CONDITIONED: &str = "ill-conditioned in this precision";
/// Return codes of the generated code.
const OK: f64 = 0.0;
const UNDETERMINED: f64 = 1.0;
const FRICTIONLESS: f64 = 2.0;

/// Excludes states at which friction is about to lock the mechanism.
fn exclude_almost_locked(states: &mut [State], answers: &[f64]) {
    let width = answers.len() / states.len();
    for (state, answer) in states.iter_mut().zip(answers.chunks_exact(width)) {
        if let (Engine::Solved(_, why @ None), [OK, ..FREE, ..]) = (&mut state.engine, answer) {
            *why = Some("friction about to lock");
        }
    }
}

/// Compares results of the code in one precision with those of the solver. `conditions` are the
/// condition numbers of the states.
fn compare(states: &[State], answers: &[f64], conditions: &[f64], precision: usize) -> Figures {
    let mut figures = Figures::default();
    let (limit, width) = (LIMITS[precision], answers.len() / states.len());
    for (state, (answer, condition)) in
        states.iter().zip(answers.chunks_exact(width).zip(conditions))
    {
        assert!(answer.iter().all(|x| x.is_finite()));
        let (code, index, efforts) = (answer[0], answer[3], &answer[4..]);
        let bound = condition * ROUNDOFF[precision] / OF_INPUTS;
        let (reason, differs) = match &state.engine {
            Engine::Solved(expected, why) => {
                let most = expected.iter().fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
                let apart = efforts.iter().zip(expected).map(|(a, b)| (a - b).abs());
                let apart =
                    if code == OK { apart.fold(0.0, f64::max) / most } else { f64::INFINITY };
                let why =
                    why.or_else(|| state.rests(REST[precision]).then_some("at rest for the code"));
                let why = why.or((bound > limit).then_some(ILL_CONDITIONED));
                let fails = match why {
                    None if code == UNDETERMINED || code == FRICTIONLESS => {
                        figures.not_converged += 1;
                        figures.compared += 1;
                        continue;
                    }
                    None if apart > limit && apart <= MAGNIFIED * limit => {
                        println!("    off by {apart:.1e}, condition {condition:.1e}");
                        figures.magnified += 1;
                        false
                    }
                    None => apart > limit,
                    Some(ILL_CONDITIONED) => code == OK && apart > bound,
                    Some(_) => false,
                };
                if fails {
                    figures.failures += 1;
                    if figures.failures <= 5 {
                        let at = &state.numbers;
                        println!(
                            "    code {code}, off by {apart:.1e}, condition {condition:.1e} at {at:?}"
                        );
                    }
                }
                if apart <= 1e-3 {
                    figures.indices.push((index - state.index).abs() / state.index);
                }
                let Some(why) = why else {
                    figures.compared += 1;
                    figures.worst = figures.worst.max(apart);
                    continue;
                };
                (why, apart > 1e-3)
            }
            Engine::Refused(why) => (*why, code == OK),
        };
        let counted = figures.others.entry(reason).or_default();
        counted[0] += 1;
        counted[1] += usize::from(differs);
    }
    figures
}

/// Compares the code of robots with the solver; returns false if no compiler is installed.
fn agree(names: &[&str], count: usize) -> bool {
    let mut good = true;
    for name in names {
        let robot = gallery_loop(name).unwrap();
        let tunables = Tunable::frictions(robot.solver.parameters());
        let program = Feedforward::record(&robot.solver, &robot.signal, &tunables).unwrap();
        let mut states = states(&robot, count);
        let rows: Vec<u8> =
            states.iter().flat_map(|s| &s.numbers).flat_map(|x| x.to_le_bytes()).collect();
        let length = robot.solver.mechanism().characteristic_length();
        let size = |(_, unit): &(String, &str)| if *unit == "m" { length } else { 1.0 };
        let sizes = labels(name, &robot).coordinates.iter().map(size).collect::<Vec<f64>>();
        let sizes = format!("{sizes:?}").replace(['[', ']'], "");
        let main = include_str!("agreement.c").replace("POSITION_SIZES", &sizes);
        let mut conditions = Vec::new();
        for (k, precision) in PRECISIONS.into_iter().enumerate() {
            let options = variant(name, precision, false);
            let files = program.files(Language::C, &labels(name, &robot), &options, &[]).unwrap();
            let folder = format!("agreement-{name}-{precision:?}");
            let Some(code) = Code::new(&folder, &options.name, &files) else { return false };
            code.write("states.bin", &rows);
            let said = code.run_with("agreement_main", &main, &["-O2"]);
            assert_eq!(said, format!("{count} rows\n"));
            let rust = program.files(Language::Rust, &labels(name, &robot), &options, &[]).unwrap();
            let main = include_str!("agreement_main.rs")
                .replace("NAME", &options.name)
                .replace("FOLDER", &folder)
                .replace("STD_MATH", include_str!("../../../src/emit/templates/std_math.rs"))
                .replace("LIMIT", &format!("{:e}", OF_INDEX[k]));
            rust_program(&format!("rust-{folder}"), &rust, &main);
            let bytes = code.read("answers.bin");
            let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
            let answers: Vec<f64> = bytes.chunks_exact(8).map(number).collect();
            if precision == Precision::Double {
                exclude_almost_locked(&mut states, &answers);
                let width = answers.len() / states.len();
                conditions.extend(answers.chunks_exact(width).map(|answer| answer[2]));
            }
            let figures = compare(&states, &answers, &conditions, k);
            let Figures {
                compared,
                worst,
                failures,
                not_converged,
                magnified,
                others,
                mut indices,
            } = figures;
            indices.sort_unstable_by(f64::total_cmp);
            let of_index = indices.last().copied().unwrap_or(0.0);
            println!(
                "{name} {precision:?}: {compared} compared, off by {worst:.1e} at most, {failures} failures, \
                 {not_converged} not converged, {magnified} with magnified rounding"
            );
            println!(
                "    singularity index: {} compared, relative error {of_index:.1e} at most, {:.1e} in the median",
                indices.len(),
                indices[indices.len() / 2]
            );
            for (why, [all, differ]) in &others {
                println!("    {all} {why}, of which code and solver differ in {differ}");
            }
            let above = indices.iter().filter(|error| **error > OF_INDEX[k]).count();
            let differing: usize = others.values().map(|[_, differ]| differ).sum();
            good &= failures == 0
                && of_index <= OF_RARE_INDEX[k]
                && above as f64 <= RARE * indices.len() as f64
                && (not_converged + magnified) as f64 <= BADLY_PIVOTED[k] * compared as f64
                && compared > count / 10
                && differing as f64 <= DIFFERING * count as f64;
        }
    }
    assert!(good, "see the numbers above");
    true
}

#[test]
fn source_code_agrees_at_random_states() {
    agree(&["five-bar", "3rrr"], 400);
}

/// Repeats the measurement stated in the book. `STICTION_STATES` and `STICTION_ROBOTS` (names
/// separated by commas) select a part.
#[test]
#[ignore = "takes an hour"]
fn source_code_agrees_at_many_random_states_for_the_gallery() {
    let count = std::env::var("STICTION_STATES").map_or(100_000, |text| text.parse().unwrap());
    let names = std::env::var("STICTION_ROBOTS").unwrap_or_default();
    let wanted: Vec<&str> = names.split_terminator(',').collect();
    let robots = if wanted.is_empty() { &ROBOTS[..] } else { &wanted };
    agree(robots, count);
}
