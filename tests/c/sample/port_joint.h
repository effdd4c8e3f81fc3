/**
 * \file port_joint.h
 * \brief The sample joint under the names that the ports use.
 */
#ifndef PORT_JOINT_H
#define PORT_JOINT_H

#include "sample_can.h"

#define PORT_SEGMENTS SAMPLE_SEGMENTS
#define PORT_SENSORS_U SAMPLE_SENSORS_U
#define PORT_SENSORS_V SAMPLE_SENSORS_V
#define PORT_PRECISION SAMPLE_PRECISION
#define PORT_CYCLE_US SAMPLE_CYCLE_US
#define PORT_WINDOW_MAX_US SAMPLE_WINDOW_MAX_US

typedef sample_node_t port_node_t;
typedef sample_t port_joint_t;
typedef sample_count_t port_count_t;
typedef sample_angle_t port_angle_t;
typedef sample_counts_t port_counts_t;
typedef sample_angles_t port_angles_t;
typedef sample_pose_t port_pose_t;

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

static inline int port_estimate(const port_joint_t *joint, const port_counts_t *counts,
                                port_angles_t *angles) {
    return sample_estimate(joint, counts, angles);
}

static inline int32_t port_missing(const port_counts_t *counts) {
    return sample_missing(counts);
}

static inline int port_segment_pose(const port_angles_t *angles, uint16_t segment,
                                    port_pose_t *pose) {
    return sample_segment_pose(angles, segment, pose);
}

static inline int port_tip_pose(const port_angles_t *angles, port_pose_t *pose) {
    return sample_tip_pose(angles, pose);
}

static inline int port_tip_jacobian(const port_angles_t *angles,
                                    float jacobian[6][2 * PORT_SEGMENTS]) {
    return sample_tip_jacobian(angles, jacobian);
}

#endif /* PORT_JOINT_H */
