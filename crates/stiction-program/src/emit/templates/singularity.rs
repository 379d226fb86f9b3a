/// Number of free motions of the joints of the spanning tree.
const MOTIONS: usize = @MOTIONS@;
/// Number of columns of the dense system: unknowns of the joints that close loops, of gearings, and
/// of local passive degrees of freedom.
const COLUMNS: usize = @COLUMNS@;
/// Number of terms: unit wrenches that make up the columns of the dense system.
const TERMS: usize = @TERMS@;
/// Number of columns that are not needed for equilibrium.
const REDUNDANT: usize = @REDUNDANT@;
/// Number of columns that resist local passive degrees of freedom.
const SPINS: usize = @SPINS@;
/// Index of the first number for the singularity index among the results of `prepare`.
const FIRST_PLACE: usize = @FIRST_PLACE@;
/// Largest number of passes of the inverse iteration.
const MOST_PASSES: u32 = @INDEX_PASSES@;
/// If the iteration converges in at most this number of passes, the starting vectors count as close
/// to the result.
const FEW_PASSES: u32 = 3;
/// Number of values for each body: six components of each of two vectors.
const WIDTH: usize = 12;
/// Convergence limit: largest squared sine of the angle between the first vector and its next
/// iterate.
const ALIGNED: Real = @ALIGNED@;
/// Convergence limit: largest relative decrease of the squared singularity index that the second
/// vector may still cause.
const LOWERED: Real = @LOWERED@;
/// Limit up to which the two iterated vectors count as parallel: squared norm of the component of
/// the second vector perpendicular to the first, divided by that of the second vector.
const PARALLEL: Real = @PARALLEL@;
/// Largest singularity index at which a position counts as singular.
const LEAST_INDEX: Real = @LEAST_INDEX@;
/// Smallest determinant at which a position counts as regular without computing the singularity
/// index.
const SMALL_DETERMINANT: Real = @SMALL_DETERMINANT@;

/// Length of an array of `count` items, at least 1.
const fn room(count: usize) -> usize {
    if count > 0 { count } else { 1 }
}

/// Index of the parent body of each body in the spanning tree; index 0 is the ground.
const PARENT: [usize; BODIES + 1] = [@PARENT@];
/// For each free motion of a joint, the index of the body that this joint connects to its parent
/// body.
const MOVES: [usize; room(MOTIONS)] = [@MOVES@];
/// For each term, the index of the column to which the term belongs.
const COLUMN_OF: [usize; room(TERMS)] = [@COLUMN_OF@];
/// For each term, the indices of the two bodies on which its wrench acts in opposite directions.
const ON: [[usize; 2]; room(TERMS)] = [@ON@];
/// For each term and free motion: +1 or -1 if the motion moves only the first or only the second
/// body of the term, otherwise 0.
const SIGN: [[Real; room(MOTIONS)]; room(TERMS)] = [
@SIGN@];

/// Two interleaved vectors, each with six components for each body including the ground.
type Pair = [Real; WIDTH * (BODIES + 1)];
/// Unknowns of the columns of the dense system for two interleaved vectors.
type Amounts = [Real; 2 * room(COLUMNS)];
/// The two interleaved vectors of the inverse iteration, without components for the ground.
type Weakest = [Real; WIDTH * BODIES];

/// Matrix A of the dimensionless force balance of all bodies at one position, prepared for the
/// solution of `A x = y` and of the transposed system. Both are solved by recursion along the
/// joints of the tree, and by the inverse of a dense system with one unknown for each free motion
/// of these joints and one row for each column.
struct Balance<'a> {
    /// Centres of mass of the bodies, three components each.
    centre: &'a [Real],
    /// Origins of the joints of the tree, three components each.
    origin: &'a [Real],
    /// Free motions of the joints of the tree, six components each.
    motion: &'a [Real],
    /// Unit wrenches of the terms, six components each.
    term: &'a [Real],
    /// First `MOTIONS` rows of the inverse of the matrix of the dense system, stored by columns.
    inverse: [[Real; room(MOTIONS)]; room(COLUMNS)],
    /// For each row of `inverse`, the column of the dense system to which the row belongs.
    column: [usize; room(COLUMNS)],
    /// Unit vectors of self-stress states (reactions in equilibrium without loads).
    stress: [[Real; 6 * BODIES + COLUMNS]; room(REDUNDANT)],
    /// Unit vectors of local passive degrees of freedom.
    spin: [[Real; 6 * BODIES]; room(SPINS)],
}

