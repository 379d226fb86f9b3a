/* Forward dynamics of two massless links with a point mass, near positions in which their mass matrix is singular. */
#include "NAME.h"
#include <math.h>
#include <stdio.h>

int main(void)
{
    static const double turned[] = { 0, 1e-12, 1e-8, 1e-6, 1e-4, 1e-3, 0.1, 1 };
    static const double straight[] = { 0, 3.14159265358979323846 };
    int failures = 0;
    unsigned side, k, i;
    for (side = 0; side < 2; ++side) {
        for (k = 0; k < sizeof turned / sizeof turned[0]; ++k) {
            const double elbow = straight[side] + turned[k];
            const NAME_real q[2] = { (NAME_real)0.3, (NAME_real)elbow };
            const NAME_real qd[2] = { (NAME_real)0.7, (NAME_real)-0.4 };
            const NAME_real tau[2] = { 1, (NAME_real)0.5 };
            NAME_real qdd[2] = { 7, 7 }, again[2];
            /* Square of the sine: the determinant of the matrix over the product of its rows and columns, but for a
               factor near 1. */
            const double pivot = sin(elbow) * sin(elbow);
            const double inexact = sizeof(NAME_real) == sizeof(double) ? 1e-11 : 1e-4;
            NAME_state state;
            NAME_info info;
            int code = NAME_init(&state, q);
            if (code != UPPER_OK) {
                printf("no start: %d\n", code);
                return 1;
            }
            code = NAME_accelerations(0, &state, q, qd, tau, qdd, &info);
            if (pivot < inexact / 10 && (code != UPPER_SINGULAR || qdd[0] != 7 || qdd[1] != 7)) {
                printf("elbow %g: code %d, %g %g\n", elbow, code, (double)qdd[0], (double)qdd[1]);
                ++failures;
            }
            if (pivot > inexact * 10) {
                double apart = 0;
                if (code != UPPER_OK || NAME_ff(0, &state, q, qd, qdd, again, &info) < 0) {
                    printf("elbow %g: code %d\n", elbow, code);
                    ++failures;
                    continue;
                }
                for (i = 0; i < 2; ++i) {
                    apart = fmax(apart, fabs((double)again[i] - (double)tau[i]));
                }
                /* The rounding of large accelerations cancels in the efforts. */
                if (!(apart <= inexact / pivot)) {
                    printf("elbow %g: efforts off by %g\n", elbow, apart);
                    ++failures;
                }
            }
        }
    }
    printf("%d failures\n", failures);
    return failures != 0;
}
