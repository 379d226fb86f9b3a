//! Self-locking, friction at rest, and the corresponding messages, against closed forms.

use crate::common::collar::push_beside;
use crate::common::*;
use stiction_core::dynamics::{FrictionMode, InverseError};
use stiction_run::inverse::Sample;
use stiction_run::{Error, Job};

/// Returns the model of a collar of 10 kg on a vertical guide with pads 0.1 m apart. A rod between
/// two balls pushes the collar 0.2 m from its axis. For the upward motion, the driver requires
/// `W/(1 - 4 mu)` with `W = 98.1 N`, and the collar locks for `mu >= 1/4`. For the downward motion,
/// the driver requires `W/(1 + 4 mu)`.
fn collar(mu: f64, rod: &str, motion: &str) -> String {
    format!(
        r#"
        gravity = [0, 0, "-9.81 m/s^2"]
        [bodies.collar]
        mass = "10 kg"
        com = [0, 0, 0]
        inertia = ["0.1 kg m^2", "0.1 kg m^2", "0.1 kg m^2"]
        [bodies.rod]
        {rod}
        [bodies.driver]
        [joints.guide]
        type = "P"
        from = "ground"
        to = "collar"
        axis = "z"
        friction = {{ mu = {mu:?}, bending_span = "0.1 m" }}
        {}
        [motions.m]
        duration = "0.1 s"
        step = "0.05 s"
        guide = "{motion}"
        [loads.none]
        [default]
        motion = "m"
        load = "none"
        "#,
        push_beside(0.2)
    )
}

const LIGHT: &str = "mass = \"1e-9 kg\"\ncom = [0, 0, 0]\ninertia = [1e-9, 1e-9, 1e-9]";
const WEIGHT: f64 = 98.1;

fn run(text: &str) -> Result<Run, Error> {
    let model = model_of("collar", text);
    Run::of(&default_job(&model, FrictionMode::Converged))
}

#[test]
fn a_collar_locks_at_the_computed_offset() {
    for rod in ["", LIGHT] {
        for mu in [0.0, 0.05, 0.125, 0.2, 0.24, 0.249, 0.2499] {
            let found = run(&collar(mu, rod, "0.1 m/s*t")).unwrap();
            for drive in found.inverse.column("drive.drive [N]") {
                let expected = WEIGHT / (1.0 - 4.0 * mu);
                // The condition number of the problem is proportional to the reciprocal of the
                // denominator.
                let tolerance = 1e-8 * expected / (1.0 - 4.0 * mu);
                assert!((drive - expected).abs() < tolerance, "{mu}: {drive} {expected}");
            }
            assert!(found.verdict.coupling.unwrap() < 1.0, "{mu}: {:?}", found.verdict.coupling);
        }
        // Just below the limit, normal loads and their rounding errors are large, but the mechanism
        // does not lock.
        for k in 0..40 {
            for below in [1e-3, 1e-4, 1e-5] {
                let mu = 0.25 * (1.0 - below * (0.5 + f64::from(k) / 40.0));
                let found = run(&collar(mu, rod, "0.1 m/s*t")).unwrap();
                let drive = found.inverse.column("drive.drive [N]")[1];
                let expected = WEIGHT / (1.0 - 4.0 * mu);
                assert!((drive / expected - 1.0).abs() < 1e-9 / below, "{mu}: {drive} {expected}");
            }
        }
        // These include coefficients that bisection reaches exactly.
        for mu in [0.25, 0.26, 1.0 / 3.0, 0.375, 0.4, 0.5, 1.0, 2.0] {
            match run(&collar(mu, rod, "0.1 m/s*t")) {
                Err(Error::Forces { error: InverseError::Locked { joint, percent }, .. }) => {
                    assert_eq!(joint, "guide");
                    assert!((percent - 25.0 / mu).abs() < 0.1, "{mu}: {percent}");
                }
                other => panic!("{mu}: {other:?}"),
            }
        }
    }
}

