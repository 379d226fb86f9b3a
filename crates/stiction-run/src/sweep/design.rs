//! Designs of a study: the values of the varied model keys in each row.

use super::latin_hypercube::{LatinHypercube, unit};
use super::sobol::{MOST_DIMENSIONS, Sobol};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use stiction_format::{Key, Setting, Variation};
use thiserror::Error;

/// Values of the varied model keys in each row of a study. The values of a row depend neither on
/// other rows nor on the total number of rows.
#[derive(Clone, Debug)]
pub struct Design {
    variations: Vec<Variation>,
    count: u64,
    plan: Plan,
}

#[derive(Clone, Debug)]
enum Plan {
    Grid,
    LatinHypercube(Vec<LatinHypercube>),
    /// Sobol sequence of each dimension, with its digital shift.
    Sobol(Vec<(Sobol, u64)>),
}

/// Largest number of rows of a grid or Sobol design; a larger number indicates an error in the count.
const MOST_ROWS: u64 = 1_000_000_000;
/// Largest number of coordinates (rows times keys) in a Latin hypercube, whose permutations are
/// stored in memory.
const MOST_COORDINATES: u64 = 1 << 28;

/// Reason why variations cannot be combined into a design.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum DesignError {
    /// No key is varied.
    #[error("no key is varied")]
    Empty,
    /// A key is varied twice.
    #[error("`{0}` is varied twice")]
    Twice(
        /// Name of the key that is varied twice.
        String,
    ),
    /// A range has no number of values, which a grid needs.
    #[error("a grid needs the number of values in the range of `{0}`")]
    Uncounted(
        /// Name of the key whose range has no number of values.
        String,
    ),
    /// A range has one value, so that one of its ends would be left out.
    #[error("the range of `{0}` has one value, which cannot be both of its ends")]
    OneValue(
        /// Name of the key whose range has one value.
        String,
    ),
    /// A range has a number of values, which sampled designs do not allow.
    #[error(
        "the range of `{0}` has a number of values (`in N`), but a sampled design chooses the \
        values itself"
    )]
    Counted(
        /// Name of the key whose range has a number of values.
        String,
    ),
    /// The number of samples is zero.
    #[error("a sampled design needs at least one row")]
    NoSamples,
    /// The design has too many rows.
    #[error("the design has {rows} rows; the maximum is {most}")]
    TooManyRows {
        /// Number of rows as text, because it may exceed every integer type.
        rows: String,
        /// Largest allowed number of rows.
        most: u64,
    },
    /// More keys are varied than Sobol's sequence has dimensions.
    #[error("{keys} keys are varied, but Sobol's sequence is available for at most {most} keys")]
    TooManyKeys {
        /// Number of varied keys.
        keys: usize,
        /// Largest allowed number of varied keys.
        most: usize,
    },
}

impl Design {
    /// Creates the grid of all combinations of values. The last key changes fastest from row to
    /// row.
    ///
    /// # Errors
    /// See [`DesignError`].
    pub fn grid(variations: Vec<Variation>) -> Result<Self, DesignError> {
        check(&variations)?;
        let mut count = 1_u64;
        for variation in &variations {
            let own = variation.count();
            let own = own.ok_or_else(|| DesignError::Uncounted(variation.key.path.clone()))?;
            if own == 1 && variation.at(0) != variation.within(1.0) {
                return Err(DesignError::OneValue(variation.key.path.clone()));
            }
            count = count.saturating_mul(own);
        }
        if count > MOST_ROWS {
            let rows = match count {
                u64::MAX => "countless".to_owned(),
                count => count.to_string(),
            };
            return Err(DesignError::TooManyRows { rows, most: MOST_ROWS });
        }
        Ok(Self { variations, count, plan: Plan::Grid })
    }

