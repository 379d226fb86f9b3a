/* Singularity index: smallest singular value of the dimensionless balance A of all bodies, by inverse iteration with
   two vectors. Along the joints of a spanning tree, A x = y and its transpose are solved by recursion; a dense system
   has one unknown for each free motion of these joints, and one row for each column, which is an unknown of a joint
   that closes a loop, or of a gearing. Vectors have six components for each body, each for both vectors. */
#define BODIES @BODIES@
#define MOTIONS @MOTIONS@
#define COLUMNS @COLUMNS@
#define TERMS @TERMS@
/* Columns without which equilibrium is possible; columns that resist local passive degrees of freedom. */
#define REDUNDANT @REDUNDANT@
#define SPINS @SPINS@
/* Size of an array that may have no items. */
#define ROOM(count) ((count) > 0 ? (count) : 1)
#define FIRST_PLACE @FIRST_PLACE@
#define MOST_PASSES @INDEX_PASSES@
/* Passes up to which the vectors of the last call count as near to those of this one. */
#define FEW_PASSES 3
/* Numbers of a body in two vectors. */
#define WIDTH 12

/* Square of the sine of the angle between a vector and its next iterate, at convergence. */
static const real ALIGNED = @ALIGNED@;
/* Relative decrease of the square of the index by the second vector, at convergence. */
static const real LOWERED = @LOWERED@;
/* Part of the square of an iterate up to which it counts as parallel to the other. */
static const real PARALLEL = @PARALLEL@;
/* Index up to which the position counts as singular, and determinant from which on it needs no test. */
static const real LEAST_INDEX = @LEAST_INDEX@;
static const real SMALL_DETERMINANT = @SMALL_DETERMINANT@;

/* Parent of each place in the tree; place 0 is the ground. */
static const short PARENT[BODIES + 1] = { @PARENT@ };
/* Place that a free motion moves first. */
static const short MOVES[ROOM(MOTIONS)] = { @MOVES@ };
/* Column of each term, and the places on which it acts, in opposite directions. */
static const short COLUMN_OF[ROOM(TERMS)] = { @COLUMN_OF@ };
static const short ON[ROOM(TERMS)][2] = { @ON@ };
/* Sign of each term on each motion. */
static const real SIGN[ROOM(TERMS)][ROOM(MOTIONS)] = {
@SIGN@};

/* Inverse of the dense system and the positions of a state. */
typedef struct {
    /* Centres of mass; origins of the joints; free motions and terms with six components. */
    const real *centre;
    const real *origin;
    const real *motion;
    const real *term;
    /* Inverse of the dense system in its first rows, and the column of each row. */
    real inverse[ROOM(COLUMNS)][ROOM(MOTIONS)];
    int column[ROOM(COLUMNS)];
    /* Unit vectors of reactions in equilibrium with each other, and of local passive degrees of freedom. */
    real stress[ROOM(REDUNDANT)][6 * BODIES + COLUMNS];
    real spin[ROOM(SPINS)][6 * BODIES];
} balance;

/* Moves the reference points of the wrenches or the motions of all bodies by `by` times the position of a point of each:
   adds products of the positions and the numbers `from` to the numbers `to`. Here and below, all numbers are read before
   any is written, and both vectors are treated alike, so that compilers use instructions for pairs of numbers. */
static void shift(real *vector, const real *points, real by, int from, int to)
{
    int k;
    for (k = 0; k < BODIES; ++k) {
        const real a = by * points[3 * k];
        const real b = by * points[3 * k + 1];
        const real c = by * points[3 * k + 2];
        const real *x = vector + WIDTH * (k + 1) + from;
        real *sum = vector + WIDTH * (k + 1) + to;
        const real x0 = sum[0] + b * x[4] - c * x[2];
        const real x1 = sum[1] + b * x[5] - c * x[3];
        const real y0 = sum[2] + c * x[0] - a * x[4];
        const real y1 = sum[3] + c * x[1] - a * x[5];
        const real z0 = sum[4] + a * x[2] - b * x[0];
        const real z1 = sum[5] + a * x[3] - b * x[1];
        sum[0] = x0;
        sum[1] = x1;
        sum[2] = y0;
        sum[3] = y1;
        sum[4] = z0;
        sum[5] = z1;
    }
}

/* Adds `by` times one vector, or each of two vectors, to another. */
static void add(real *x, real by, const real *y)
{
    real sum[WIDTH];
    int i;
    for (i = 0; i < WIDTH; ++i) {
        sum[i] = x[i] + by * y[i];
    }
    for (i = 0; i < WIDTH; ++i) {
        x[i] = sum[i];
    }
}

