/**
 * \file kernel16.h
 * \brief The sums and angles of estimator16.h, as each kind of core does them best.
 *
 * All arithmetic is modulo 2^32: sums that the exporter's proof covers are exact, and no input
 * overflows a signed type. Same bits on every core.
 *
 * A sum begins with ccgen_start16() and becomes an angle in ccgen_store16(); what the first adds
 * the second takes away, so that saturating to the symmetric range -32767 to 32767 costs least:
 * - SMLAD cores: the sum is one step low, SSAT clips to 16 bits, QADD16 adds the step;
 * - other cores with SSAT: nothing is added;
 * - elsewhere: the sum is 32767 steps high, and one unsigned comparison finds both ends. The sum's
 *   magnitude is below 2^31 and 32768 steps are at most 2^31, so that sums below the range wrap to
 *   numbers above it and never into it.
 */
#ifndef CCGEN_KERNEL16_H
#define CCGEN_KERNEL16_H

#include "ccgen/axis16.h"
#include "ccgen/integer.h"
#include "ccgen/kernel16_thumb1.h"
#include "ccgen/load.h"

#if defined(__ARM_FEATURE_SIMD32) || defined(__ARM_FEATURE_SAT)
#include <arm_acle.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Largest angle; saturation clips to plus and minus this, the value below means "no reading". */
#define CCGEN_ANGLE16_LIMIT 32767

/** Most pairs of sensors on one axis. */
#define CCGEN_PAIRS_MAX (CCGEN_AXIS_SENSORS_MAX / 2)

/** What one snapshot contributes to every segment. */
typedef struct {
    uint32_t start;                     /**< what every sum begins with */
    uint32_t pair[2 * CCGEN_PAIRS_MAX]; /**< two factors of every pair of sensors */
    const int16_t *end;                 /**< of the angles */
    bool narrow;                        /**< every difference fits 16 bits */
} ccgen_factors16_t;

/** \return words of one segment's row. */
CCGEN_INLINE uint8_t ccgen_words16(const ccgen_axis16_t *const axis) {
    return (uint8_t)((axis->sensors + 1u) / 2u);
}

/** \return value of one sensor, 0 where the axis has no such sensor. */
CCGEN_INLINE int32_t ccgen_value16(const ccgen_axis16_t *const axis, const int16_t *const values,
                                   const uint8_t sensor) {
    return (sensor < axis->sensors) ? values[sensor] : 0;
}

/** \return what every sum begins with. */
CCGEN_INLINE uint32_t ccgen_start16(const ccgen_axis16_t *const axis) {
    const uint32_t bias = (uint32_t)axis->bias;
    if (!axis->saturates) {
        return bias;
    }
#if defined(__ARM_FEATURE_SIMD32)
    return bias - ((uint32_t)1 << axis->shift);
#elif defined(__ARM_FEATURE_SAT)
    return bias;
#else
    return bias + ((uint32_t)CCGEN_ANGLE16_LIMIT << axis->shift);
#endif
}

/** Finds the factors of sensors 2k and 2k + 1. */
CCGEN_INLINE void ccgen_prepare16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                  const int16_t *const counts, const uint8_t k,
                                  ccgen_factors16_t *const factors) {
    const uint8_t a = (uint8_t)(2u * k);
    const uint8_t b = (uint8_t)(2u * k + 1u);
    const uint32_t count_a = (uint32_t)ccgen_value16(axis, counts, a);
    const uint32_t count_b = (uint32_t)ccgen_value16(axis, counts, b);
    const uint32_t zero_a = (uint32_t)ccgen_value16(axis, zero, a);
    const uint32_t zero_b = (uint32_t)ccgen_value16(axis, zero, b);
#if CCGEN_HALVES
    if (factors->narrow) {
        factors->pair[2u * k] = ((count_a - zero_a) & 0xFFFFu) | ((count_b - zero_b) << 16);
    } else {
        /* A difference has 17 bits, a count and a negated zero have 16 each. */
        factors->pair[2u * k] = (count_a & 0xFFFFu) | (count_b << 16);
        factors->pair[2u * k + 1u] = ((0u - zero_a) & 0xFFFFu) | ((0u - zero_b) << 16);
    }
#else
    const uint32_t difference = count_a - zero_a;
    factors->pair[2u * k] = difference;
    factors->pair[2u * k + 1u] = (count_b - zero_b) - (difference << 16);
    factors->start -= difference << 15;
#endif
}

