/**
 * \file check.c
 * \brief The checks of a group of sensors, the watch over it and what serves without a sensor, for
 * Python and from plain tables.
 */
#include "ccgen/check16.h"
#include "ccgen/check32.h"
#include "ccgen/serving16.h"
#include "ccgen/serving32.h"

#define WORDS_MAX ((CCGEN_SENSORS_MAX + 1) / 2)

uint8_t probe_check16(uint8_t sensors, int narrow, const int16_t *weights, const int32_t *threshold,
                      const int32_t *margin, const int16_t *zero, const int16_t *counts);
uint8_t probe_check32(uint8_t sensors, const int32_t *weights, const int64_t *threshold,
                      const int64_t *margin, const int32_t *zero, const int32_t *counts);
int probe_serving16(uint8_t sensors, uint32_t without, uint32_t absent);
int probe_serving32(uint8_t sensors, uint32_t without, uint32_t absent);
void probe_blank16(uint16_t segments, int16_t *angles);
void probe_blank32(uint16_t segments, int32_t *angles);
void probe_watch_init(uint8_t *state);
void probe_watch_follow(uint8_t *state, int complete, uint8_t verdict, uint16_t *masks);

uint8_t probe_check16(const uint8_t sensors, const int narrow, const int16_t *const weights,
                      const int32_t *const threshold, const int32_t *const margin,
                      const int16_t *const zero, const int16_t *const counts) {
    uint32_t words[CCGEN_SENSORS_MAX * WORDS_MAX];
    uint16_t next = 0;
    for (uint8_t j = 0; j < sensors; ++j) {
        const int16_t *const row = weights + (size_t)j * sensors;
        for (uint8_t k = 0; k < sensors; k = (uint8_t)(k + 2u)) {
            const int16_t high = ((k + 1u) < sensors) ? row[k + 1u] : (int16_t)0;
            words[next] = CCGEN_PAIR(row[k], high);
            ++next;
        }
    }
    const ccgen_axis16_t rows = {sensors, sensors, 0, 0, false, narrow != 0, 0, NULL, words};
    const ccgen_check16_t check = {threshold, margin};
    return ccgen_check16(&rows, &check, zero, counts);
}

uint8_t probe_check32(const uint8_t sensors, const int32_t *const weights,
                      const int64_t *const threshold, const int64_t *const margin,
                      const int32_t *const zero, const int32_t *const counts) {
    const ccgen_axis32_t rows = {sensors, sensors, 0, 0, false, 0, NULL, weights};
    const ccgen_check32_t check = {threshold, margin};
    return ccgen_check32(&rows, &check, zero, counts);
}

/** Number of the rows that serve; -1: the axis' own; -2: none. `without`: who has rows. */
int probe_serving16(const uint8_t sensors, const uint32_t without, const uint32_t absent) {
    static const uint32_t weights[1] = {0};
    const ccgen_axis16_t none = CCGEN_ZERO;
    ccgen_axis16_t own = CCGEN_ZERO;
    ccgen_axis16_t others[CCGEN_SENSORS_MAX];
    own.rows = weights;
    for (uint8_t j = 0; j < CCGEN_SENSORS_MAX; ++j) {
        const bool has = (j < sensors) && (((without >> j) & 1u) != 0u);
        others[j] = has ? own : none;
    }
    const ccgen_axis16_t *const found = ccgen_serving16(&own, others, absent);
    return (found == NULL) ? -2 : (found == &own) ? -1 : (int)(found - others);
}

void probe_blank16(const uint16_t segments, int16_t *const angles) {
    ccgen_blank16(segments, angles);
}

/** Number of the rows that serve; -1: the axis' own; -2: none. `without`: who has rows. */
int probe_serving32(const uint8_t sensors, const uint32_t without, const uint32_t absent) {
    static const int32_t weights[1] = {0};
    const ccgen_axis32_t none = CCGEN_ZERO;
    ccgen_axis32_t own = CCGEN_ZERO;
    ccgen_axis32_t others[CCGEN_SENSORS_MAX];
    own.weights = weights;
    for (uint8_t j = 0; j < CCGEN_SENSORS_MAX; ++j) {
        const bool has = (j < sensors) && (((without >> j) & 1u) != 0u);
        others[j] = has ? own : none;
    }
    const ccgen_axis32_t *const found = ccgen_serving32(&own, others, absent);
    return (found == NULL) ? -2 : (found == &own) ? -1 : (int)(found - others);
}

void probe_blank32(const uint16_t segments, int32_t *const angles) {
    ccgen_blank32(segments, angles);
}

static ccgen_watch_t watch_of(const uint8_t *const state) {
    ccgen_watch_t watch;
    watch.sensor = state[0];
    watch.run = state[1];
    watch.out = (state[2] != 0u);
    return watch;
}

static void keep(const ccgen_watch_t *const watch, uint8_t *const state) {
    state[0] = watch->sensor;
    state[1] = watch->run;
    state[2] = watch->out ? 1u : 0u;
}

void probe_watch_init(uint8_t *const state) {
    ccgen_watch_t watch;
    ccgen_watch_init(&watch);
    keep(&watch, state);
}

void probe_watch_follow(uint8_t *const state, const int complete, const uint8_t verdict,
                        uint16_t *const masks) {
    ccgen_watch_t watch = watch_of(state);
    if (complete != 0) {
        ccgen_watch_follow(&watch, verdict);
    } else {
        ccgen_watch_incomplete(&watch);
    }
    masks[0] = ccgen_watch_out(&watch);
    masks[1] = ccgen_watch_suspected(&watch, (complete != 0) ? verdict : CCGEN_VERDICT_QUIET);
    keep(&watch, state);
}
