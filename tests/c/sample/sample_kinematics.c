#include "sample_kinematics.h"

#include <stddef.h>

#define SEGMENT_LENGTH 0.02f
#define RADIANS_PER_STEP (1.0f / 262144.0f)

static const sample_pose_t base = {{{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}},
                                   {0.0f, 0.0f, 0.0f}};

/** One constant-curvature segment: a = sin(phi)/phi and b = (1 - cos(phi))/phi^2 as polynomials. */
static void segment_pose(const float u, const float v, sample_pose_t *const pose) {
    const float phi2 = u * u + v * v;
    const float a = 1.0f - phi2 * (1.0f / 6.0f) * (1.0f - phi2 * (1.0f / 20.0f));
    const float b = 0.5f - phi2 * (1.0f / 24.0f) * (1.0f - phi2 * (1.0f / 30.0f));
    const sample_pose_t result = {
        {{1.0f - b * v * v, b * u * v, a * v},
         {b * u * v, 1.0f - b * u * u, -a * u},
         {-a * v, a * u, 1.0f - b * phi2}},
        {SEGMENT_LENGTH * b * v, -SEGMENT_LENGTH * b * u, SEGMENT_LENGTH * a}};
    *pose = result;
}

static void compose(sample_pose_t *const pose, const sample_pose_t *const step) {
    const sample_pose_t from = *pose;
    for (uint8_t i = 0; i < 3u; ++i) {
        for (uint8_t j = 0; j < 3u; ++j) {
            pose->rotation[i][j] = from.rotation[i][0] * step->rotation[0][j] +
                                   from.rotation[i][1] * step->rotation[1][j] +
                                   from.rotation[i][2] * step->rotation[2][j];
        }
        pose->position[i] = from.position[i] + from.rotation[i][0] * step->position[0] +
                            from.rotation[i][1] * step->position[1] +
                            from.rotation[i][2] * step->position[2];
    }
}

int sample_segment_pose(const sample_angles_t *const angles, const uint16_t segment,
                        sample_pose_t *const pose) {
    if ((angles == NULL) || (pose == NULL) || (segment >= SAMPLE_SEGMENTS)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    *pose = base;
    for (uint16_t i = 0; i <= segment; ++i) {
        sample_pose_t step;
        segment_pose((float)angles->u[i] * RADIANS_PER_STEP, (float)angles->v[i] * RADIANS_PER_STEP,
                     &step);
        compose(pose, &step);
    }
    return CCGEN_OK;
}

int sample_tip_pose(const sample_angles_t *const angles, sample_pose_t *const pose) {
    return sample_segment_pose(angles, SAMPLE_SEGMENTS - 1, pose);
}

/** Rigid links hinged at each segment's base: close to the derivative for small angles. */
int sample_tip_jacobian(const sample_angles_t *const angles,
                        float jacobian[6][SAMPLE_VALUES]) {
    sample_pose_t tip;
    sample_pose_t hinge = base;
    if ((jacobian == NULL) || (sample_tip_pose(angles, &tip) != CCGEN_OK)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint16_t i = 0; i < SAMPLE_SEGMENTS; ++i) {
        for (uint16_t axis = 0; axis < 2u; ++axis) {
            const uint16_t column = (uint16_t)(axis * SAMPLE_SEGMENTS + i);
            for (uint16_t k = 0; k < 3u; ++k) {
                const uint16_t l = (uint16_t)((k + 1u) % 3u);
                const uint16_t m = (uint16_t)((k + 2u) % 3u);
                const float arm_l = tip.position[l] - hinge.position[l];
                const float arm_m = tip.position[m] - hinge.position[m];
                jacobian[k][column] =
                    hinge.rotation[l][axis] * arm_m - hinge.rotation[m][axis] * arm_l;
                jacobian[3u + k][column] = hinge.rotation[k][axis];
            }
        }
        (void)sample_segment_pose(angles, i, &hinge);
    }
    return CCGEN_OK;
}
