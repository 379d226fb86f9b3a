/// Number of free motions of the joints of the spanning tree; number of columns, which are the
/// unknowns of joints that close loops and of gearings; number of terms of the columns.
const MOTIONS: usize = @MOTIONS@;
const COLUMNS: usize = @COLUMNS@;
const TERMS: usize = @TERMS@;
/// Number of redundant columns; number of columns that resist local passive degrees of freedom.
const REDUNDANT: usize = @REDUNDANT@;
const SPINS: usize = @SPINS@;
const FIRST_PLACE: usize = @FIRST_PLACE@;
const MOST_PASSES: u32 = @INDEX_PASSES@;
/// Number of components of a body in a pair of vectors.
const WIDTH: usize = 12;
/// Square of the sine of the angle between a vector and its next iterate, at convergence.
const ALIGNED: Real = @ALIGNED@;
/// Fraction of the square of a vector up to which its remainder after orthogonalisation is a
/// rounding error.
const PARALLEL: Real = @PARALLEL@;
/// Index up to which a position is singular; relative determinant from which the index is not
/// needed.
const LEAST_INDEX: Real = @LEAST_INDEX@;
const SMALL_DETERMINANT: Real = @SMALL_DETERMINANT@;

/// Size of an array, at least one.
const fn room(count: usize) -> usize {
    if count > 0 { count } else { 1 }
}

/// Place of the parent of each body in the tree; place 0 is the ground.
const PARENT: [usize; BODIES + 1] = [@PARENT@];
/// Place of the first body that each free motion moves.
const MOVES: [usize; room(MOTIONS)] = [@MOVES@];
/// Column of each term, and the places of the two bodies on which it acts, in opposite directions.
const COLUMN_OF: [usize; room(TERMS)] = [@COLUMN_OF@];
const ON: [[usize; 2]; room(TERMS)] = [@ON@];
/// Sign with which each term does work in each free motion; 0 for none.
const SIGN: [[i8; room(TERMS)]; room(MOTIONS)] = [
@SIGN@];

/// Two vectors with six components for each body, including the ground; components of both vectors
/// alternate.
type Pair = [Real; WIDTH * (BODIES + 1)];
/// Amounts of the columns for both vectors, which alternate.
type Amounts = [Real; 2 * room(COLUMNS)];
type Weakest = [Real; WIDTH * BODIES];

/// Data of a state with its decomposed dense system. The system `A x = y`, where A is the
/// dimensionless balance of all bodies, and its transpose are solved by recursion along the tree
/// and by the dense system, which has one unknown for each free motion of the tree's joints and one
/// row for each column.
struct Balance<'a> {
    /// Centres of mass, origins of the joints, free motions, and terms; the last two have six
    /// components each.
    centre: &'a [Real],
    origin: &'a [Real],
    motion: &'a [Real],
    term: &'a [Real],
    /// Triangular factors with reciprocal pivots, and the column of each row.
    factors: [[Real; room(MOTIONS)]; room(COLUMNS)],
    column: [usize; room(COLUMNS)],
    /// Orthonormal self-stresses, and orthonormal local passive degrees of freedom.
    stress: [[Real; 6 * BODIES + COLUMNS]; room(REDUNDANT)],
    spin: [[Real; 6 * BODIES]; room(SPINS)],
}

/// For each of two vectors: adds `by` times the cross product of the vector at `k` in `r` and the
/// vector at `from` to the vector at `to`.
fn add_cross(r: &[Real], k: usize, x: &mut Pair, from: usize, by: Real, to: usize) {
    for lane in 0..2 {
        let (a, b, c) = (x[from + lane], x[from + 2 + lane], x[from + 4 + lane]);
        x[to + lane] += by * (r[k + 1] * c - r[k + 2] * b);
        x[to + 2 + lane] += by * (r[k + 2] * a - r[k] * c);
        x[to + 4 + lane] += by * (r[k] * b - r[k + 1] * a);
    }
}

