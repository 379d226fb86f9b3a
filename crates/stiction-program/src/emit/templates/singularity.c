/* Singularity index: smallest singular value of the dimensionless balance A of all bodies, by inverse iteration with
   two vectors. Along the joints of a spanning tree, A x = y and its transpose are solved by recursion; a dense system
   has one unknown for each free motion of these joints, and one row for each column, which is an unknown of a joint
   that closes a loop, or of a gearing. Two vectors with six components for each body are stored alternately. */
#define BODIES @BODIES@
#define MOTIONS @MOTIONS@
#define COLUMNS @COLUMNS@
#define TERMS @TERMS@
/* Number of redundant columns; number of columns that resist local passive degrees of freedom. */
#define REDUNDANT @REDUNDANT@
#define SPINS @SPINS@
/* Size of an array, at least one. */
#define ROOM(count) ((count) > 0 ? (count) : 1)
#define FIRST_PLACE @FIRST_PLACE@
#define MOST_PASSES @INDEX_PASSES@
/* Number of components of a body in a pair of vectors. */
#define WIDTH 12

/* Square of the sine of the angle between a vector and its next iterate, at convergence. */
static const real ALIGNED = @ALIGNED@;
/* Fraction of the square of a vector up to which its remainder after orthogonalisation is a rounding error. */
static const real PARALLEL = @PARALLEL@;
/* Index up to which a position is singular; relative determinant from which the index is not needed. */
static const real LEAST_INDEX = @LEAST_INDEX@;
static const real SMALL_DETERMINANT = @SMALL_DETERMINANT@;

/* Place of the parent of each body in the tree; place 0 is the ground. */
static const short PARENT[BODIES + 1] = { @PARENT@ };
/* Place of the first body that each free motion moves. */
static const short MOVES[ROOM(MOTIONS)] = { @MOVES@ };
/* Column of each term, and the places of the two bodies on which it acts, in opposite directions. */
static const short COLUMN_OF[ROOM(TERMS)] = { @COLUMN_OF@ };
static const short ON[ROOM(TERMS)][2] = { @ON@ };
/* Sign with which each term does work in each free motion; 0 for none. */
static const signed char SIGN[ROOM(MOTIONS)][ROOM(TERMS)] = {
@SIGN@};

/* Data of a state with its decomposed dense system. */
typedef struct {
    /* Centres of mass, origins of the joints, free motions, and terms; the last two have six components each. */
    const real *centre;
    const real *origin;
    const real *motion;
    const real *term;
    /* Triangular factors with reciprocal pivots, and the column of each row. */
    real factors[ROOM(COLUMNS)][ROOM(MOTIONS)];
    int column[ROOM(COLUMNS)];
    /* Orthonormal self-stresses, and orthonormal local passive degrees of freedom. */
    real stress[ROOM(REDUNDANT)][6 * BODIES + COLUMNS];
    real spin[ROOM(SPINS)][6 * BODIES];
} balance;

/* Adds `by` times the product of r and each of two vectors. */
static void add_cross(const real *r, const real *x, real by, real *sum)
{
    int lane;
    for (lane = 0; lane < 2; ++lane) {
        sum[lane] += by * (r[1] * x[4 + lane] - r[2] * x[2 + lane]);
        sum[2 + lane] += by * (r[2] * x[lane] - r[0] * x[4 + lane]);
        sum[4 + lane] += by * (r[0] * x[2 + lane] - r[1] * x[lane]);
    }
}