/// Tests other solutions of the downward motion, which has a solution for every coefficient. For
/// coefficients of at least 1/4, pulling the collar down against binding pads is a second solution,
/// and the result reports it.
#[test]
fn other_solutions_are_reported() {
    for mu in [0.1, 0.24, 0.3, 0.5, 1.0] {
        let found = run(&collar(mu, LIGHT, "-0.1 m/s*t")).unwrap();
        let drive = found.inverse.column("drive.drive [N]")[1];
        assert!((drive - WEIGHT / (1.0 + 4.0 * mu)).abs() < 1e-6, "{mu}: {drive}");
        let coupling = found.verdict.coupling.unwrap();
        assert!((coupling - 4.0 * mu).abs() < 1e-6, "{mu}: {coupling}");
        // The other solution, W / (1 - 4 mu), is found: the pads bind while the collar is pushed
        // down.
        let others = found.verdict.other_solutions;
        if mu < 0.25 {
            assert_eq!(others, None, "{mu}");
            continue;
        }
        let others = others.unwrap();
        assert_eq!((others.samples, others.drives.len()), (3, 1), "{mu}: {others:?}");
        let (other, expected) = (others.drives[0][0], WEIGHT / (1.0 - 4.0 * mu));
        assert!((other - expected).abs() < 1e-5 * expected.abs(), "{mu}: {other} {expected}");
    }
}

/// Tests the friction margin: for the upward motion, the coefficients can grow to 1/4, at which the
/// collar locks; for the downward motion, they can grow without limit.
#[test]
fn friction_margin_of_a_collar() {
    let margin = |text: &str| {
        let model = model_of("collar", text);
        let asked = Job { friction_margin: true, ..default_job(&model, FrictionMode::Converged) };
        Run::of(&asked).unwrap().verdict.friction_margin.unwrap()
    };
    for mu in [0.01, 0.05, 0.125, 0.2, 0.249] {
        let up = margin(&collar(mu, LIGHT, "0.1 m/s*t"));
        let factor = up.factor.unwrap();
        // The search increases the coefficients in relative steps down to 1e-5. Close to the limit,
        // normal loads have grown by a factor of ten thousand, and their rounding errors prevent
        // convergence of Newton's method.
        assert!((factor * mu / 0.25 - 1.0).abs() < 2e-4, "{mu}: {factor}");
        assert_eq!(up.joint.as_deref(), Some("guide"));
        let down = margin(&collar(mu, LIGHT, "-0.1 m/s*t"));
        assert_eq!((down.factor, down.joint), (None, None), "{mu}");
    }
    // Without friction there is no continuation and no margin.
    let model = model_of("collar", &collar(0.2, LIGHT, "0.1 m/s*t"));
    let asked = Job { friction_margin: true, ..default_job(&model, FrictionMode::Off) };
    assert!(Run::of(&asked).unwrap().verdict.friction_margin.is_none());
}

/// Tests the friction margin of the regular variant of the printed robot against an independent
/// program (two digits). The uniqueness certificate holds up to mu = 0.57 at the worst of the
/// eleven instants and 1.02 at the best, and the solution ends at 0.60 to 1.8.
#[test]
fn friction_margin_of_the_twin() {
    let model = model("zhang2018-regular");
    let base = job(&model, "regular", "L0", FrictionMode::Converged);
    let asked = Job { friction_margin: true, step: Some(0.1), ..base };
    let (mut unique, mut lost) = (Vec::new(), Vec::new());
    let look = |sample: &Sample| {
        unique.push(0.12 / sample.coupling.unwrap());
        lost.push(0.12 * sample.friction_margin.unwrap());
        Ok(())
    };
    let verdict = asked.run(look, |_, _, _| true).unwrap();
    assert_eq!(verdict.samples, 11);
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    assert!((least(&unique) - 0.57).abs() < 0.006, "{unique:?}");
    assert!((most(&unique) - 1.02).abs() < 0.006, "{unique:?}");
    assert!((least(&lost) - 0.60).abs() < 0.006, "{lost:?}");
    assert!(most(&lost) < 1.85, "{lost:?}");
    // The guaranteed value never exceeds the actual one.
    assert!(unique.iter().zip(&lost).all(|(unique, lost)| unique <= lost));
}

#[test]
fn at_rest_a_collar_has_an_interval_that_may_be_without_limit() {
    for rod in ["", LIGHT] {
        for mu in [0.1, 0.2, 0.24, 0.3, 1.0] {
            let found = run(&collar(mu, rod, "1 m")).unwrap();
            let at = |column: &str| found.inverse.column(column)[0];
            let (drive, low) = (at("drive.drive [N]"), at("drive.drive_low [N]"));
            let high = at("drive.drive_high [N]");
            assert!((drive - WEIGHT).abs() < 1e-6, "{mu}: {drive}");
            assert!((low - WEIGHT / (1.0 + 4.0 * mu)).abs() < 1e-6, "{mu}: {low}");
            if mu < 0.25 {
                assert!((high - WEIGHT / (1.0 - 4.0 * mu)).abs() < 1e-5, "{mu}: {high}");
            } else {
                assert_eq!(high, f64::INFINITY, "{mu}");
            }
        }
    }
}

