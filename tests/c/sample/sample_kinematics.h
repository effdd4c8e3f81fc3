/**
 * \file sample_kinematics.h
 * \brief Poses of the sample joint, written by hand: 12 segments of 20 mm.
 */
#ifndef SAMPLE_KINEMATICS_H
#define SAMPLE_KINEMATICS_H

#include "sample.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float rotation[3][3];
    float position[3];
} sample_pose_t;

int sample_segment_pose(const sample_angles_t *angles, uint16_t segment, sample_pose_t *pose);
int sample_tip_pose(const sample_angles_t *angles, sample_pose_t *pose);
int sample_tip_jacobian(const sample_angles_t *angles, float jacobian[6][SAMPLE_VALUES]);

#ifdef __cplusplus
}
#endif

#endif /* SAMPLE_KINEMATICS_H */