/** \return whether a sensor's difference fits 16 bits. */
CCGEN_INLINE bool ccgen_fits16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                               const int16_t *const counts, const uint8_t sensor) {
    const int32_t difference =
        ccgen_value16(axis, counts, sensor) - ccgen_value16(axis, zero, sensor);
    return (difference >= INT16_MIN) && (difference <= INT16_MAX);
}

/** \return whether halves can hold the differences; where weights are no halves, always. */
CCGEN_INLINE bool ccgen_fits_halves16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                      const int16_t *const counts) {
#if CCGEN_HALVES
    return axis->narrow ||
           (ccgen_fits16(axis, zero, counts, 0) && ccgen_fits16(axis, zero, counts, 1) &&
            ccgen_fits16(axis, zero, counts, 2) && ccgen_fits16(axis, zero, counts, 3) &&
            ccgen_fits16(axis, zero, counts, 4) && ccgen_fits16(axis, zero, counts, 5) &&
            ccgen_fits16(axis, zero, counts, 6) && ccgen_fits16(axis, zero, counts, 7));
#else
    (void)axis;
    (void)zero;
    (void)counts;
    return true;
#endif
}

#if CCGEN_HALVES
/** \return sum and the products of the lower and of the upper halves of two words. */
CCGEN_INLINE uint32_t ccgen_add_halves(const uint32_t sum, const uint32_t a, const uint32_t b) {
#if defined(__ARM_FEATURE_SIMD32)
    return (uint32_t)__smlad(ccgen_signed32(a), ccgen_signed32(b), ccgen_signed32(sum));
#else
    return sum + (uint32_t)((int32_t)ccgen_low16(a) * ccgen_low16(b)) +
           (uint32_t)((int32_t)ccgen_high16(a) * ccgen_high16(b));
#endif
}
#endif

/** \return sum and the products of sensors 2k and 2k + 1, where the axis has them. */
CCGEN_INLINE uint32_t ccgen_add_pair16(const ccgen_axis16_t *const axis, const uint32_t sum,
                                       const uint32_t weights,
                                       const ccgen_factors16_t *const factors, const uint8_t k) {
    if (2u * k >= axis->sensors) {
        return sum;
    }
#if CCGEN_HALVES
    const uint32_t most = ccgen_add_halves(sum, weights, factors->pair[2u * k]);
    return factors->narrow ? most : ccgen_add_halves(most, weights, factors->pair[2u * k + 1u]);
#else
    uint32_t result = sum + weights * factors->pair[2u * k];
    CCGEN_OPAQUE(result);
    if (2u * k + 1u < axis->sensors) {
        result += (uint32_t)(ccgen_signed32(weights) >> 16) * factors->pair[2u * k + 1u];
        CCGEN_OPAQUE(result);
    }
    return result;
#endif
}

#if defined(__ARM_FEATURE_SAT)
/* The compiler's own macro converts without a cast. */
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion"
#endif
/** \return value clipped to -32768 to 32767, modulo 2^32. */
CCGEN_INLINE uint32_t ccgen_clip16(const int32_t value) {
    return (uint32_t)__ssat(value, 16);
}
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
#endif

/** Stores the angle of a whole sum. */
CCGEN_INLINE void ccgen_store16(const ccgen_axis16_t *const axis, const uint32_t sum,
                                int16_t *const angle) {
    uint32_t steps = (uint32_t)(ccgen_signed32(sum) >> axis->shift);
    if (axis->saturates) {
#if defined(__ARM_FEATURE_SIMD32)
        const uint32_t clipped = ccgen_clip16(ccgen_signed32(sum) >> axis->shift);
        steps = (uint32_t)__qadd16(ccgen_signed32(clipped), 1);
#elif defined(__ARM_FEATURE_SAT)
        const uint32_t clipped = ccgen_clip16(ccgen_signed32(sum) >> axis->shift);
        steps = clipped + ((clipped + CCGEN_ANGLE16_LIMIT) >> 31); /* -32768 becomes -32767 */
#else
        steps = sum >> axis->shift;
        if (steps > 2u * CCGEN_ANGLE16_LIMIT) {
            const uint32_t without = sum - ((uint32_t)CCGEN_ANGLE16_LIMIT << axis->shift);
            steps = (without >= 0x80000000u) ? 0u : 2u * CCGEN_ANGLE16_LIMIT;
        }
        steps -= CCGEN_ANGLE16_LIMIT;
#endif
    }
    *(uint16_t *)angle = (uint16_t)(steps & 0xFFFFu); /* the unsigned type may alias */
}

