//! Short models.

/// 2 kg on a slope of 30 degrees: without an actuator force it slides if mu < tan 30 deg = 0.57735.
pub(crate) fn slope(mu: f64) -> String {
    format!(
        r#"
        gravity = [0, 0, "-10 m/s^2"]
        [bodies.block]
        mass = "2 kg"
        com = [0, 0, 0]
        inertia = [1, 1, 1]
        [joints.slope]
        type = "P"
        from = "ground"
        to = "block"
        axis = ["cos(30 deg)", 0, "sin(30 deg)"]
        actuated = true
        friction = {{ mu = {mu:?} }}
        [motions.up]
        duration = "2 s"
        slope = "0.1 m/s*t"
        "#
    )
}
