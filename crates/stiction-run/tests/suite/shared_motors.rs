//! Simulations of motors that share the effort of a joint and have different losses, against closed
//! forms.

use crate::drive_trains::{LIFT, SLIDE, relative_error, with};
use stiction_core::forward::{ConstantEfforts, Forward, ForwardError, Settings, Simulation};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::JointId;
use stiction_format::ModelFile;

const MASS: f64 = 40.0;
const WEIGHT: f64 = MASS * 9.81;

/// Motor on the slide; all its values are reflected to the slide.
#[derive(Clone, Copy, Debug)]
struct Drive {
    share: f64,
    /// Inertia of the rotor, reflected to the slide, kg.
    rotor: f64,
    /// Efficiencies of the gear while the motor drives, and while it is back-driven.
    eta: (f64, f64),
    /// Constant friction of the motor, N.
    dry: f64,
    /// Viscous friction of the motor, N s/m.
    viscous: f64,
}

impl Drive {
    fn new(share: f64, rotor: f64, eta: (f64, f64), dry: f64) -> Self {
        Self { share, rotor, eta, dry, viscous: 0.0 }
    }

    fn text(&self, name: &str) -> String {
        let n = std::f64::consts::TAU / 0.01;
        format!(
            "[actuators.{name}]\njoint = \"axis\"\nlead = 0.01\nshare = {}\nrotor_inertia = {}\nefficiency = {}\n\
             backward_efficiency = {}\nmotor_friction = {{ constant = {}, viscous = {} }}\n",
            self.share,
            self.rotor / (n * n),
            self.eta.0,
            self.eta.1,
            self.dry / n,
            self.viscous / (n * n),
        )
    }

    /// Returns the effort of the gear on the slide when the motor is about to move in the direction
    /// `sense`. If several efforts are possible, the one closest to that of a lossless gear is
    /// returned. `None` for a self-locking gear that its motor cannot turn.
    fn holds(&self, effort: f64, sense: f64) -> Option<f64> {
        let input = (self.share * effort - sense * self.dry) * sense;
        let factor = if input >= 0.0 { self.eta.0 } else { 1.0 / self.eta.1 };
        (input >= 0.0 || self.eta.1 > 0.0).then_some(sense * input * factor)
    }
}

fn hoist(drives: &[Drive], guide: f64) -> ModelFile {
    let friction = format!("axis = \"z\"\nfriction = {{ mu = 0.1, preload = {} }}", 10.0 * guide);
    let slide = if guide > 0.0 { SLIDE.replace("axis = \"z\"", &friction) } else { SLIDE.into() };
    let trains: String =
        drives.iter().enumerate().map(|(k, drive)| drive.text(&format!("m{k}"))).collect();
    with(&[&slide, LIFT, &trains])
}

/// Returns the accelerations that satisfy all laws while the slide moves at `rate`. Each gear is
/// assumed to drive and to be back-driven in turn.
fn accelerations(drives: &[Drive], guide: f64, effort: f64, rate: f64) -> Vec<f64> {
    let sense = rate.signum();
    let mut found: Vec<f64> = Vec::new();
    for pattern in 0..1 << drives.len() {
        let factor = |k: usize| {
            let (forward, backward) = drives[k].eta;
            if pattern >> k & 1 == 1 { forward } else { 1.0 / backward }
        };
        let input = |k: usize| {
            let Drive { share, dry, viscous, .. } = drives[k];
            share * effort - sense * dry - viscous * rate
        };
        let each = 0..drives.len();
        let force: f64 = each.clone().map(|k| factor(k) * input(k)).sum();
        let mass: f64 = each.clone().map(|k| factor(k) * drives[k].rotor).sum();
        let a = (force - WEIGHT - sense * guide) / (MASS + mass);
        let is_right = |k: usize| {
            let transmitted = factor(k) * (input(k) - drives[k].rotor * a);
            (transmitted * sense > 0.0) == (pattern >> k & 1 == 1)
        };
        if each.clone().all(is_right) {
            found.push(a);
        }
    }
    found
}

fn started<'a>(
    forward: &'a Forward,
    effort: f64,
    rate: f64,
) -> Result<Simulation<'a>, ForwardError> {
    let mut efforts = ConstantEfforts(vec![effort]);
    let joint = Coordinate::Joint { joint: JointId(0), dof: 0 };
    let start = Target { value: 0.0, rate, acceleration: 0.0 };
    let state = forward.assemble(&[], &[joint], &[start]).unwrap();
    forward.start(0.0, state, Settings::default(), &mut efforts)
}

