//! Products and decompositions of the square blocks of block matrices.

/// Number of rows and columns of a block.
pub(crate) const BLOCK: usize = 6;
/// Block vector: the six components of a vector that belong to one block row.
pub(crate) type Part = [f64; BLOCK];
/// Square block of a matrix, stored in row-major order.
pub(crate) type Block = [Part; BLOCK];

pub(super) const NOTHING: Block = [[0.0; BLOCK]; BLOCK];
pub(super) const UNIT: Block = {
    let mut unit = NOTHING;
    let mut i = 0;
    while i < BLOCK {
        unit[i][i] = 1.0;
        i += 1;
    }
    unit
};

/// Computes the inverse of the lower Cholesky factor of the first `size` rows and columns of a
/// block, of which the upper triangle is overwritten. `inverse` must be [`UNIT`]. Returns `false` if
/// a pivot does not exceed `least` or is not finite.
#[inline(always)]
pub(super) fn inverse_factor(
    left: &mut Block,
    inverse: &mut Block,
    size: usize,
    least: f64,
) -> bool {
    let size = size.min(BLOCK);
    eliminate_column::<0>(left, inverse, size, least)
        && eliminate_column::<1>(left, inverse, size, least)
        && eliminate_column::<2>(left, inverse, size, least)
        && eliminate_column::<3>(left, inverse, size, least)
        && eliminate_column::<4>(left, inverse, size, least)
        && eliminate_column::<5>(left, inverse, size, least)
}

/// Eliminates column `J` of the upper triangle `left` of a symmetric block, and applies the same
/// operations to `inverse`. Returns `false` if the pivot does not exceed `least` or is not finite.
/// A constant column allows the compiler to omit operations on zeros.
#[inline(always)]
fn eliminate_column<const J: usize>(
    left: &mut Block,
    inverse: &mut Block,
    size: usize,
    least: f64,
) -> bool {
    if J >= size {
        return true;
    }
    let pivot = left[J][J];
    if !(pivot > least && pivot.is_finite()) {
        return false;
    }
    let over = 1.0 / pivot.sqrt();
    // Column J of the factor, stored as a row, and row J of the inverse of the factor.
    let (column, row) = (left[J].map(|x| x * over), inverse[J].map(|x| x * over));
    inverse[J] = row;
    // Pairs of entries fill a vector register.
    let (first, end) = (J.div_ceil(2) * 2, J / 2 * 2 + 2);
    for i in J + 1..size {
        let amount = column[i];
        (first..BLOCK).for_each(|k| left[i][k] -= amount * column[k]);
        (0..end).for_each(|k| inverse[i][k] -= amount * row[k]);
    }
    true
}

/// Adds the outer product of two vectors to the given first rows of a block.
pub(crate) fn add_outer(block: &mut [Part], a: &Part, b: &Part) {
    for (row, &amount) in block.iter_mut().zip(a) {
        (0..BLOCK).for_each(|j| row[j] += amount * b[j]);
    }
}

/// Adds the sum of the outer products of the vectors `a` and `b` with the same index to a block, of
/// which `size` rows are in use.
pub(crate) fn add_outer_products(block: &mut Block, a: &[Part], b: &[Part], size: usize) {
    update_block(block, (a.iter().zip(b), size), |entry, product| entry + product);
}

/// Adds the sum of the outer products of vectors with themselves to the upper triangle of a block,
/// of which `size` rows are in use.
pub(crate) fn add_squares(block: &mut Block, vectors: &[Part], size: usize) {
    update_triangle(block, (vectors.iter().zip(vectors), size), |entry, product| entry + product);
}

/// Computes the scalar product of two vectors.
#[inline(always)]
pub(crate) fn dot(a: &Part, b: &Part) -> f64 {
    dot_of_pairs::<3>(a, b)
}

/// Computes the scalar product of the first `PAIRS` pairs of components of two vectors. A pair
/// fills a vector register.
#[inline(always)]
fn dot_of_pairs<const PAIRS: usize>(a: &Part, b: &Part) -> f64 {
    let [mut even, mut odd] = [a[0] * b[0], a[1] * b[1]];
    for k in 1..PAIRS {
        even += a[2 * k] * b[2 * k];
        odd += a[2 * k + 1] * b[2 * k + 1];
    }
    even + odd
}

