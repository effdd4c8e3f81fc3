/**
 * \file factors16.h
 * \brief What one snapshot contributes to every segment's sum of estimator16.h.
 *
 * A sum begins with ccgen_start16() and becomes an angle in ccgen_store16(); what the first adds
 * the second takes away, so that saturating to the symmetric range -32767 to 32767 costs least:
 * - SMLAD cores: the sum is one step low, SSAT clips to 16 bits, QADD16 adds the step;
 * - other cores with SSAT: nothing is added;
 * - elsewhere: the sum is 32767 steps high, and one unsigned comparison finds both ends. The sum's
 *   magnitude is below 2^31 and 32768 steps are at most 2^31, so that sums below the range wrap to
 *   numbers above it and never into it.
 */
#ifndef CCGEN_FACTORS16_H
#define CCGEN_FACTORS16_H

#include "ccgen/axis16.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Whether one instruction clips; clang 14 says so of Cortex-M23 too, which has none. */
#if defined(__ARM_FEATURE_SAT) && !CCGEN_THUMB1
#define CCGEN_HAS_SSAT 1
#else
#define CCGEN_HAS_SSAT 0
#endif

/** Largest angle; saturation clips to plus and minus this, the value below means "no reading". */
#define CCGEN_ANGLE16_LIMIT 32767

/** Most pairs of sensors on one axis, and most that stand one after the other. */
#define CCGEN_PAIRS_MAX (CCGEN_SENSORS_MAX / 2u)
#define CCGEN_PAIRS_UNROLLED (CCGEN_UNROLLED_MAX / 2u)

/** What one snapshot contributes to every segment. */
typedef struct {
    uint32_t start;                     /**< what every sum begins with */
    /* MISRA 10.4 */
    uint32_t pair[2 * CCGEN_PAIRS_MAX]; /**< two factors of every pair of sensors */
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
#elif CCGEN_HAS_SSAT
    return bias;
#else
    return bias + ((uint32_t)CCGEN_ANGLE16_LIMIT << axis->shift);
#endif
}

/** \return difference count - zero of one sensor modulo 2^32, 0 where the axis has no such sensor. */
CCGEN_INLINE uint32_t ccgen_difference16(const ccgen_axis16_t *const axis,
                                         const int16_t *const zero, const int16_t *const counts,
                                         const uint8_t sensor) {
    return (uint32_t)ccgen_value16(axis, counts, sensor) -
           (uint32_t)ccgen_value16(axis, zero, sensor);
}

#if CCGEN_HALVES
/** Finds the factors of sensors 2k and 2k + 1. */
CCGEN_INLINE void ccgen_prepare16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                  const int16_t *const counts, const uint8_t k,
                                  ccgen_factors16_t *const factors) {
    const uint8_t a = (uint8_t)(2u * k);
    const uint8_t b = (uint8_t)(2u * k + 1u);
    if (factors->narrow) {
        factors->pair[a] = (ccgen_difference16(axis, zero, counts, a) & 0xFFFFu) |
                           (ccgen_difference16(axis, zero, counts, b) << 16);
    } else {
        /* A difference has 17 bits, a count and a negated zero have 16 each. */
        const uint32_t zero_a = 0u - (uint32_t)ccgen_value16(axis, zero, a);
        const uint32_t zero_b = 0u - (uint32_t)ccgen_value16(axis, zero, b);
        factors->pair[a] = ((uint32_t)ccgen_value16(axis, counts, a) & 0xFFFFu) |
                           ((uint32_t)ccgen_value16(axis, counts, b) << 16);
        factors->pair[b] = (zero_a & 0xFFFFu) | (zero_b << 16);
    }
}
#else
/** Finds the factors of sensors 2k and 2k + 1, and takes from `start` what their words add. */
CCGEN_INLINE void ccgen_combine16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                  const int16_t *const counts, const uint8_t k,
                                  uint32_t *const start, uint32_t *const first,
                                  uint32_t *const second) {
    const uint32_t difference = ccgen_difference16(axis, zero, counts, (uint8_t)(2u * k));
    *start -= difference << 15;
    *first = difference;
    *second =
        ccgen_difference16(axis, zero, counts, (uint8_t)(2u * k + 1u)) - (difference << 16);
}

/** Finds the factors of sensors 2k and 2k + 1. */
CCGEN_INLINE void ccgen_prepare16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                  const int16_t *const counts, const uint8_t k,
                                  ccgen_factors16_t *const factors) {
    ccgen_combine16(axis, zero, counts, k, &factors->start, &factors->pair[2u * k],
                    &factors->pair[2u * k + 1u]);
}
#endif

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
    for (uint8_t j = CCGEN_UNROLLED_MAX; !axis->narrow && (j < axis->sensors); ++j) {
        if (!ccgen_fits16(axis, zero, counts, j)) {
            return false;
        }
    }
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

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_FACTORS16_H */
