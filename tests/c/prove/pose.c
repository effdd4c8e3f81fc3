/**
 * \file pose.c
 * \brief Proof driver: the arithmetic of a joint's pose meets any angles without a fault, from any
 * frame whose axes are as long as the exporter's induction over the segments shows: at most 1.01.
 */
#include POSE_SOURCE

#include "anything.h"

#define LONGEST ((int32_t)ONE / 100 * 101)

int main(void);

int main(void) {
    int32_t frame[9];
    int32_t distal[9];
    int32_t chord[3];
    int32_t sums[3] = {0};
    int32_t position[3];
    POSE_ANGLE u;
    POSE_ANGLE v;
    for (int segment = 0; segment < SEGMENTS; ++segment) {
        for (int k = 0; k < 9; ++k) {
            frame[k] = (int32_t)Frama_C_long_interval(-LONGEST, LONGEST);
        }
        Frama_C_make_unknown((char *)&u, sizeof u);
        Frama_C_make_unknown((char *)&v, sizeof v);
        //@ split u < 0;
        //@ split v < 0;
        turn(frame, u, v, distal, chord);
        //@ merge u < 0;
        //@ merge v < 0;
        for (int k = 0; k < 3; ++k) {
            sums[k] += chord[k];
        }
    }
    place(sums, position);
    return 0;
}
