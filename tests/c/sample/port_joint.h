/**
 * \file port_joint.h
 * \brief The sample joint under the names that the ports use.
 */
#ifndef PORT_JOINT_H
#define PORT_JOINT_H

#include "sample_can.h"

#define PORT_SEGMENTS SAMPLE_SEGMENTS
#define PORT_SENSORS SAMPLE_SENSORS
#define PORT_VALUES SAMPLE_VALUES
#define PORT_PRECISION SAMPLE_PRECISION
#define PORT_FUNCTION_WORDS 0
#define PORT_CYCLE_US SAMPLE_CYCLE_US
#define PORT_WINDOW_MAX_US SAMPLE_WINDOW_MAX_US

typedef sample_node_t port_node_t;
typedef sample_t port_joint_t;
typedef sample_count_t port_count_t;
typedef sample_angle_t port_angle_t;
typedef sample_counts_t port_counts_t;
typedef sample_angles_t port_angles_t;
typedef sample_pose_t port_pose_t;

/** Steps of 1. */
typedef struct {
    int32_t rotation[9];
    int32_t position[3];
} port_integer_pose_t;

static inline int port_node_init(port_node_t *node) {
    return sample_node_init(node);
}

static inline int port_node_receive(port_node_t *node, const ccgen_frame_t *frame,
                                    uint32_t now_us) {
    return sample_node_receive(node, frame, now_us);
}

static inline int port_node_transmit(port_node_t *node, uint32_t now_us, ccgen_frame_t *frame) {
    return sample_node_transmit(node, now_us, frame);
}

static inline int port_node_unsent(port_node_t *node) {
    return sample_node_unsent(node);
}

static inline int port_node_set_window(port_node_t *node, uint32_t window_us) {
    return sample_node_set_window(node, window_us);
}

static inline int port_init(port_joint_t *joint) {
    return sample_init(joint);
}

static inline int port_capture_zero(port_joint_t *joint, const port_counts_t *counts) {
    return sample_capture_zero(joint, counts);
}

static inline int port_restore_zero(port_joint_t *joint, const port_counts_t *zero) {
    return sample_restore_zero(joint, zero);
}

static inline int port_estimate(const port_joint_t *joint, const port_counts_t *counts,
                                port_angles_t *angles) {
    return sample_estimate(joint, counts, angles);
}

static inline int port_follow(port_joint_t *joint, const port_counts_t *counts,
                                port_angles_t *angles) {
    return sample_estimate(joint, counts, angles);
}

static inline int32_t port_missing(const port_joint_t *joint, const port_counts_t *counts) {
    return sample_missing(joint, counts);
}

static inline int port_segment_pose(const port_angles_t *angles, uint16_t segment,
                                    port_pose_t *pose) {
    return sample_segment_pose(angles, segment, pose);
}

static inline int port_tip_pose(const port_angles_t *angles, port_pose_t *pose) {
    return sample_tip_pose(angles, pose);
}

static inline int port_integer_segment_pose(const port_angles_t *angles, uint16_t segment,
                                            port_integer_pose_t *pose) {
    port_pose_t found;
    const int result = sample_segment_pose(angles, segment, &found);
    for (uint8_t i = 0; (result == CCGEN_OK) && (i < 3u); ++i) {
        for (uint8_t j = 0; j < 3u; ++j) {
            pose->rotation[3u * j + i] = (int32_t)found.rotation[i][j];
        }
        pose->position[i] = (int32_t)found.position[i];
    }
    return result;
}

static inline int port_integer_tip_jacobian(const port_angles_t *angles,
                                            int32_t jacobian[6][PORT_VALUES]) {
    float found[6][PORT_VALUES];
    const int result = sample_tip_jacobian(angles, found);
    for (uint8_t i = 0; (result == CCGEN_OK) && (i < 6u); ++i) {
        for (uint8_t j = 0; j < PORT_VALUES; ++j) {
            jacobian[i][j] = (int32_t)found[i][j];
        }
    }
    return result;
}

static inline int port_tip_jacobian(const port_angles_t *angles,
                                    float jacobian[6][PORT_VALUES]) {
    return sample_tip_jacobian(angles, jacobian);
}

static inline void port_unpack_counts(const port_count_t *list, port_counts_t *counts) {
    for (uint8_t j = 0; j < SAMPLE_SENSORS_U; ++j) {
        counts->u[j] = list[j];
    }
    for (uint8_t j = 0; j < SAMPLE_SENSORS_V; ++j) {
        counts->v[j] = list[SAMPLE_SENSORS_U + j];
    }
}

static inline void port_unpack_angles(const port_angle_t *list, port_angles_t *angles) {
    for (uint8_t i = 0; i < SAMPLE_SEGMENTS; ++i) {
        angles->u[i] = list[i];
        angles->v[i] = list[SAMPLE_SEGMENTS + i];
    }
}

static inline void port_pack_angles(const port_angles_t *angles, port_angle_t *list) {
    for (uint8_t i = 0; i < SAMPLE_SEGMENTS; ++i) {
        list[i] = angles->u[i];
        list[SAMPLE_SEGMENTS + i] = angles->v[i];
    }
}

#endif /* PORT_JOINT_H */