    /// Creates a Latin hypercube. The range of each key is divided into as many intervals as there
    /// are rows, and each interval is used exactly once.
    ///
    /// # Errors
    /// See [`DesignError`].
    pub fn latin_hypercube(
        variations: Vec<Variation>,
        samples: u64,
        seed: u64,
    ) -> Result<Self, DesignError> {
        check_sampled(&variations, samples)?;
        let most = MOST_COORDINATES / variations.len() as u64;
        let points = u32::try_from(samples).ok().filter(|_| samples <= most);
        let points =
            points.ok_or_else(|| DesignError::TooManyRows { rows: samples.to_string(), most })?;
        let cube = |dimension| LatinHypercube::new(seed, dimension, points);
        let plan = Plan::LatinHypercube((0..variations.len()).map(cube).collect());
        Ok(Self { variations, count: samples, plan })
    }

    /// Creates a design from the first points of Sobol's sequence. A seed shifts the points at
    /// random (digital shift); without a seed the points are not shifted. A longer design begins
    /// with the rows of a shorter one.
    ///
    /// # Errors
    /// See [`DesignError`].
    pub fn sobol(
        variations: Vec<Variation>,
        samples: u64,
        seed: Option<u64>,
    ) -> Result<Self, DesignError> {
        check_sampled(&variations, samples)?;
        let (keys, most) = (variations.len(), MOST_DIMENSIONS);
        if keys > most {
            return Err(DesignError::TooManyKeys { keys, most });
        }
        if samples > MOST_ROWS {
            let rows = samples.to_string();
            return Err(DesignError::TooManyRows { rows, most: MOST_ROWS });
        }
        let mut random = seed.map(ChaCha8Rng::seed_from_u64);
        let mut shift = || random.as_mut().map_or(0, Rng::next_u64);
        let plan = Plan::Sobol((0..keys).map(|k| (Sobol::new(k), shift())).collect());
        Ok(Self { variations, count: samples, plan })
    }

    /// Returns the number of rows of the design.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the varied keys.
    pub fn keys(&self) -> impl Iterator<Item = &Key> {
        self.variations.iter().map(|variation| &variation.key)
    }

    /// Returns the number of values of each key in a grid; `None` for a sampled design.
    pub fn shape(&self) -> Option<Vec<u64>> {
        match self.plan {
            Plan::Grid => self.variations.iter().map(Variation::count).collect(),
            _ => None,
        }
    }

    /// Returns the values of the keys in a row; rows count from 0.
    pub fn row(&self, row: u64) -> Vec<Setting> {
        match &self.plan {
            Plan::Grid => {
                let mut rest = row;
                let mut values: Vec<Setting> = Vec::with_capacity(self.variations.len());
                for variation in self.variations.iter().rev() {
                    let count = variation.count().unwrap_or(1).max(1);
                    values.push(variation.at(rest % count));
                    rest /= count;
                }
                values.reverse();
                values
            }
            Plan::LatinHypercube(cubes) => {
                let all = self.variations.iter().zip(cubes);
                all.map(|(variation, cube)| variation.within(cube.at(row))).collect()
            }
            Plan::Sobol(sequences) => {
                let all = self.variations.iter().zip(sequences);
                all.map(|(variation, (sobol, shift))| variation.within(unit(sobol.at(row) ^ shift)))
                    .collect()
            }
        }
    }
}

fn check(variations: &[Variation]) -> Result<(), DesignError> {
    if variations.is_empty() {
        return Err(DesignError::Empty);
    }
    for (k, variation) in variations.iter().enumerate() {
        let path = &variation.key.path;
        if variations[..k].iter().any(|other| other.key.path == *path) {
            return Err(DesignError::Twice(path.clone()));
        }
    }
    Ok(())
}

fn check_sampled(variations: &[Variation], samples: u64) -> Result<(), DesignError> {
    check(variations)?;
    let is_counted = |variation: &&Variation| {
        matches!(variation.values, stiction_format::Values::Range { count: Some(_), .. })
    };
    if let Some(variation) = variations.iter().find(is_counted) {
        return Err(DesignError::Counted(variation.key.path.clone()));
    }
    if samples == 0 { Err(DesignError::NoSamples) } else { Ok(()) }
}
