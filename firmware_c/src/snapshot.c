#include "ccgen/snapshot.h"

#define STALE_CYCLES 3u
#define US_PER_MS 1000u

static void flag(ccgen_snapshot_t *const snapshot, uint32_t *const count, const uint8_t fault) {
    *count += 1u;
    snapshot->faults |= fault;
}

int ccgen_snapshot_init(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot) {
    if ((snapshot == NULL) || !ccgen_layout_valid(layout)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    /* Field by field: a state that is assigned whole is first built on the stack. */
    for (uint8_t i = 0; i < CCGEN_COUNTS_MAX; ++i) {
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
    snapshot->counter = 0;
    snapshot->window_us = layout->window_us;
    snapshot->first_us = 0;
    snapshot->heard_us = 0;
    snapshot->complete_us = 0;
    snapshot->received = 0;
    snapshot->newest = 0;
    snapshot->faults = 0;
    snapshot->phase = CCGEN_SNAPSHOT_NONE;
    snapshot->started = false;
    snapshot->stale = false;
    snapshot->aged = true;
    return CCGEN_OK;
}

int ccgen_snapshot_set_window(ccgen_snapshot_t *const snapshot, const uint32_t window_us) {
    if ((snapshot == NULL) || (window_us == 0u) || (window_us > CCGEN_PERIOD_MAX_US)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    snapshot->window_us = window_us;
    return CCGEN_OK;
}

/** Forgets the counter after silence, so that a restarted sender is heard. */
static void notice_silence(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                           const uint32_t now_us) {
    const uint32_t cycles_us = STALE_CYCLES * layout->cycle_us;
    const uint32_t limit_us = (cycles_us > snapshot->window_us) ? cycles_us : snapshot->window_us;
    if ((snapshot->phase == CCGEN_SNAPSHOT_NONE) || ((now_us - snapshot->heard_us) <= limit_us)) {
        return;
    }
    if (snapshot->phase == CCGEN_SNAPSHOT_PENDING) {
        flag(snapshot, &snapshot->lost, CCGEN_FAULT_LOST);
    }
    snapshot->phase = CCGEN_SNAPSHOT_NONE;
}

/** Latches how long ago the latest complete snapshot is, before the clock can wrap around. */
static void notice_age(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                       const uint32_t now_us) {
    const uint32_t age_us = now_us - snapshot->complete_us;
    if (age_us >= (CCGEN_AGE_MAX_MS * (uint32_t)US_PER_MS)) {
        snapshot->aged = true;
    }
    if (age_us > (STALE_CYCLES * layout->cycle_us)) {
        snapshot->stale = true;
    }
    if (snapshot->stale) {
        snapshot->faults |= CCGEN_FAULT_STALE;
    }
}

int ccgen_snapshot_tick(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                        const uint32_t now_us) {
    if ((layout == NULL) || (snapshot == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (!snapshot->started) {
        snapshot->started = true;
        snapshot->complete_us = now_us;
    }
    notice_silence(layout, snapshot, now_us);
    notice_age(layout, snapshot, now_us);
    return CCGEN_OK;
}

uint8_t ccgen_snapshot_age_ms(const ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    if ((snapshot == NULL) || snapshot->aged) {
        return CCGEN_AGE_MAX_MS;
    }
    const uint32_t age_ms = (now_us - snapshot->complete_us) / US_PER_MS;
    return (uint8_t)((age_ms < CCGEN_AGE_MAX_MS) ? age_ms : CCGEN_AGE_MAX_MS);
}

/** \return the frame's counter; negative when it was counted as harmed. */
static int check_frame(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                       const ccgen_frame_t *const frame) {
    int counter = CCGEN_ERROR_FORMAT;
    if (!frame->remote && (frame->fd == layout->fd) &&
        (frame->length == ccgen_layout_frame_length(layout))) {
        counter = ccgen_e2e_check(ccgen_layout_profile(layout), (uint16_t)(frame->id & 0xFFFFu),
                                  frame->data, frame->length);
    }
    if (counter == CCGEN_ERROR_CRC) {
        flag(snapshot, &snapshot->corrupted, CCGEN_FAULT_CRC);
    } else if (counter < 0) {
        flag(snapshot, &snapshot->malformed, CCGEN_FAULT_FORMAT);
    }
    return counter;
}

static void begin(ccgen_snapshot_t *const snapshot, const uint8_t counter, const uint32_t now_us) {
    snapshot->phase = CCGEN_SNAPSHOT_PENDING;
    snapshot->newest = counter;
    snapshot->received = 0;
    snapshot->first_us = now_us;
}

/** \return whether the frame belongs to the snapshot in progress, which it may have begun. */
static bool follow_counter(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                           const uint8_t counter, const uint32_t now_us) {
    const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    const uint16_t ahead = (uint16_t)(((uint16_t)(counter + modulus) - snapshot->newest) % modulus);
    if (snapshot->phase == CCGEN_SNAPSHOT_NONE) {
        begin(snapshot, counter, now_us);
        return true;
    }
    if (ahead >= ((modulus + 1u) / 2u)) {
        flag(snapshot, &snapshot->reordered, CCGEN_FAULT_REORDERED);
        return false;
    }
    snapshot->heard_us = now_us;
    if (ahead == 0u) {
        if (snapshot->phase == CCGEN_SNAPSHOT_COMPLETE) {
            flag(snapshot, &snapshot->repeated, CCGEN_FAULT_REPEATED);
        }
        return snapshot->phase == CCGEN_SNAPSHOT_PENDING;
    }
    const bool interrupted = (snapshot->phase == CCGEN_SNAPSHOT_PENDING);
    const uint32_t lost = (uint32_t)ahead - (interrupted ? 0u : 1u);
    if (lost > 0u) {
        snapshot->lost += lost;
        snapshot->faults |= CCGEN_FAULT_LOST;
    }
    begin(snapshot, counter, now_us);
    return true;
}

static void store(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                  const ccgen_frame_t *const frame, const uint16_t slot) {
    const uint8_t bytes = layout->count_bytes;
    const uint8_t per_frame = ccgen_layout_slots(layout, bytes);
    const uint16_t total = (uint16_t)(layout->sensors_u + layout->sensors_v);
    const uint8_t *signal = frame->data + ccgen_e2e_header(ccgen_layout_profile(layout));
    uint16_t index = (uint16_t)(slot * per_frame);
    for (uint8_t i = 0; (i < per_frame) && (index < total); ++i) {
        const int32_t count = ccgen_get_signed(signal, bytes);
        snapshot->pending[index] = (count == ccgen_no_reading(bytes)) ? INT32_MIN : count;
        signal += bytes;
        ++index;
    }
    snapshot->received = (uint16_t)(snapshot->received | (1u << slot));
}

static void complete(ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    for (uint8_t i = 0; i < CCGEN_COUNTS_MAX; ++i) {
        snapshot->counts[i] = snapshot->pending[i];
    }
    snapshot->counter = snapshot->newest;
    snapshot->phase = CCGEN_SNAPSHOT_COMPLETE;
    snapshot->snapshots += 1u;
    snapshot->complete_us = now_us;
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
    const int counter = check_frame(layout, snapshot, frame);
    if ((counter < 0) || !follow_counter(layout, snapshot, (uint8_t)counter, now_us)) {
        return 0;
    }
    snapshot->heard_us = now_us;
    if ((now_us - snapshot->first_us) > snapshot->window_us) {
        flag(snapshot, &snapshot->late, CCGEN_FAULT_LATE);
        snapshot->phase = CCGEN_SNAPSHOT_DROPPED;
        return 0;
    }
    if ((snapshot->received & (1u << slot)) != 0u) {
        flag(snapshot, &snapshot->repeated, CCGEN_FAULT_REPEATED);
        return 0;
    }
    store(layout, snapshot, frame, slot);
    const uint32_t all = ((uint32_t)1u << ccgen_layout_lengths_frames(layout)) - 1u;
    if (snapshot->received != all) {
        return 0;
    }
    complete(snapshot, now_us);
    return 1;
}
