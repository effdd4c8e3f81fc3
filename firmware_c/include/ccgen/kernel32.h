/**
 * \file kernel32.h
 * \brief The sums and angles of estimator32.h, with one SMLAL a sensor where the core has it.
 *
 * Internal to estimator32.h. All arithmetic is modulo 2^64: sums that the exporter's proof covers
 * are exact, and no input overflows a signed type. Same bits on every core.
 */
#ifndef CCGEN_KERNEL32_H
#define CCGEN_KERNEL32_H

#include "ccgen/axis32.h"
#include "ccgen/integer.h"
#include "ccgen/load.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What one snapshot contributes to every segment. */
typedef struct {
    uint32_t start_low;                         /**< what every sum begins with */
    uint32_t start_high;
    int32_t difference[CCGEN_SENSORS_MAX]; /**< count - zero, 0 where there is no sensor */
} ccgen_factors32_t;

/** \return count - zero of one sensor modulo 2^32, 0 where the axis has no such sensor. */
CCGEN_INLINE int32_t ccgen_axis32_difference(const ccgen_axis32_t *const axis,
                                             const int32_t *const zero, const int32_t *const counts,
                                             const uint8_t sensor) {
    return (sensor < axis->sensors)
               ? ccgen_signed32((uint32_t)counts[sensor] - (uint32_t)zero[sensor])
               : 0;
}

/**
 * Adds the product of one weight with its sensor's difference.
 * Sums modulo 2^64: sums that the proof covers are exact, and no input overflows a signed type.
 */
CCGEN_INLINE uint64_t ccgen_axis32_add(const ccgen_axis32_t *const axis, const uint64_t sum,
                                       const uint32_t weight,
                                       const ccgen_factors32_t *const factors,
                                       const uint8_t sensor) {
    if (sensor >= axis->sensors) {
        return sum;
    }
#if CCGEN_HAS_THUMB2_LOAD
    uint32_t low = (uint32_t)(sum & 0xFFFFFFFFu);
    uint32_t high = (uint32_t)(sum >> 32);
    __asm__("smlal %0, %1, %2, %3"
            : "+r"(low), "+r"(high)
            : "r"(weight), "r"(factors->difference[sensor]));
    return ((uint64_t)high << 32) | low;
#else
    /* MISRA 10.8 */
    return sum + (uint64_t)((int64_t)ccgen_signed32(weight) * factors->difference[sensor]);
#endif
}

/** \return sum and the products of sensors 2k and 2k + 1, whose weights stand at *row. */
CCGEN_INLINE uint64_t ccgen_axis32_add_pair(const ccgen_axis32_t *const axis, const uint64_t sum,
                                            const ccgen_factors32_t *const factors,
                                            const uint32_t **const row, const uint8_t k) {
    const uint8_t sensor = (uint8_t)(2u * k);
    uint32_t first = 0;
    uint32_t second = 0;
    if (axis->sensors > (sensor + 1u)) {
        ccgen_load_two(row, &first, &second);
    } else if (axis->sensors > sensor) {
        first = ccgen_load(row);
    } else {
        return sum;
    }
    const uint64_t half = ccgen_axis32_add(axis, sum, first, factors, sensor);
    return ccgen_axis32_add(axis, half, second, factors, (uint8_t)(sensor + 1u));
}

/** \return what sums of a saturating axis are too high by: 2^31 steps. */
CCGEN_INLINE uint64_t ccgen_axis32_offset(const ccgen_axis32_t *const axis) {
    return axis->saturates ? ((uint64_t)0x80000000u << axis->shift) : 0u;
}

/**
 * Turns a sum into an angle.
 * A saturating axis's sum is 2^31 steps high. The sum's magnitude is below 2^63 and 2^31 steps are
 * at most 2^63: what lies below the range wraps to numbers above it and never into it, so that the
 * upper word alone tells what lies outside. The lowest pattern is clipped to the lowest angle.
 */
CCGEN_INLINE int32_t ccgen_axis32_angle(const ccgen_axis32_t *const axis, const uint64_t sum) {
    if (!axis->saturates) {
        const uint64_t angle = (uint64_t)(ccgen_signed64(sum) >> axis->shift); /* MISRA 10.1 */
        return ccgen_signed32((uint32_t)(angle & 0xFFFFFFFFu));
    }
    uint32_t steps = (uint32_t)((sum >> axis->shift) & 0xFFFFFFFFu);
    if (CCGEN_RARELY((sum >> 32) >= ((uint64_t)1 << axis->shift))) {
        const uint64_t without = sum - ccgen_axis32_offset(axis);
        steps = (without > (uint64_t)INT64_MAX) ? 0u : 0xFFFFFFFFu;
    }
    steps = (steps == 0u) ? 1u : steps;
    return ccgen_signed32(steps ^ 0x80000000u);
}

/** Estimates segment k of a turn from its row at *row, which moves on to the next. */
CCGEN_INLINE void ccgen_axis32_segment(const ccgen_axis32_t *const axis,
                                       const ccgen_factors32_t *const factors,
                                       const uint32_t **const row, const int64_t *const biases,
                                       int32_t *const angles, const uint8_t k) {
    uint64_t sum = ((uint64_t)factors->start_high << 32) | factors->start_low;
    if (axis->biases != NULL) {
        sum += (uint64_t)biases[k];
    }
    if (axis->sensors > CCGEN_UNROLLED_MAX) {
        for (uint8_t sensor = 0; sensor < axis->sensors; ++sensor) {
            sum = ccgen_axis32_add(axis, sum, ccgen_load(row), factors, sensor);
        }
    } else {
        sum = ccgen_axis32_add_pair(axis, sum, factors, row, 0);
        sum = ccgen_axis32_add_pair(axis, sum, factors, row, 1);
        sum = ccgen_axis32_add_pair(axis, sum, factors, row, 2);
        sum = ccgen_axis32_add_pair(axis, sum, factors, row, 3);
    }
    angles[k] = ccgen_axis32_angle(axis, sum);
}

/** Estimates all segments: four a turn, three, two or one, as their number divides. */
CCGEN_INLINE void ccgen_axis32_segments(const ccgen_axis32_t *const axis,
                                        const ccgen_factors32_t *const factors,
                                        int32_t *const angles) {
    const uint16_t turn = ccgen_turn(axis->segments, (uint8_t)(4u * axis->sensors));
    const uint32_t *row = (const uint32_t *)axis->weights; /* the unsigned type may alias */
    const int64_t *biases = axis->biases;
    int32_t *angle = angles;
    const int32_t *end = angles + axis->segments;
    CCGEN_OPAQUE(end); /* or else short loops are unrolled whole */
    do {
        ccgen_axis32_segment(axis, factors, &row, biases, angle, 0);
        if (turn > 1u) {
            ccgen_axis32_segment(axis, factors, &row, biases, angle, 1);
        }
        if (turn > 2u) {
            ccgen_axis32_segment(axis, factors, &row, biases, angle, 2);
        }
        if (turn > 3u) {
            ccgen_axis32_segment(axis, factors, &row, biases, angle, 3);
        }
        if (axis->biases != NULL) {
            biases += turn;
        }
        angle += turn;
    } while (angle != end);
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_KERNEL32_H */
