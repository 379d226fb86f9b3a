//! Simulations by a recorded program compared with simulations by the general solver.

use crate::common::Robot;
use crate::counting::allocations;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{
    AccelerationProgram, Forward, Inputs, ProgramInputs, Settings, Simulation, View,
};
use stiction_core::kinematics::{ProgramMemory, State, Target};
use stiction_program::ForwardProgram;

/// Program that counts its runs, and can refuse or falsify its results.
#[derive(Debug)]
struct Watched {
    program: ForwardProgram,
    conduct: Conduct,
    runs: AtomicUsize,
    valid: AtomicUsize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Conduct {
    Works,
    /// Never valid.
    Refuses,
    /// The first acceleration is wrong.
    WrongAcceleration,
    /// The efforts are doubled.
    WrongEfforts,
    /// The first friction is wrong.
    WrongFriction,
    /// The rate of the potential energy is wrong.
    WrongPower,
}

impl AccelerationProgram for Watched {
    fn memory(&self) -> ProgramMemory {
        AccelerationProgram::memory(&self.program)
    }

    fn run(&self, memory: &mut ProgramMemory, inputs: &ProgramInputs<'_>) -> bool {
        self.runs.fetch_add(1, Ordering::Relaxed);
        let twice: Vec<f64>;
        let mut inputs = *inputs;
        if self.conduct == Conduct::WrongEfforts {
            twice = inputs.efforts.iter().map(|effort| 2.0 * effort).collect();
            inputs.efforts = &twice;
        }
        let is_valid = AccelerationProgram::run(&self.program, memory, &inputs)
            && self.conduct != Conduct::Refuses;
        self.valid.fetch_add(usize::from(is_valid), Ordering::Relaxed);
        let first = self.results().start;
        let [targets, dofs, joints, interfaces] = self.program.sizes();
        match self.conduct {
            Conduct::WrongAcceleration => memory.slots[first] += 1e-3,
            Conduct::WrongFriction => memory.slots[first + dofs + interfaces] += 1e-3,
            // As many actuators as prescribed coordinates; then the powers, the rate last.
            Conduct::WrongPower => {
                let rate = first + dofs + 5 * interfaces + targets + 2;
                assert_eq!(rate + 1 + 6 * joints, self.results().end);
                memory.slots[rate] += 1e-3;
            }
            _ => {}
        }
        is_valid
    }

    fn results(&self) -> Range<usize> {
        AccelerationProgram::results(&self.program)
    }
}

/// Efforts that change every millisecond, like those of a digital controller.
struct Sampled {
    steady: Vec<f64>,
    now: Vec<f64>,
    loads: Vec<AppliedLoad<f64>>,
    samples: usize,
}

impl Inputs for Sampled {
    fn efforts(&mut self, _: &View<'_>, efforts: &mut [f64]) {
        efforts.copy_from_slice(&self.now);
    }

    fn loads(&mut self, _: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        loads.extend_from_slice(&self.loads);
    }

    fn are_constant(&self) -> bool {
        true
    }

    fn next_change(&self, _: f64) -> Option<f64> {
        Some(1e-3 * self.samples as f64)
    }

    fn change(&mut self, view: &View<'_>) {
        self.samples += 1;
        for (now, steady) in self.now.iter_mut().zip(&self.steady) {
            *now = steady * (1.0 + 0.1 * (30.0 * view.time).sin());
        }
    }
}

struct Case {
    robot: Robot,
    state: State<f64>,
    efforts: Vec<f64>,
}

impl Case {
    fn new(name: &str, load: Option<&str>) -> Self {
        let mut robot = Robot::new(name, load);
        let moving: Vec<Target<f64>> =
            robot.signal[3].iter().map(|target| Target { rate: 0.1, ..*target }).collect();
        robot.solver.move_to(&moving).unwrap();
        let efforts = robot.solver.solve(&robot.loads).unwrap().efforts.clone();
        let state = robot.solver.state().clone();
        robot.solver.move_to(&robot.signal[0]).unwrap();
        Self { robot, state, efforts }
    }

    fn watched(&self, conduct: Conduct) -> Arc<Watched> {
        let Robot { solver, signal, loads } = &self.robot;
        let program = ForwardProgram::record(solver, signal, loads).unwrap();
        Arc::new(Watched { program, conduct, runs: 0.into(), valid: 0.into() })
    }

    fn forward(&self, program: Option<&Arc<Watched>>) -> Forward {
        let mut forward = Forward::new(self.robot.solver.mechanism().clone(), &[]);
        if let Some(program) = program {
            let program: Arc<dyn AccelerationProgram> = Arc::clone(program) as _;
            assert!(forward.use_program(program, &self.robot.loads, 0.0));
        }
        forward
    }