/* Assembles and inverts the dense system; returns 0 if it is singular. All loops over a row have the same length, which
   makes them faster than those of a triangular decomposition. */
static int invert(const real *places, balance *own)
{
    real pivot[ROOM(MOTIONS)];
    int i;
    int j;
    int k;
    own->centre = places;
    own->origin = places + 3 * BODIES;
    own->motion = places + 6 * BODIES;
    own->term = places + 6 * BODIES + 6 * MOTIONS;
    for (k = 0; k < COLUMNS; ++k) {
        own->column[k] = k;
        for (i = 0; i < MOTIONS; ++i) {
            own->inverse[k][i] = 0;
        }
    }
    for (k = 0; k < TERMS; ++k) {
        const real *w = own->term + 6 * k;
        real *row = own->inverse[COLUMN_OF[k]];
        for (i = 0; i < MOTIONS; ++i) {
            const real *s = own->motion + 6 * i;
            row[i] += SIGN[k][i]
                * ((s[0] * w[0] + s[2] * w[2] + s[4] * w[4])
                    + (s[1] * w[1] + s[3] * w[3] + s[5] * w[5]));
        }
    }
    for (k = 0; k < MOTIONS; ++k) {
        real most = 0;
        real by;
        int row = k;
        for (i = k; i < COLUMNS; ++i) {
            const real size = fabs@F@(own->inverse[i][k]);
            if (size > most) {
                most = size;
                row = i;
            }
        }
        if (!(most > 0) || !is_finite(most)) {
            return 0;
        }
        j = own->column[row];
        own->column[row] = own->column[k];
        own->column[k] = j;
        by = 1 / own->inverse[row][k];
        for (i = 0; i < MOTIONS; ++i) {
            const real value = own->inverse[row][i];
            own->inverse[row][i] = own->inverse[k][i];
            pivot[i] = value * by;
        }
        pivot[k] = by;
        for (j = 0; j < COLUMNS; ++j) {
            const real factor = own->inverse[j][k];
            own->inverse[j][k] = 0;
            for (i = 0; i < MOTIONS; ++i) {
                own->inverse[j][i] -= factor * pivot[i];
            }
        }
        for (i = 0; i < MOTIONS; ++i) {
            own->inverse[k][i] = pivot[i];
        }
    }
    return 1;
}

/* Adds the amounts of all columns as wrenches on the bodies. */
static void add_terms(const balance *own, const real *amounts, real *sum)
{
    real wrench[WIDTH];
    int i;
    int k;
    for (k = 0; k < TERMS; ++k) {
        const real *w = own->term + 6 * k;
        const real first = amounts[2 * COLUMN_OF[k]];
        const real second = amounts[2 * COLUMN_OF[k] + 1];
        for (i = 0; i < 6; ++i) {
            wrench[2 * i] = first * w[i];
            wrench[2 * i + 1] = second * w[i];
        }
        add(sum + WIDTH * ON[k][0], 1, wrench);
        add(sum + WIDTH * ON[k][1], -1, wrench);
    }
}

/* Adds the wrenches on all outer bodies to those on each body. */
static void gather(real *x)
{
    int k;
    for (k = BODIES; k > 0; --k) {
        add(x + WIDTH * PARENT[k], 1, x + WIDTH * k);
    }
}

/* Adds the motion of its parent to that of each body. */
static void spread(real *x)
{
    int k;
    for (k = 0; k < WIDTH; ++k) {
        x[k] = 0;
    }
    for (k = 1; k <= BODIES; ++k) {
        add(x + WIDTH * k, 1, x + WIDTH * PARENT[k]);
    }
}

/* Solves A x = y: `x` are the wrenches on the bodies about the reference point, and becomes those of the joints of the
   tree about their origins; `amounts` are those of the columns. */
static void carry(const balance *own, real *x, real *amounts)
{
    real whole[WIDTH * (BODIES + 1)];
    real right[2 * ROOM(MOTIONS)];
    int i;
    int k;
    for (k = 0; k < WIDTH * (BODIES + 1); ++k) {
        whole[k] = x[k];
    }
    gather(whole);
    for (i = 0; i < MOTIONS; ++i) {
        const real *s = own->motion + 6 * i;
        const real *f = whole + WIDTH * MOVES[i];
        real first = 0;
        real second = 0;
        for (k = 0; k < 6; ++k) {
            first -= s[k] * f[2 * k];
            second -= s[k] * f[2 * k + 1];
        }
        right[2 * i] = first;
        right[2 * i + 1] = second;
    }
    for (k = 0; k < COLUMNS; ++k) {
        real first = 0;
        real second = 0;
        for (i = 0; i < MOTIONS && k < MOTIONS; ++i) {
            first += own->inverse[i][k] * right[2 * i];
            second += own->inverse[i][k] * right[2 * i + 1];
        }
        amounts[2 * own->column[k]] = first;
        amounts[2 * own->column[k] + 1] = second;
    }
    add_terms(own, amounts, x);
    gather(x);
    shift(x, own->origin, -1, 0, 6);
    for (k = 0; k < 2 * COLUMNS; ++k) {
        amounts[k] = -amounts[k];
    }
}

