//! Why a mechanism cannot be brought into a position.

use thiserror::Error;

/// Why a mechanism could not be assembled or moved as prescribed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// The loops do not close at the prescribed position.
    #[error("{0}")]
    Gap(Gap),
    /// The prescription leaves freedoms open.
    #[error("the motion leaves {} open: {}", count(open.len()), list(open))]
    Open {
        /// Each open freedom in words.
        open: Vec<OpenFreedom>,
    },
    /// The prescribed second angle is where the other two are not defined.
    #[error(
        "the second rotation angle of body `{body}` is prescribed as {degrees:.3} deg, at or beyond \
         the limit of its range ({range}) where the other two are not defined; prescribe another \
         order of axes"
    )]
    AngleRange {
        /// The body.
        body: String,
        /// The prescribed value, deg.
        degrees: f64,
        /// The range in words.
        range: &'static str,
    },
    /// The mechanism cannot follow without changing its assembly mode.
    #[error(
        "the mechanism cannot follow the motion smoothly: between two instants that are {step:.1e} s \
         apart, body `{body}` would jump by {distance_mm:.4} mm and {angle_deg:.4} deg (it changes \
         its assembly mode, or passes a singular position)"
    )]
    Jump {
        /// The body that moves most.
        body: String,
        /// Its displacement beyond what its velocity explains, mm.
        distance_mm: f64,
        /// Its rotation beyond that, deg.
        angle_deg: f64,
        /// The time between the two instants, s.
        step: f64,
    },
}

/// By how much a mechanism fails to assemble.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// The joint that is open most.
    pub joint: Option<String>,
    /// How far it is open, m.
    pub length: f64,
    /// By which angle it is open, rad.
    pub angle: f64,
    /// The largest deviation from the prescription that remains as well, m or rad.
    pub deviation: f64,
}

impl core::fmt::Display for Gap {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match &self.joint {
            Some(joint) => write!(
                f,
                "the loops do not close: at best, joint `{joint}` stays open by {:.4} mm and {:.4} deg",
                self.length * 1e3,
                self.angle.to_degrees()
            )?,
            None => write!(f, "the prescribed coordinates contradict each other")?,
        }
        if self.joint.is_none() || self.deviation > 1e-9 {
            write!(
                f,
                " (prescribed coordinates are missed by up to {:.2e} m or rad)",
                self.deviation
            )?;
        }
        Ok(())
    }
}

/// A freedom that neither the loops nor the prescription determine.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenFreedom {
    /// The body that moves most.
    pub body: String,
    /// How it moves, in words; places are in the world.
    pub motion: String,
}

fn count(n: usize) -> String {
    if n == 1 { "one freedom".to_owned() } else { format!("{n} freedoms") }
}

fn list(open: &[OpenFreedom]) -> String {
    let told = open.iter().map(|o| format!("body `{}` can still move ({})", o.body, o.motion));
    told.collect::<Vec<_>>().join("; ")
}
