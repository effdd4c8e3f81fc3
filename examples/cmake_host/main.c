/*
 * Reads snapshots from standard input, one a line, as six counts (u sensors, then v sensors), and
 * prints the bending of every segment in degrees and the tip's position in metres.
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>

#include "shoulder.h"
#include "shoulder_kinematics.h"

#define DEGREES_PER_RADIAN 57.29578f

static bool read_axis(shoulder_count_t *counts, int sensors) {
    for (int j = 0; j < sensors; ++j) {
        if (scanf("%" SCNd16, &counts[j]) != 1) {
            return false;
        }
    }
    return true;
}

static void print_axis(const char *axis, const shoulder_angle_t *angles, float radians_per_step) {
    printf("%s", axis);
    for (int i = 0; i < SHOULDER_SEGMENTS; ++i) {
        printf(" %.4f", (double)((float)angles[i] * radians_per_step * DEGREES_PER_RADIAN));
    }
    printf("\n");
}

static void print_tip(const shoulder_pose_t *tip) {
    printf("tip %.5f %.5f %.5f\n", (double)tip->position[0], (double)tip->position[1],
        (double)tip->position[2]);
}

int main(void) {
    shoulder_t joint;
    shoulder_counts_t counts;
    shoulder_init(&joint);
    while (read_axis(counts.u, SHOULDER_SENSORS_U) && read_axis(counts.v, SHOULDER_SENSORS_V)) {
        shoulder_angles_t angles;
        shoulder_pose_t tip;
        if (shoulder_estimate(&joint, &counts, &angles) != CCGEN_OK) {
            printf("missing sensors: mask %d\n", (int)shoulder_missing(&joint, &counts));
            continue;
        }
        print_axis("u", angles.u, SHOULDER_RADIANS_PER_STEP_U);
        print_axis("v", angles.v, SHOULDER_RADIANS_PER_STEP_V);
        shoulder_tip_pose(&angles, &tip);
        print_tip(&tip);
    }
    return 0;
}