/* Solves the transposed system: `x` are the motions of the joints of the tree about their origins, `amounts` those of
   the columns; `x` becomes the motions of the bodies about their centres of mass. */
static void move(const balance *own, real *x, const real *amounts)
{
    real whole[WIDTH * (BODIES + 1)];
    real left[2 * ROOM(COLUMNS)];
    int i;
    int k;
    shift(x, own->origin, 1, 6, 0);
    for (k = 0; k < WIDTH * (BODIES + 1); ++k) {
        whole[k] = x[k];
    }
    spread(whole);
    for (k = 0; k < 2 * COLUMNS; ++k) {
        left[k] = amounts[k];
    }
    for (k = 0; k < TERMS; ++k) {
        const real *w = own->term + 6 * k;
        const real *a = whole + WIDTH * ON[k][0];
        const real *b = whole + WIDTH * ON[k][1];
        real first = 0;
        real second = 0;
        for (i = 0; i < 6; ++i) {
            first += w[i] * (a[2 * i] - b[2 * i]);
            second += w[i] * (a[2 * i + 1] - b[2 * i + 1]);
        }
        left[2 * COLUMN_OF[k]] -= first;
        left[2 * COLUMN_OF[k] + 1] -= second;
    }
    for (i = 0; i < MOTIONS; ++i) {
        const real *s = own->motion + 6 * i;
        real moved[WIDTH];
        real first = 0;
        real second = 0;
        for (k = 0; k < MOTIONS; ++k) {
            first += own->inverse[i][k] * left[2 * own->column[k]];
            second += own->inverse[i][k] * left[2 * own->column[k] + 1];
        }
        for (k = 0; k < 6; ++k) {
            moved[2 * k] = first * s[k];
            moved[2 * k + 1] = second * s[k];
        }
        add(x + WIDTH * MOVES[i], 1, moved);
    }
    spread(x);
    shift(x, own->centre, -1, 6, 0);
}

/* Subtracts from a vector its component along a unit vector. */
static void subtract(real *x, const real *unit, int stride, int count)
{
    real along = 0;
    int k;
    for (k = 0; k < count; ++k) {
        along += unit[k] * x[stride * k];
    }
    for (k = 0; k < count; ++k) {
        x[stride * k] -= along * unit[k];
    }
}

/* Subtracts from a vector its components along unit vectors, and scales it to a unit vector. */
static void normalise(real *x, const real *units, int units_count, int count)
{
    real square = 0;
    int k;
    for (k = 0; k < units_count; ++k) {
        subtract(x, units + k * count, 1, count);
    }
    for (k = 0; k < count; ++k) {
        square += x[k] * x[k];
    }
    square = 1 / sqrt@F@(square);
    for (k = 0; k < count; ++k) {
        x[k] *= square;
    }
}

/* Numbers without any pattern, from -0.5 to 0.5. */
static real without_pattern(int k)
{
    const unsigned n = (unsigned)k;
    return (real)(int)(((n * n + 12345u) * 40503u >> 3) & 0xffffu) / 65536 - (real)0.5;
}

/* Fills two vectors, of which the first gets unit length. */
static void fill(real *x)
{
    real square = 0;
    int k;
    for (k = 0; k < WIDTH * BODIES; ++k) {
        x[k] = without_pattern(k);
        square += k % 2 == 0 ? x[k] * x[k] : 0;
    }
    square = 1 / sqrt@F@(square);
    for (k = 0; k < 6 * BODIES; ++k) {
        x[2 * k] *= square;
    }
}

/* Subtracts reactions in equilibrium with each other from the wrenches of the joints and the amounts of the columns. */
static void remove_stresses(const balance *own, real *x, real *amounts)
{
    int lane;
    int i;
    int k;
    for (k = 0; k < 2 * REDUNDANT; ++k) {
        const real *stress = own->stress[k / 2];
        real along = 0;
        lane = k % 2;
        for (i = 0; i < 6 * BODIES; ++i) {
            along += stress[i] * x[2 * i + lane];
        }
        for (i = 0; i < COLUMNS; ++i) {
            along += stress[6 * BODIES + i] * amounts[2 * i + lane];
        }
        for (i = 0; i < 6 * BODIES; ++i) {
            x[2 * i + lane] -= along * stress[i];
        }
        for (i = 0; i < COLUMNS; ++i) {
            amounts[2 * i + lane] -= along * stress[6 * BODIES + i];
        }
    }
}