/// Adds the wrenches on all outer bodies to those on each body, from the tips to the ground.
fn gather(x: &mut Pair) {
    for k in (1..=BODIES).rev() {
        for i in 0..WIDTH {
            x[WIDTH * PARENT[k] + i] += x[WIDTH * k + i];
        }
    }
}

/// Adds the motion of its parent to that of each body, from the ground to the tips.
fn spread(x: &mut Pair) {
    x[..WIDTH].fill(0.0);
    for k in 1..=BODIES {
        for i in 0..WIDTH {
            x[WIDTH * k + i] += x[WIDTH * PARENT[k] + i];
        }
    }
}

/// Subtracts from a vector its component along a unit vector; `stride` is 2 for one vector of a
/// pair.
fn subtract(x: &mut [Real], unit: &[Real], stride: usize) {
    let mut along = 0.0;
    for (x, unit) in x.iter().step_by(stride).zip(unit) {
        along += unit * x;
    }
    for (x, unit) in x.iter_mut().step_by(stride).zip(unit) {
        *x -= along * unit;
    }
}

/// Scales a vector to unit length.
fn normalise<M: Math>(x: &mut [Real]) {
    let mut square = 0.0;
    for x in x.iter() {
        square += x * x;
    }
    let scale = 1.0 / M::sqrt(square);
    for x in x.iter_mut() {
        *x *= scale;
    }
}

/// Fills a vector with numbers that have no symmetry; `stride` is 2 for one vector of a pair.
fn fill(x: &mut [Real], stride: usize) {
    let mut seed = 1_u32;
    for x in x.iter_mut().step_by(stride) {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *x = (seed >> 16) as Real / 65536.0 - 0.5;
    }
}

/// Initial vectors of the first call.
fn without_pattern() -> Weakest {
    let mut weakest = [0.0; WIDTH * BODIES];
    fill(&mut weakest, 1);
    weakest
}

/// Adds the inner products of the two vectors of a pair: first with first, first with second,
/// second with second.
fn multiply(x: &[Real], products: &mut [Real; 3]) {
    for pair in x.chunks_exact(2) {
        products[0] += pair[0] * pair[0];
        products[1] += pair[0] * pair[1];
        products[2] += pair[1] * pair[1];
    }
}

impl<'a> Balance<'a> {
    /// Assembles and decomposes the dense system; `None` if it is singular.
    fn decompose(places: &'a [Real]) -> Option<Self> {
        let mut own = Self {
            centre: &places[..3 * BODIES],
            origin: &places[3 * BODIES..6 * BODIES],
            motion: &places[6 * BODIES..6 * BODIES + 6 * MOTIONS],
            term: &places[6 * BODIES + 6 * MOTIONS..6 * BODIES + 6 * MOTIONS + 6 * TERMS],
            factors: [[0.0; room(MOTIONS)]; room(COLUMNS)],
            column: core::array::from_fn(|k| k),
            stress: [[0.0; 6 * BODIES + COLUMNS]; room(REDUNDANT)],
            spin: [[0.0; 6 * BODIES]; room(SPINS)],
        };
        for i in 0..MOTIONS {
            let s = &own.motion[6 * i..6 * i + 6];
            for k in 0..TERMS {
                let w = &own.term[6 * k..6 * k + 6];
                if SIGN[i][k] != 0 {
                    let power = s[0] * w[0] + s[1] * w[1] + s[2] * w[2] + s[3] * w[3] + s[4] * w[4]
                        + s[5] * w[5];
                    own.factors[COLUMN_OF[k]][i] += SIGN[i][k] as Real * power;
                }
            }
        }
        for k in 0..MOTIONS {
            let (mut most, mut row) = (0.0, k);
            for i in k..COLUMNS {
                let size = size_of(own.factors[i][k]);
                if size > most {
                    (most, row) = (size, i);
                }
            }
            if !(most > 0.0) || !most.is_finite() {
                return None;
            }
            own.column.swap(k, row);
            own.factors.swap(k, row);
            own.factors[k][k] = 1.0 / own.factors[k][k];
            let pivot = own.factors[k];
            for i in k + 1..COLUMNS {
                if own.factors[i][k] != 0.0 {
                    let factor = own.factors[i][k] * pivot[k];
                    own.factors[i][k] = factor;
                    for j in k + 1..MOTIONS {
                        own.factors[i][j] -= factor * pivot[j];
                    }
                }
            }
        }
        Some(own)
    }