fn acceleration(simulation: &Simulation<'_>) -> f64 {
    simulation.joint_motion(JointId(0), 0).acceleration
}

/// Returns pairs of motors and one triple: unequal losses; equal losses with unequal rotors and
/// friction, so that one gear may drive while the other is back-driven; a motor with zero share; a
/// lossless gear with a lossy one.
fn sets() -> Vec<Vec<Drive>> {
    vec![
        vec![Drive::new(0.5, 90.0, (0.9, 0.85), 10.0), Drive::new(0.5, 30.0, (0.6, 0.3), 25.0)],
        vec![Drive::new(0.5, 200.0, (0.7, 0.6), 0.0), Drive::new(0.5, 10.0, (0.7, 0.6), 60.0)],
        vec![Drive::new(1.0, 20.0, (0.8, 0.7), 5.0), Drive::new(0.0, 60.0, (0.5, 0.4), 15.0)],
        vec![Drive::new(0.3, 0.0, (1.0, 1.0), 0.0), Drive::new(0.7, 40.0, (0.5, 0.2), 12.0)],
        vec![
            Drive { viscous: 40.0, ..Drive::new(0.2, 50.0, (0.95, 0.9), 4.0) },
            Drive { viscous: 9.0, ..Drive::new(0.3, 80.0, (0.6, 0.5), 30.0) },
            Drive::new(0.5, 15.0, (0.75, 0.9), 8.0),
        ],
    ]
}

const EFFORTS: [f64; 9] = [-9000.0, -900.0, -300.0, 0.0, 150.0, 392.4, 500.0, 900.0, 3000.0];

/// Tests the accelerations in both directions, with each gear driving or back-driven.
#[test]
fn accelerations_with_unequal_losses() {
    let (mut mixed, mut alike) = (0, 0);
    for drives in sets() {
        for guide in [0.0, 30.0] {
            let model = hoist(&drives, guide);
            let forward = Forward::new(model.mechanism.clone(), &[]);
            for effort in EFFORTS {
                for rate in [0.1, -0.1] {
                    let expected = accelerations(&drives, guide, effort, rate);
                    assert_eq!(expected.len(), 1, "{drives:?} {effort} {rate}");
                    let simulation = started(&forward, effort, rate).unwrap();
                    let a = acceleration(&simulation);
                    // Tolerance for the rounding errors of forces, divided by the least inertia.
                    let size = (effort.abs() + WEIGHT) / MASS;
                    assert!(
                        (a - expected[0]).abs() < 1e-12 * size,
                        "{drives:?} {guide} {effort} {rate}: {a} {expected:?}"
                    );
                    let transmits = |drive: &Drive| {
                        let Drive { share, rotor, dry, viscous, .. } = *drive;
                        let input = share * effort - viscous * rate - rotor * a;
                        (input - dry * rate.signum()) * rate > 0.0
                    };
                    let driving = drives.iter().filter(|drive| transmits(drive)).count();
                    match driving % drives.len() {
                        0 => alike += 1,
                        _ => mixed += 1,
                    }
                    // The reaction of the slide equals the sum of the gear efforts minus the
                    // friction of the guide.
                    let (force, _) = simulation.instant().reactions()[0];
                    assert!((force.z - MASS * (a + 9.81)).abs() < 1e-11 * (effort.abs() + WEIGHT));
                }
            }
        }
    }
    assert!(mixed > 20 && alike > 20, "{mixed} {alike}");
}

/// Tests that the slide remains at rest for efforts between the onsets of motion, and for no
/// others. At an onset, the friction of every motor is at its limit.
#[test]
fn rest_with_unequal_losses() {
    for drives in sets() {
        for guide in [0.0, 20.0] {
            let model = hoist(&drives, guide);
            let forward = Forward::new(model.mechanism.clone(), &[]);
            for sense in [1.0, -1.0] {
                let exerted = |effort: f64| -> f64 {
                    drives.iter().map(|drive| drive.holds(effort, sense).unwrap()).sum()
                };
                let load = WEIGHT + sense * guide;
                // The sum of the gears' efforts grows with the effort.
                let (mut low, mut high) = (-1e5, 1e5);
                for _ in 0..200 {
                    let middle = 0.5 * (low + high);
                    if exerted(middle) < load { low = middle } else { high = middle }
                }
                let mechanism = &model.mechanism;
                let [shared] = &mechanism.shared_motors()[..] else { panic!("{drives:?}") };
                let range = shared.holding(mechanism.drive_trains(), (load, load)).unwrap();
                let end = if sense > 0.0 { range.1 } else { range.0 };
                assert!((end - high).abs() < 1e-10 * (high.abs() + WEIGHT), "{range:?} {high}");
                for (part, begins) in [(-1e-4, false), (1e-4, true)] {
                    // Static frictions that share an effort may exceed their limits by 1e-5, see `stick`.
                    let effort = high + part * sense * (high.abs() + WEIGHT);
                    let simulation = started(&forward, effort, 0.0).unwrap();
                    let a = acceleration(&simulation);
                    assert_eq!(a * sense > 0.0, begins, "{drives:?} {guide} {effort} {sense}: {a}");
                    assert_eq!(a == 0.0, !begins, "{drives:?} {guide} {effort} {sense}: {a}");
                }
            }
        }
    }
}