/// For each of the two vectors in `x`: takes the cross product of `r[k..k + 3]` with the three
/// components at `from`, and adds `by` times this product to the three components at `to`.
fn add_cross(r: &[Real], k: usize, x: &mut Pair, from: usize, by: Real, to: usize) {
    for lane in 0..2 {
        let (a, b, c) = (x[from + lane], x[from + 2 + lane], x[from + 4 + lane]);
        x[to + lane] += by * (r[k + 1] * c - r[k + 2] * b);
        x[to + 2 + lane] += by * (r[k + 2] * a - r[k] * c);
        x[to + 4 + lane] += by * (r[k] * b - r[k + 1] * a);
    }
}

/// Adds the wrenches on all bodies further out in the tree to the wrench on each body.
fn gather(x: &mut Pair) {
    for k in (1..=BODIES).rev() {
        for i in 0..WIDTH {
            x[WIDTH * PARENT[k] + i] += x[WIDTH * k + i];
        }
    }
}

/// Adds the motion of the parent body to the motion of each body.
fn spread(x: &mut Pair) {
    x[..WIDTH].fill(0.0);
    for k in 1..=BODIES {
        for i in 0..WIDTH {
            x[WIDTH * k + i] += x[WIDTH * PARENT[k] + i];
        }
    }
}

/// Removes the component along a unit vector from the vector that consists of every `stride`-th
/// item of `x`.
fn subtract(x: &mut [Real], unit: &[Real], stride: usize) {
    let mut along = 0.0;
    for (x, unit) in x.iter().step_by(stride).zip(unit) {
        along += unit * x;
    }
    for (x, unit) in x.iter_mut().step_by(stride).zip(unit) {
        *x -= along * unit;
    }
}

/// Scales `x` to unit length.
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

/// Returns a pseudo-random number from -0.5 to 0.5, which depends only on `k`.
fn without_pattern(k: usize) -> Real {
    let n = k as u32;
    let mixed = n.wrapping_mul(n).wrapping_add(12345).wrapping_mul(40503) >> 3;
    (mixed & 0xffff) as Real / 65536.0 - 0.5
}

/// Returns the two starting vectors of the inverse iteration in the first call. The first vector
/// has unit length.
fn first_vectors<M: Math>() -> Weakest {
    let mut weakest: Weakest = core::array::from_fn(without_pattern);
    let mut square = 0.0;
    for x in weakest.iter().step_by(2) {
        square += x * x;
    }
    let scale = 1.0 / M::sqrt(square);
    for x in weakest.iter_mut().step_by(2) {
        *x *= scale;
    }
    weakest
}

/// Adds to `products` three scalar products of the two interleaved vectors in `x`: of the first
/// vector with itself, of the first with the second, and of the second with itself.
fn multiply(x: &[Real], products: &mut [Real; 3]) {
    for pair in x.chunks_exact(2) {
        products[0] += pair[0] * pair[0];
        products[1] += pair[0] * pair[1];
        products[2] += pair[1] * pair[1];
    }
}