/// Multiplies a block, of which `size` rows are in use, by a lower triangular block from the left.
#[inline(always)]
pub(super) fn multiply_lower(lower: &Block, block: &mut Block, size: usize) {
    // A row of the product depends on this row and the rows above it.
    for i in (0..size.min(BLOCK)).rev() {
        // The row stays in registers.
        let mut row = [0.0; BLOCK];
        for (amount, other) in lower[i].iter().zip(&*block).take(i + 1) {
            (0..BLOCK).for_each(|j| row[j] += amount * other[j]);
        }
        block[i] = row;
    }
}

/// Subtracts a product in place: `from -= transpose(a) * b`. The first `size` rows of `a` and `b`
/// are in use.
#[inline(always)]
pub(super) fn subtract_product(from: &mut Block, (a, b): (&Block, &Block), size: usize) {
    update_block(from, (a.iter().zip(b).take(size), BLOCK), |entry, product| entry - product);
}

/// Subtracts a product from the upper triangle of a block: `from -= transpose(a) * a`. The first
/// `size` rows of `a` are in use.
#[inline(always)]
pub(super) fn subtract_square(from: &mut Block, a: &Block, size: usize) {
    update_triangle(from, (a.iter().zip(a).take(size), BLOCK), |entry, product| entry - product);
}

/// Updates the first `size` rows of a block, in pairs, with the outer products of pairs of vectors.
#[inline(always)]
fn update_block<'a>(
    block: &mut Block,
    (pairs, size): (impl Iterator<Item = (&'a Part, &'a Part)> + Clone, usize),
    update: impl Fn(f64, f64) -> f64,
) {
    update_rows::<0, 0>(block, pairs.clone(), &update);
    if size > 2 {
        update_rows::<2, 0>(block, pairs.clone(), &update);
    }
    if size > 4 {
        update_rows::<4, 0>(block, pairs, &update);
    }
}

/// Updates the first `size` rows of the upper triangle of a block, in pairs, with the outer products
/// of pairs of vectors.
#[inline(always)]
fn update_triangle<'a>(
    block: &mut Block,
    (pairs, size): (impl Iterator<Item = (&'a Part, &'a Part)> + Clone, usize),
    update: impl Fn(f64, f64) -> f64,
) {
    update_rows::<0, 0>(block, pairs.clone(), &update);
    if size > 2 {
        update_rows::<2, 2>(block, pairs.clone(), &update);
    }
    if size > 4 {
        update_rows::<4, 4>(block, pairs, &update);
    }
}

/// Updates the rows `ROW` and `ROW + 1` of a block, from column `FIRST` on, with the outer products
/// of pairs of vectors. Two rows with constant columns stay in registers.
#[inline(always)]
fn update_rows<'a, const ROW: usize, const FIRST: usize>(
    block: &mut Block,
    pairs: impl Iterator<Item = (&'a Part, &'a Part)>,
    update: impl Fn(f64, f64) -> f64,
) {
    let [mut upper, mut lower] = [block[ROW], block[ROW + 1]];
    for (a, b) in pairs {
        let (of_upper, of_lower) = (a[ROW], a[ROW + 1]);
        for j in FIRST..BLOCK {
            upper[j] = update(upper[j], of_upper * b[j]);
            lower[j] = update(lower[j], of_lower * b[j]);
        }
    }
    [block[ROW], block[ROW + 1]] = [upper, lower];
}

/// Computes the product of a lower triangular block and a vector.
#[inline(always)]
pub(super) fn lower_times(lower: &Block, x: &Part) -> Part {
    let [a, b, c, d, e, f] = lower;
    [
        dot_of_pairs::<1>(a, x),
        dot_of_pairs::<1>(b, x),
        dot_of_pairs::<2>(c, x),
        dot_of_pairs::<2>(d, x),
        dot_of_pairs::<3>(e, x),
        dot_of_pairs::<3>(f, x),
    ]
}

/// Computes the product of the transpose of a lower triangular block and a vector, of which the
/// first components are given; the others are zero.
#[inline(always)]
pub(super) fn upper_times(lower: &Block, x: &[f64]) -> Part {
    let mut product = [0.0; BLOCK];
    for (row, amount) in lower.iter().zip(x) {
        (0..BLOCK).for_each(|i| product[i] += row[i] * amount);
    }
    product
}
