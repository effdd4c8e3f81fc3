/**
 * \file rule.h
 * \brief The rule of snapshot.h, said again: without bits and CRCs, with a clock that never wraps.
 *
 * A frame is its number, its place among the LENGTHS frames and the bytes of its counts; `sending`
 * is what an observer knows of where it comes from, and the rule does not look at it.
 */
#ifndef RULE_H
#define RULE_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define RULE_PLACES 16
#define RULE_BYTES 64

typedef enum { RULE_NONE, RULE_PENDING, RULE_COMPLETE, RULE_LATE } rule_phase_t;

typedef struct {
    bool taken;
    uint32_t sending;
    uint64_t at_us;
    uint8_t length;
    uint8_t bytes[RULE_BYTES];
} rule_place_t;

typedef struct {
    int numbers;
    int places;
    uint64_t cycle_us;
    uint64_t window_us;
    rule_phase_t phase;
    int newest;
    uint64_t first_us;
    uint64_t heard_us;
    rule_place_t taken[RULE_PLACES];
    uint32_t snapshots;
    uint32_t repeated;
    uint32_t reordered;
    uint32_t lost;
    uint32_t late;
} rule_t;

static inline void rule_start(rule_t *const rule, const int numbers, const int places,
                              const uint64_t cycle_us, const uint64_t window_us) {
    memset(rule, 0, sizeof *rule);
    rule->numbers = numbers;
    rule->places = places;
    rule->cycle_us = cycle_us;
    rule->window_us = window_us;
}

/** Whatever else happens at a time: after silence any number begins a snapshot. */
static inline void rule_pass(rule_t *const rule, const uint64_t now_us) {
    const uint64_t cycles_us = 3u * rule->cycle_us;
    const uint64_t limit_us = (cycles_us > rule->window_us) ? cycles_us : rule->window_us;
    if ((rule->phase != RULE_NONE) && ((now_us - rule->heard_us) > limit_us)) {
        rule->lost += (rule->phase == RULE_PENDING) ? 1u : 0u;
        rule->phase = RULE_NONE;
    }
}

static inline void rule_begin(rule_t *const rule, const int number, const uint64_t now_us) {
    memset(rule->taken, 0, sizeof rule->taken);
    rule->phase = RULE_PENDING;
    rule->newest = number;
    rule->first_us = now_us;
}

/** Puts a frame of the newest number into its place. \return whether that completes the snapshot.
 */
static inline bool rule_put(rule_t *const rule, const int place, const rule_place_t *const frame) {
    int taken = 0;
    if (rule->phase != RULE_PENDING) {
        rule->repeated += (rule->phase == RULE_COMPLETE) ? 1u : 0u;
        return false;
    }
    if ((frame->at_us - rule->first_us) > rule->window_us) {
        rule->late += 1u;
        rule->phase = RULE_LATE;
        return false;
    }
    if (rule->taken[place].taken) {
        rule->repeated += 1u;
        return false;
    }
    rule->taken[place] = *frame;
    for (int k = 0; k < rule->places; ++k) {
        taken += rule->taken[k].taken ? 1 : 0;
    }
    if (taken < rule->places) {
        return false;
    }
    rule->phase = RULE_COMPLETE;
    rule->snapshots += 1u;
    return true;
}

/** Takes an unharmed LENGTHS frame. \return whether it completes a snapshot: that in `taken`. */
static inline bool rule_receive(rule_t *const rule, const int number, const int place,
                                const rule_place_t *const frame) {
    const rule_place_t *const there = &rule->taken[place];
    const uint32_t interrupted = (rule->phase == RULE_PENDING) ? 1u : 0u;
    const int ahead = (number - rule->newest + rule->numbers) % rule->numbers;
    if (rule->phase == RULE_NONE) {
        rule_begin(rule, number, frame->at_us);
    } else if ((2 * ahead) >= rule->numbers) {
        rule->reordered += 1u;
        return false;
    } else if (ahead > 0) {
        rule->lost += (uint32_t)ahead - 1u + interrupted;
        rule_begin(rule, number, frame->at_us);
    } else if (there->taken && (memcmp(there->bytes, frame->bytes, frame->length) != 0)) {
        rule->lost += interrupted;
        rule_begin(rule, number, frame->at_us);
    }
    rule->heard_us = frame->at_us;
    return rule_put(rule, place, frame);
}

#endif /* RULE_H */
