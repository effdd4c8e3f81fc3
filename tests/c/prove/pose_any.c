/**
 * \file pose_any.c
 * \brief Stands for a joint's pose where the joint is proven: any pose. pose.c proves the pose itself.
 */
#include "anything.h"
#include POSE_HEADER

int POSE_TIP(const POSE_ANGLES *angles, POSE_TYPE *pose) {
    (void)angles;
    Frama_C_make_unknown((char *)pose, sizeof *pose);
    return CCGEN_OK;
}
