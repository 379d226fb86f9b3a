/* Answers the states of a file: positions, rates and accelerations in; code, determinant with friction
   and efforts out. */
#include "NAME.h"
#include <stdio.h>

#define COUNT UPPER_COORDINATES
#define DRIVES UPPER_ACTUATORS

int main(void)
{
    double row[3 * COUNT], result[2 + DRIVES];
    long rows = 0;
    FILE *states = fopen("states.bin", "rb");
    FILE *answers = fopen("answers.bin", "wb");
    if (states == NULL || answers == NULL) {
        return 2;
    }
    while (fread(row, sizeof row[0], 3 * COUNT, states) == 3 * COUNT) {
        NAME_state state;
        NAME_real q[COUNT], qd[COUNT], qdd[COUNT], tau[DRIVES];
        NAME_info info = { 0 };
        int code, k;
        for (k = 0; k < COUNT; ++k) {
            q[k] = (NAME_real)row[k];
            qd[k] = (NAME_real)row[COUNT + k];
            qdd[k] = (NAME_real)row[2 * COUNT + k];
        }
        for (k = 0; k < DRIVES; ++k) {
            tau[k] = 0;
        }
        code = NAME_init(&state, q);
        if (code == UPPER_OK) {
            code = NAME_ff(0, &state, q, qd, qdd, tau, &info);
        }
        result[0] = code;
        result[1] = (double)info.coupling;
        for (k = 0; k < DRIVES; ++k) {
            result[2 + k] = (double)tau[k];
        }
        if (fwrite(result, sizeof result[0], 2 + DRIVES, answers) != 2 + DRIVES) {
            return 2;
        }
        ++rows;
    }
    fclose(states);
    printf("%ld rows\n", rows);
    return fclose(answers) != 0;
}
