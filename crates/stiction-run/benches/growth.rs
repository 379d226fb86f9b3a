//! Growth of time and memory with the size of a mechanism: chains of closed loops, and platforms on
//! legs.
//!
//! `cargo bench -p stiction-run --bench growth` prints the tables; with `-- --svg FOLDER` it also
//! draws them. Each loop is a spatial four-bar of R, U, S and R joints, mounted on the rocker of
//! the previous loop. Each leg consists of U, P and S joints between ground and platform. Revolute
//! and prismatic joints have friction.

use std::process::ExitCode;
use std::time::{Duration, Instant};
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::friction::{JointFriction, Law};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodySpec, GROUND_NAME, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_core::statics::SingularityDistances;
use stiction_draw::figure::{Figure, Line, Panel};

const LOOPS: [usize; 7] = [1, 3, 10, 30, 100, 300, 1000];
const LEGS: [usize; 5] = [6, 12, 20, 30, 50];
/// Number of batches of each measurement. The fastest batch counts, because other programs may use
/// the machine.
const BATCHES: usize = 9;
/// Number of times that the set-up of a mechanism is repeated.
const SET_UPS: usize = 3;
const BATCH: Duration = Duration::from_millis(20);

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let folder = match (arguments.next().as_deref(), arguments.next()) {
        (None, _) => None,
        (Some("--svg"), Some(folder)) => Some(folder),
        _ => {
            eprintln!("usage: growth [--svg FOLDER]");
            return ExitCode::from(2);
        }
    };
    let (chains, platforms) =
        (LOOPS.map(|size| (size, loops as Make)), LEGS.map(|size| (size, legs as Make)));
    // Platforms are measured first, because they could otherwise reuse the resident memory of the
    // chains.
    for (name, file, sizes) in
        [("legs", "legs", &platforms[..]), ("chained loops", "loops", &chains)]
    {
        println!(
            "\n| {name} | bodies | set-up, ms | memory, kB | frictionless, µs | per body | with friction, \
             µs | per body | distances, µs | per body |\n{}",
            "| --- ".repeat(10) + "|"
        );
        let rows: Vec<Row> = sizes.iter().map(|(size, make)| measure(*size, make(*size))).collect();
        let Some(folder) = &folder else { continue };
        let title = format!("Time and memory for each body: {name}");
        let x_label = format!("number of {name}, as a power of ten");
        let svg = Figure { title, x_label, panels: panels_of(&rows).into() }.svg();
        let file = format!("{folder}/growth-{file}.svg");
        if let Err(error) = std::fs::write(&file, svg) {
            eprintln!("{file}: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Constructor of a mechanism of a given size.
type Make = fn(usize) -> Subject;

/// Mechanism and its prescribed coordinates.
struct Subject {
    mechanism: Mechanism,
    coordinates: Vec<Coordinate>,
}

struct Row {
    size: usize,
    /// Time per body, µs.
    frictionless: f64,
    friction: f64,
    distances: f64,
    setup: f64,
    /// Memory per body, kB; `None` if it cannot be measured.
    memory: Option<f64>,
}

fn measure(size: usize, subject: Subject) -> Row {
    let Subject { mechanism, coordinates } = subject;
    let bodies = (mechanism.bodies().len() - 1) as f64;
    let at = Target { value: 0.0, rate: 0.3, acceleration: 0.2 };
    let targets = vec![at; coordinates.len()];
    let (memory, begun) = (resident(), Instant::now());
    let set_up = || {
        let mechanism = mechanism.clone();
        InverseDynamics::new(mechanism, &[], &coordinates, &targets, Settings::default()).unwrap()
    };
    let solver = set_up();
    let first = begun.elapsed();
    let memory = resident().zip(memory).map(|(after, before)| after.saturating_sub(before));
    // A smaller increase may be memory that the process already had.
    let memory = memory.filter(|bytes| *bytes > 1_000_000);
    let again = (0..SET_UPS).map(|_| {
        let begun = Instant::now();
        std::hint::black_box(set_up());
        begun.elapsed()
    });
    let setup = again.fold(first, Duration::min).as_secs_f64() * 1e3;
    let model = solver.model().unwrap();
    let parameters = solver.parameters().clone();
    let mut data = model.data(solver.state(), Settings::default());
    let [frictionless, friction] = [FrictionMode::Off, FrictionMode::Converged].map(|friction| {
        data.settings.friction = friction;
        fastest(|| model.evaluate(&parameters, &mut data, &targets, &[]))
    });
    let mut proximity = SingularityDistances::new(solver.mechanism()).unwrap();
    let distances = fastest(|| {
        let (mechanism, parameters) = (solver.mechanism(), solver.parameters());
        std::hint::black_box(proximity.measure(mechanism, parameters, solver.bodies()));
    });
    let each = memory.map(|bytes| bytes as f64 / 1e3 / bodies);
    let memory = memory.map_or("-".to_owned(), |bytes| format!("{}", bytes / 1000));
    println!(
        "| {size} | {bodies} | {setup:.1} | {memory} | {frictionless:.2} | {:.3} | {friction:.2} | {:.3} | \
         {distances:.1} | {:.3} |",
        frictionless / bodies,
        friction / bodies,
        distances / bodies
    );
    let [frictionless, friction, distances] =
        [frictionless, friction, distances].map(|time| time / bodies);
    Row { size, frictionless, friction, distances, setup: setup * 1e3 / bodies, memory: each }
}

/// Returns the microseconds per call in the fastest of several batches.
fn fastest(mut call: impl FnMut()) -> f64 {
    let once = |call: &mut dyn FnMut(), count: u32| {
        let begun = Instant::now();
        (0..count).for_each(|_| call());
        begun.elapsed() / count
    };
    let first = once(&mut call, 1).max(Duration::from_nanos(100));
    let count = (BATCH.as_nanos() / first.as_nanos()).clamp(1, 100_000) as u32;
    let best = (0..BATCHES).map(|_| once(&mut call, count)).min().unwrap_or(first);
    best.as_secs_f64() * 1e6
}

/// Returns the resident memory of the process, bytes; `None` if the system does not report it.
fn resident() -> Option<usize> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(1024 * line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()?)
}

/// Draws panels with logarithmic axes, in which linear growth is a horizontal line.
fn panels_of(rows: &[Row]) -> [Panel; 2] {
    let line = |label: &str, colour: usize, of: fn(&Row) -> Option<f64>| Line {
        label: label.to_owned(),
        points: rows
            .iter()
            .filter_map(|row| Some(((row.size as f64).log10(), of(row)?.log10())))
            .filter(|(_, y)| y.is_finite())
            .collect(),
        colour,
        dashed: false,
    };
    let times = vec![
        line("frictionless", 1, |row| Some(row.frictionless)),
        line("with friction", 0, |row| Some(row.friction)),
        line("distances", 2, |row| Some(row.distances)),
    ];
    let once =
        vec![line("set-up, µs", 3, |row| Some(row.setup)), line("memory, kB", 4, |row| row.memory)];
    [
        Panel { y_label: "log of µs/body".to_owned(), lines: times, ..Panel::default() },
        Panel { y_label: "log, per body".to_owned(), lines: once, ..Panel::default() },
    ]
}

fn v(x: f64, y: f64, z: f64) -> Vec3<f64> {
    Vec3::new(x, y, z)
}

/// Body whose frame has a given world position while all coordinates are zero.
struct Placed {
    name: String,
    at: Vec3<f64>,
}

fn bar(name: String, at: Vec3<f64>) -> (Placed, BodySpec) {
    let inertia = Mat3::from_columns(v(2e-3, 0.0, 0.0), v(0.0, 3e-3, 0.0), v(0.0, 0.0, 4e-3));
    let spec = BodySpec::new(name.clone()).mass(0.8).com(v(0.02, 0.01, 0.05)).inertia(inertia);
    (Placed { name, at }, spec)
}

/// Returns a frame at a position, with its z axis along `z` and its x axis near `x`.
fn frame(place: Vec3<f64>, z: Vec3<f64>, x: Vec3<f64>) -> Pose<f64> {
    let z = z * (1.0 / z.norm());
    let y = z.cross(x);
    let y = y * (1.0 / y.norm());
    Pose { rotation: Mat3::from_columns(y.cross(z), y, z), position: place }
}

/// Returns a joint whose two frames coincide at a world pose.
fn joint(name: String, kind: JointType, [from, to]: [&Placed; 2], at: Pose<f64>) -> JointSpec {
    let seen = |body: &Placed| Pose { position: at.position - body.at, ..at };
    let names = [from, to].map(|body| body.name.clone());
    let [predecessor, successor] = names;
    JointSpec::new(name, kind, predecessor, successor).frames(seen(from), seen(to))
}

fn rubbing(spec: JointSpec, radius: Option<f64>) -> JointSpec {
    let law = Law::coulomb_viscous(0.02, 0.01);
    spec.friction(JointFriction { radius, ..JointFriction::guide(law) })
}

fn ground() -> Placed {
    Placed { name: GROUND_NAME.to_owned(), at: Vec3::zero() }
}

fn built(builder: MechanismBuilder, driven: &[String]) -> Subject {
    let mechanism = builder.build().unwrap();
    let joint = |name: &String| mechanism.joint_id(name).unwrap();
    let coordinates = driven.iter().map(|name| Coordinate::Joint { joint: joint(name), dof: 0 });
    Subject { coordinates: coordinates.collect(), mechanism }
}

/// Creates loops mounted on each other, arranged so that all of them remain close together.
fn loops(count: usize) -> Subject {
    let mut builder = MechanismBuilder::new("loops").gravity(v(0.0, 0.0, -9.81));
    let (mut base, mut driven) = (ground(), Vec::new());
    let (x, y, z) = (v(1.0, 0.0, 0.0), v(0.1, 1.0, 0.05), v(0.1, -0.05, 1.0));
    for k in 0..count {
        let angle = 0.7 * k as f64;
        let root = v(0.3 * angle.cos(), 0.3 * angle.sin(), 0.05 * (1.3 * angle).sin());
        let (pivot, end, tip) = (v(0.3, 0.02, 0.0), v(0.02, 0.0, 0.1), v(0.33, 0.01, 0.2));
        let (crank, crank_spec) = bar(format!("crank{k}"), root);
        let (rod, rod_spec) = bar(format!("rod{k}"), root + end);
        let (rocker, rocker_spec) = bar(format!("rocker{k}"), root + pivot);
        for spec in [crank_spec, rod_spec, rocker_spec] {
            builder = builder.body(spec);
        }
        let name = |what: &str| format!("{what}{k}");
        let at = |place: Vec3<f64>, axis| frame(root + place, axis, x + z * 0.3);
        let first = joint(name("a"), JointType::Revolute, [&base, &crank], at(v(0.0, 0.0, 0.0), y));
        let second = joint(name("b"), JointType::Universal, [&crank, &rod], at(end, z));
        let third = joint(name("c"), JointType::Spherical, [&rod, &rocker], at(tip, z));
        let last = joint(name("d"), JointType::Revolute, [&base, &rocker], at(pivot, y));
        for spec in
            [rubbing(first.actuated(), Some(0.01)), second, third, rubbing(last, Some(0.01))]
        {
            builder = builder.joint(spec);
        }
        driven.push(name("a"));
        base = rocker;
    }
    built(builder, &driven)
}

/// Creates a platform on `count` legs, six of which are actuated.
fn legs(count: usize) -> Subject {
    let mut builder = MechanismBuilder::new("legs").gravity(v(0.0, 0.0, -9.81));
    let height = 0.6;
    let (platform, spec) = bar("platform".to_owned(), v(0.0, 0.0, height));
    builder = builder.body(spec);
    let mut driven = Vec::new();
    for k in 0..count {
        let angle = 2.4 * k as f64;
        // Feet and tips are irregular; on circles, they would permit a screw motion.
        let radius = 0.5 + 0.06 * (3.1 * k as f64).sin();
        let foot = v(radius * angle.cos(), radius * angle.sin(), 0.02 * angle.sin());
        let turned = angle + if k % 2 == 0 { 0.5 } else { -0.5 };
        let above = height + 0.04 * (1.7 * k as f64).sin();
        let tip = v(0.3 * turned.cos(), 0.3 * turned.sin(), above);
        let axis = tip - foot;
        let (lower, lower_spec) = bar(format!("lower{k}"), foot);
        let (upper, upper_spec) = bar(format!("upper{k}"), foot + axis * 0.5);
        builder = builder.body(lower_spec).body(upper_spec);
        let name = |what: &str| format!("{what}{k}");
        let (x, z) = (v(1.0, 0.0, 0.0), v(0.0, 0.0, 1.0));
        let at = |place: Vec3<f64>, axis: Vec3<f64>| frame(place, axis, x + z * 0.3);
        let across = axis.cross(z);
        let first = joint(name("u"), JointType::Universal, [&ground(), &lower], at(foot, across));
        let middle = at(foot + axis * 0.5, axis);
        let slide = joint(name("p"), JointType::Prismatic, [&lower, &upper], middle);
        let last = joint(name("s"), JointType::Spherical, [&upper, &platform], at(tip, z));
        let slide = if k < 6 { slide.actuated() } else { slide };
        for spec in [first, rubbing(slide, None), last] {
            builder = builder.joint(spec);
        }
        if k < 6 {
            driven.push(name("p"));
        }
    }
    built(builder, &driven)
}