/* Adds the products of two vectors: of the first with itself, of both, of the second with itself. Two sums for each,
   because an addition waits for the one before it. */
static void multiply(const real *x, int count, real *products)
{
    real a = 0;
    real b = 0;
    real c = 0;
    real d = 0;
    real e = 0;
    real f = 0;
    int k;
    for (k = 0; k + 3 < 2 * count; k += 4) {
        a += x[k] * x[k];
        b += x[k] * x[k + 1];
        c += x[k + 1] * x[k + 1];
        d += x[k + 2] * x[k + 2];
        e += x[k + 2] * x[k + 3];
        f += x[k + 3] * x[k + 3];
    }
    if (k < 2 * count) {
        a += x[k] * x[k];
        b += x[k] * x[k + 1];
        c += x[k + 1] * x[k + 1];
    }
    products[0] += a + d;
    products[1] += b + e;
    products[2] += c + f;
}

/* Finds the reactions in equilibrium with each other, and the local passive degrees of freedom. */
static void find_null_vectors(balance *own)
{
    real x[WIDTH * (BODIES + 1)];
    real amounts[2 * ROOM(COLUMNS)];
    int k;
    int n;
    for (n = 0; n < REDUNDANT + SPINS; ++n) {
        const int is_stress = n < REDUNDANT;
        const int column = is_stress ? own->column[MOTIONS + n] : COLUMNS - SPINS + n - REDUNDANT;
        real *found = is_stress ? own->stress[n] : own->spin[n - REDUNDANT];
        for (k = 0; k < WIDTH * (BODIES + 1); ++k) {
            x[k] = 0;
        }
        for (k = 0; k < 2 * COLUMNS; ++k) {
            amounts[k] = 0;
        }
        amounts[2 * column] = -1;
        if (is_stress) {
            add_terms(own, amounts, x);
            carry(own, x, amounts);
            amounts[2 * column] += 1;
            for (k = 0; k < COLUMNS; ++k) {
                found[6 * BODIES + k] = amounts[2 * k];
            }
        } else {
            move(own, x, amounts);
        }
        for (k = 0; k < 6 * BODIES; ++k) {
            found[k] = x[WIDTH + 2 * k];
        }
        if (is_stress) {
            normalise(found, own->stress[0], n, 6 * BODIES + COLUMNS);
        } else {
            normalise(found, own->spin[0], n - REDUNDANT, 6 * BODIES);
        }
    }
}

/* Makes both vectors orthogonal to local passive degrees of freedom and to each other, of unit length. */
static void make_orthonormal(const balance *own, real *x)
{
    int lane;
    int k;
    for (lane = 0; lane < 2; ++lane) {
        real square = 0;
        real along = 0;
        for (k = 0; k < SPINS; ++k) {
            subtract(x + lane, own->spin[k], 2, 6 * BODIES);
        }
        for (k = 0; lane > 0 && k < 6 * BODIES; ++k) {
            along += x[2 * k] * x[2 * k + 1];
        }
        for (k = 0; k < 6 * BODIES; ++k) {
            x[2 * k + lane] -= along * x[2 * k];
            square += x[2 * k + lane] * x[2 * k + lane];
        }
        square = 1 / sqrt@F@(square);
        for (k = 0; k < 6 * BODIES; ++k) {
            x[2 * k + lane] *= square;
        }
    }
}

/* Replaces the second vector by one without any pattern. */
static void renew(const balance *own, real *x, int pattern)
{
    int k;
    for (k = 0; k < 6 * BODIES; ++k) {
        x[2 * k + 1] = without_pattern(k + pattern);
    }
    make_orthonormal(own, x);
}

/* Improves two unit vectors of least resistance by a step of inverse iteration, of which the first has the lower
   resistance. Returns the square of this resistance; sets `aligned` to 1 if the first vector has hardly turned and the
   second has hardly lowered the resistance. */