impl<'a> Balance<'a> {
    /// Assembles and inverts the dense system. Returns `None` if this system is singular.
    fn invert(places: &'a [Real]) -> Option<Self> {
        let mut own = Self {
            centre: &places[..3 * BODIES],
            origin: &places[3 * BODIES..6 * BODIES],
            motion: &places[6 * BODIES..6 * BODIES + 6 * MOTIONS],
            term: &places[6 * BODIES + 6 * MOTIONS..6 * BODIES + 6 * MOTIONS + 6 * TERMS],
            inverse: [[0.0; room(MOTIONS)]; room(COLUMNS)],
            column: core::array::from_fn(|k| k),
            stress: [[0.0; 6 * BODIES + COLUMNS]; room(REDUNDANT)],
            spin: [[0.0; 6 * BODIES]; room(SPINS)],
        };
        for k in 0..TERMS {
            let w = &own.term[6 * k..6 * k + 6];
            for i in 0..MOTIONS {
                let s = &own.motion[6 * i..6 * i + 6];
                let power = (s[0] * w[0] + s[2] * w[2] + s[4] * w[4])
                    + (s[1] * w[1] + s[3] * w[3] + s[5] * w[5]);
                own.inverse[COLUMN_OF[k]][i] += SIGN[k][i] * power;
            }
        }
        for k in 0..MOTIONS {
            let (mut most, mut row) = (0.0, k);
            for i in k..COLUMNS {
                let size = size_of(own.inverse[i][k]);
                if size > most {
                    (most, row) = (size, i);
                }
            }
            if !(most > 0.0) || !most.is_finite() {
                return None;
            }
            own.column.swap(k, row);
            own.inverse.swap(k, row);
            let by = 1.0 / own.inverse[k][k];
            let mut pivot = own.inverse[k].map(|value| value * by);
            pivot[k] = by;
            for row in &mut own.inverse {
                let factor = row[k];
                row[k] = 0.0;
                for i in 0..MOTIONS {
                    row[i] -= factor * pivot[i];
                }
            }
            own.inverse[k] = pivot;
        }
        Some(own)
    }

    /// Adds to `sum` the wrenches that the unknowns of all columns exert on the bodies.
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
    /// point; on return, the wrenches of the joints of the tree about their origins. Returns the
    /// unknowns of the columns.
    fn carry(&self, x: &mut Pair) -> Amounts {
        let mut right = [0.0; 2 * room(MOTIONS)];
        let mut amounts = [0.0; 2 * room(COLUMNS)];
        let mut whole = *x;
        gather(&mut whole);
        for i in 0..MOTIONS {
            for k in 0..6 {
                let s = self.motion[6 * i + k];
                right[2 * i] -= s * whole[WIDTH * MOVES[i] + 2 * k];
                right[2 * i + 1] -= s * whole[WIDTH * MOVES[i] + 2 * k + 1];
            }
        }
        for k in 0..MOTIONS {
            for i in 0..MOTIONS {
                amounts[2 * self.column[k]] += self.inverse[i][k] * right[2 * i];
                amounts[2 * self.column[k] + 1] += self.inverse[i][k] * right[2 * i + 1];
            }
        }
        self.add_terms(&amounts, x);
        gather(x);
        for k in 1..=BODIES {
            add_cross(self.origin, 3 * (k - 1), x, WIDTH * k, -1.0, WIDTH * k + 6);
        }
        amounts.map(|amount| -amount)
    }

    /// Solves the transposed system. On entry, `x` contains the motions of the joints of the tree
    /// about their origins, and `amounts` those of the columns; on return, `x` contains the motions
    /// of the bodies about their centres of mass.
    fn shift(&self, x: &mut Pair, amounts: &Amounts) {
        for k in 1..=BODIES {
            add_cross(self.origin, 3 * (k - 1), x, WIDTH * k + 6, 1.0, WIDTH * k);
        }
        let mut whole = *x;
        spread(&mut whole);
        let mut left = *amounts;
        for k in 0..TERMS {
            let [a, b] = ON[k];
            for i in 0..6 {
                let w = self.term[6 * k + i];
                for lane in 0..2 {
                    let apart = whole[WIDTH * a + 2 * i + lane] - whole[WIDTH * b + 2 * i + lane];
                    left[2 * COLUMN_OF[k] + lane] -= w * apart;
                }
            }
        }
        for i in 0..MOTIONS {
            let (mut first, mut second) = (0.0, 0.0);
            for k in 0..MOTIONS {
                first += self.inverse[i][k] * left[2 * self.column[k]];
                second += self.inverse[i][k] * left[2 * self.column[k] + 1];
            }
            for k in 0..6 {
                let s = self.motion[6 * i + k];
                x[WIDTH * MOVES[i] + 2 * k] += first * s;
                x[WIDTH * MOVES[i] + 2 * k + 1] += second * s;
            }
        }
        spread(x);
        for k in 1..=BODIES {
            add_cross(self.centre, 3 * (k - 1), x, WIDTH * k + 6, -1.0, WIDTH * k);
        }
    }

