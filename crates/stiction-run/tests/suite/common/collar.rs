//! Collars with eccentric forces.

/// Returns the joints of a driver that pushes a collar at a given offset from the guide of the
/// collar, m, through a rod between two balls.
pub(crate) fn push_beside(offset: f64) -> String {
    format!(
        r#"
        [joints.drive]
        type = "P"
        from = "ground"
        to = "driver"
        at = ["{offset:?} m", 0, "-1 m"]
        axis = "z"
        actuated = true
        [joints.A]
        type = "S"
        from = "driver"
        to = "rod"
        [joints.B]
        type = "S"
        from = "rod"
        to = "collar"
        at = [0, 0, "1 m"]
        to_at = ["{offset:?} m", 0, 0]
        "#
    )
}