/// Solves a few equations by Gaussian elimination.
fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    for i in 0..N {
        let pivot = (i..N).max_by(|&a, &b| matrix[a][i].abs().total_cmp(&matrix[b][i].abs()));
        matrix.swap(i, pivot.unwrap());
        right.swap(i, pivot.unwrap());
        for k in i + 1..N {
            let factor = matrix[k][i] / matrix[i][i];
            for j in i..N {
                matrix[k][j] -= factor * matrix[i][j];
            }
            right[k] -= factor * right[i];
        }
    }
    for i in (0..N).rev() {
        for j in i + 1..N {
            right[i] -= matrix[i][j] * right[j];
        }
        right[i] /= matrix[i][i];
    }
    right
}

/// Tests a wedge at rest that lifts a follower. All eight combinations of the friction of the three
/// slides at their limits, with all signs of the three normal forces, are solved by hand.
#[test]
fn a_wedge_at_rest_against_all_combinations_of_frictions() {
    let mut random = 1_u64;
    let mut uniform = |low: f64, high: f64| {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * (random >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut compared = 0;
    for _ in 0..40 {
        let (tilt, mu) = (uniform(10.0, 60.0_f64), uniform(0.05, 0.35));
        let (wedge, follower) = (uniform(0.5, 7.0), uniform(0.5, 20.0));
        let (s, c) = tilt.to_radians().sin_cos();
        // Unit vectors along the incline and perpendicular to it.
        let (along, across) = ([-c, s], [s, c]);
        let mut drives = Vec::new();
        let signs = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { 1.0 } else { -1.0 });
        for [l1, l2, l3] in (0..8).map(signs) {
            for [s1, s2, s3] in (0..8).map(signs) {
                let rub = mu * s3 * l3;
                let matrix = [
                    [1.0, -mu * s1 * l1, 0.0, -across[0] + rub * along[0]],
                    [0.0, 1.0, 0.0, -across[1] + rub * along[1]],
                    [0.0, 0.0, 1.0, across[0] - rub * along[0]],
                    [0.0, 0.0, -mu * s2 * l2, across[1] - rub * along[1]],
                ];
                let [drive, n1, n2, n3] = solve(matrix, [0.0, wedge * 9.81, 0.0, follower * 9.81]);
                if s1 * n1 >= 0.0 && s2 * n2 >= 0.0 && s3 * n3 >= 0.0 {
                    drives.push(drive);
                }
            }
        }
        let low = drives.iter().copied().fold(f64::INFINITY, f64::min);
        let high = drives.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let text = format!(
            r#"
            gravity = [0, 0, "-9.81 m/s^2"]
            [parameters]
            tilt = "{tilt} deg"
            [bodies.wedge]
            mass = {wedge:?}
            com = [0, 0, 0]
            inertia = [0.1, 0.1, 0.1]
            [bodies.follower]
            mass = {follower:?}
            com = [0, 0, 0]
            inertia = [0.1, 0.1, 0.1]
            [joints.X]
            type = "P"
            from = "ground"
            to = "wedge"
            axis = "x"
            actuated = true
            friction = {{ mu = {mu:?} }}
            [joints.Z]
            type = "P"
            from = "ground"
            to = "follower"
            axis = "z"
            friction = {{ mu = {mu:?} }}
            [joints.W]
            type = "P"
            from = "wedge"
            to = "follower"
            axis = ["-cos(tilt)", 0, "sin(tilt)"]
            friction = {{ mu = {mu:?} }}
            [motions.sit]
            duration = 0
            X = "0 m"
            [loads.none]
            [default]
            motion = "sit"
            load = "none"
            "#
        );
        let found = run(&text).unwrap();
        let at = |column: &str| found.inverse.column(column)[0];
        let (found_low, found_high) = (at("X.drive_low [N]"), at("X.drive_high [N]"));
        // If the mechanism can lock, other branches of the friction law also have solutions.
        if found.verdict.coupling.is_some() && found_low.is_finite() && found_high.is_finite() {
            let size = 1e-9 * (low.abs() + high.abs());
            assert!((found_low - low).abs() < size, "{tilt} {mu}: {found_low} {low}");
            assert!((found_high - high).abs() < size, "{tilt} {mu}: {found_high} {high}");
            compared += 1;
        }
    }
    assert!(compared >= 20, "{compared}");
}
