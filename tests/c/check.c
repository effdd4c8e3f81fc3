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

uint8_t probe_check16(const uint8_t *sizes, int narrow, const int16_t *weights,
                      const int16_t *directions, const int32_t *threshold, const int32_t *margin,
                      const int16_t *zero, const int16_t *counts);
uint8_t probe_check32(const uint8_t *sizes, const int32_t *weights, const int16_t *directions,
                      const int32_t *threshold, const int32_t *margin, const int32_t *zero,
                      const int32_t *counts);
int probe_quiet16(const uint8_t *sizes, int narrow, const int16_t *weights, const int16_t *zero,
                  const int16_t *counts);
int probe_quiet32(const uint8_t *sizes, const int32_t *weights, const int32_t *zero,
                  const int32_t *counts);
int probe_serving16(uint8_t sensors, uint32_t without, uint32_t absent);
int probe_serving32(uint8_t sensors, uint32_t without, uint32_t absent);
void probe_blank16(uint16_t segments, int16_t *angles);
void probe_blank32(uint16_t segments, int32_t *angles);
void probe_watch_init(uint8_t *state);
void probe_watch_follow(uint8_t *state, int complete, uint8_t verdict, uint16_t *masks);

/** Words of a table of weights. */
static void pair_up(const uint8_t sensors, const int16_t *const weights, uint32_t *const words) {
    uint16_t next = 0;
    for (uint8_t j = 0; j < sensors; ++j) {
        const int16_t *const row = weights + (size_t)j * sensors;
        for (uint8_t k = 0; k < sensors; k = (uint8_t)(k + 2u)) {
            const int16_t high = ((k + 1u) < sensors) ? row[k + 1u] : (int16_t)0;
            words[next] = CCGEN_PAIR(row[k], high);
            ++next;
        }
    }
}

/** In the place of a verdict: what is quiet has another verdict when it is examined. */
#define HIDDEN 0xFDu

/** sizes: sensors, kept, quiet_bits, shift. */
uint8_t probe_check16(const uint8_t *const sizes, const int narrow, const int16_t *const weights,
                      const int16_t *const directions, const int32_t *const threshold,
                      const int32_t *const margin, const int16_t *const zero,
                      const int16_t *const counts) {
    uint32_t words[CCGEN_SENSORS_MAX * WORDS_MAX];
    const uint8_t sensors = sizes[0];
    pair_up(sensors, weights, words);
    const ccgen_axis16_t rows = {sensors, sensors, 0, 0, false, narrow != 0, 0, NULL, words};
    const ccgen_check_t check = {directions, threshold, margin, sensors,
                                 sizes[1],   sizes[2],  sizes[3]};
    const bool quiet = ccgen_check16(&rows, &check, zero, counts);
    const uint8_t verdict = ccgen_examine16(&rows, &check, zero, counts);
    return (quiet && (verdict != CCGEN_VERDICT_QUIET)) ? HIDDEN : verdict;
}

/** Whether the same snapshot is quiet. */
int probe_quiet16(const uint8_t *const sizes, const int narrow, const int16_t *const weights,
                  const int16_t *const zero, const int16_t *const counts) {
    uint32_t words[CCGEN_SENSORS_MAX * WORDS_MAX];
    const uint8_t sensors = sizes[0];
    pair_up(sensors, weights, words);
    const ccgen_axis16_t rows = {sensors, sensors, 0, 0, false, narrow != 0, 0, NULL, words};
    const ccgen_check_t check = {NULL, NULL, NULL, sensors, sizes[1], sizes[2], sizes[3]};
    return ccgen_check16(&rows, &check, zero, counts) ? 1 : 0;
}

uint8_t probe_check32(const uint8_t *const sizes, const int32_t *const weights,
                      const int16_t *const directions, const int32_t *const threshold,
                      const int32_t *const margin, const int32_t *const zero,
                      const int32_t *const counts) {
    const ccgen_axis32_t rows = {sizes[0], sizes[0], 0, 0, false, 0, NULL, weights};
    const ccgen_check_t check = {directions, threshold, margin,  sizes[0],
                                 sizes[1],   sizes[2],  sizes[3]};
    const bool quiet = ccgen_check32(&rows, &check, zero, counts);
    const uint8_t verdict = ccgen_examine32(&rows, &check, zero, counts);
    return (quiet && (verdict != CCGEN_VERDICT_QUIET)) ? HIDDEN : verdict;
}

int probe_quiet32(const uint8_t *const sizes, const int32_t *const weights,
                  const int32_t *const zero, const int32_t *const counts) {
    const ccgen_axis32_t rows = {sizes[0], sizes[0], 0, 0, false, 0, NULL, weights};
    const ccgen_check_t check = {NULL, NULL, NULL, sizes[0], sizes[1], sizes[2], sizes[3]};
    return ccgen_check32(&rows, &check, zero, counts) ? 1 : 0;
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