    /// Adds the wrenches of all columns, in these amounts, to those on the bodies.
    fn add_terms(&self, amounts: &Amounts, sum: &mut Pair) {
        for k in 0..TERMS {
            let (first, second) = (amounts[2 * COLUMN_OF[k]], amounts[2 * COLUMN_OF[k] + 1]);
            let [a, b] = ON[k];
            for i in 0..6 {
                let w = self.term[6 * k + i];
                sum[WIDTH * a + 2 * i] += first * w;
                sum[WIDTH * a + 2 * i + 1] += second * w;
                sum[WIDTH * b + 2 * i] -= first * w;
                sum[WIDTH * b + 2 * i + 1] -= second * w;
            }
        }
    }

    /// Solves `A x = y`. On entry, `x` contains the wrenches on the bodies about the reference
    /// point; on return, those of the joints of the tree about their origins. Returns the amounts
    /// of the columns.
    fn carry(&self, x: &mut Pair) -> Amounts {
        let mut right = [0.0; 2 * room(MOTIONS)];
        let mut amounts = [0.0; 2 * room(COLUMNS)];
        gather(x);
        for i in 0..MOTIONS {
            for k in 0..6 {
                let s = self.motion[6 * i + k];
                right[2 * i] += s * x[WIDTH * MOVES[i] + 2 * k];
                right[2 * i + 1] += s * x[WIDTH * MOVES[i] + 2 * k + 1];
            }
        }
        for lane in 0..2 {
            for k in 0..MOTIONS {
                right[2 * k + lane] *= self.factors[k][k];
                for i in k + 1..MOTIONS {
                    right[2 * i + lane] -= self.factors[k][i] * right[2 * k + lane];
                }
            }
            for k in (1..MOTIONS).rev() {
                for i in 0..k {
                    right[2 * i + lane] -= self.factors[k][i] * right[2 * k + lane];
                }
            }
            for k in 0..MOTIONS {
                amounts[2 * self.column[k] + lane] = right[2 * k + lane];
            }
        }
        let mut rest = [0.0; WIDTH * (BODIES + 1)];
        self.add_terms(&amounts, &mut rest);
        gather(&mut rest);
        for k in 1..=BODIES {
            for i in WIDTH * k..WIDTH * (k + 1) {
                x[i] -= rest[i];
            }
            add_cross(self.origin, 3 * (k - 1), x, WIDTH * k, -1.0, WIDTH * k + 6);
        }
        amounts
    }

    /// Solves the transposed system. On entry, `x` contains the motions of the joints of the tree
    /// about their origins, and `amounts` those of the columns; on return, `x` contains the motions
    /// of the bodies about their centres of mass.
    fn shift(&self, x: &mut Pair, amounts: &Amounts) {
        let mut right = [0.0; 2 * room(MOTIONS)];
        let mut rest = [0.0; WIDTH * (BODIES + 1)];
        for k in 1..=BODIES {
            add_cross(self.origin, 3 * (k - 1), x, WIDTH * k + 6, 1.0, WIDTH * k);
        }
        spread(x);
        let mut left = *amounts;
        for k in 0..TERMS {
            let [a, b] = ON[k];
            for i in 0..6 {
                let w = self.term[6 * k + i];
                for lane in 0..2 {
                    let apart = x[WIDTH * a + 2 * i + lane] - x[WIDTH * b + 2 * i + lane];
                    left[2 * COLUMN_OF[k] + lane] -= w * apart;
                }
            }
        }
        for lane in 0..2 {
            for k in 0..MOTIONS {
                right[2 * k + lane] = left[2 * self.column[k] + lane];
                for i in 0..k {
                    right[2 * k + lane] -= self.factors[k][i] * right[2 * i + lane];
                }
            }
            for k in (0..MOTIONS).rev() {
                for i in k + 1..MOTIONS {
                    right[2 * k + lane] -= self.factors[k][i] * right[2 * i + lane];
                }
                right[2 * k + lane] *= self.factors[k][k];
                for i in 0..6 {
                    rest[WIDTH * MOVES[k] + 2 * i + lane] += self.motion[6 * k + i] * right[2 * k + lane];
                }
            }
        }
        spread(&mut rest);
        for k in 1..=BODIES {
            for i in WIDTH * k..WIDTH * (k + 1) {
                x[i] += rest[i];
            }
            add_cross(self.centre, 3 * (k - 1), x, WIDTH * k + 6, -1.0, WIDTH * k);
        }
    }

