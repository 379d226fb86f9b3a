//! The low-pass filter of noisy recordings, from the file to the efforts.

use std::path::{Path, PathBuf};
use stiction::{ModelText, Robot};
use stiction_core::random::Random;

/// Displacement of each platform coordinate, m or deg, and its initial value.
const MOVES: [(&str, f64, f64); 6] = [
    ("x [m]", 0.08, 0.0),
    ("y [m]", -0.05, 0.0),
    ("z [m]", 0.06, 0.9),
    ("rx [deg]", 4.0, 0.0),
    ("ry [deg]", -3.0, 0.0),
    ("rz [deg]", 6.0, 0.0),
];
/// Standard deviations of the noise: 20 um and 0.002 deg.
const NOISE: (f64, f64) = (20e-6, 2e-3);

/// A normally distributed number of unit variance: twelve uniform ones.
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.number() * 0.5).sum()
}

/// Writes a recording of the platform at 1 kHz; `law` increases from 0 to 1 within `duration`, s.
fn recording(name: &str, duration: f64, seed: Option<u64>, law: impl Fn(f64) -> f64) -> PathBuf {
    let mut random = Random::new(seed.unwrap_or(0));
    let mut text = "time [s]".to_owned();
    MOVES.iter().for_each(|(name, ..)| text += &format!(",platform.{name}"));
    for k in 0..=(1000.0 * duration) as usize {
        let t = k as f64 / 1000.0;
        text += &format!("\n{t:.3}");
        for (name, rise, start) in MOVES {
            let size = if name.ends_with("[m]") { NOISE.0 } else { NOISE.1 };
            let noise = seed.map_or(0.0, |_| size * normal(&mut random));
            text += &format!(",{:.12}", start + rise * law(t) + noise);
        }
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("filter-{name}.csv"));
    std::fs::write(&path, text).unwrap();
    path
}

/// Quintic polynomial from 0 to 1 in 2 s that is at rest at both ends.
fn quintic(t: f64) -> f64 {
    let u = (t / 2.0).clamp(0.0, 1.0);
    u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u)
}

/// Peak and root mean square of each effort, N, along a recording.
fn efforts(robot: &Robot, recording: &Path) -> Vec<(f64, f64)> {
    let mut found = vec![(0.0_f64, 0.0); robot.actuators().count()];
    let mut count = 0.0;
    let request = robot.inverse().motion(recording.to_str().unwrap()).unwrap();
    request
        .each(|sample| {
            count += 1.0;
            for ((peak, squares), effort) in found.iter_mut().zip(sample.efforts()) {
                *peak = peak.max(effort.abs());
                *squares += effort * effort;
            }
            Ok(())
        })
        .unwrap();
    found.into_iter().map(|(peak, squares)| (peak, (squares / count).sqrt())).collect()
}

/// The cut-off that the cautions about a recording suggest, Hz, as text.
fn suggested(robot: &Robot, recording: &Path) -> String {
    let request = robot.inverse().motion(recording.to_str().unwrap()).unwrap();
    let cautions: Vec<String> = request.job().unwrap().motion.cautions().collect();
    let caution = cautions.first().expect("a noisy recording has a caution");
    let (_, rest) = caution.split_once("--filter \"").expect("the caution names a filter");
    rest.split_once(" Hz\"").unwrap().0.to_owned()
}

fn filtered(cutoff: f64) -> Robot {
    ModelText::builtin("gough").unwrap().with_filter(cutoff).read().unwrap()
}

/// With the suggested filter, peak and rms of all efforts of a hexapod agree with those of the
/// motion without noise to 2 %, including the ends. Without a filter, they are wrong by a factor of
/// hundreds.
#[test]
fn the_suggested_filter_gives_the_efforts_of_the_motion_without_noise() {
    let plain = Robot::builtin("gough").unwrap();
    let truth = efforts(&plain, &recording("truth", 2.0, None, quintic));
    let mut worst = 0.0_f64;
    for seed in 1..=20 {
        let noisy = recording("noisy", 2.0, Some(seed), quintic);
        let cutoff = suggested(&plain, &noisy).parse().unwrap();
        for ((peak, rms), (true_peak, true_rms)) in
            efforts(&filtered(cutoff), &noisy).iter().zip(&truth)
        {
            let errors = [peak / true_peak - 1.0, rms / true_rms - 1.0];
            for error in errors {
                assert!(error.abs() < 0.02, "seed {seed}, {cutoff} Hz: {error}");
                worst = worst.max(error.abs());
            }
        }
    }
    println!("largest error {:.2} %", 100.0 * worst);
}

/// Acceleration of the trapezoidal law of 2 s at a time, per unit of rise.
fn trapezoid_acceleration(t: f64) -> f64 {
    match t {
        _ if t < 0.5 => 1.0 / 0.75,
        _ if t < 1.5 => 0.0,
        _ => -1.0 / 0.75,
    }
}

/// Steps of the acceleration are smeared, and the report states by how much. If the cut-off is too
/// low, a caution states the error at a step; with the suggested cut-off this error is below the
/// noise, and the rise time is stated.
#[test]
fn smearing_is_reported() {
    let trapezoid = |t: f64| {
        let t = t.clamp(0.0, 2.0);
        let edge = |t: f64| 0.5 * t * t / 0.75;
        match t {
            _ if t < 0.5 => edge(t),
            _ if t < 1.5 => edge(0.5) + 0.5 * (t - 0.5) / 0.75,
            _ => 1.0 - edge(2.0 - t),
        }
    };
    let file = recording("trapezoid", 2.0, Some(1), trapezoid);
    let (_, rise, _) = MOVES[0];
    let step = rise / 0.75;

    let robot = filtered(3.0);
    let request = robot.inverse().motion(file.to_str().unwrap()).unwrap();
    let motion = request.job().unwrap().motion;
    let about = "the low-pass filter of 3 Hz smears `platform.x`";
    let caution = motion.cautions().find(|caution| caution.starts_with(about)).unwrap();
    let (_, rest) = caution.split_once("and by about ").unwrap();
    let stated: f64 = rest.split_once(' ').unwrap().0.parse().unwrap();
    // At the steps themselves the true acceleration has two values.
    let times = (0..2000).map(|k| (f64::from(k) + 0.5) / 1000.0);
    let errors = times.map(|t| {
        let found = motion.at(t).next().unwrap().acceleration;
        (found - rise * trapezoid_acceleration(t)).abs()
    });
    let most = errors.fold(0.0, f64::max);
    // Half of the step, and the noise that remains after the filter.
    assert!((stated / most - 1.0).abs() < 0.2, "{caution}: {most}");

    let best: f64 = suggested(&Robot::builtin("gough").unwrap(), &file).parse().unwrap();
    let robot = filtered(best);
    let request = robot.inverse().motion(file.to_str().unwrap()).unwrap();
    let motion = request.job().unwrap().motion;
    let notes = motion.interpolation.clone().unwrap();
    let (_, rest) = notes.split_once("steps of the acceleration are spread over ").unwrap();
    let stated: f64 = rest.split_once(" s").unwrap().0.parse().unwrap();
    // Noise shifts the times at which the step at 0.5 s crosses 90 % and 10 %.
    let after = |level: f64| {
        let times = (0..2000).map(|k| 0.4 + f64::from(k) * 1e-4);
        times.into_iter().find(|t| motion.at(*t).next().unwrap().acceleration < level * step)
    };
    let spread = after(0.1).unwrap() - after(0.9).unwrap();
    assert!((spread / stated - 1.0).abs() < 0.35, "{best} Hz: {spread} {stated}");
}
