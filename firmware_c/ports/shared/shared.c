/**
 * \file shared.c
 * \brief The joint as a shared library: plain C types for a caller such as Python's ctypes.
 *
 * port_joint.h, generated for each joint, names the joint's types and functions: port_node_t with
 * port_node_init, port_node_receive, port_node_transmit, port_node_unsent, port_node_set_window;
 * port_joint_t,
 * port_counts_t, port_angles_t, port_count_t, port_angle_t, port_pose_t with port_init,
 * port_restore_zero, port_follow, port_unpack_counts, port_pack_angles, port_unpack_angles,
 * port_segment_pose, port_tip_pose, port_tip_jacobian, port_integer_segment_pose and
 * port_integer_tip_jacobian; PORT_SEGMENTS, PORT_SENSORS, PORT_VALUES
 * and PORT_PRECISION. With PORT_INTEGERS_ONLY it has none of port_pose_t, port_segment_pose,
 * port_tip_pose and port_tip_jacobian.
 *
 * All arrays are dense, row-major and the caller's. Counts of a snapshot are in the order of the
 * joint's sensors; its values those of u, then v, then h, of the axes that are estimated.
 */
#include "port_joint.h"

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Indices into what ccgen_shared_node_counters() writes. */
enum {
    COUNTER_SNAPSHOTS,
    COUNTER_CORRUPTED,
    COUNTER_MALFORMED,
    COUNTER_REPEATED,
    COUNTER_REORDERED,
    COUNTER_LOST,
    COUNTER_LATE,
    COUNTER_ESTIMATES,
    COUNTER_FAILURES,
    COUNTER_OVERRUNS,
    COUNTERS
};

/** \param[out] shape  [4] segments, sensors, values, precision  \return CCGEN_OK or error */
EXPORT int ccgen_shared_shape(int32_t *shape);

/** \return bytes that a node needs; aligned as malloc() aligns */
EXPORT size_t ccgen_shared_node_size(void);

/** Starts a node in the caller's memory. \return as NAME_node_init() */
EXPORT int ccgen_shared_node_init(void *node);

/** Replaces the snapshot's window. \return as NAME_node_set_window() */
EXPORT int ccgen_shared_node_set_window(void *node, uint32_t window_us);

/**
 * Hands one frame to the node.
 * \param[in] extended  not 0: 29-bit identifier
 * \param[in] fd        not 0: CAN FD frame
 * \param[in] data      [length], length at most 64
 * \return as NAME_node_receive(); CCGEN_ERROR_FORMAT for more than 64 bytes
 */
EXPORT int ccgen_shared_node_receive(void *node, uint32_t id, int extended, int fd, size_t length,
                                     const uint8_t *data, uint32_t now_us);

/**
 * Fetches the next frame that the node sends.
 * \param[out] data  [64]
 * \return as NAME_node_transmit(); nothing is written unless it is 1
 */
EXPORT int ccgen_shared_node_transmit(void *node, uint32_t now_us, uint32_t *id, uint8_t *extended,
                                      uint8_t *fd, uint8_t *length, uint8_t *data);

/** Takes back the frame that was fetched last. \return as NAME_node_unsent() */
EXPORT int ccgen_shared_node_unsent(void *node);

/**
 * Reads the node's counters.
 * \param[out] counters  [10] snapshots, corrupted, malformed, repeated, reordered, lost, late,
 *                       estimates, failures, overruns
 */
EXPORT int ccgen_shared_node_counters(const void *node, uint32_t *counters);

/**
 * Estimates n snapshots.
 * \param[in] counts    [n][sensors]
 * \param[in] zero      [sensors] counts at the straight pose; NULL for those of the model
 * \param[out] angles   [n][values]; rows of failed snapshots stay as they are
 * \param[out] results  [n] what NAME_follow(), or NAME_estimate() without checks, returned for each
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer; what NAME_restore_zero() returned
 *         for a zero that it refuses
 */
EXPORT int ccgen_batch_estimate(const port_count_t *counts, const port_count_t *zero, size_t n,
                                port_angle_t *angles, int8_t *results);

#ifndef PORT_INTEGERS_ONLY
/**
 * Poses of every segment's distal end, and after them the tip's, for n sets of angles.
 * \param[in] angles      [n][values]
 * \param[out] positions  [n][segments + 1][3] metres
 * \param[out] rotations  [n][segments + 1][3][3]
 * \return CCGEN_OK, or the first error
 */
EXPORT int ccgen_batch_poses(const port_angle_t *angles, size_t n, float *positions,
                             float *rotations);
#endif

/**
 * Poses in integers of every segment's distal end for n sets of angles.
 * \param[in] angles  [n][values]
 * \param[out] poses  [n][segments][12] axes X, Y, Z and position
 * \return CCGEN_OK, or the first error
 */
EXPORT int ccgen_batch_integer_poses(const port_angle_t *angles, size_t n, int32_t *poses);

