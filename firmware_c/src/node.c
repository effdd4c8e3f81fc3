#include "ccgen/node.h"

#include "ccgen/integer.h"

#define TIP_BYTES 2u

/** The angles of the snapshot last published, of either precision; the other list is NULL. */
typedef struct {
    const int16_t *const *narrow; /* [CCGEN_AXES_MAX] */
    const int32_t *const *wide;   /* [CCGEN_AXES_MAX] */
} angles_t;

int ccgen_node_init(const ccgen_layout_t *const layout, ccgen_node_t *const node) {
    if ((node == NULL) || (ccgen_snapshot_init(layout, &node->snapshot) != CCGEN_OK)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    node->estimates = 0;
    node->failures = 0;
    node->overruns = 0;
    node->missing = 0;
    node->status_us = 0;
    node->status_wait_us = 0;
    ccgen_health_init(layout, &node->health);
    node->next = (uint16_t)(ccgen_layout_status_index(layout) + 1u);
    for (uint8_t i = 0; i < 3u; ++i) {
        node->tip[i] = 0;
    }
    node->published = 0;
    node->status_counter = 0;
    node->handed = CCGEN_HANDED_NOTHING;
    node->status_again = false;
    node->estimated = false;
    return CCGEN_OK;
}

int ccgen_node_receive(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                       const ccgen_frame_t *const frame, const uint32_t now_us) {
    if (node == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    return ccgen_snapshot_receive(layout, &node->snapshot, frame, now_us);
}

/** \return a count of the bus in 16 bits; what does not fit is no reading. */
static int16_t narrow_count(const int32_t count) {
    return ((count > INT16_MAX) || (count < INT16_MIN)) ? (int16_t)INT16_MIN : (int16_t)count;
}

/** \return whether a snapshot has these sensors. */
static bool are_sensors(const uint8_t first, const uint8_t sensors) {
    return (first <= CCGEN_SENSORS_MAX) && (sensors <= (CCGEN_SENSORS_MAX - first));
}

int ccgen_node_counts16(const ccgen_node_t *const node, const uint8_t first, const uint8_t sensors,
                        int16_t *const counts) {
    if ((node == NULL) || (counts == NULL) || !are_sensors(first, sensors)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t j = 0; j < sensors; ++j) {
        counts[j] = narrow_count(node->snapshot.counts[first + j]);
    }
    return CCGEN_OK;
}

int ccgen_node_counts32(const ccgen_node_t *const node, const uint8_t first, const uint8_t sensors,
                        int32_t *const counts) {
    if ((node == NULL) || (counts == NULL) || !are_sensors(first, sensors)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t j = 0; j < sensors; ++j) {
        counts[j] = node->snapshot.counts[first + j];
    }
    return CCGEN_OK;
}

/** Moves on to the next frame of the answer that is sent, or behind STATUS. */
static void skip_unpublished(const ccgen_layout_t *const layout, ccgen_node_t *const node) {
    while ((node->next <= ccgen_layout_status_index(layout)) &&
           !ccgen_layout_publishes(layout, node->next)) {
        node->next = (uint16_t)(node->next + 1u);
    }
}

int ccgen_node_publish(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                       const int result, const int32_t missing, const int16_t *const tip) {
    const bool estimated = (result >= 0);
    if ((layout == NULL) || (node == NULL) || (missing < 0) || (missing > 0xFFFF) ||
        (estimated && (tip == NULL))) {
        return CCGEN_ERROR_ARGUMENT;
    }
    skip_unpublished(layout, node);
    if (node->next <= ccgen_layout_status_index(layout)) {
        node->overruns += 1u;
    }
    if (missing != 0) {
        node->snapshot.faults |= CCGEN_FAULT_MISSING;
        node->snapshot.recent |= CCGEN_FAULT_MISSING;
    }
    if (node->handed == CCGEN_HANDED_ESTIMATE) {
        node->handed = CCGEN_HANDED_NOTHING; /* its answer is replaced */
    }
    for (uint8_t i = 0; i < 3u; ++i) {
        node->tip[i] = estimated ? tip[i] : (int16_t)INT16_MIN;
    }
    node->estimates += estimated ? 1u : 0u;
    node->failures += estimated ? 0u : 1u;
    node->missing = (uint16_t)missing;
    node->health.axes = estimated ? 0u : ccgen_health_all_lost(layout);
    node->estimated = estimated;
    node->published = node->snapshot.number;
    node->next = ccgen_layout_lengths_frames(layout);
    return estimated ? 1 : result;
}

/** \return the value of an index in the list of u, v and h. */
static int32_t angle_at(const ccgen_layout_t *const layout, const angles_t *const angles,
                        const uint16_t index) {
    uint16_t row = index;
    uint8_t axis = 0;
    while ((axis < (CCGEN_AXES_MAX - 1u)) && (row >= layout->rows[axis])) {
        row = (uint16_t)(row - layout->rows[axis]);
        ++axis;
    }
    return (angles->narrow != NULL) ? angles->narrow[axis][row] : angles->wide[axis][row];
}

static void put_angles(const ccgen_layout_t *const layout, const ccgen_node_t *const node,
                       const angles_t *const angles, uint8_t *const payload) {
    const uint8_t bytes = layout->angle_bytes;
    const uint8_t per_frame = ccgen_layout_slots(layout, bytes);
    const uint8_t total = ccgen_layout_values(layout);
    const uint16_t slot = (uint16_t)(node->next - ccgen_layout_lengths_frames(layout));
    uint16_t index = (uint16_t)(slot * per_frame);
    for (uint8_t i = 0; (i < per_frame) && (index < total); ++i) {
        const int32_t angle =
            node->estimated ? angle_at(layout, angles, index) : ccgen_no_reading(bytes);
        ccgen_put_signed(&payload[i * bytes], bytes, angle);
        ++index;
    }
}

static void put_tip(const ccgen_node_t *const node, uint8_t *const payload) {
    for (uint8_t i = 0; i < 3u; ++i) {
        ccgen_put_signed(&payload[i * TIP_BYTES], TIP_BYTES, node->tip[i]);
    }
}

static void put_status(const ccgen_node_t *const node, uint8_t *const payload) {
    const uint32_t samples = node->snapshot.snapshots;
    payload[0] = (uint8_t)(samples & 0xFFu);
    payload[1] = (uint8_t)((samples >> 8) & 0xFFu);
    payload[2] = (uint8_t)(node->missing & 0xFFu);
    payload[3] = (uint8_t)(node->missing >> 8);
    payload[4] = node->snapshot.faults;
    payload[5] = ccgen_snapshot_age_ms(&node->snapshot, node->snapshot.now_us);
}

/** What was handed out counts as sent, unless it was taken back. */
static void settle(const ccgen_layout_t *const layout, ccgen_node_t *const node) {
    if (node->handed == CCGEN_HANDED_STATUS) {
        const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
        const uint16_t next = (uint16_t)(node->status_counter + 1u);
        node->status_counter = (uint8_t)((next < modulus) ? next : 0u);
        node->snapshot.faults = node->snapshot.recent;
    } else if (node->handed == CCGEN_HANDED_HEALTH) {
        ccgen_health_sent(layout, &node->health);
    }
    node->handed = CCGEN_HANDED_NOTHING;
}

static int transmit_status(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                           ccgen_frame_t *const frame) {
    ccgen_layout_begin(layout, ccgen_layout_status_index(layout), frame);
    put_status(node, &frame->data[ccgen_e2e_header(ccgen_layout_profile(layout))]);
    (void)ccgen_layout_protect(layout, node->status_counter, frame);
    node->handed = CCGEN_HANDED_STATUS;
    node->status_again = false;
    node->snapshot.recent = 0;
    node->status_us = node->snapshot.now_us;
    return 1;
}

static int transmit_health(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                           ccgen_frame_t *const frame) {
    ccgen_health_frame(layout, &node->health, node->snapshot.now_us, frame);
    node->handed = CCGEN_HANDED_HEALTH;
    return 1;
}

static int transmit_estimate(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                             const angles_t *const angles, ccgen_frame_t *const frame) {
    const size_t header = ccgen_e2e_header(ccgen_layout_profile(layout));
    ccgen_layout_begin(layout, node->next, frame);
    if (node->next < ccgen_layout_tip_index(layout)) {
        put_angles(layout, node, angles, &frame->data[header]);
    } else {
        put_tip(node, &frame->data[header]);
    }
    (void)ccgen_layout_protect(layout, node->published, frame);
    node->handed = CCGEN_HANDED_ESTIMATE;
    return 1;
}

/** The next frame of an answer: ANGLES, TIP, STATUS. */
static int transmit_answer(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                           const angles_t *const angles, ccgen_frame_t *const frame) {
    const bool is_status = (node->next == ccgen_layout_status_index(layout));
    const int result = is_status ? transmit_status(layout, node, frame)
                                 : transmit_estimate(layout, node, angles, frame);
    node->next = (uint16_t)(node->next + 1u);
    node->status_wait_us = layout->cycle_us + layout->cycle_us / 2u;
    return result;
}

static int transmit(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                    const angles_t *const angles, const uint32_t now_us,
                    ccgen_frame_t *const frame) {
    (void)ccgen_snapshot_tick(layout, &node->snapshot, now_us);
    settle(layout, node);
    skip_unpublished(layout, node);
    /* Both stay due while other frames go first, for the clock may come round meanwhile. */
    const uint32_t overdue_us = 2u * layout->cycle_us;
    if ((uint32_t)(node->snapshot.now_us - node->status_us) > overdue_us) {
        node->status_us = node->snapshot.now_us - overdue_us;
    }
    node->health.due = ccgen_health_due(layout, &node->health, node->snapshot.now_us);
    if (node->next <= ccgen_layout_status_index(layout)) {
        return transmit_answer(layout, node, angles, frame);
    }
    if (node->health.due) {
        return transmit_health(layout, node, frame);
    }
    if ((layout->publish & CCGEN_PUBLISH_STATUS) == 0u) {
        return 0;
    }
    const uint32_t since_us = node->snapshot.now_us - node->status_us;
    if (node->status_again) {
        return transmit_status(layout, node, frame);
    }
    if (since_us >= node->status_wait_us) {
        node->status_wait_us = layout->cycle_us;
        return transmit_status(layout, node, frame);
    }
    return 0;
}

int ccgen_node_transmit16(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                          const int16_t *const angles[CCGEN_AXES_MAX], const uint32_t now_us,
                          ccgen_frame_t *const frame) {
    const angles_t of_either = {angles, NULL};
    if ((layout == NULL) || (node == NULL) || (angles == NULL) || (frame == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t axis = 0; axis < CCGEN_AXES_MAX; ++axis) {
        if ((layout->rows[axis] > 0u) && (angles[axis] == NULL)) {
            return CCGEN_ERROR_ARGUMENT;
        }
    }
    return transmit(layout, node, &of_either, now_us, frame);
}

int ccgen_node_transmit32(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                          const int32_t *const angles[CCGEN_AXES_MAX], const uint32_t now_us,
                          ccgen_frame_t *const frame) {
    const angles_t of_either = {NULL, angles};
    if ((layout == NULL) || (node == NULL) || (angles == NULL) || (frame == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t axis = 0; axis < CCGEN_AXES_MAX; ++axis) {
        if ((layout->rows[axis] > 0u) && (angles[axis] == NULL)) {
            return CCGEN_ERROR_ARGUMENT;
        }
    }
    return transmit(layout, node, &of_either, now_us, frame);
}

int ccgen_node_unsent(ccgen_node_t *const node) {
    if (node == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const ccgen_handed_t handed = node->handed;
    node->handed = CCGEN_HANDED_NOTHING;
    if (handed == CCGEN_HANDED_ESTIMATE) {
        node->next = (uint16_t)(node->next - 1u);
    }
    node->status_again = node->status_again || (handed == CCGEN_HANDED_STATUS);
    node->health.due = node->health.due || (handed == CCGEN_HANDED_HEALTH);
    return (handed == CCGEN_HANDED_NOTHING) ? 0 : 1;
}
