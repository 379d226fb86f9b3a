/* Compares sine and cosine of the code with those of the library in a wider format. */
/* The code is linked, too: its functions have other names here. */
#define NAME_defaults included_defaults
#define NAME_identity included_identity
#define NAME_init included_init
#define NAME_ff included_ff
#define NAME_ff_towards included_ff_towards
#define NAME_hold included_hold
#include "NAME.c"
#include <stdio.h>

static double units_apart(double found, long double expected)
{
    int exponent;
    (void)frexpl(expected, &exponent);
    return (double)(fabsl((long double)found - expected) / ldexpl(1.0L, exponent - 53));
}

static double check(double x)
{
    double sine, cosine, a, b;
    NAME_sin_cos(x, &sine, &cosine);
    a = units_apart(sine, sinl((long double)x));
    b = units_apart(cosine, cosl((long double)x));
    return a > b ? a : b;
}

int main(void)
{
    unsigned long long state = 1;
    double worst = 0;
    int k;
    if (sizeof(long double) <= sizeof(double)) {
        return 0;
    }
    for (k = 0; k < 2000000; ++k) {
        double x, error;
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        x = ((double)(state >> 11) / 9007199254740992.0 * 2 - 1) * 1e4;
        /* Many magnitudes, and near multiples of quarter turns, where digits cancel. */
        if (k % 3 == 1) {
            x = ldexp(x, -(k % 40));
        } else if (k % 3 == 2) {
            x = floor(x * 0.6366197723675814) * 1.5707963267948966;
            if (fabs(x) > 1e4) {
                continue;
            }
        }
        error = check(x);
        if (error > worst) {
            worst = error;
        }
    }
    printf("%g units in the last place\n", worst);
    return worst <= 2.0 ? 0 : 1;
}