/* Assembles and decomposes the dense system; returns 0 if it is singular. */
static int decompose(const real *places, balance *own)
{
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
            own->factors[k][i] = 0;
        }
    }
    for (i = 0; i < MOTIONS; ++i) {
        const real *s = own->motion + 6 * i;
        for (k = 0; k < TERMS; ++k) {
            const real *w = own->term + 6 * k;
            if (SIGN[i][k] != 0) {
                own->factors[COLUMN_OF[k]][i] += (real)SIGN[i][k]
                    * (s[0] * w[0] + s[1] * w[1] + s[2] * w[2] + s[3] * w[3] + s[4] * w[4]
                        + s[5] * w[5]);
            }
        }
    }
    for (k = 0; k < MOTIONS; ++k) {
        real most = 0;
        int row = k;
        const real *pivot = own->factors[k];
        for (i = k; i < COLUMNS; ++i) {
            const real size = fabs@F@(own->factors[i][k]);
            if (size > most) {
                most = size;
                row = i;
            }
        }
        if (!(most > 0) || !is_finite(most)) {
            return 0;
        }
        if (row != k) {
            const int column = own->column[row];
            own->column[row] = own->column[k];
            own->column[k] = column;
            for (j = 0; j < MOTIONS; ++j) {
                const real value = own->factors[row][j];
                own->factors[row][j] = own->factors[k][j];
                own->factors[k][j] = value;
            }
        }
        own->factors[k][k] = 1 / own->factors[k][k];
        for (i = k + 1; i < COLUMNS; ++i) {
            if (own->factors[i][k] != 0) {
                const real factor = own->factors[i][k] * pivot[k];
                own->factors[i][k] = factor;
                for (j = k + 1; j < MOTIONS; ++j) {
                    own->factors[i][j] -= factor * pivot[j];
                }
            }
        }
    }
    return 1;
}

/* Adds the wrenches of all columns, in these amounts, to those on the bodies. */
static void add_terms(const balance *own, const real *amounts, real *sum)
{
    int i;
    int k;
    for (k = 0; k < TERMS; ++k) {
        const real *w = own->term + 6 * k;
        const real first = amounts[2 * COLUMN_OF[k]];
        const real second = amounts[2 * COLUMN_OF[k] + 1];
        real *a = sum + WIDTH * ON[k][0];
        real *b = sum + WIDTH * ON[k][1];
        for (i = 0; i < 6; ++i) {
            a[2 * i] += first * w[i];
            a[2 * i + 1] += second * w[i];
            b[2 * i] -= first * w[i];
            b[2 * i + 1] -= second * w[i];
        }
    }
}

/* Adds the wrenches on all outer bodies to those on each body, from the tips to the ground. */
static void gather(real *x)
{
    int k;
    int i;
    for (k = BODIES; k > 0; --k) {
        for (i = 0; i < WIDTH; ++i) {
            x[WIDTH * PARENT[k] + i] += x[WIDTH * k + i];
        }
    }
}

/* Adds the motion of its parent to that of each body, from the ground to the tips. */
static void spread(real *x)
{
    int k;
    int i;
    for (i = 0; i < WIDTH; ++i) {
        x[i] = 0;
    }
    for (k = 1; k <= BODIES; ++k) {
        for (i = 0; i < WIDTH; ++i) {
            x[WIDTH * k + i] += x[WIDTH * PARENT[k] + i];
        }
    }
}

/* Solves A x = y. On entry, `x` contains the wrenches on the bodies about the reference point; on return, those of the
   joints of the tree about their origins, and `amounts` those of the columns. */
static void carry(const balance *own, real *x, real *amounts)
{
    real rest[WIDTH * (BODIES + 1)];
    real right[2 * ROOM(MOTIONS)];
    int i;
    int k;
    gather(x);
    for (i = 0; i < MOTIONS; ++i) {
        const real *s = own->motion + 6 * i;
        const real *f = x + WIDTH * MOVES[i];
        right[2 * i] = 0;
        right[2 * i + 1] = 0;
        for (k = 0; k < 6; ++k) {
            right[2 * i] += s[k] * f[2 * k];
            right[2 * i + 1] += s[k] * f[2 * k + 1];
        }
    }
    for (k = 0; k < MOTIONS; ++k) {
        right[2 * k] *= own->factors[k][k];
        right[2 * k + 1] *= own->factors[k][k];
        for (i = k + 1; i < MOTIONS; ++i) {
            right[2 * i] -= own->factors[k][i] * right[2 * k];
            right[2 * i + 1] -= own->factors[k][i] * right[2 * k + 1];
        }
    }
    for (k = MOTIONS - 1; k > 0; --k) {
        for (i = 0; i < k; ++i) {
            right[2 * i] -= own->factors[k][i] * right[2 * k];
            right[2 * i + 1] -= own->factors[k][i] * right[2 * k + 1];
        }
    }
    for (k = 0; k < COLUMNS; ++k) {
        amounts[2 * own->column[k]] = k < MOTIONS ? right[2 * k] : 0;
        amounts[2 * own->column[k] + 1] = k < MOTIONS ? right[2 * k + 1] : 0;
    }
    for (k = 0; k < WIDTH * (BODIES + 1); ++k) {
        rest[k] = 0;
    }
    add_terms(own, amounts, rest);
    gather(rest);
    for (k = 1; k <= BODIES; ++k) {
        for (i = WIDTH * k; i < WIDTH * (k + 1); ++i) {
            x[i] -= rest[i];
        }
        add_cross(own->origin + 3 * (k - 1), x + WIDTH * k, -1, x + WIDTH * k + 6);
    }
}

