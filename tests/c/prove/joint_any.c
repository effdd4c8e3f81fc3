/**
 * \file joint_any.c
 * \brief Stands for the estimator of a joint where its node is proven: any angles, any zero, any
 * result. estimator.c proves the estimator itself.
 */
#include "joint_any.h"

static int any_result(void) {
    int result;
    Frama_C_make_unknown((char *)&result, sizeof result);
    return result;
}

static void read_all(const port_counts_t *const counts) {
    port_count_t list[PORT_SENSORS];
    port_pack_counts(counts, list);
}

static int any_change(port_joint_t *const joint) {
    any_joint(joint);
    return any_result();
}

int OF_JOINT(init)(port_joint_t *const joint) {
    return any_change(joint);
}

int OF_JOINT(restore_model)(port_joint_t *const joint) {
    return any_change(joint);
}

int OF_JOINT(restore_last)(port_joint_t *const joint) {
    return any_change(joint);
}

int OF_JOINT(capture_zero)(port_joint_t *const joint, const port_counts_t *const counts) {
    read_all(counts);
    return any_change(joint);
}

int OF_JOINT(estimate)(const port_joint_t *const joint, const port_counts_t *const counts,
                       port_angles_t *const angles) {
    (void)joint;
    read_all(counts);
    Frama_C_make_unknown((char *)angles, sizeof *angles);
    return any_result();
}

int OF_JOINT(follow)(port_joint_t *const joint, const port_counts_t *const counts,
                     port_angles_t *const angles) {
    const int result = OF_JOINT(estimate)(joint, counts, angles);
    any_joint(joint);
    return result;
}

int32_t OF_JOINT(missing)(const port_joint_t *const joint, const port_counts_t *const counts) {
    (void)joint;
    int32_t mask;
    read_all(counts);
    Frama_C_make_unknown((char *)&mask, sizeof mask);
    return mask;
}
