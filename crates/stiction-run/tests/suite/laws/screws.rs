//! Threads: flank forces and driving torque.

use crate::laws::{G, body, model, run};
use stiction_core::dynamics::InverseError;
use stiction_run::Error;

/// Screw jack under 50 kg: lead angle, half flank angle in the section normal to the thread, and
/// friction angle.
struct Jack {
    radius: f64,
    pitch: f64,
    /// Half the flank angle in a section along the axis, deg.
    flank: f64,
    mu: f64,
}

impl Jack {
    const WEIGHT: f64 = 50.0 * G;

    fn angles(&self) -> (f64, f64) {
        let lead = (self.pitch / self.radius).atan();
        let across = (self.flank.to_radians().tan() * lead.cos()).atan();
        (lead, (self.mu / across.cos()).atan())
    }

    fn friction(&self) -> String {
        let Self { radius, flank, mu, .. } = self;
        format!("friction = {{ mu = {mu:?}, radius = {radius:?}, flank_angle = \"{flank} deg\" }}")
    }

    /// Returns the model in which a motor turns the spindle in a fixed nut.
    fn turned_spindle(&self, motion: &str) -> String {
        let parts = format!(
            "{}\n[joints.drive]\ntype = \"H\"\nfrom = \"ground\"\nto = \"spindle\"\naxis = \"z\"\n\
             pitch = {:?}\nactuated = true\n{}\n",
            body("spindle", 50.0),
            self.pitch,
            self.friction()
        );
        model(&parts, &format!("drive = \"{motion}\""))
    }

    /// Returns the model in which a motor turns the nut on a spindle that does not turn.
    fn turned_nut(&self, motion: &str) -> String {
        let parts = format!(
            r#"{}{}
            [joints.drive]
            type = "R"
            from = "ground"
            to = "nut"
            axis = "-z"
            actuated = true
            [joints.thread]
            type = "H"
            from = "nut"
            to = "spindle"
            axis = "z"
            pitch = {:?}
            {}
            [joints.guide]
            type = "P"
            from = "ground"
            to = "spindle"
            axis = "z"
            "#,
            body("nut", 1e-9),
            body("spindle", 50.0),
            self.pitch,
            self.friction()
        );
        model(&parts, &format!("drive = \"{motion}\""))
    }
}

#[test]
fn a_screw_jack() {
    let mut held = [0, 0];
    for (radius, pitch) in [(0.01, 0.0008), (0.01, 0.004), (0.02, -0.01), (0.01, 0.012)] {
        for flank in [0.0, 15.0, 30.0] {
            for mu in [0.0, 0.05, 0.15, 0.4] {
                let jack = Jack { radius, pitch, flank, mu };
                let (lead, rub) = jack.angles();
                // For a right-hand thread, the forward motion is upward.
                let up = Jack::WEIGHT * radius * (lead + rub * pitch.signum()).tan();
                let down = Jack::WEIGHT * radius * (lead - rub * pitch.signum()).tan();
                let (up_rate, down_rate) = (pitch.signum(), -pitch.signum());
                for text in [Jack::turned_spindle, Jack::turned_nut] {
                    let torque = |motion: String, column: &str| {
                        let run = run(&text(&jack, &motion)).unwrap();
                        assert!(run.power_residual < 1e-9);
                        run.inverse.column(&format!("drive.{column} [N m]"))[1]
                    };
                    let near = |found: f64, expected: f64| {
                        // The light nut and the redundant guide leave round-off relative to the
                        // weight.
                        let error = (found - expected).abs();
                        assert!(error < 1e-8 * Jack::WEIGHT * radius, "{found} {expected}");
                    };
                    near(torque(format!("{up_rate:?} rad/s*t"), "drive"), up);
                    near(torque(format!("{down_rate:?} rad/s*t"), "drive"), down);
                    let (low, high) = (up.min(down), up.max(down));
                    near(torque("1 rad".into(), "drive_low"), low);
                    near(torque("1 rad".into(), "drive_high"), high);
                    // The jack is self-locking if the friction angle exceeds the lead angle.
                    assert_eq!(low < 0.0 && 0.0 < high, rub > lead.abs(), "{lead} {rub}");
                    held[usize::from(rub > lead.abs())] += 1;
                }
            }
        }
    }
    assert!(held.iter().all(|count| *count > 10), "{held:?}");
}

/// Tests that no torque raises a load if lead and friction angle add up to a right angle.
#[test]
fn a_screw_that_locks() {
    let jack = |mu| Jack { radius: 0.01, pitch: 0.02, flank: 0.0, mu };
    // The tangent of the lead angle is 2, so the screw locks for mu >= 1/2.
    for mu in [0.45, 0.49] {
        let run = run(&jack(mu).turned_spindle("1 rad/s*t")).unwrap();
        let torque = run.inverse.column("drive.drive [N m]")[1];
        let expected = Jack::WEIGHT * 0.01 * (2f64.atan() + mu.atan()).tan();
        assert!((torque / expected - 1.0).abs() < 1e-10, "{torque} {expected}");
    }
    for mu in [0.5, 0.6, 1.0] {
        match run(&jack(mu).turned_spindle("1 rad/s*t")) {
            Err(Error::Forces { error: InverseError::Locked { joint, percent }, .. }) => {
                assert_eq!(joint, "drive");
                assert!((percent - 50.0 / mu).abs() < 0.1, "{mu}: {percent}");
            }
            other => panic!("{mu}: {other:?}"),
        }
    }
    // A radial load also causes friction on the flanks, which carries a part of the axial load: N =
    // (W + mu N sin l) / cos l + F, with the lead angle l.
    let (mu, side) = (0.1, 300.0);
    let text = jack(mu).turned_spindle("1 rad/s*t");
    let text = text.replace("[loads.none]", "[loads.none]\nspindle = { fx = \"300 N\" }");
    let found = run(&text).unwrap();
    let (sin, cos) = 2f64.atan().sin_cos();
    let load = (Jack::WEIGHT / cos + side) / (1.0 - mu * sin / cos);
    let torque = Jack::WEIGHT * 0.02 + mu * load * 0.01 / cos;
    // At this instant the load acts on a spindle that has moved along its axis.
    assert!((found.friction.column("drive.load [N]")[0] / load - 1.0).abs() < 1e-12);
    assert!((found.inverse.column("drive.drive [N m]")[0] / torque - 1.0).abs() < 1e-12);
}