/**
 * Tip Jacobians in integers for n sets of angles.
 * \param[in] angles      [n][values]
 * \param[out] jacobians  [n][6][values]
 * \return CCGEN_OK, or the first error
 */
EXPORT int ccgen_batch_integer_jacobians(const port_angle_t *angles, size_t n, int32_t *jacobians);

#if PORT_FUNCTION_WORDS > 0
/**
 * Results of the user's own functions for n sets of angles.
 * \param[in] angles  [n][values]
 * \param[out] words  [n][PORT_FUNCTION_WORDS] function by function
 * \return CCGEN_OK, or the first error
 */
EXPORT int ccgen_batch_functions(const port_angle_t *angles, size_t n, int32_t *words);
#endif

#ifndef PORT_INTEGERS_ONLY
/**
 * Tip Jacobians for n sets of angles.
 * \param[in] angles      [n][values]
 * \param[out] jacobians  [n][6][values]
 * \return CCGEN_OK, or the first error
 */
EXPORT int ccgen_batch_jacobians(const port_angle_t *angles, size_t n, float *jacobians);

static void pack_pose(const port_pose_t *const pose, float *const position, float *const rotation) {
    for (size_t i = 0; i < 3u; ++i) {
        position[i] = pose->position[i];
        for (size_t j = 0; j < 3u; ++j) {
            rotation[3u * i + j] = pose->rotation[i][j];
        }
    }
}
#endif