    /// Computes the self-stresses and the local passive degrees of freedom.
    fn find_null_vectors<M: Math>(&mut self) {
        for n in 0..REDUNDANT {
            let column = self.column[MOTIONS + n];
            let mut x = [0.0; WIDTH * (BODIES + 1)];
            let mut unit = [0.0; 2 * room(COLUMNS)];
            unit[2 * column] = -1.0;
            self.add_terms(&unit, &mut x);
            let mut amounts = self.carry(&mut x);
            amounts[2 * column] += 1.0;
            let mut found = [0.0; 6 * BODIES + COLUMNS];
            for k in 0..6 * BODIES {
                found[k] = x[WIDTH + 2 * k];
            }
            for k in 0..COLUMNS {
                found[6 * BODIES + k] = amounts[2 * k];
            }
            for stress in &self.stress[..n] {
                subtract(&mut found, stress, 1);
            }
            normalise::<M>(&mut found);
            self.stress[n] = found;
        }
        for n in 0..SPINS {
            let mut x = [0.0; WIDTH * (BODIES + 1)];
            let mut unit = [0.0; 2 * room(COLUMNS)];
            unit[2 * (COLUMNS - SPINS + n)] = -1.0;
            self.shift(&mut x, &unit);
            let mut found: [Real; 6 * BODIES] = core::array::from_fn(|k| x[WIDTH + 2 * k]);
            for spin in &self.spin[..n] {
                subtract(&mut found, spin, 1);
            }
            normalise::<M>(&mut found);
            self.spin[n] = found;
        }
    }

    /// Makes both vectors orthogonal to the local passive degrees of freedom and to each other,
    /// with unit length.
    fn make_orthonormal<M: Math>(&self, x: &mut Weakest) {
        for lane in 0..2 {
            for spin in &self.spin[..SPINS] {
                subtract(&mut x[lane..], spin, 2);
            }
            let (mut along, mut square) = (0.0, 0.0);
            if lane > 0 {
                for pair in x.chunks_exact(2) {
                    along += pair[0] * pair[1];
                }
            }
            for k in 0..6 * BODIES {
                x[2 * k + lane] -= along * x[2 * k];
                square += x[2 * k + lane] * x[2 * k + lane];
            }
            let scale = 1.0 / M::sqrt(square);
            for k in 0..6 * BODIES {
                x[2 * k + lane] *= scale;
            }
        }
    }

    /// Subtracts the self-stresses from the wrenches of the joints and the amounts of the columns.
    fn remove_stresses(&self, x: &mut Pair, amounts: &mut Amounts) {
        for stress in &self.stress[..REDUNDANT] {
            for lane in 0..2 {
                let mut along = 0.0;
                for i in 0..6 * BODIES {
                    along += stress[i] * x[WIDTH + 2 * i + lane];
                }
                for i in 0..COLUMNS {
                    along += stress[6 * BODIES + i] * amounts[2 * i + lane];
                }
                for i in 0..6 * BODIES {
                    x[WIDTH + 2 * i + lane] -= along * stress[i];
                }
                for i in 0..COLUMNS {
                    amounts[2 * i + lane] -= along * stress[6 * BODIES + i];
                }
            }
        }
    }