/// Tests the energy balance of a motion up, to rest and down again.
#[test]
fn runs_with_unequal_losses() {
    for drives in sets() {
        let model = hoist(&drives, 20.0);
        let forward = Forward::new(model.mechanism.clone(), &[]);
        let mut efforts = ConstantEfforts(vec![2500.0]);
        let mut simulation = started(&forward, 2500.0, 0.0).unwrap();
        simulation.advance(0.4, &mut efforts).unwrap();
        assert!(simulation.joint_motion(JointId(0), 0).rate > 0.0);
        assert!(relative_error(&simulation) < 1e-11, "{}", relative_error(&simulation));
        let from = simulation.instant().state.clone();
        let mut none = ConstantEfforts(vec![0.0]);
        let mut simulation = forward.start(0.4, from, Settings::default(), &mut none).unwrap();
        simulation.advance(3.0, &mut none).unwrap();
        let motion = simulation.joint_motion(JointId(0), 0);
        let falls = accelerations(&drives, 20.0, 0.0, -1e-9);
        let holds = {
            let held: f64 = drives.iter().map(|drive| drive.holds(0.0, -1.0).unwrap()).sum();
            held > WEIGHT - 20.0
        };
        assert_eq!(motion.rate == 0.0, holds, "{drives:?} {motion:?} {falls:?}");
        assert!(relative_error(&simulation) < 1e-9, "{}", relative_error(&simulation));
    }
}

/// Tests that, with power off, a self-locking worm gear holds the slide at rest, regardless of the
/// other gear, and stops its motion. `breakaway` reports this, and requires brakes if no gear is
/// self-locking.
#[test]
fn one_worm_holds_for_both() {
    use crate::common::job;
    use stiction_core::dynamics::FrictionMode;
    let drives =
        [Drive::new(0.5, 90.0, (0.4, -0.2), 10.0), Drive::new(0.5, 90.0, (0.95, 0.95), 0.0)];
    let still = "[motions.still]\nduration = 1\naxis = 0\n";
    let power_off = |drives: &[Drive]| {
        let trains: String =
            drives.iter().enumerate().map(|(k, drive)| drive.text(&format!("m{k}"))).collect();
        let model = with(&[SLIDE, still, &trains]);
        let job = job(&model, "still", "none", FrictionMode::Converged);
        let found = stiction_run::breakaway::evaluate(&job, None).unwrap();
        let json = found.json(&job);
        ["m0", "m1"].map(|name| json["actuators"][name]["power_off"].clone())
    };
    let model = hoist(&drives, 0.0);
    let forward = Forward::new(model.mechanism.clone(), &[]);
    let simulation = started(&forward, 0.0, 0.0).unwrap();
    assert_eq!(acceleration(&simulation), 0.0);
    let mut none = ConstantEfforts(vec![0.0]);
    let mut simulation = started(&forward, 0.0, 0.3).unwrap();
    simulation.advance(2.0, &mut none).unwrap();
    assert_eq!(simulation.joint_motion(JointId(0), 0).rate, 0.0);
    assert!(relative_error(&simulation) < 1e-10);
    for held in power_off(&drives) {
        assert_eq!(held["held"], true, "{held}");
    }

    // Without the worm gear, the motors need brakes that share the least holding effort.
    let drives =
        [Drive::new(0.25, 90.0, (0.8, 0.7), 10.0), Drive::new(0.75, 90.0, (0.95, 0.95), 0.0)];
    // 0.25 U + 10 N = 0.7 a, 0.75 U = 0.95 b, a + b = the weight.
    let least = (WEIGHT - 10.0 / 0.7) / (0.25 / 0.7 + 0.75 / 0.95);
    let n = std::f64::consts::TAU / 0.01;
    for (held, drive) in power_off(&drives).iter().zip(&drives) {
        let brake = held["brake_torque"].as_f64().unwrap();
        assert!((brake - drive.share * least / n).abs() < 1e-12, "{held} {least}");
    }
}
