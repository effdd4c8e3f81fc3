/**
 * \file snapshot_inline.h
 * \brief What snapshot.h describes, inline: where a joint's layout is known, it folds into code.
 */
#ifndef CCGEN_SNAPSHOT_INLINE_H
#define CCGEN_SNAPSHOT_INLINE_H

#include "ccgen/layout_inline.h"
#include "ccgen/snapshot.h"

#define CCGEN_SNAPSHOT_STALE_CYCLES 3u
#define CCGEN_SNAPSHOT_US_PER_MS 1000u

static inline void ccgen_snapshot_set_fault(ccgen_snapshot_t *const snapshot, const uint8_t fault) {
    snapshot->faults |= fault;
    snapshot->recent |= fault;
}

static inline void ccgen_snapshot_flag(ccgen_snapshot_t *const snapshot, uint32_t *const count,
                                       const uint8_t fault) {
    *count += 1u;
    ccgen_snapshot_set_fault(snapshot, fault);
}

static inline uint32_t ccgen_snapshot_longer(const uint32_t one_us, const uint32_t other_us) {
    return (one_us > other_us) ? one_us : other_us;
}

/**
 * Sets the state to: nothing received.
 * \param[in] layout
 * \param[out] snapshot
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer or an invalid layout
 */
static inline int ccgen_snapshot_init(const ccgen_layout_t *const layout,
                                      ccgen_snapshot_t *const snapshot) {
    if ((snapshot == NULL) || !ccgen_layout_valid(layout)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    /* Field by field: a state that is assigned whole is first built on the stack. */
    for (uint8_t i = 0; i < CCGEN_SENSORS_MAX; ++i) {
        snapshot->counts[i] = 0;
        snapshot->pending[i] = 0;
    }
    snapshot->snapshots = 0;
    snapshot->corrupted = 0;
    snapshot->malformed = 0;
    snapshot->repeated = 0;
    snapshot->reordered = 0;
    snapshot->lost = 0;
    snapshot->late = 0;
    snapshot->number = 0;
    snapshot->window_us = layout->window_us;
    snapshot->window_max_us = ccgen_layout_window_max_us(layout);
    snapshot->stale_us = CCGEN_SNAPSHOT_STALE_CYCLES * layout->cycle_us;
    snapshot->silence_us = ccgen_snapshot_longer(snapshot->stale_us, layout->window_us);
    snapshot->now_us = 0;
    snapshot->first_us = 0;
    snapshot->heard_us = 0;
    snapshot->complete_us = 0;
    snapshot->received = 0;
    snapshot->newest = 0;
    snapshot->faults = 0;
    snapshot->recent = 0;
    snapshot->phase = CCGEN_SNAPSHOT_NONE;
    snapshot->started = false;
    snapshot->stale = false;
    snapshot->aged = true;
    return CCGEN_OK;
}

/**
 * Replaces the window of the layout, for transports slower than the bus.
 * \param[in,out] snapshot
 * \param[in] window_us  1 to ccgen_layout_window_max_us()
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer or another window, which is not taken
 */
static inline int ccgen_snapshot_set_window(ccgen_snapshot_t *const snapshot,
                                            const uint32_t window_us) {
    if ((snapshot == NULL) || (window_us == 0u) || (window_us > snapshot->window_max_us)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    snapshot->window_us = window_us;
    snapshot->silence_us = ccgen_snapshot_longer(snapshot->stale_us, window_us);
    return CCGEN_OK;
}

/** \return the later of a time and the latest that was told. */
static inline uint32_t ccgen_snapshot_latest_us(const ccgen_snapshot_t *const snapshot,
                                                const uint32_t now_us) {
    return ((now_us - snapshot->now_us) < CCGEN_BEHIND_US) ? now_us : snapshot->now_us;
}

/** Forgets the number after silence, so that a restarted sender is heard. */
CCGEN_INLINE void ccgen_snapshot_notice_silence(ccgen_snapshot_t *const snapshot) {
    if ((snapshot->phase == CCGEN_SNAPSHOT_NONE) ||
        ((snapshot->now_us - snapshot->heard_us) <= snapshot->silence_us)) {
        return;
    }
    if (snapshot->phase == CCGEN_SNAPSHOT_PENDING) {
        ccgen_snapshot_flag(snapshot, &snapshot->lost, CCGEN_FAULT_LOST);
    }
    snapshot->phase = CCGEN_SNAPSHOT_NONE;
}

/** Latches how long ago the latest complete snapshot is, before the clock can wrap. */
CCGEN_INLINE void ccgen_snapshot_notice_age(ccgen_snapshot_t *const snapshot) {
    const uint32_t age_us = snapshot->now_us - snapshot->complete_us;
    if (age_us >= (CCGEN_AGE_MAX_MS * (uint32_t)CCGEN_SNAPSHOT_US_PER_MS)) {
        snapshot->aged = true;
    }
    if (age_us > snapshot->stale_us) {
        snapshot->stale = true;
    }
    if (snapshot->stale) {
        ccgen_snapshot_set_fault(snapshot, CCGEN_FAULT_STALE);
    }
}

CCGEN_INLINE void ccgen_snapshot_advance(ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    if (!snapshot->started) {
        snapshot->started = true;
        snapshot->now_us = now_us;
        snapshot->complete_us = now_us;
    }
    snapshot->now_us = ccgen_snapshot_latest_us(snapshot, now_us);
    ccgen_snapshot_notice_silence(snapshot);
    ccgen_snapshot_notice_age(snapshot);
}

/**
 * Notices silence: sets CCGEN_FAULT_STALE as long as it lasts.
 * \param[in] layout
 * \param[in,out] snapshot
 * \param[in] now_us
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_snapshot_tick(const ccgen_layout_t *const layout,
                                      ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    if ((layout == NULL) || (snapshot == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    ccgen_snapshot_advance(snapshot, now_us);
    return CCGEN_OK;
}

/**
 * \param[in] snapshot
 * \param[in] now_us
 * \return milliseconds since the latest complete snapshot, at most CCGEN_AGE_MAX_MS, which also
 *         means "never"; CCGEN_AGE_MAX_MS for a null pointer
 */
static inline uint8_t ccgen_snapshot_age_ms(const ccgen_snapshot_t *const snapshot,
                                            const uint32_t now_us) {
    if ((snapshot == NULL) || snapshot->aged) {
        return CCGEN_AGE_MAX_MS;
    }
    const uint32_t age_ms = (ccgen_snapshot_latest_us(snapshot, now_us) - snapshot->complete_us) /
                            CCGEN_SNAPSHOT_US_PER_MS;
    return (uint8_t)((age_ms < CCGEN_AGE_MAX_MS) ? age_ms : CCGEN_AGE_MAX_MS);
}

/** \return whether the latest complete snapshot is more than three cycles old. */
static inline bool ccgen_snapshot_is_stale(const ccgen_snapshot_t *const snapshot,
                                           const uint32_t now_us) {
    const uint32_t age_us = ccgen_snapshot_latest_us(snapshot, now_us) - snapshot->complete_us;
    return snapshot->stale || (age_us > snapshot->stale_us);
}

/** \return the frame's number; negative when it was counted as harmed. */
static inline int ccgen_snapshot_check_frame(const ccgen_layout_t *const layout,
                                             ccgen_snapshot_t *const snapshot,
                                             const ccgen_frame_t *const frame) {
    const int number = ccgen_layout_check(layout, frame);
    if (number == CCGEN_ERROR_CRC) {
        ccgen_snapshot_flag(snapshot, &snapshot->corrupted, CCGEN_FAULT_CRC);
    } else if (number < 0) {
        ccgen_snapshot_flag(snapshot, &snapshot->malformed, CCGEN_FAULT_FORMAT);
    } else {
        /* it is whole */
    }
    return number;
}

/** The counts of a frame: where they are in it and in the list of all, and how many. */
typedef struct {
    const uint8_t *signal;
    uint8_t first;
    uint8_t behind; /* the last */
} ccgen_snapshot_part_t;

static inline ccgen_snapshot_part_t ccgen_snapshot_part_of(const ccgen_layout_t *const layout,
                                                           const ccgen_frame_t *const frame,
                                                           const uint32_t slot) {
    const uint8_t first = (uint8_t)(slot * layout->counts_per_frame);
    const uint8_t left = (uint8_t)(layout->sensors - first);
    const bool is_last = left < layout->counts_per_frame;
    const ccgen_snapshot_part_t part = {
        &frame->data[ccgen_layout_header(layout)], first,
        is_last ? layout->sensors : (uint8_t)(first + layout->counts_per_frame)};
    return part;
}

/** \return whether a frame's counts are those in its place. */
static inline bool ccgen_snapshot_is_same(const ccgen_layout_t *const layout,
                                          const ccgen_snapshot_t *const snapshot,
                                          const ccgen_frame_t *const frame, const uint32_t slot) {
    ccgen_snapshot_part_t part = ccgen_snapshot_part_of(layout, frame, slot);
    for (; part.first < part.behind; ++part.first) {
        if (ccgen_get_count(part.signal, layout->count_bytes) != snapshot->pending[part.first]) {
            return false;
        }
        part.signal += layout->count_bytes;
    }
    return true;
}

/** Puts a frame's counts into their place. */
static inline void ccgen_snapshot_place(const ccgen_layout_t *const layout,
                                        ccgen_snapshot_t *const snapshot,
                                        const ccgen_frame_t *const frame, const uint32_t slot) {
    ccgen_snapshot_part_t part = ccgen_snapshot_part_of(layout, frame, slot);
    for (; part.first < part.behind; ++part.first) {
        snapshot->pending[part.first] = ccgen_get_count(part.signal, layout->count_bytes);
        part.signal += layout->count_bytes;
    }
}

static inline bool ccgen_snapshot_is_taken(const ccgen_snapshot_t *const snapshot,
                                           const uint32_t slot) {
    return (snapshot->received & (1u << slot)) != 0u;
}

static inline void ccgen_snapshot_begin(ccgen_snapshot_t *const snapshot, const uint8_t number) {
    snapshot->phase = CCGEN_SNAPSHOT_PENDING;
    snapshot->newest = number;
    snapshot->received = 0;
    snapshot->first_us = snapshot->now_us;
}

/** Begins a newer snapshot and counts those that were lost on the way to it. */
static inline void ccgen_snapshot_begin_newer(ccgen_snapshot_t *const snapshot,
                                              const uint8_t number, const uint16_t ahead) {
    const bool interrupted = (snapshot->phase == CCGEN_SNAPSHOT_PENDING);
    const uint32_t lost = (uint32_t)ahead - (interrupted ? 0u : 1u);
    if (lost > 0u) {
        snapshot->lost += lost;
        ccgen_snapshot_set_fault(snapshot, CCGEN_FAULT_LOST);
    }
    ccgen_snapshot_begin(snapshot, number);
}

/** Takes a frame of the newest number. \return whether it belongs to the snapshot in progress. */
static inline bool ccgen_snapshot_follow_newest(const ccgen_layout_t *const layout,
                                                ccgen_snapshot_t *const snapshot,
                                                const ccgen_frame_t *const frame,
                                                const uint32_t slot) {
    if (ccgen_snapshot_is_taken(snapshot, slot) &&
        !ccgen_snapshot_is_same(layout, snapshot, frame, slot)) {
        if (snapshot->phase == CCGEN_SNAPSHOT_PENDING) {
            ccgen_snapshot_flag(snapshot, &snapshot->lost, CCGEN_FAULT_LOST);
        }
        ccgen_snapshot_begin(snapshot, snapshot->newest);
    }
    if (snapshot->phase == CCGEN_SNAPSHOT_COMPLETE) {
        ccgen_snapshot_flag(snapshot, &snapshot->repeated, CCGEN_FAULT_REPEATED);
    }
    return snapshot->phase == CCGEN_SNAPSHOT_PENDING;
}

/** \return whether the frame belongs to the snapshot in progress, which it may have begun. */
static inline bool ccgen_snapshot_follow(const ccgen_layout_t *const layout,
                                         ccgen_snapshot_t *const snapshot,
                                         const ccgen_frame_t *const frame, const uint32_t slot,
                                         const uint8_t number) {
    const uint16_t numbers = layout->numbers;
    const uint16_t wrapped = (number < snapshot->newest) ? numbers : 0u;
    const uint16_t ahead = (uint16_t)(number + wrapped - snapshot->newest);
    if (snapshot->phase == CCGEN_SNAPSHOT_NONE) {
        ccgen_snapshot_begin(snapshot, number);
    } else if (ahead >= ((numbers + 1u) / 2u)) {
        ccgen_snapshot_flag(snapshot, &snapshot->reordered, CCGEN_FAULT_REORDERED);
        return false;
    } else if (ahead > 0u) {
        ccgen_snapshot_begin_newer(snapshot, number, ahead);
    } else {
        snapshot->heard_us = snapshot->now_us;
        return ccgen_snapshot_follow_newest(layout, snapshot, frame, slot);
    }
    snapshot->heard_us = snapshot->now_us;
    return true;
}

static inline void ccgen_snapshot_complete(const ccgen_layout_t *const layout,
                                           ccgen_snapshot_t *const snapshot) {
    for (uint8_t i = 0; i < layout->sensors; ++i) {
        snapshot->counts[i] = snapshot->pending[i];
    }
    snapshot->number = snapshot->newest;
    snapshot->phase = CCGEN_SNAPSHOT_COMPLETE;
    snapshot->snapshots += 1u;
    snapshot->complete_us = snapshot->now_us;
    snapshot->stale = false;
    snapshot->aged = false;
}

/**
 * Completes a snapshot of the node's own sensors, whose counts stand in `pending`: it takes the
 * number behind that of the latest, 0 for the first. A snapshot of frames that was incomplete is
 * lost.
 * \param[in] layout
 * \param[in,out] snapshot
 * \param[in] now_us  when they were read
 * \return 1, or CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_snapshot_own(const ccgen_layout_t *const layout,
                                     ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    if ((layout == NULL) || (snapshot == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    ccgen_snapshot_advance(snapshot, now_us);
    const uint16_t next = (snapshot->snapshots > 0u) ? (uint16_t)(snapshot->number + 1u) : 0u;
    ccgen_snapshot_begin_newer(snapshot, (uint8_t)((next < layout->numbers) ? next : 0u), 1u);
    snapshot->heard_us = snapshot->now_us;
    ccgen_snapshot_complete(layout, snapshot);
    return 1;
}

/**
 * Takes one frame.
 * \param[in] layout
 * \param[in,out] snapshot
 * \param[in] frame   any frame of the bus
 * \param[in] now_us  time of arrival
 * \return 1: a snapshot is complete, its counts stand in `counts`; 0: not yet, not ours, or dropped
 *         and counted; CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_snapshot_receive(const ccgen_layout_t *const layout,
                                         ccgen_snapshot_t *const snapshot,
                                         const ccgen_frame_t *const frame, const uint32_t now_us) {
    if ((layout == NULL) || (snapshot == NULL) || (frame == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    ccgen_snapshot_advance(snapshot, now_us);
    const uint32_t slot = frame->id - layout->base_id;
    if ((slot >= layout->lengths_frames) || (frame->extended != layout->extended)) {
        return 0;
    }
    const int number = ccgen_snapshot_check_frame(layout, snapshot, frame);
    if ((number < 0) || !ccgen_snapshot_follow(layout, snapshot, frame, slot, (uint8_t)number)) {
        return 0;
    }
    if ((snapshot->now_us - snapshot->first_us) > snapshot->window_us) {
        ccgen_snapshot_flag(snapshot, &snapshot->late, CCGEN_FAULT_LATE);
        snapshot->phase = CCGEN_SNAPSHOT_DROPPED;
        return 0;
    }
    if (ccgen_snapshot_is_taken(snapshot, slot)) {
        ccgen_snapshot_flag(snapshot, &snapshot->repeated, CCGEN_FAULT_REPEATED);
        return 0;
    }
    ccgen_snapshot_place(layout, snapshot, frame, slot);
    snapshot->received = (uint16_t)(snapshot->received | (1u << slot));
    const uint32_t all = ((uint32_t)1u << layout->lengths_frames) - 1u;
    if (snapshot->received != all) {
        return 0;
    }
    ccgen_snapshot_complete(layout, snapshot);
    return 1;
}

#endif /* CCGEN_SNAPSHOT_INLINE_H */