    /// Computes unit vectors of the self-stress states and of the local passive degrees of freedom.
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

    /// Replaces the second vector by a pseudo-random unit vector.
    fn renew<M: Math>(&self, x: &mut Weakest, pattern: usize) {
        for k in 0..6 * BODIES {
            x[2 * k + 1] = without_pattern(k + pattern);
        }
        self.make_orthonormal::<M>(x);
    }

    /// Makes both vectors orthogonal to the local passive degrees of freedom and to each other, and
    /// scales them to unit length.
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

    /// Removes the self-stress states from the wrenches of the joints and the unknowns of the
    /// columns.
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

    /// Improves the two unit vectors of least resistance by one step of inverse iteration. The
    /// resistance is the norm of A transposed times the vector; the first vector has the lower
    /// resistance. Returns the square of this resistance, and `true` on convergence: the first
    /// vector has hardly turned, and the second has hardly lowered the resistance.
    fn improve<M: Math>(&self, x: &mut Weakest) -> (Real, bool) {
        // Products of the iterates and of A transposed times the iterates.
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
        let second = moved[2] - along * moved[1];
        let least = resisted[0] / moved[0];
        if !(second > PARALLEL * moved[2]) {
            self.renew::<M>(x, 0);
            return (least, is_aligned);
        }
        // Principal axes of A times its transpose in the plane of both iterates.
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
        // Both axes, as linear combinations of both iterates.
        let mut axes = [
            [cosine * a + sine * b * along, -sine * b],
            [sine * a - cosine * b * along, cosine * b],
        ];
        axes.swap(0, first);
        for pair in x.chunks_exact_mut(2) {
            let [u, v] = [pair[0], pair[1]];
            pair[0] = axes[0][0] * u + axes[0][1] * v;
            pair[1] = axes[1][0] * u + axes[1][1] * v;
        }
        let lowered = least - ends[first];
        (ends[first], is_aligned && lowered <= LOWERED * ends[first])
    }
}

/// Computes the singularity index from the results of `prepare`: the smallest singular value of the
/// dimensionless balance of all bodies. The inverse iteration with two vectors starts from those of
/// the last call.
fn find_index<M: Math>(places: &[Real], weakest: &mut Weakest, info: &mut Info) {
    (info.singularity_index, info.index_passes) = (0.0, 0);
    let Some(mut own) = Balance::invert(places) else { return };
    own.find_null_vectors::<M>();
    // In motions with a symmetry, the iterated vectors would keep this symmetry. A small component
    // without symmetry lets the iteration find all other vectors.
    for k in (0..6 * BODIES).step_by(5) {
        weakest[2 * k + 1] += without_pattern(k) / 8.0;
    }
    if SPINS > 0 {
        own.make_orthonormal::<M>(weakest);
    }
    let mut square = 0.0;
    let mut least_passes = 0;
    for pass in 1..=MOST_PASSES {
        let (least, is_aligned) = own.improve::<M>(weakest);
        (square, info.index_passes) = (least, pass);
        // If both starting vectors are almost orthogonal to the vector of least resistance, the
        // iteration may stop at another vector. After many passes, it therefore makes as many
        // passes again with a new second vector.
        if is_aligned && least_passes == 0 && pass > FEW_PASSES {
            own.renew::<M>(weakest, WIDTH * BODIES);
            least_passes = 2 * pass;
        }
        if is_aligned && pass >= least_passes {
            break;
        }
    }
    if square > 0.0 && square.is_finite() {
        info.singularity_index = M::sqrt(square);
    } else {
        *weakest = first_vectors::<M>();
    }
}
