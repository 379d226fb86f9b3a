//! Textbook mechanisms whose efforts at rest have closed forms.

use crate::breakaway::{at_rest, near};
use stiction_core::dynamics::{Bounds, Verdict};

const G: f64 = 9.81;

#[test]
fn an_inclined_plane() {
    for (angle, mu, mu_back) in [
        (10.0_f64, 0.1, 0.1),
        (10.0, 0.3, 0.3),
        (35.0, 0.6, 0.8),
        (35.0, 0.8, 0.6),
        (60.0, 0.2, 0.2),
    ] {
        let found = at_rest(&format!(
            r#"
            gravity = [0, 0, "-9.81 m/s^2"]
            [bodies.block]
            mass = "3 kg"
            com = [0, 0, 0]
            inertia = [1, 1, 1]
            [joints.plane]
            type = "P"
            from = "ground"
            to = "block"
            axis = ["cos({angle:?} deg)", 0, "sin({angle:?} deg)"]
            actuated = true
            friction = {{ mu = 0.05, mu_static = {mu:?}, backward = {{ mu_static = {mu_back:?} }} }}
            [motions.sit]
            duration = 0
            plane = "0 m"
            [loads.none]
            [default]
            motion = "sit"
            load = "none"
            "#
        ));
        let (s, c) = angle.to_radians().sin_cos();
        let (along, normal) = (3.0 * G * s, 3.0 * G * c);
        let (low, high) = found.forces.effort_bounds[0];
        // Up the plane, forward friction resists; down the plane, backward friction holds.
        near(high, along + mu * normal);
        near(low, along - mu_back * normal);
        assert_eq!(found.forces.bounds, Bounds::Exact);
        let breakaway = found.rest.breakaway[0].unwrap();
        near(breakaway.forward.1, high);
        near(breakaway.backward.1, low);
        // Friction that holds the block opposes sliding down: it is negative.
        let holding = &found.rest.unpowered;
        let locks = mu_back >= s / c;
        assert_eq!(holding.verdict, if locks { Verdict::Holds } else { Verdict::Slips });
        near(holding.needed.1, s / c / mu_back);
        assert_eq!(holding.needed.0, holding.needed.1);
        if locks {
            near(holding.frictions[0][0], -along);
        }
        assert_eq!(found.rest.alone[0], *holding);
    }
}

/// The screw jack of the textbooks, `W r tan(l + r')` to raise a load and `W r tan(r' - l)` to
/// lower it; it is self-locking if `r' >= l`.
#[test]
fn a_screw_jack() {
    for (lead, mu) in [(5.0_f64, 0.05), (5.0, 0.12), (40.0, 0.12), (12.0, 0.2)] {
        let found = at_rest(&format!(
            r#"
            gravity = [0, 0, "-9.81 m/s^2"]
            [bodies.nut]
            mass = "50 kg"
            com = [0, 0, 0]
            inertia = [1, 1, 1]
            [joints.screw]
            type = "H"
            from = "ground"
            to = "nut"
            axis = "z"
            pitch = "{lead:?} mm/rev"
            actuated = true
            friction = {{ mu = {mu:?}, radius = "9 mm", flank_angle = "15 deg" }}
            [motions.sit]
            duration = 0
            screw = "0 deg"
            [loads.none]
            [default]
            motion = "sit"
            load = "none"
            "#
        ));
        let (weight, radius) = (50.0 * G, 0.009);
        let slope = 1e-3 * lead / std::f64::consts::TAU / radius;
        let climb = slope.atan();
        // The flank angle is given in a section along the axis.
        let flank = (15.0_f64.to_radians().tan() * climb.cos()).atan();
        let friction = (mu / flank.cos()).atan();
        let (low, high) = found.forces.effort_bounds[0];
        near(high, weight * radius * (climb + friction).tan());
        near(low, weight * radius * (climb - friction).tan());
        let holding = &found.rest.unpowered;
        let locks = friction >= climb;
        assert_eq!(holding.verdict, if locks { Verdict::Holds } else { Verdict::Slips });
        // The normal force of a thread depends on its friction, unless the equilibrium is
        // satisfied.
        near(holding.needed.1, slope * flank.cos() / mu);
        near(holding.needed.0, slope * flank.cos() / mu);
    }
}