/** \return sum and the products of sensors 4h to 4h + 3, whose weights stand at *row. */
CCGEN_INLINE uint32_t ccgen_add_pairs16(const ccgen_axis16_t *const axis, const uint32_t sum,
                                        const ccgen_factors16_t *const factors,
                                        const uint32_t **const row, const uint8_t h) {
    const uint8_t pair = (uint8_t)(2u * h);
    uint32_t first = 0;
    uint32_t second = 0;
    if (ccgen_words16(axis) > (pair + 1u)) {
        ccgen_load_two(row, &first, &second);
    } else if (ccgen_words16(axis) > pair) {
        first = ccgen_load(row);
    } else {
        return sum;
    }
    const uint32_t half = ccgen_add_pair16(axis, sum, first, factors, pair);
    return ccgen_add_pair16(axis, half, second, factors, (uint8_t)(pair + 1u));
}

/** Estimates segment k of a turn from its row at *row, which moves on to the next. */
CCGEN_INLINE void ccgen_segment16(const ccgen_axis16_t *const axis,
                                  const ccgen_factors16_t *const factors,
                                  const uint32_t **const row, const int32_t *const biases,
                                  int16_t *const angles, const uint8_t k) {
    uint32_t sum = factors->start;
    if (axis->biases != NULL) {
        sum += (uint32_t)biases[k];
    }
    sum = ccgen_add_pairs16(axis, sum, factors, row, 0);
    sum = ccgen_add_pairs16(axis, sum, factors, row, 1);
    ccgen_store16(axis, sum, angles + k);
}

/** Estimates all segments: four a turn, three, two or one, as their number divides. */
CCGEN_INLINE void ccgen_segments16(const ccgen_axis16_t *const axis,
                                   ccgen_factors16_t *const factors, int16_t *const angles) {
    const uint16_t turn = ccgen_turn(axis->segments);
    factors->end = angles + axis->segments;
#if CCGEN_HAS_THUMB1_LOOP
    if (__builtin_constant_p(axis->sensors) && __builtin_constant_p(axis->shift) &&
        __builtin_constant_p(axis->saturates) && __builtin_constant_p(turn) &&
        (axis->biases == NULL)) {
        ccgen_thumb1_loop16(axis->rows, angles, factors, offsetof(ccgen_factors16_t, end),
                            axis->sensors, axis->shift, axis->saturates, turn);
        return;
    }
#endif
    CCGEN_OPAQUE(factors->end); /* or else short loops are unrolled whole */
    const uint32_t *row = axis->rows;
    const int32_t *biases = axis->biases;
    int16_t *angle = angles;
    do {
        ccgen_segment16(axis, factors, &row, biases, angle, 0);
        if (turn > 1u) {
            ccgen_segment16(axis, factors, &row, biases, angle, 1);
        }
        if (turn > 2u) {
            ccgen_segment16(axis, factors, &row, biases, angle, 2);
        }
        if (turn > 3u) {
            ccgen_segment16(axis, factors, &row, biases, angle, 3);
        }
        if (axis->biases != NULL) {
            biases += turn;
        }
        angle += turn;
    } while (angle != factors->end);
}

/** Estimates all segments; `narrow` tells whether every difference fits 16 bits. */
CCGEN_INLINE void ccgen_evaluate16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                   const int16_t *const counts, const bool narrow,
                                   int16_t *const angles) {
    ccgen_factors16_t factors = CCGEN_ZERO;
    factors.narrow = narrow;
    factors.start = ccgen_start16(axis);
    ccgen_prepare16(axis, zero, counts, 0, &factors);
    ccgen_prepare16(axis, zero, counts, 1, &factors);
    ccgen_prepare16(axis, zero, counts, 2, &factors);
    ccgen_prepare16(axis, zero, counts, 3, &factors);
    ccgen_segments16(axis, &factors, angles);
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_KERNEL16_H */
