#include "ccgen/snapshot.h"

#define STALE_CYCLES 3u
#define US_PER_MS 1000u
#define BEHIND_US 0x80000000u /* a time that seems this far ahead or more lies behind */

static void set_fault(ccgen_snapshot_t *const snapshot, const uint8_t fault) {
    snapshot->faults |= fault;
    snapshot->recent |= fault;
}

static void flag(ccgen_snapshot_t *const snapshot, uint32_t *const count, const uint8_t fault) {
    *count += 1u;
    set_fault(snapshot, fault);
}

int ccgen_snapshot_init(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot) {
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

int ccgen_snapshot_set_window(ccgen_snapshot_t *const snapshot, const uint32_t window_us) {
    if ((snapshot == NULL) || (window_us == 0u) || (window_us > snapshot->window_max_us)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    snapshot->window_us = window_us;
    return CCGEN_OK;
}

/** \return the later of a time and the latest that was told. */
static uint32_t latest_us(const ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    return ((now_us - snapshot->now_us) < BEHIND_US) ? now_us : snapshot->now_us;
}

/** Forgets the number after silence, so that a restarted sender is heard. */
static void notice_silence(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot) {
    const uint32_t cycles_us = STALE_CYCLES * layout->cycle_us;
    const uint32_t limit_us = (cycles_us > snapshot->window_us) ? cycles_us : snapshot->window_us;
    if ((snapshot->phase == CCGEN_SNAPSHOT_NONE) ||
        ((snapshot->now_us - snapshot->heard_us) <= limit_us)) {
        return;
    }
    if (snapshot->phase == CCGEN_SNAPSHOT_PENDING) {
        flag(snapshot, &snapshot->lost, CCGEN_FAULT_LOST);
    }
    snapshot->phase = CCGEN_SNAPSHOT_NONE;
}

/** Latches how long ago the latest complete snapshot is, before the clock can wrap around. */
static void notice_age(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot) {
    const uint32_t age_us = snapshot->now_us - snapshot->complete_us;
    if (age_us >= (CCGEN_AGE_MAX_MS * (uint32_t)US_PER_MS)) {
        snapshot->aged = true;
    }
    if (age_us > (STALE_CYCLES * layout->cycle_us)) {
        snapshot->stale = true;
    }
    if (snapshot->stale) {
        set_fault(snapshot, CCGEN_FAULT_STALE);
    }
}

int ccgen_snapshot_tick(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                        const uint32_t now_us) {
    if ((layout == NULL) || (snapshot == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (!snapshot->started) {
        snapshot->started = true;
        snapshot->now_us = now_us;
        snapshot->complete_us = now_us;
    }
    snapshot->now_us = latest_us(snapshot, now_us);
    notice_silence(layout, snapshot);
    notice_age(layout, snapshot);
    return CCGEN_OK;
}

uint8_t ccgen_snapshot_age_ms(const ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    if ((snapshot == NULL) || snapshot->aged) {
        return CCGEN_AGE_MAX_MS;
    }
    const uint32_t age_ms = (latest_us(snapshot, now_us) - snapshot->complete_us) / US_PER_MS;
    return (uint8_t)((age_ms < CCGEN_AGE_MAX_MS) ? age_ms : CCGEN_AGE_MAX_MS);
}

/** \return the frame's number; negative when it was counted as harmed. */
static int check_frame(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                       const ccgen_frame_t *const frame) {
    const int number = ccgen_layout_check(layout, frame);
    if (number == CCGEN_ERROR_CRC) {
        flag(snapshot, &snapshot->corrupted, CCGEN_FAULT_CRC);
    } else if (number < 0) {
        flag(snapshot, &snapshot->malformed, CCGEN_FAULT_FORMAT);
    }
    return number;
}

/** \return a count of the frame; INT32_MIN for "no reading", whatever the count's width. */
static int32_t count_in(const ccgen_layout_t *const layout, const uint8_t *const signal) {
    const int32_t count = ccgen_get_signed(signal, layout->count_bytes);
    return (count == ccgen_no_reading(layout->count_bytes)) ? INT32_MIN : count;
}

/** Compares a frame's counts with those in its place, or puts them there. \return whether they were
 * the same. */
static bool place(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                  const ccgen_frame_t *const frame, const uint16_t slot, const bool store) {
    const uint8_t per_frame = ccgen_layout_slots(layout, layout->count_bytes);
    const uint8_t *signal = frame->data + ccgen_e2e_header(ccgen_layout_profile(layout));
    uint16_t index = (uint16_t)(slot * per_frame);
    bool same = true;
    for (uint8_t i = 0; (i < per_frame) && (index < layout->sensors); ++i) {
        const int32_t count = count_in(layout, signal);
        same = same && (count == snapshot->pending[index]);
        if (store) {
            snapshot->pending[index] = count;
        }
        signal += layout->count_bytes;
        ++index;
    }
    return same;
}

static bool is_taken(const ccgen_snapshot_t *const snapshot, const uint16_t slot) {
    return (snapshot->received & (1u << slot)) != 0u;
}

static void begin(ccgen_snapshot_t *const snapshot, const uint8_t number) {
    snapshot->phase = CCGEN_SNAPSHOT_PENDING;
    snapshot->newest = number;
    snapshot->received = 0;
    snapshot->first_us = snapshot->now_us;
}

/** Begins a newer snapshot and counts those that were lost on the way to it. */
static void begin_newer(ccgen_snapshot_t *const snapshot, const uint8_t number,
                        const uint16_t ahead) {
    const bool interrupted = (snapshot->phase == CCGEN_SNAPSHOT_PENDING);
    const uint32_t lost = (uint32_t)ahead - (interrupted ? 0u : 1u);
    if (lost > 0u) {
        snapshot->lost += lost;
        set_fault(snapshot, CCGEN_FAULT_LOST);
    }
    begin(snapshot, number);
}

/** Takes a frame of the newest number. \return whether it belongs to the snapshot in progress. */
static bool follow_newest(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                          const ccgen_frame_t *const frame, const uint16_t slot) {
    if (is_taken(snapshot, slot) && !place(layout, snapshot, frame, slot, false)) {
        if (snapshot->phase == CCGEN_SNAPSHOT_PENDING) {
            flag(snapshot, &snapshot->lost, CCGEN_FAULT_LOST);
        }
        begin(snapshot, snapshot->newest);
    }
    if (snapshot->phase == CCGEN_SNAPSHOT_COMPLETE) {
        flag(snapshot, &snapshot->repeated, CCGEN_FAULT_REPEATED);
    }
    return snapshot->phase == CCGEN_SNAPSHOT_PENDING;
}

/** \return whether the frame belongs to the snapshot in progress, which it may have begun. */
static bool follow(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                   const ccgen_frame_t *const frame, const uint16_t slot, const uint8_t number) {
    const uint16_t numbers = ccgen_layout_numbers(layout);
    const uint16_t wrapped = (number < snapshot->newest) ? numbers : 0u;
    const uint16_t ahead = (uint16_t)(number + wrapped - snapshot->newest);
    if (snapshot->phase == CCGEN_SNAPSHOT_NONE) {
        begin(snapshot, number);
    } else if (ahead >= ((numbers + 1u) / 2u)) {
        flag(snapshot, &snapshot->reordered, CCGEN_FAULT_REORDERED);
        return false;
    } else if (ahead > 0u) {
        begin_newer(snapshot, number, ahead);
    } else {
        snapshot->heard_us = snapshot->now_us;
        return follow_newest(layout, snapshot, frame, slot);
    }
    snapshot->heard_us = snapshot->now_us;
    return true;
}

static void complete(ccgen_snapshot_t *const snapshot) {
    for (uint8_t i = 0; i < CCGEN_SENSORS_MAX; ++i) {
        snapshot->counts[i] = snapshot->pending[i];
    }
    snapshot->number = snapshot->newest;
    snapshot->phase = CCGEN_SNAPSHOT_COMPLETE;
    snapshot->snapshots += 1u;
    snapshot->complete_us = snapshot->now_us;
    snapshot->stale = false;
    snapshot->aged = false;
}

int ccgen_snapshot_receive(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                           const ccgen_frame_t *const frame, const uint32_t now_us) {
    uint16_t slot = 0;
    if ((layout == NULL) || (snapshot == NULL) || (frame == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    (void)ccgen_snapshot_tick(layout, snapshot, now_us);
    if (ccgen_layout_kind(layout, frame, &slot) != CCGEN_FRAME_LENGTHS) {
        return 0;
    }
    const int number = check_frame(layout, snapshot, frame);
    if ((number < 0) || !follow(layout, snapshot, frame, slot, (uint8_t)number)) {
        return 0;
    }
    if ((snapshot->now_us - snapshot->first_us) > snapshot->window_us) {
        flag(snapshot, &snapshot->late, CCGEN_FAULT_LATE);
        snapshot->phase = CCGEN_SNAPSHOT_DROPPED;
        return 0;
    }
    if (is_taken(snapshot, slot)) {
        flag(snapshot, &snapshot->repeated, CCGEN_FAULT_REPEATED);
        return 0;
    }
    (void)place(layout, snapshot, frame, slot, true);
    snapshot->received = (uint16_t)(snapshot->received | (1u << slot));
    const uint32_t all = ((uint32_t)1u << ccgen_layout_lengths_frames(layout)) - 1u;
    if (snapshot->received != all) {
        return 0;
    }
    complete(snapshot);
    return 1;
}