int ccgen_shared_shape(int32_t *const shape) {
    if (shape == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    shape[0] = PORT_SEGMENTS;
    shape[1] = PORT_SENSORS;
    shape[2] = PORT_VALUES;
    shape[3] = PORT_PRECISION;
    return CCGEN_OK;
}

size_t ccgen_shared_node_size(void) {
    return sizeof(port_node_t);
}

int ccgen_shared_node_init(void *const node) {
    return port_node_init((port_node_t *)node);
}

int ccgen_shared_node_set_window(void *const node, const uint32_t window_us) {
    return port_node_set_window((port_node_t *)node, window_us);
}

int ccgen_shared_node_receive(void *const node, const uint32_t id, const int extended, const int fd,
                              const size_t length, const uint8_t *const data,
                              const uint32_t now_us) {
    ccgen_frame_t frame = CCGEN_ZERO;
    if ((node == NULL) || ((data == NULL) && (length > 0u))) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (length > CCGEN_FRAME_CAPACITY) {
        return CCGEN_ERROR_FORMAT;
    }
    frame.id = id;
    frame.extended = (extended != 0);
    frame.fd = (fd != 0);
    frame.length = (uint8_t)length;
    for (size_t i = 0; i < length; ++i) {
        frame.data[i] = data[i];
    }
    return port_node_receive((port_node_t *)node, &frame, now_us);
}

int ccgen_shared_node_transmit(void *const node, const uint32_t now_us, uint32_t *const id,
                               uint8_t *const extended, uint8_t *const fd, uint8_t *const length,
                               uint8_t *const data) {
    ccgen_frame_t frame = CCGEN_ZERO;
    if ((node == NULL) || (id == NULL) || (extended == NULL) || (fd == NULL) || (length == NULL) ||
        (data == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const int result = port_node_transmit((port_node_t *)node, now_us, &frame);
    if (result == 1) {
        *id = frame.id;
        *extended = frame.extended ? 1u : 0u;
        *fd = frame.fd ? 1u : 0u;
        *length = frame.length;
        for (size_t i = 0; i < frame.length; ++i) {
            data[i] = frame.data[i];
        }
    }
    return result;
}

int ccgen_shared_node_unsent(void *const node) {
    return port_node_unsent((port_node_t *)node);
}

int ccgen_shared_node_counters(const void *const node, uint32_t *const counters) {
    if ((node == NULL) || (counters == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const ccgen_node_t *const state = &((const port_node_t *)node)->node;
    counters[COUNTER_SNAPSHOTS] = state->snapshot.snapshots;
    counters[COUNTER_CORRUPTED] = state->snapshot.corrupted;
    counters[COUNTER_MALFORMED] = state->snapshot.malformed;
    counters[COUNTER_REPEATED] = state->snapshot.repeated;
    counters[COUNTER_REORDERED] = state->snapshot.reordered;
    counters[COUNTER_LOST] = state->snapshot.lost;
    counters[COUNTER_LATE] = state->snapshot.late;
    counters[COUNTER_ESTIMATES] = state->estimates;
    counters[COUNTER_FAILURES] = state->failures;
    counters[COUNTER_OVERRUNS] = state->overruns;
    return CCGEN_OK;
}

/** Starts a joint with the given zero offsets, or the model's. */
static int start_joint(const port_count_t *const zero, port_joint_t *const joint) {
    port_counts_t counts;
    const int result = port_init(joint);
    if ((result != CCGEN_OK) || (zero == NULL)) {
        return result;
    }
    port_unpack_counts(zero, &counts);
    return port_restore_zero(joint, &counts);
}

int ccgen_batch_estimate(const port_count_t *const counts, const port_count_t *const zero,
                         const size_t n, port_angle_t *const angles, int8_t *const results) {
    port_joint_t joint;
    if ((counts == NULL) || (angles == NULL) || (results == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const int started = start_joint(zero, &joint);
    if (started != CCGEN_OK) {
        return started;
    }
    for (size_t k = 0; k < n; ++k) {
        port_counts_t snapshot;
        port_angles_t estimate;
        port_unpack_counts(&counts[k * PORT_SENSORS], &snapshot);
        results[k] = (int8_t)port_follow(&joint, &snapshot, &estimate);
        if (results[k] >= 0) {
            port_pack_angles(&estimate, &angles[k * PORT_VALUES]);
        }
    }
    return CCGEN_OK;
}

#ifndef PORT_INTEGERS_ONLY
int ccgen_batch_poses(const port_angle_t *const angles, const size_t n, float *const positions,
                      float *const rotations) {
    if ((angles == NULL) || (positions == NULL) || (rotations == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (size_t k = 0; k < n; ++k) {
        port_angles_t shape;
        port_unpack_angles(&angles[k * PORT_VALUES], &shape);
        for (uint16_t i = 0; i <= PORT_SEGMENTS; ++i) {
            port_pose_t pose;
            const size_t row = k * (PORT_SEGMENTS + 1u) + i;
            const int result = (i < PORT_SEGMENTS) ? port_segment_pose(&shape, i, &pose)
                                                   : port_tip_pose(&shape, &pose);
            if (result != CCGEN_OK) {
                return result;
            }
            pack_pose(&pose, &positions[3u * row], &rotations[9u * row]);
        }
    }
    return CCGEN_OK;
}
#endif

int ccgen_batch_integer_poses(const port_angle_t *const angles, const size_t n,
                              int32_t *const poses) {
    if ((angles == NULL) || (poses == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (size_t k = 0; k < n; ++k) {
        port_angles_t shape;
        port_unpack_angles(&angles[k * PORT_VALUES], &shape);
        for (uint16_t i = 0; i < PORT_SEGMENTS; ++i) {
            port_integer_pose_t pose;
            const int result = port_integer_segment_pose(&shape, i, &pose);
            if (result != CCGEN_OK) {
                return result;
            }
            int32_t *const row = &poses[12u * (k * PORT_SEGMENTS + i)];
            for (size_t j = 0; j < 12u; ++j) {
                row[j] = (j < 9u) ? pose.rotation[j] : pose.position[j - 9u];
            }
        }
    }
    return CCGEN_OK;
}

int ccgen_batch_integer_jacobians(const port_angle_t *const angles, const size_t n,
                                  int32_t *const jacobians) {
    if ((angles == NULL) || (jacobians == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (size_t k = 0; k < n; ++k) {
        port_angles_t shape;
        int32_t jacobian[6][PORT_VALUES];
        port_unpack_angles(&angles[k * PORT_VALUES], &shape);
        const int result = port_integer_tip_jacobian(&shape, jacobian);
        if (result != CCGEN_OK) {
            return result;
        }
        int32_t *const row = &jacobians[k * 6u * PORT_VALUES];
        for (size_t i = 0; i < 6u; ++i) {
            for (size_t j = 0; j < PORT_VALUES; ++j) {
                row[i * PORT_VALUES + j] = jacobian[i][j];
            }
        }
    }
    return CCGEN_OK;
}

#if PORT_FUNCTION_WORDS > 0
int ccgen_batch_functions(const port_angle_t *const angles, const size_t n, int32_t *const words) {
    if ((angles == NULL) || (words == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (size_t k = 0; k < n; ++k) {
        port_angles_t shape;
        port_unpack_angles(&angles[k * PORT_VALUES], &shape);
        const int result = port_functions(&shape, &words[k * PORT_FUNCTION_WORDS]);
        if (result != CCGEN_OK) {
            return result;
        }
    }
    return CCGEN_OK;
}
#endif

#ifndef PORT_INTEGERS_ONLY
int ccgen_batch_jacobians(const port_angle_t *const angles, const size_t n,
                          float *const jacobians) {
    if ((angles == NULL) || (jacobians == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (size_t k = 0; k < n; ++k) {
        port_angles_t shape;
        float jacobian[6][PORT_VALUES];
        port_unpack_angles(&angles[k * PORT_VALUES], &shape);
        const int result = port_tip_jacobian(&shape, jacobian);
        if (result != CCGEN_OK) {
            return result;
        }
        float *const row = &jacobians[k * 6u * PORT_VALUES];
        for (size_t i = 0; i < 6u; ++i) {
            for (size_t j = 0; j < PORT_VALUES; ++j) {
                row[i * PORT_VALUES + j] = jacobian[i][j];
            }
        }
    }
    return CCGEN_OK;
}
#endif

#ifdef __cplusplus
}
#endif