/* Solves the transposed system. On entry, `x` contains the motions of the joints of the tree about their origins, and
   `amounts` those of the columns; on return, `x` contains the motions of the bodies about their centres of mass. */
static void move(const balance *own, real *x, const real *amounts)
{
    real rest[WIDTH * (BODIES + 1)];
    real left[2 * ROOM(COLUMNS)];
    real right[2 * ROOM(MOTIONS)];
    int i;
    int k;
    for (k = 1; k <= BODIES; ++k) {
        add_cross(own->origin + 3 * (k - 1), x + WIDTH * k + 6, 1, x + WIDTH * k);
    }
    spread(x);
    for (k = 0; k < 2 * COLUMNS; ++k) {
        left[k] = amounts[k];
    }
    for (k = 0; k < TERMS; ++k) {
        const real *w = own->term + 6 * k;
        const real *a = x + WIDTH * ON[k][0];
        const real *b = x + WIDTH * ON[k][1];
        for (i = 0; i < 6; ++i) {
            left[2 * COLUMN_OF[k]] -= w[i] * (a[2 * i] - b[2 * i]);
            left[2 * COLUMN_OF[k] + 1] -= w[i] * (a[2 * i + 1] - b[2 * i + 1]);
        }
    }
    for (k = 0; k < MOTIONS; ++k) {
        right[2 * k] = left[2 * own->column[k]];
        right[2 * k + 1] = left[2 * own->column[k] + 1];
        for (i = 0; i < k; ++i) {
            right[2 * k] -= own->factors[k][i] * right[2 * i];
            right[2 * k + 1] -= own->factors[k][i] * right[2 * i + 1];
        }
    }
    for (k = 0; k < WIDTH * (BODIES + 1); ++k) {
        rest[k] = 0;
    }
    for (k = MOTIONS - 1; k >= 0; --k) {
        const real *s = own->motion + 6 * k;
        real *moved = rest + WIDTH * MOVES[k];
        for (i = k + 1; i < MOTIONS; ++i) {
            right[2 * k] -= own->factors[k][i] * right[2 * i];
            right[2 * k + 1] -= own->factors[k][i] * right[2 * i + 1];
        }
        right[2 * k] *= own->factors[k][k];
        right[2 * k + 1] *= own->factors[k][k];
        for (i = 0; i < 6; ++i) {
            moved[2 * i] += s[i] * right[2 * k];
            moved[2 * i + 1] += s[i] * right[2 * k + 1];
        }
    }
    spread(rest);
    for (k = 1; k <= BODIES; ++k) {
        for (i = WIDTH * k; i < WIDTH * (k + 1); ++i) {
            x[i] += rest[i];
        }
        add_cross(own->centre + 3 * (k - 1), x + WIDTH * k + 6, -1, x + WIDTH * k);
    }
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

/* Fills a vector with numbers that have no symmetry. */
static void fill(real *x, int stride, int count)
{
    unsigned long seed = 1;
    int k;
    for (k = 0; k < count; ++k) {
        seed = (seed * 1664525u + 1013904223u) & 0xffffffffu;
        x[stride * k] = (real)((seed >> 16) & 0xffffu) / 65536 - (real)0.5;
    }
}

/* Subtracts the self-stresses from the wrenches of the joints and the amounts of the columns. */
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

/* Adds the inner products of two vectors: first with first, first with second, second with second. */
static void multiply(const real *x, int count, real *products)
{
    int k;
    for (k = 0; k < 2 * count; k += 2) {
        products[0] += x[k] * x[k];
        products[1] += x[k] * x[k + 1];
        products[2] += x[k + 1] * x[k + 1];
    }
}

/* Computes the self-stresses and the local passive degrees of freedom. */
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

/* Makes both vectors orthogonal to the local passive degrees of freedom and to each other, with unit length. */
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

/* Improves the two unit vectors of least resistance by a step of inverse iteration; the first has the lower resistance.
   Returns the square of this resistance; sets `aligned` to 1 if the first vector has hardly turned. */
static real improve(const balance *own, real *x, int *aligned)
{
    real bodies[WIDTH * (BODIES + 1)];
    real amounts[2 * ROOM(COLUMNS)];
    /* Inner products of the iterates, and of A transposed times the iterates. */
    real moved[3] = { 0, 0, 0 };
    real resisted[3] = { 0, 0, 0 };
    real second = 0;
    real along;
    real least;
    int k;
    for (k = 0; k < WIDTH; ++k) {
        bodies[k] = 0;
    }
    for (k = 0; k < WIDTH * BODIES; ++k) {
        bodies[WIDTH + k] = x[k];
    }
    for (k = 1; k <= BODIES; ++k) {
        add_cross(own->centre + 3 * (k - 1), bodies + WIDTH * k, 1, bodies + WIDTH * k + 6);
    }
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
    for (k = 0; k < 6 * BODIES; ++k) {
        x[2 * k + 1] -= along * x[2 * k];
        second += x[2 * k + 1] * x[2 * k + 1];
    }
    least = resisted[0] / moved[0];
    if (second > PARALLEL * moved[2]) {
        /* Principal axes of A times its transpose in the plane of both iterates (Rayleigh-Ritz). */
        const real a = 1 / sqrt@F@(moved[0]);
        const real b = 1 / sqrt@F@(second);
        const real mixed = (resisted[1] - along * resisted[0]) * a * b;
        const real other =
            (resisted[2] - 2 * along * resisted[1] + along * along * resisted[0]) * b * b;
        real tangent = 0;
        real cosine;
        real sine;
        int is_second;
        if (mixed != 0) {
            const real ratio = (other - least) / (2 * mixed);
            tangent = (ratio < 0 ? -1 : 1) / (fabs@F@(ratio) + sqrt@F@(1 + ratio * ratio));
        }
        is_second = other + tangent * mixed < least - tangent * mixed;
        least = is_second ? other + tangent * mixed : least - tangent * mixed;
        cosine = 1 / sqrt@F@(1 + tangent * tangent);
        sine = tangent * cosine;
        for (k = 0; k < 6 * BODIES; ++k) {
            const real u = a * x[2 * k];
            const real v = b * x[2 * k + 1];
            x[2 * k + is_second] = cosine * u - sine * v;
            x[2 * k + 1 - is_second] = sine * u + cosine * v;
        }
    } else {
        fill(x + 1, 2, 6 * BODIES);
        make_orthonormal(own, x);
    }
    return least;
}

/* Computes the singularity index from the results of `prepare`, starting from the vectors of the last call. */
static void find_index(const real *places, @NAME@_state *warm, @NAME@_info *info)
{
    balance own;
    real added[6 * BODIES];
    real square = 0;
    int aligned = 0;
    int k;
    info->singularity_index = 0;
    info->index_passes = 0;
    if (!decompose(places, &own)) {
        return;
    }
    find_null_vectors(&own);
    /* Symmetric motions preserve a symmetry of the vectors: a small part without symmetry finds the others. */
    fill(added, 1, 6 * BODIES);
    for (k = 0; k < 6 * BODIES; ++k) {
        warm->weakest[2 * k + 1] += added[k] / 32;
    }
    make_orthonormal(&own, warm->weakest);
    while (info->index_passes < MOST_PASSES && !aligned) {
        square = improve(&own, warm->weakest, &aligned);
        ++info->index_passes;
    }
    if (square > 0 && is_finite(square)) {
        info->singularity_index = sqrt@F@(square);
    }
    if (!are_finite(warm->weakest, WIDTH * BODIES)) {
        fill(warm->weakest, 1, WIDTH * BODIES);
    }
}