/// Tests a collar on a rod with supports at a distance s. A force along the rod at the offset e
/// cannot move the collar, regardless of its magnitude, if `mu 2 e / s >= 1`.
#[test]
fn a_collar_that_binds() {
    for (offset, mu) in [(0.3_f64, 0.2_f64), (0.2, 0.2), (0.25, 0.2), (0.9, 0.05)] {
        let found = at_rest(&format!(
            r#"
            gravity = [0, 0, 0]
            [bodies.collar]
            [joints.guide]
            type = "P"
            from = "ground"
            to = "collar"
            axis = "z"
            actuated = true
            friction = {{ mu = {mu:?}, bending_span = "100 mm" }}
            [motions.sit]
            duration = 0
            guide = "0 m"
            [loads.push]
            collar = {{ force = [0, 0, "-70 N"], at = ["{offset:?} m", 0, 0] }}
            [default]
            motion = "sit"
            load = "push"
            "#
        ));
        let grip = mu * 2.0 * offset / 0.1;
        let holding = &found.rest.unpowered;
        assert_eq!(holding.verdict, if grip >= 1.0 { Verdict::Holds } else { Verdict::Slips });
        near(holding.needed.1, 1.0 / grip);
        near(holding.needed.0, 1.0 / grip);
    }
}

/// Tests a crank with a weight on its slider. The rod presses the slider against its guide. With
/// the crank at the angle t and the rod at the angle p below the horizontal, the push P of the rod
/// satisfies `P cos p = F + f`, `N = |W + P sin p|`.
#[test]
fn a_slider_crank() {
    for (turn, mu, load) in [(50.0_f64, 0.15, 200.0), (120.0, 0.3, -80.0), (300.0, 0.2, 40.0)] {
        let (sin_t, cos_t) = turn.to_radians().sin_cos();
        let sin_p = 0.1 * sin_t / 0.25;
        let cos_p = (1.0 - sin_p * sin_p).sqrt();
        let (down, slide) = (sin_p.asin().to_degrees(), 0.1 * cos_t + 0.25 * cos_p);
        let text = format!(
            r#"
            gravity = [0, 0, 0]
            [bodies.crank]
            [bodies.rod]
            [bodies.slider]
            [joints.A]
            type = "R"
            from = "ground"
            to = "crank"
            axis = "z"
            actuated = true
            start = "{turn:?} deg"
            [joints.B]
            type = "R"
            from = "crank"
            to = "rod"
            at = ["100 mm", 0, 0]
            axis = "z"
            start = "{:?} deg"
            [joints.C]
            type = "R"
            from = "rod"
            to = "slider"
            at = ["250 mm", 0, 0]
            axis = "z"
            start = "{down:?} deg"
            [joints.guide]
            type = "P"
            from = "ground"
            to = "slider"
            axis = "x"
            start = "{slide:?} m"
            friction = {{ mu = {mu:?} }}
            [motions.sit]
            duration = 0
            A = "{turn:?} deg"
            [loads.push]
            slider = {{ force = ["{:?} N", "-60 N", 0] }}
            [default]
            motion = "sit"
            load = "push"
            "#,
            -turn - down,
            -load,
        );
        let found = at_rest(&text);
        // The push P for the friction f = s mu N, with the sign n of the expression in N.
        let mut torques = Vec::new();
        for (s, n) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let push = (load + s * mu * n * 60.0) / (cos_p - s * mu * n * sin_p);
            if n * (60.0 + push * sin_p) >= 0.0 {
                torques.push(-push * 0.1 * (sin_t * cos_p + cos_t * sin_p));
            }
        }
        let low = torques.iter().copied().fold(f64::INFINITY, f64::min);
        let high = torques.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (found_low, found_high) = found.forces.effort_bounds[0];
        near(found_low, low);
        near(found_high, high);
        let (outer_low, outer_high) = found.forces.effort_outer_bounds[0];
        // Exact intervals are their own outer bounds, up to the rounding of both formulas.
        let rounding = 8.0 * f64::EPSILON * low.abs().max(high.abs());
        assert!(outer_low <= low + rounding && high - rounding <= outer_high);
        // The push P is zero where friction alone carries the load.
        let needed = load.abs() / (mu * 60.0);
        let holding = &found.rest.unpowered;
        near(holding.needed.1, needed);
        near(holding.needed.0, needed);
        assert_eq!(holding.verdict, if needed <= 1.0 { Verdict::Holds } else { Verdict::Slips });
    }
}
