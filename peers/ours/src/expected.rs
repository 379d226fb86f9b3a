//! Forces that the program prints for every state, from the file that `peers/states.py` writes.

/// Actuator forces and reactions at one state.
pub(crate) struct Forces {
    pub(crate) drives: Vec<f64>,
    /// For each joint, force and moment about the joint's origin, world axes.
    pub(crate) reactions: Vec<[f64; 6]>,
}

/// Forces of all states of a motion.
pub(crate) struct Expected {
    /// Names of the joints in the order of [`Forces::reactions`].
    pub(crate) joints: Vec<String>,
    /// Instants, s.
    pub(crate) times: Vec<f64>,
    pub(crate) frictionless: Vec<Forces>,
    pub(crate) with_friction: Vec<Forces>,
}

impl Expected {
    pub(crate) fn read(path: &str) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
        Self::parse(&text).ok_or_else(|| format!("{path} is not complete"))
    }

    fn parse(text: &str) -> Option<Self> {
        let mut words = text.split_whitespace();
        if words.next()? != "samples" {
            return None;
        }
        let mut sizes = [0usize; 3];
        for size in &mut sizes {
            *size = words.next()?.parse().ok()?;
        }
        let [samples, drives, joints] = sizes;
        let joints: Vec<String> = words.by_ref().take(joints).map(String::from).collect();
        let mut numbers = words.map_while(|word| word.parse::<f64>().ok());
        let mut expected =
            Self { joints, times: Vec::new(), frictionless: Vec::new(), with_friction: Vec::new() };
        for _ in 0..samples {
            expected.times.push(numbers.next()?);
            for list in [&mut expected.frictionless, &mut expected.with_friction] {
                let mut forces = Forces { drives: Vec::new(), reactions: Vec::new() };
                for _ in 0..drives {
                    forces.drives.push(numbers.next()?);
                }
                for _ in 0..expected.joints.len() {
                    let mut wrench = [0.0; 6];
                    for number in &mut wrench {
                        *number = numbers.next()?;
                    }
                    forces.reactions.push(wrench);
                }
                list.push(forces);
            }
        }
        (samples > 0).then_some(expected)
    }
}

/// Largest differences along a motion, separately for actuator forces, forces, moments and
/// accelerations, each relative to the largest of its kind.
#[derive(Default)]
pub(crate) struct Difference([(f64, f64); 4]);

impl Difference {
    fn add(&mut self, kind: usize, got: f64, expected: f64) {
        let (error, size) = &mut self.0[kind];
        let difference = (got - expected).abs();
        // NaN must not pass as small.
        *error = if difference.is_finite() { error.max(difference) } else { f64::INFINITY };
        *size = size.max(expected.abs());
    }

    pub(crate) fn add_drive(&mut self, got: f64, expected: f64) {
        self.add(0, got, expected);
    }

    pub(crate) fn add_acceleration(&mut self, got: f64, expected: f64) {
        self.add(3, got, expected);
    }

    pub(crate) fn add_reaction(&mut self, got: [f64; 6], expected: [f64; 6]) {
        for (k, (got, expected)) in got.into_iter().zip(expected).enumerate() {
            self.add(1 + k / 3, got, expected);
        }
    }

    pub(crate) fn relative(&self) -> f64 {
        let relative = |&(error, size): &(f64, f64)| if error == 0.0 { 0.0 } else { error / size };
        self.0.iter().map(relative).fold(0.0, f64::max)
    }
}
