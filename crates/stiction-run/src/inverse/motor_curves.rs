//! Plot of the torque of each motor over its speed, with the limits of the motor.

use crate::job::Job;
use stiction_core::mechanism::{DriveTrain, Motor};
use stiction_draw::figure::{Figure, Line, Panel};

/// Largest number of points drawn for one motor.
const DRAWN: usize = 4000;

/// Collects the torque and the speed of each motor, sample by sample.
#[derive(Clone, Debug)]
pub(super) struct MotorCurves {
    trains: Vec<DriveTrain>,
    /// Points of each motor (speed, rad/s, and torque, N m), and the sum of the squared torques
    /// over all samples.
    points: Vec<(Vec<(f64, f64)>, f64)>,
    /// Number of samples from one drawn point to the next.
    stride: usize,
    count: usize,
}

impl MotorCurves {
    pub(super) fn new(job: &Job<'_>, count: usize) -> Self {
        let trains = job.model.mechanism.drive_trains().to_vec();
        let points = vec![Default::default(); trains.len()];
        Self { trains, points, stride: count.div_ceil(DRAWN).max(1), count: 0 }
    }

    pub(super) fn add(&mut self, motors: &[Motor]) {
        let drawn = self.count.is_multiple_of(self.stride);
        self.count += 1;
        for ((points, squares), motor) in self.points.iter_mut().zip(motors) {
            *squares += motor.torque * motor.torque;
            if drawn {
                points.push((motor.speed, motor.torque));
            }
        }
    }

    /// Draws the torque of each motor over its speed; `None` if there are no drive trains.
    pub(super) fn figure(self, title: &str) -> Option<Figure> {
        let count = self.count.max(1) as f64;
        let panels = self
            .trains
            .iter()
            .zip(self.points)
            .map(|(train, (points, squares))| panel(train, points, (squares / count).sqrt()));
        let panels: Vec<Panel> = panels.collect();
        (!panels.is_empty()).then(|| Figure {
            title: format!("Motor torque over speed: {title}"),
            x_label: "motor speed [rad/s]".to_owned(),
            panels,
        })
    }
}

fn panel(train: &DriveTrain, points: Vec<(f64, f64)>, rms: f64) -> Panel {
    let most = |value: fn(&(f64, f64)) -> f64| {
        points.iter().map(value).fold(0.0_f64, |most, x| most.max(x.abs()))
    };
    let limits = train.limits;
    // Limits that are not declared do not affect the size of the panel.
    let reach = limits.speed.unwrap_or(0.0).max(1.05 * most(|p| p.0)).max(f64::MIN_POSITIVE);
    let height = limits.peak.or(limits.rated).unwrap_or(0.0).max(1.05 * most(|p| p.1));
    let mut lines = vec![Line { label: "motion".to_owned(), points, colour: 0, dashed: false }];
    let mut both = |label: &str, level: f64, colour: usize| {
        for (label, level) in [(label, level), ("", -level)] {
            let points = vec![(-reach, level), (reach, level)];
            lines.push(Line { label: label.to_owned(), points, colour, dashed: true });
        }
    };
    both("rms", rms, 2);
    if let Some(rated) = limits.rated {
        both("rated", rated, 4);
    }
    if let Some(peak) = limits.peak {
        both("peak", peak, 1);
    }
    if let Some(speed) = limits.speed {
        for (label, speed) in [("speed", speed), ("", -speed)] {
            let points = vec![(speed, -height), (speed, height)];
            lines.push(Line { label: label.to_owned(), points, colour: 3, dashed: true });
        }
    }
    Panel { y_label: format!("{} [N m]", train.name), lines, ..Panel::default() }
}