static real improve(const balance *own, real *x, int *aligned)
{
    real bodies[WIDTH * (BODIES + 1)];
    /* Zeros for compilers, which see uninitialized numbers where an open chain has no columns. */
    real amounts[2 * ROOM(COLUMNS)] = { 0 };
    /* Products of the iterates and of A transposed times the iterates. */
    real moved[3] = { 0, 0, 0 };
    real resisted[3] = { 0, 0, 0 };
    real second;
    real along;
    real least;
    real before;
    int is_second;
    int k;
    for (k = 0; k < WIDTH; ++k) {
        bodies[k] = 0;
    }
    for (k = 0; k < WIDTH * BODIES; ++k) {
        bodies[WIDTH + k] = x[k];
    }
    shift(bodies, own->centre, 1, 0, 6);
    carry(own, bodies, amounts);
    for (k = 2 * (COLUMNS - SPINS); k < 2 * COLUMNS; ++k) {
        amounts[k] = 0;
    }
    remove_stresses(own, bodies + WIDTH, amounts);
    multiply(bodies + WIDTH, 6 * BODIES, resisted);
    multiply(amounts, COLUMNS, resisted);
    move(own, bodies, amounts);
    for (k = 0; k < WIDTH * BODIES; ++k) {
        x[k] = bodies[WIDTH + k];
    }
    for (k = 0; k < SPINS; ++k) {
        subtract(x, own->spin[k], 2, 6 * BODIES);
        subtract(x + 1, own->spin[k], 2, 6 * BODIES);
    }
    multiply(x, 6 * BODIES, moved);
    *aligned = moved[0] / (resisted[0] * resisted[0]) - 1 <= ALIGNED;
    along = moved[1] / moved[0];
    second = moved[2] - along * moved[1];
    least = resisted[0] / moved[0];
    if (second > PARALLEL * moved[2]) {
        /* Principal axes of A times its transpose in the plane of both iterates. */
        const real a = 1 / sqrt@F@(moved[0]);
        const real b = 1 / sqrt@F@(second);
        const real mixed = (resisted[1] - along * resisted[0]) * a * b;
        const real other =
            (resisted[2] - 2 * along * resisted[1] + along * along * resisted[0]) * b * b;
        real tangent = 0;
        real cosine;
        real sine;
        /* Both axes, as parts of both iterates. */
        real axes[2][2];
        if (mixed != 0) {
            const real ratio = (other - least) / (2 * mixed);
            tangent = (ratio < 0 ? -1 : 1) / (fabs@F@(ratio) + sqrt@F@(1 + ratio * ratio));
        }
        before = least;
        is_second = other + tangent * mixed < least - tangent * mixed;
        least = is_second ? other + tangent * mixed : least - tangent * mixed;
        *aligned = *aligned && before - least <= LOWERED * least;
        cosine = 1 / sqrt@F@(1 + tangent * tangent);
        sine = tangent * cosine;
        axes[is_second][0] = cosine * a + sine * b * along;
        axes[is_second][1] = -sine * b;
        axes[1 - is_second][0] = sine * a - cosine * b * along;
        axes[1 - is_second][1] = cosine * b;
        for (k = 0; k < 6 * BODIES; ++k) {
            const real u = axes[0][0] * x[2 * k] + axes[0][1] * x[2 * k + 1];
            const real v = axes[1][0] * x[2 * k] + axes[1][1] * x[2 * k + 1];
            x[2 * k] = u;
            x[2 * k + 1] = v;
        }
    } else {
        renew(own, x, 0);
    }
    return least;
}

/* Finds the singularity index from the positions after `prepare`, starting from the vectors of the last call. */
static void find_index(const real *places, @NAME@_state *warm, @NAME@_info *info)
{
    balance own;
    real square = 0;
    int aligned = 0;
    int least_passes = 0;
    int k;
    info->singularity_index = 0;
    info->index_passes = 0;
    if (!invert(places, &own)) {
        return;
    }
    find_null_vectors(&own);
    /* Motions with a symmetry keep vectors with this symmetry: a small part of a vector without any finds the others. */
    for (k = 0; k < 6 * BODIES; k += 5) {
        warm->weakest[2 * k + 1] += without_pattern(k) / 8;
    }
    if (SPINS > 0) {
        make_orthonormal(&own, warm->weakest);
    }
    while (info->index_passes < MOST_PASSES && (!aligned || info->index_passes < least_passes)) {
        square = improve(&own, warm->weakest, &aligned);
        ++info->index_passes;
        /* If both first vectors are almost orthogonal to the weakest one, the search hardly turns at another one. After
           a long way, it therefore goes as far again with another second vector. */
        if (aligned && least_passes == 0 && info->index_passes > FEW_PASSES) {
            renew(&own, warm->weakest, WIDTH * BODIES);
            least_passes = 2 * info->index_passes;
        }
    }
    if (square > 0 && is_finite(square)) {
        info->singularity_index = sqrt@F@(square);
    } else {
        fill(warm->weakest);
    }
}
