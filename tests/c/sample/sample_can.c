#include "sample_can.h"

#include "ccgen/flash.h"
#include "ccgen/node_inline.h"
#include "ccgen/tip.h"

#define SAMPLE_POSITION_BITS 28

#ifndef SAMPLE_PUBLISH
#define SAMPLE_PUBLISH (CCGEN_PUBLISH_ANGLES | CCGEN_PUBLISH_TIP | CCGEN_PUBLISH_STATUS)
#endif

/* What the check values take from identifiers 0x300 to 0x30D. */
static const uint8_t keys[14] CCGEN_FLASH = {0x27, 0x6B, 0xBF, 0xF3, 0x0A, 0x46, 0x92,
                                             0xDE, 0x7D, 0x31, 0xE5, 0xA9, 0x50, 0x1C};

const ccgen_layout_t sample_layout = {
    0x300u,                                /* base_id */
    false,                                 /* extended */
    (SAMPLE_FD != 0),                      /* fd */
    true,                                  /* turn */
    SAMPLE_SENSORS,                        /* sensors */
    {SAMPLE_SEGMENTS, SAMPLE_SEGMENTS, 0}, /* rows of u, v and h */
    2,                                     /* count_bytes */
    2,                                     /* angle_bytes */
    10000u,                                /* cycle_us */
    10000u,                                /* window_us */
    0xC0DEu,                               /* fingerprint */
    SAMPLE_PUBLISH,                        /* publish */
    false,                                 /* rate_switch */
    false,                                 /* commands */
    (SAMPLE_FD != 0) ? 256 : 240,          /* numbers */
    2 * SAMPLE_SEGMENTS,                   /* values */
    (SAMPLE_FD != 0) ? 30 : 3,             /* counts_per_frame */
    (SAMPLE_FD != 0) ? 30 : 3,             /* angles_per_frame */
    (SAMPLE_FD != 0) ? 1 : 2,              /* lengths_frames */
    (SAMPLE_FD != 0) ? 1 : 8,              /* angles_frames */
    (SAMPLE_FD != 0) ? 64 : 8,             /* frame_bytes */
    (SAMPLE_FD != 0) ? 16 : 8,             /* last_lengths_bytes */
    (SAMPLE_FD != 0) ? 64 : 8,             /* last_angles_bytes */
    (SAMPLE_FD != 0) ? 12 : 8,             /* single_bytes */
    keys                                   /* keys */
};

static int estimate(sample_node_t *const node) {
    sample_counts_t counts;
    sample_pose_t pose;
    int16_t tip[3] = {0, 0, 0};
    (void)ccgen_node_counts16(&node->node, 0, SAMPLE_SENSORS_U, counts.u);
    (void)ccgen_node_counts16(&node->node, SAMPLE_SENSORS_U, SAMPLE_SENSORS_V, counts.v);
    const int result = sample_estimate(&node->joint, &counts, &node->angles);
    if ((result == CCGEN_OK) && (sample_tip_pose(&node->angles, &pose) == CCGEN_OK)) {
        for (uint8_t k = 0; k < 3u; ++k) {
            const int32_t position = (int32_t)(pose.position[k] * (1 << SAMPLE_POSITION_BITS));
            tip[k] = ccgen_tip_signal(position, SAMPLE_POSITION_BITS - SAMPLE_TIP_FRACTION_BITS);
        }
    }
    return ccgen_node_publish(&sample_layout, &node->node, result,
                              sample_missing(&node->joint, &counts), tip);
}

int sample_node_init(sample_node_t *const node) {
    const sample_angles_t straight = CCGEN_ZERO;
    if (node == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    node->angles = straight;
    (void)sample_init(&node->joint);
    return ccgen_node_init(&sample_layout, &node->node);
}

int sample_node_receive(sample_node_t *const node, const ccgen_frame_t *const frame,
                        const uint32_t now_us) {
    if (node == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const int result = ccgen_node_receive(&sample_layout, &node->node, frame, now_us);
    return (result == 1) ? estimate(node) : result;
}

int sample_node_transmit(sample_node_t *const node, const uint32_t now_us,
                         ccgen_frame_t *const frame) {
    if (node == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const sample_angle_t *const angles[CCGEN_AXES_MAX] = {node->angles.u, node->angles.v, NULL};
    return ccgen_node_transmit16(&sample_layout, &node->node, angles, now_us, frame);
}

int sample_node_unsent(sample_node_t *const node) {
    return (node == NULL) ? CCGEN_ERROR_ARGUMENT : ccgen_node_unsent(&node->node);
}

int sample_node_set_window(sample_node_t *const node, const uint32_t window_us) {
    return (node == NULL) ? CCGEN_ERROR_ARGUMENT
                          : ccgen_snapshot_set_window(&node->node.snapshot, window_us);
}