    /// Improves the two unit vectors of least resistance by a step of inverse iteration; the first
    /// has the lower resistance. Returns the square of this resistance, and `true` if the first
    /// vector has hardly turned.
    fn improve<M: Math>(&self, x: &mut Weakest) -> (Real, bool) {
        // Inner products of the iterates, and of A transposed times the iterates.
        let (mut moved, mut resisted) = ([0.0; 3], [0.0; 3]);
        let mut bodies = [0.0; WIDTH * (BODIES + 1)];
        bodies[WIDTH..].copy_from_slice(x);
        for k in 1..=BODIES {
            add_cross(self.centre, 3 * (k - 1), &mut bodies, WIDTH * k, 1.0, WIDTH * k + 6);
        }
        let mut amounts = self.carry(&mut bodies);
        amounts[2 * (COLUMNS - SPINS)..].fill(0.0);
        self.remove_stresses(&mut bodies, &mut amounts);
        multiply(&bodies[WIDTH..], &mut resisted);
        multiply(&amounts, &mut resisted);
        self.shift(&mut bodies, &amounts);
        x.copy_from_slice(&bodies[WIDTH..]);
        for spin in &self.spin[..SPINS] {
            subtract(x, spin, 2);
            subtract(&mut x[1..], spin, 2);
        }
        multiply(x, &mut moved);
        let is_aligned = moved[0] / (resisted[0] * resisted[0]) - 1.0 <= ALIGNED;
        let along = moved[1] / moved[0];
        let mut second = 0.0;
        for pair in x.chunks_exact_mut(2) {
            pair[1] -= along * pair[0];
            second += pair[1] * pair[1];
        }
        let least = resisted[0] / moved[0];
        if !(second > PARALLEL * moved[2]) {
            fill(&mut x[1..], 2);
            self.make_orthonormal::<M>(x);
            return (least, is_aligned);
        }
        // Principal axes of A times its transpose in the plane of both iterates (Rayleigh-Ritz).
        let (a, b) = (1.0 / M::sqrt(moved[0]), 1.0 / M::sqrt(second));
        let mixed = (resisted[1] - along * resisted[0]) * a * b;
        let other = (resisted[2] - 2.0 * along * resisted[1] + along * along * resisted[0]) * b * b;
        let mut tangent = 0.0;
        if mixed != 0.0 {
            let ratio = (other - least) / (2.0 * mixed);
            let sign: Real = if ratio < 0.0 { -1.0 } else { 1.0 };
            tangent = sign / (size_of(ratio) + M::sqrt(1.0 + ratio * ratio));
        }
        let ends = [least - tangent * mixed, other + tangent * mixed];
        let first = if ends[1] < ends[0] { 1 } else { 0 };
        let cosine = 1.0 / M::sqrt(1.0 + tangent * tangent);
        let sine = tangent * cosine;
        for pair in x.chunks_exact_mut(2) {
            let (u, v) = (a * pair[0], b * pair[1]);
            pair[first] = cosine * u - sine * v;
            pair[1 - first] = sine * u + cosine * v;
        }
        (ends[first], is_aligned)
    }
}

/// Computes the singularity index from the results of `prepare`: the smallest singular value of the
/// dimensionless balance of all bodies, by inverse iteration with two vectors that start from those
/// of the last call.
fn find_index<M: Math>(places: &[Real], weakest: &mut Weakest, info: &mut Info) {
    (info.singularity_index, info.index_passes) = (0.0, 0);
    let Some(mut own) = Balance::decompose(places) else { return };
    own.find_null_vectors::<M>();
    // Symmetric motions preserve a symmetry of the vectors: a small part without symmetry finds the
    // others.
    let mut added = [0.0; 6 * BODIES];
    fill(&mut added, 1);
    for k in 0..6 * BODIES {
        weakest[2 * k + 1] += added[k] / 32.0;
    }
    own.make_orthonormal::<M>(weakest);
    let mut square = 0.0;
    for pass in 1..=MOST_PASSES {
        let (least, is_aligned) = own.improve::<M>(weakest);
        (square, info.index_passes) = (least, pass);
        if is_aligned {
            break;
        }
    }
    if square > 0.0 && square.is_finite() {
        info.singularity_index = M::sqrt(square);
    }
    if !are_finite(weakest) {
        *weakest = without_pattern();
    }
}
