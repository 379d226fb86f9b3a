//! Exact ranks of integer matrices, modulo primes near 2^61.
//!
//! The rank modulo a prime never exceeds the true rank, and it is smaller only if the prime divides
//! every minor of that size. Such a minor of the matrices of these tests (at most 150 columns of
//! length at most 30) is below 30^150 < 2^740 by Hadamard's inequality, so at most 12 of the 5e16
//! primes of this size divide it. For a fixed prime and random minors, a wrong rank has a
//! probability of about 2^-61, and the tests compute about 1e6 ranks. The results for two primes
//! must agree, so that even such an error is detected: the same error with both primes has a
//! probability of 2^-122.
//! error is detected: the same error in both has a probability of 2^-122.

/// The two largest primes below 2^61; a test verifies them with [`is_prime`].
pub const PRIMES: [u64; 2] = [(1 << 61) - 1, (1 << 61) - 31];

/// The span of integer rows modulo a prime, stored as rows with leading ones.
#[derive(Clone)]
pub struct RowSpace {
    prime: u64,
    /// Rows, indexed by the column of their leading one; all entries before it are zero.
    rows: Vec<Option<Vec<u64>>>,
    rank: usize,
}

impl RowSpace {
    pub fn new(prime: u64, columns: usize) -> Self {
        Self { prime, rows: vec![None; columns], rank: 0 }
    }

    pub fn of(prime: u64, columns: usize, rows: &[Vec<i64>]) -> Self {
        let mut space = Self::new(prime, columns);
        rows.iter().for_each(|row| {
            space.insert(row);
        });
        space
    }

    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns `true` if a row is a linear combination of the rows in the space.
    pub fn contains(&self, row: &[i64]) -> bool {
        self.reduced(row).1.is_none()
    }

    /// Adds a row; returns `true` if it is independent of the rows already in the space.
    pub fn insert(&mut self, row: &[i64]) -> bool {
        let (mut row, leading) = self.reduced(row);
        let Some(leading) = leading else { return false };
        let inverse = power(row[leading], self.prime - 2, self.prime);
        row.iter_mut().for_each(|x| *x = times(*x, inverse, self.prime));
        self.rows[leading] = Some(row);
        self.rank += 1;
        true
    }

    /// Returns the remainder of a row, and its first nonzero column.
    fn reduced(&self, row: &[i64]) -> (Vec<u64>, Option<usize>) {
        let p = self.prime;
        let mut row: Vec<u64> = row.iter().map(|x| x.rem_euclid(p as i64) as u64).collect();
        let mut leading = None;
        for column in 0..row.len() {
            if row[column] == 0 {
                continue;
            }
            let Some(known) = &self.rows[column] else {
                leading = leading.or(Some(column));
                continue;
            };
            let factor = p - row[column];
            for k in column..row.len() {
                row[k] = (row[k] + times(factor, known[k], p)) % p;
            }
        }
        (row, leading)
    }
}

fn times(a: u64, b: u64, prime: u64) -> u64 {
    (u128::from(a) * u128::from(b) % u128::from(prime)) as u64
}

fn power(base: u64, mut exponent: u64, prime: u64) -> u64 {
    let (mut base, mut result) = (base, 1);
    while exponent > 0 {
        if exponent % 2 == 1 {
            result = times(result, base, prime);
        }
        base = times(base, base, prime);
        exponent /= 2;
    }
    result
}

/// Miller's test with the bases that are sufficient for all numbers below 3.3e24 (Sorenson, Webster
/// 2015).
pub fn is_prime(n: u64) -> bool {
    let (mut odd, mut halvings) = (n - 1, 0);
    while odd % 2 == 0 {
        odd /= 2;
        halvings += 1;
    }
    [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41].into_iter().all(|base| {
        let mut x = power(base, odd, n);
        x == 1
            || (0..halvings).any(|_| {
                let found = x == n - 1;
                x = times(x, x, n);
                found
            })
    })
}
