//! Buffer of numbers that is aligned to cache lines, for fast access through vector registers.

use core::ops::{Deref, DerefMut};

/// Size of a cache line and of the widest register, bytes.
const LINE: usize = 64;

/// Buffer of numbers whose first element lies at the start of a cache line. An unaligned access as
/// wide as a vector register would touch two cache lines.
#[derive(Debug, Default)]
pub(crate) struct Aligned {
    numbers: Vec<f64>,
    first: usize,
}

impl Aligned {
    /// Creates memory for `count` numbers, all zero.
    pub(crate) fn zeros(count: usize) -> Self {
        let numbers = vec![0.0; count + LINE / size_of::<f64>()];
        // Any offset is valid: an unaligned buffer is only slower.
        let first = numbers.as_ptr().align_offset(LINE).min(numbers.len() - count);
        let mut aligned = Self { numbers, first };
        aligned.numbers.truncate(first + count);
        aligned
    }
}

impl From<&[f64]> for Aligned {
    fn from(numbers: &[f64]) -> Self {
        let mut aligned = Self::zeros(numbers.len());
        aligned.copy_from_slice(numbers);
        aligned
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        Self::from(&**self)
    }
}

impl Deref for Aligned {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.numbers[self.first..]
    }
}

impl DerefMut for Aligned {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.first..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_to_cache_lines() {
        for count in [0, 1, 7, 8, 1000, 100_000] {
            let mut aligned = Aligned::zeros(count);
            assert_eq!((aligned.len(), aligned.as_ptr() as usize % LINE), (count, 0));
            aligned.iter_mut().enumerate().for_each(|(k, x)| *x = k as f64);
            let again = aligned.clone();
            assert_eq!((&*again, again.as_ptr() as usize % LINE), (&*aligned, 0));
        }
    }
}