    fn start<'f>(&self, forward: &'f Forward) -> (Simulation<'f>, Sampled) {
        let mut inputs = Sampled {
            steady: self.efforts.clone(),
            now: self.efforts.clone(),
            loads: self.robot.loads.clone(),
            samples: 0,
        };
        let settings = Settings::default();
        (forward.start(0.0, self.state.clone(), settings, &mut inputs).unwrap(), inputs)
    }
}

const ROBOTS: [(&str, Option<&str>); 3] = [("3rps", None), ("gough", None), ("4ups-upu", None)];

/// Both simulations find the same motion within the tolerance of their steps, and close their
/// energy balance. The program computes most of it.
#[test]
fn simulations_by_program_find_the_same_motion() {
    for (name, load) in ROBOTS {
        let case = Case::new(name, load);
        let program = case.watched(Conduct::Works);
        let models = [case.forward(None), case.forward(Some(&program))];
        let [(mut general, mut first), (mut recorded, mut second)] =
            models.each_ref().map(|model| case.start(model));
        for k in 1..=20 {
            let time = 0.01 * f64::from(k);
            general.advance(time, &mut first).unwrap();
            recorded.advance(time, &mut second).unwrap();
            let (a, b) = (general.instant(), recorded.instant());
            let pairs = a.state.coordinates.iter().zip(&b.state.coordinates);
            let apart = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            // Each of two hundred steps has a relative tolerance of 1e-8.
            assert!(apart < 1e-7, "{name} at {time} s: {apart:e}");
            let loads = a.interfaces.iter().zip(&b.interfaces);
            let scale = a.interfaces.iter().fold(1.0_f64, |most, c| most.max(c.load));
            let apart = loads.fold(0.0_f64, |most, (a, b)| most.max((a.load - b.load).abs()));
            assert!(apart < 1e-5 * scale, "{name} at {time} s: {apart:e} N");
            assert_eq!(a.mobility, b.mobility, "{name}");
            assert_eq!(a.redundant, b.redundant, "{name}");
        }
        let kinds = |simulation: &Simulation<'_>| -> Vec<String> {
            let events = simulation.events().iter();
            events.map(|event| format!("{:?}", std::mem::discriminant(&event.kind))).collect()
        };
        assert_eq!(kinds(&general), kinds(&recorded), "{name}");
        let size = recorded.energies().turnover;
        assert!(recorded.energy_error().abs() < 1e-8 * size, "{name}");
        let (runs, valid) = (&program.runs, &program.valid);
        let (runs, valid) = (runs.load(Ordering::Relaxed), valid.load(Ordering::Relaxed));
        assert!(valid > 600 && 10 * valid > 8 * runs, "{name}: {valid} of {runs} runs");
    }
}

/// At states where the program is not valid, the general solver computes; its results are then
/// identical to those of a simulation without a program.
/// A program whose results do not satisfy all equations is not used further.
#[test]
fn invalid_results_are_refused() {
    let case = Case::new("3rps", None);
    let general = case.forward(None);
    let (mut simulation, mut inputs) = case.start(&general);
    simulation.advance(0.02, &mut inputs).unwrap();
    let expected = simulation.instant().state.clone();
    let program = case.watched(Conduct::Refuses);
    let refusing = case.forward(Some(&program));
    let (mut simulation, mut inputs) = case.start(&refusing);
    simulation.advance(0.02, &mut inputs).unwrap();
    assert_eq!(simulation.instant().state.coordinates, expected.coordinates);
    assert!(program.runs.load(Ordering::Relaxed) > 60);

    // At the first end of a step the verification fails, and the general solver repeats the step.
    for conduct in [
        Conduct::WrongAcceleration,
        Conduct::WrongEfforts,
        Conduct::WrongFriction,
        Conduct::WrongPower,
    ] {
        let program = case.watched(conduct);
        let wrong = case.forward(Some(&program));
        let (mut simulation, mut inputs) = case.start(&wrong);
        simulation.advance(0.02, &mut inputs).unwrap();
        let found = simulation.instant().state.coordinates.iter();
        let apart = found.zip(&expected.coordinates).map(|(a, b)| (a - b).abs());
        let apart = apart.fold(0.0_f64, f64::max);
        assert!(apart < 1e-12, "{conduct:?}: {apart:e}");
        let runs = program.runs.load(Ordering::Relaxed);
        // Stages that contradict the start of the step shorten it, until its end is verified.
        assert!((1..400).contains(&runs), "{conduct:?}: {runs} runs");
    }
}

/// Between events, a simulation by a program allocates nothing.
#[test]
fn simulations_by_program_allocate_nothing() {
    let case = Case::new("3rps", None);
    let program = case.watched(Conduct::Works);
    let forward = case.forward(Some(&program));
    let (mut simulation, mut inputs) = case.start(&forward);
    simulation.advance(0.05, &mut inputs).unwrap();
    let before = simulation.events().len();
    let found = allocations(|| simulation.advance(0.06, &mut inputs).unwrap());
    assert_eq!(simulation.events().len(), before, "no event");
    assert_eq!(found, 0);
}
