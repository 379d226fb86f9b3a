/*
 * Sine and cosine, at most 2 units in the last place for |x| <= 1e4: the remainder after quarter
 * turns, with its rounding error, and power series about zero. Always in double precision.
 */
static void @NAME@_sin_cos(real x, real *sine, real *cosine)
{
    const double angle = (double)x;
    const double turns = angle * @QUARTERS@;
    /* Beyond the range of the reduction the results are inexact, but between -1 and 1. Those of NaN are NaN. */
    const double bounded = turns < 1e9 ? (turns > -1e9 ? turns : -1e9) : 1e9;
    const long n = (long)(bounded < 0 ? bounded - 0.5 : bounded + 0.5);
    const double count = (double)n;
    const double first = (angle - count * @QUARTER_1@);
    const double step = count * @QUARTER_2@;
    const double main_part = first - step;
    const double rest = ((first - main_part) - step) - count * @QUARTER_3@;
    const double within = main_part > 1.0 ? 1.0 : (main_part < -1.0 ? -1.0 : main_part);
    const double z = within * within;
    const double s3 = @SINE@;
    const double c4 = @COSINE@;
    const double half = 0.5 * z;
    const double near_one = 1.0 - half;
    const double s = within - (z * within * s3 - rest * near_one);
    const double c = near_one + (((1.0 - near_one) - half) + (z * z * c4 - within * rest));
    switch (n & 3) {
    case 0:
        *sine = (real)s;
        *cosine = (real)c;
        break;
    case 1:
        *sine = (real)c;
        *cosine = (real)-s;
        break;
    case 2:
        *sine = (real)-s;
        *cosine = (real)-c;
        break;
    default:
        *sine = (real)-c;
        *cosine = (real)s;
        break;
    }
}

