/**
 * \file axis16.h
 * \brief The model of one bending axis with 16-bit counts, weights and angles: a table in flash.
 *
 * Two weights share a word, and how they do depends on what the core multiplies best:
 * - halves: each weight in its half, for cores that multiply both halves at once (SMLAD) and for
 *   those whose int has 16 bits;
 * - combined: high * 2^16 + low + 2^15. With word = that sum and high = word >> 16,
 *
 *       low a + high b = word a + high (b - 2^16 a) - 2^15 a   (mod 2^32)
 *
 *   holds for any differences a and b. The factor b - 2^16 a and the last term are the same for
 *   all segments, so that a pair costs one shift and two multiplications, and no extraction.
 */
#ifndef CCGEN_AXIS16_H
#define CCGEN_AXIS16_H

#include "ccgen/check.h"
#include "ccgen/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Whether weights are stored as halves; may be set to 0 or 1 to try the other layout. */
#if !defined(CCGEN_HALVES)
#if defined(__ARM_FEATURE_SIMD32) || (UINT_MAX < 0xFFFFFFFFu)
#define CCGEN_HALVES 1
#else
#define CCGEN_HALVES 0
#endif
#endif

/** Two signed 16-bit weights in one word of `rows`: constant expression of constants. */
#if CCGEN_HALVES
#define CCGEN_PAIR(low, high) ((uint32_t)(uint16_t)(low) | ((uint32_t)(uint16_t)(high) << 16))
#else
#define CCGEN_PAIR(low, high) (((uint32_t)(high) << 16) + (uint32_t)((int32_t)(low) + 0x8000))
#endif

/** The model of one axis: lives in flash. */
typedef struct {
    uint16_t segments;      /**< 1 to CCGEN_SEGMENTS_MAX */
    uint8_t sensors;        /**< 1 to CCGEN_AXIS_SENSORS_MAX */
    uint8_t shift;          /**< 0 to 31; 0 to 16 where `saturates` */
    uint8_t fraction_bits;  /**< an angle is in steps of 2^-fraction_bits rad */
    bool saturates;         /**< some readings in range exceed the angle's limit */
    bool narrow;            /**< every difference count - zero fits 16 bits */
    const int16_t *minimum; /**< [sensors] counts; above INT16_MIN, which means "no reading" */
    const int16_t *maximum; /**< [sensors] counts */
    const int16_t *zero;    /**< [sensors] counts at the straight pose, before any capture */
    int32_t bias;           /**< intercept and rounding half at the sum's scale */
    const int32_t *biases;  /**< [segments] what a segment adds to `bias`; NULL where none does */
    /**
     * [segments][(sensors + 1) / 2] words: CCGEN_PAIR(W_i0, W_i1), ...; an odd number of sensors
     * is padded with a weight of 0.
     */
    const uint32_t *rows;
} ccgen_axis16_t;

/** \return whether the model can be evaluated; folds to a constant for a constant model. */
CCGEN_INLINE bool ccgen_axis16_valid(const ccgen_axis16_t *const axis) {
    return (axis != NULL) && (axis->sensors >= 1u) && (axis->sensors <= CCGEN_AXIS_SENSORS_MAX) &&
           (axis->segments >= 1u) && (axis->segments <= CCGEN_SEGMENTS_MAX) && (axis->shift < 32u);
}

/** \return whether a sensor's count is in range; true where the axis has no such sensor. */
CCGEN_INLINE bool ccgen_axis16_has(const ccgen_axis16_t *const axis, const int16_t *const counts,
                                   const uint8_t sensor) {
    if (sensor >= axis->sensors) {
        return true;
    }
    const int32_t minimum = axis->minimum[sensor];
    return (uint32_t)(counts[sensor] - minimum) <= (uint32_t)(axis->maximum[sensor] - minimum);
}

/**
 * Tells which sensors' counts are outside their ranges.
 * \param[in] axis    model
 * \param[in] counts  [sensors] counts
 * \return mask of 8 bits, bit j for sensor j; or CCGEN_ERROR_ARGUMENT for a null pointer or an
 *         invalid model
 */
CCGEN_INLINE int ccgen_axis16_missing(const ccgen_axis16_t *const axis,
                                      const int16_t *const counts) {
    if (!ccgen_axis16_valid(axis) || (counts == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    int mask = 0;
    for (uint8_t sensor = 0; sensor < axis->sensors; ++sensor) {
        mask |= ccgen_axis16_has(axis, counts, sensor) ? 0 : (1 << sensor);
    }
    return mask;
}

/**
 * Tells whether every count is in its range; the cheap form of ccgen_axis16_missing() == 0.
 * \param[in] axis    valid model
 * \param[in] counts  [sensors] counts
 */
CCGEN_INLINE bool ccgen_axis16_complete(const ccgen_axis16_t *const axis,
                                        const int16_t *const counts) {
    return ccgen_axis16_has(axis, counts, 0) && ccgen_axis16_has(axis, counts, 1) &&
           ccgen_axis16_has(axis, counts, 2) && ccgen_axis16_has(axis, counts, 3) &&
           ccgen_axis16_has(axis, counts, 4) && ccgen_axis16_has(axis, counts, 5) &&
           ccgen_axis16_has(axis, counts, 6) && ccgen_axis16_has(axis, counts, 7);
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_AXIS16_H */
