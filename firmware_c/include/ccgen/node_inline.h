/**
 * \file node_inline.h
 * \brief What node.h describes, inline: where a joint's layout is known, it folds into the code.
 */
#ifndef CCGEN_NODE_INLINE_H
#define CCGEN_NODE_INLINE_H

#include "ccgen/health_inline.h"
#include "ccgen/node.h"
#include "ccgen/snapshot_inline.h"

#define CCGEN_NODE_TIP_BYTES 6u
#define CCGEN_NODE_STATUS_BYTES 6u

/** The angles of the snapshot last published, of either precision; the other list is NULL. */
typedef struct {
    const int16_t *const *narrow; /* [CCGEN_AXES_MAX] */
    const int32_t *const *wide;   /* [CCGEN_AXES_MAX] */
} ccgen_node_angles_t;

/**
 * Sets the state to: nothing received, nothing to send but a status.
 * \param[in] layout
 * \param[out] node
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer or an invalid layout
 */
static inline int ccgen_node_init(const ccgen_layout_t *const layout, ccgen_node_t *const node) {
    if ((node == NULL) || (ccgen_snapshot_init(layout, &node->snapshot) != CCGEN_OK)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    node->estimates = 0;
    node->failures = 0;
    node->overruns = 0;
    node->missing = 0;
    node->status_us = 0;
    node->status_wait_us = 0;
    node->looked_us = 0;
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

/** Takes one frame; parameters and result as ccgen_snapshot_receive(). */
static inline int ccgen_node_receive(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                                     const ccgen_frame_t *const frame, const uint32_t now_us) {
    if (node == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    return ccgen_snapshot_receive(layout, &node->snapshot, frame, now_us);
}

/** \return a count of the bus in 16 bits; what does not fit is no reading. */
static inline int16_t ccgen_node_narrow_count(const int32_t count) {
    return ((count > INT16_MAX) || (count < INT16_MIN)) ? (int16_t)INT16_MIN : (int16_t)count;
}

/**
 * Hands out counts of the latest complete snapshot, for a joint of precision 16.
 * \param[in] node
 * \param[in] first    the first sensor, in the joint's order
 * \param[in] sensors  how many; first + sensors at most CCGEN_SENSORS_MAX
 * \param[out] counts  [sensors]
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer or sensors that there are not
 */
static inline int ccgen_node_counts16(const ccgen_node_t *const node, const uint8_t first,
                                      const uint8_t sensors, int16_t *const counts) {
    if ((node == NULL) || (counts == NULL) || !ccgen_sensors_exist(first, sensors)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t j = 0; j < sensors; ++j) {
        counts[j] = ccgen_node_narrow_count(node->snapshot.counts[first + j]);
    }
    return CCGEN_OK;
}

/** The same for a joint of precision 32; "no reading" is INT32_MIN whatever the count's width. */
static inline int ccgen_node_counts32(const ccgen_node_t *const node, const uint8_t first,
                                      const uint8_t sensors, int32_t *const counts) {
    if ((node == NULL) || (counts == NULL) || !ccgen_sensors_exist(first, sensors)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t j = 0; j < sensors; ++j) {
        counts[j] = node->snapshot.counts[first + j];
    }
    return CCGEN_OK;
}

/**
 * Completes a snapshot of counts that the node's own chip has read and that were put into
 * `snapshot.pending`; then comes what comes after a complete snapshot of frames. Parameters and
 * result as ccgen_snapshot_own().
 */
static inline int ccgen_node_own(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                                 const uint32_t now_us) {
    return (node == NULL) ? CCGEN_ERROR_ARGUMENT
                          : ccgen_snapshot_own(layout, &node->snapshot, now_us);
}

/**
 * Tells what the angles of the snapshot last published are worth.
 * \param[in] node
 * \param[in] now_us
 * \return CCGEN_ANGLES_...; CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_node_worth(const ccgen_node_t *const node, const uint32_t now_us) {
    if (node == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (node->snapshot.snapshots == 0u) {
        return CCGEN_ANGLES_LOST;
    }
    if (ccgen_snapshot_is_stale(&node->snapshot, now_us)) {
        return CCGEN_ANGLES_STALE;
    }
    if (!node->estimated) {
        return CCGEN_ANGLES_LOST;
    }
    return (node->health.axes == 0u) ? CCGEN_ANGLES_GOOD : CCGEN_ANGLES_DEGRADED;
}

/**
 * Tells when silence has made the angles of the snapshot last published worthless, so that whoever
 * holds them forgets them: no frame needs them any more.
 * \param[in] layout
 * \param[in,out] node
 * \return true once a silence
 */
static inline bool ccgen_node_forgets(const ccgen_layout_t *const layout,
                                      ccgen_node_t *const node) {
    /* A frame of the answer that may be taken back has STATUS's place still before it. */
    const bool answered = node->next > ccgen_layout_status_index(layout);
    if (!node->estimated || !node->snapshot.stale || !answered) {
        return false;
    }
    node->estimated = false;
    return true;
}

/** Moves on to the next frame of the answer that is sent, or behind STATUS. */
CCGEN_INLINE void ccgen_node_skip_unpublished(const ccgen_layout_t *const layout,
                                              ccgen_node_t *const node) {
    while ((node->next <= ccgen_layout_status_index(layout)) &&
           !ccgen_layout_publishes(layout, node->next)) {
        node->next = (uint16_t)(node->next + 1u);
    }
}

/**
 * Announces the outcome of the latest snapshot: its frames become due.
 * \param[in] layout
 * \param[in,out] node
 * \param[in] result   what NAME_estimate() returned: a mask of what is degraded or lost, whose lost
 *                     axes hold "no reading"; below 0: there are no angles
 * \param[in] missing  what NAME_missing() returned: mask of 16 bits
 * \param[in] tip      [3] tip position from ccgen_tip_signal(); read only when there are angles
 * \return 1: a new estimate stands; otherwise `result`; CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_node_publish(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                                     const int result, const int32_t missing,
                                     const int16_t *const tip) {
    const bool estimated = (result >= 0);
    if ((layout == NULL) || (node == NULL) || (missing < 0) || (missing > 0xFFFF) ||
        (estimated && (tip == NULL))) {
        return CCGEN_ERROR_ARGUMENT;
    }
    ccgen_node_skip_unpublished(layout, node);
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
    /* MISRA 10.4 */
    node->health.axes = (uint8_t)(estimated ? result : ccgen_health_all_lost(layout));
    node->estimated = estimated;
    node->published = node->snapshot.number;
    node->next = layout->lengths_frames;
    return estimated ? 1 : result;
}

/** Where the value of an index in the list of u, v and h stands, and how many follow it there. */
typedef struct {
    uint8_t axis;
    uint8_t row;
    uint8_t left;
} ccgen_node_place_t;

CCGEN_INLINE ccgen_node_place_t ccgen_node_place_of(const ccgen_layout_t *const layout,
                                                    const uint8_t index) {
    ccgen_node_place_t place = {0, index, 0};
    while (place.row >= layout->rows[place.axis]) {
        place.row = (uint8_t)(place.row - layout->rows[place.axis]);
        ++place.axis;
    }
    place.left = (uint8_t)(layout->rows[place.axis] - place.row);
    return place;
}

/** Puts the values from an index on, in the list of u, v and h, into a frame. */
CCGEN_INLINE void ccgen_node_put_angles(const ccgen_layout_t *const layout,
                                        const ccgen_node_angles_t *const angles,
                                        const uint8_t first, const uint8_t values,
                                        uint8_t *const payload) {
    const bool narrow = (angles->narrow != NULL);
    uint8_t *signal = payload;
    uint8_t index = first;
    const uint8_t behind = (uint8_t)(first + values);
    while (index < behind) {
        const ccgen_node_place_t place = ccgen_node_place_of(layout, index);
        const uint8_t wanted = (uint8_t)(behind - index);
        const uint8_t run = (place.left < wanted) ? place.left : wanted;
        for (uint8_t i = 0; i < run; ++i) {
            if (narrow) {
                ccgen_put16(signal, angles->narrow[place.axis][place.row + i]);
                signal += 2;
            } else {
                ccgen_put32(signal, angles->wide[place.axis][place.row + i]);
                signal += 4;
            }
        }
        index = (uint8_t)(index + run);
    }
}

/** The same where there is no estimate. */
CCGEN_INLINE void ccgen_node_put_no_reading(const bool narrow, const uint8_t values,
                                            uint8_t *const payload) {
    uint8_t *signal = payload;
    for (uint8_t i = 0; i < values; ++i) {
        if (narrow) {
            ccgen_put16(signal, INT16_MIN);
            signal += 2;
        } else {
            ccgen_put32(signal, INT32_MIN);
            signal += 4;
        }
    }
}

static inline void ccgen_node_put_status(const ccgen_node_t *const node, uint8_t *const payload) {
    const uint32_t samples = node->snapshot.snapshots;
    payload[0] = (uint8_t)(samples & 0xFFu);
    payload[1] = (uint8_t)((samples >> 8) & 0xFFu);
    payload[2] = (uint8_t)(node->missing & 0xFFu);
    payload[3] = (uint8_t)(node->missing >> 8);
    payload[4] = node->snapshot.faults;
    payload[5] = ccgen_snapshot_age_ms(&node->snapshot, node->snapshot.now_us);
}

/** What was handed out counts as sent, unless it was taken back. */
CCGEN_INLINE void ccgen_node_settle(const ccgen_layout_t *const layout, ccgen_node_t *const node) {
    if (node->handed == CCGEN_HANDED_STATUS) {
        const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
        const uint16_t next = (uint16_t)(node->status_counter + 1u);
        node->status_counter = (uint8_t)((next < modulus) ? next : 0u);
        node->snapshot.faults = node->snapshot.recent;
    } else if (node->handed == CCGEN_HANDED_HEALTH) {
        ccgen_health_sent(layout, &node->health);
    } else {
        /* the other frames have no state of their own */
    }
    node->handed = CCGEN_HANDED_NOTHING;
}

static inline int ccgen_node_transmit_status(const ccgen_layout_t *const layout,
                                             ccgen_node_t *const node, ccgen_frame_t *const frame) {
    ccgen_node_put_status(node,
                          ccgen_layout_open(layout, ccgen_layout_status_index(layout), frame));
    (void)ccgen_layout_close(layout, node->status_counter, CCGEN_NODE_STATUS_BYTES, frame);
    node->handed = CCGEN_HANDED_STATUS;
    node->status_again = false;
    node->snapshot.recent = 0;
    node->status_us = node->snapshot.now_us;
    return 1;
}

static inline int ccgen_node_transmit_health(const ccgen_layout_t *const layout,
                                             ccgen_node_t *const node, ccgen_frame_t *const frame) {
    ccgen_health_frame(layout, &node->health, node->snapshot.now_us, frame);
    node->handed = CCGEN_HANDED_HEALTH;
    return 1;
}

static inline void ccgen_node_put_tip(const ccgen_node_t *const node, uint8_t *const payload) {
    ccgen_put16(&payload[0], node->tip[0]);
    ccgen_put16(&payload[2], node->tip[1]);
    ccgen_put16(&payload[4], node->tip[2]);
}

/** The next frame of an answer that has its number: ANGLES, TIP. */
CCGEN_INLINE int ccgen_node_transmit_estimate(const ccgen_layout_t *const layout,
                                              ccgen_node_t *const node,
                                              const ccgen_node_angles_t *const angles,
                                              ccgen_frame_t *const frame) {
    uint8_t *const payload = ccgen_layout_open(layout, node->next, frame);
    const uint8_t slot = (uint8_t)(node->next - layout->lengths_frames);
    uint8_t bytes = CCGEN_NODE_TIP_BYTES;
    if (slot >= layout->angles_frames) {
        ccgen_node_put_tip(node, payload);
    } else {
        const uint8_t first = (uint8_t)(slot * layout->angles_per_frame);
        const uint8_t left = (uint8_t)(layout->values - first);
        const uint8_t values = (left < layout->angles_per_frame) ? left : layout->angles_per_frame;
        if (node->estimated) {
            ccgen_node_put_angles(layout, angles, first, values, payload);
        } else {
            ccgen_node_put_no_reading(angles->narrow != NULL, values, payload);
        }
        bytes = (uint8_t)(values * layout->angle_bytes);
    }
    (void)ccgen_layout_close(layout, node->published, bytes, frame);
    node->handed = CCGEN_HANDED_ESTIMATE;
    node->next = (uint16_t)(node->next + 1u);
    return 1;
}

/** STATUS as the last frame of an answer, and what is due apart from answers. */
CCGEN_ONCE int ccgen_node_transmit_state(const ccgen_layout_t *const layout,
                                         ccgen_node_t *const node, ccgen_frame_t *const frame) {
    if (node->next == ccgen_layout_status_index(layout)) {
        node->next = (uint16_t)(node->next + 1u);
        return ccgen_node_transmit_status(layout, node, frame);
    }
    if (node->health.due) {
        return ccgen_node_transmit_health(layout, node, frame);
    }
    if ((layout->publish & CCGEN_PUBLISH_STATUS) == 0u) {
        return 0;
    }
    const uint32_t since_us = node->snapshot.now_us - node->status_us;
    if (node->status_again) {
        return ccgen_node_transmit_status(layout, node, frame);
    }
    if (since_us >= node->status_wait_us) {
        node->status_wait_us = layout->cycle_us;
        return ccgen_node_transmit_status(layout, node, frame);
    }
    return 0;
}

/** Notices how long ago things are, before the clock can come round. */
CCGEN_ONCE void ccgen_node_look(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                                const uint32_t now_us) {
    (void)ccgen_snapshot_tick(layout, &node->snapshot, now_us);
    /* Both stay due while other frames go first. */
    const uint32_t overdue_us = 2u * layout->cycle_us;
    if ((uint32_t)(node->snapshot.now_us - node->status_us) > overdue_us) {
        node->status_us = node->snapshot.now_us - overdue_us;
    }
    node->health.due = ccgen_health_due(layout, &node->health, node->snapshot.now_us);
    node->looked_us = node->snapshot.now_us;
}

CCGEN_INLINE int ccgen_node_transmit(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                                     const ccgen_node_angles_t *const angles, const uint32_t now_us,
                                     ccgen_frame_t *const frame) {
    const bool answers = (node->next < ccgen_layout_status_index(layout));
    /* What goes out of an answer does not depend on the time: once a cycle is enough there. */
    if (!answers || !ccgen_snapshot_pass(&node->snapshot, now_us) ||
        ((node->snapshot.now_us - node->looked_us) >= layout->cycle_us)) {
        ccgen_node_look(layout, node, now_us);
    }
    ccgen_node_settle(layout, node);
    ccgen_node_skip_unpublished(layout, node);
    if (node->next <= ccgen_layout_status_index(layout)) {
        node->status_wait_us = layout->cycle_us + layout->cycle_us / 2u;
    }
    if (node->next < ccgen_layout_status_index(layout)) {
        return ccgen_node_transmit_estimate(layout, node, angles, frame);
    }
    return ccgen_node_transmit_state(layout, node, frame);
}

/** \return whether a layout has values of so many bytes, and angles are where it has some. */
CCGEN_INLINE bool ccgen_node_are_angles(const ccgen_layout_t *const layout, const uint8_t bytes,
                                        const bool has_u, const bool has_v, const bool has_h) {
    return (layout->angle_bytes == bytes) && (has_u || (layout->rows[0] == 0u)) &&
           (has_v || (layout->rows[1] == 0u)) && (has_h || (layout->rows[2] == 0u));
}

/**
 * Fetches the next frame to send, for a joint of precision 16.
 * \param[in] layout
 * \param[in,out] node
 * \param[in] angles  of u, v and h, [rows] each, of the snapshot last published; NULL for an axis
 *                    without rows
 * \param[in] now_us
 * \param[out] frame  to send; written only with result 1
 * \return 1: send `frame` and call again; 0: nothing is due; CCGEN_ERROR_ARGUMENT for a null
 *         pointer, or a layout of the other precision
 */
static inline int ccgen_node_transmit16(const ccgen_layout_t *const layout,
                                        ccgen_node_t *const node,
                                        const int16_t *const angles[CCGEN_AXES_MAX],
                                        const uint32_t now_us, ccgen_frame_t *const frame) {
    const ccgen_node_angles_t of_either = {angles, NULL};
    if ((layout == NULL) || (node == NULL) || (angles == NULL) || (frame == NULL) ||
        !ccgen_node_are_angles(layout, 2, angles[0] != NULL, angles[1] != NULL,
                               angles[2] != NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    return ccgen_node_transmit(layout, node, &of_either, now_us, frame);
}

/** The same for a joint of precision 32. */
static inline int ccgen_node_transmit32(const ccgen_layout_t *const layout,
                                        ccgen_node_t *const node,
                                        const int32_t *const angles[CCGEN_AXES_MAX],
                                        const uint32_t now_us, ccgen_frame_t *const frame) {
    const ccgen_node_angles_t of_either = {NULL, angles};
    if ((layout == NULL) || (node == NULL) || (angles == NULL) || (frame == NULL) ||
        !ccgen_node_are_angles(layout, 4, angles[0] != NULL, angles[1] != NULL,
                               angles[2] != NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    return ccgen_node_transmit(layout, node, &of_either, now_us, frame);
}

/**
 * Takes back the frame that transmit handed out last, for it could not be sent: the next call of
 * transmit gives it again, a STATUS with all its faults.
 * \param[in,out] node
 * \return 1: it comes again; 0: there is none, or a newer snapshot has replaced its answer;
 *         CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_node_unsent(ccgen_node_t *const node) {
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

#endif /* CCGEN_NODE_INLINE_H */
