/*
 * Estimates one snapshot of the shoulder and prints the u angles, in steps.
 */
#include <stdio.h>

#include "shoulder.h"

void app_main(void) {
    static const shoulder_counts_t counts = {{1500, 1200, 900}, {0, 0, 0}};
    shoulder_t joint;
    shoulder_angles_t angles;
    if (shoulder_init(&joint) != CCGEN_OK ||
        shoulder_estimate(&joint, &counts, &angles) != CCGEN_OK) {
        printf("no estimate\n");
        return;
    }
    for (int i = 0; i < SHOULDER_SEGMENTS; ++i) {
        printf("%d\n", angles.u[i]);
    }
}
