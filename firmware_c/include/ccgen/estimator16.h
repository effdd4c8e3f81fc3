/**
 * \file estimator16.h
 * \brief The estimator of one bending axis with 16-bit counts, weights and angles.
 *
 *     angle_i = saturate((bias_i + sum_j W_ij (count_j - zero_j)) >> shift)
 *
 * Accumulates in 32 bits; there is no division, float, 64-bit arithmetic, loop over sensors or
 * function call. Called with a `static const ccgen_axis16_t` that the compiler sees, everything
 * that depends on the number of sensors, the shift and the flags is decided at compile time.
 * Time grows with segments times sensors. Re-entrant; the state belongs to the caller.
 *
 * The exporter proves for every count within [minimum, maximum] and every zero within the same
 * bounds that no intermediate sum leaves 32 bits and, where `saturates` is false, that every angle
 * fits 16 bits. A zero outside its bounds gives wrong angles, never undefined behaviour.
 */
#ifndef CCGEN_ESTIMATOR16_H
#define CCGEN_ESTIMATOR16_H

#include "ccgen/check.h"
#include "ccgen/error.h"
#include "ccgen/integer.h"

#if defined(__ARM_FEATURE_SIMD32)
#include <arm_acle.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Largest angle; saturation clips to plus and minus this, the value below means "no reading". */
#define CCGEN_ANGLE16_LIMIT 32767

/** Two signed 16-bit weights in one word of `rows`: constant expression of constants. */
#define CCGEN_PAIR(low, high) ((uint32_t)(uint16_t)(low) | ((uint32_t)(uint16_t)(high) << 16))

/** A signed 32-bit bias as a word of `rows`: constant expression of a constant. */
#define CCGEN_BIAS(bias) ((uint32_t)(bias))

/** The model of one axis: lives in flash. */
typedef struct {
    uint16_t segments;      /**< 1 to CCGEN_SEGMENTS_MAX */
    uint8_t sensors;        /**< 1 to CCGEN_AXIS_SENSORS_MAX */
    uint8_t shift;          /**< 0 to 31 */
    uint8_t fraction_bits;  /**< an angle is in steps of 2^-fraction_bits rad */
    bool saturates;         /**< some readings in range exceed the angle's limit */
    bool narrow;            /**< every difference count - zero fits 16 bits */
    const int16_t *minimum; /**< [sensors] counts; above INT16_MIN, which means "no reading" */
    const int16_t *maximum; /**< [sensors] counts */
    const int16_t *zero;    /**< [sensors] counts at the straight pose, before any capture */
    /**
     * [segments][1 + (sensors + 1) / 2] words: CCGEN_BIAS(bias), then CCGEN_PAIR(W_i0, W_i1), ...;
     * an odd number of sensors is padded with a weight of 0. The bias holds the rounding half.
     */
    const uint32_t *rows;
} ccgen_axis16_t;

/** Differences count - zero of one snapshot, 0 for sensors that the axis has not. */
typedef struct {
    int32_t wide[CCGEN_AXIS_SENSORS_MAX];
} ccgen_differences16_t;

/** \return whether the model can be evaluated; folds to a constant for a constant model. */
CCGEN_INLINE bool ccgen_axis16_valid(const ccgen_axis16_t *const axis) {
    return (axis != NULL) && (axis->sensors >= 1u) && (axis->sensors <= CCGEN_AXIS_SENSORS_MAX) &&
           (axis->segments >= 1u) && (axis->segments <= CCGEN_SEGMENTS_MAX) && (axis->shift < 32u);
}

/** \return whether a sensor's count is in range; true where the axis has no such sensor. */
CCGEN_INLINE bool ccgen_axis16_has(const ccgen_axis16_t *const axis, const int16_t *const counts,
                                   const uint8_t sensor) {
    return (sensor >= axis->sensors) ||
           ((counts[sensor] >= axis->minimum[sensor]) && (counts[sensor] <= axis->maximum[sensor]));
}

/** \return bit `sensor` where its count is out of range, 0 otherwise. */
CCGEN_INLINE int ccgen_axis16_missing_bit(const ccgen_axis16_t *const axis,
                                          const int16_t *const counts, const uint8_t sensor) {
    return ccgen_axis16_has(axis, counts, sensor) ? 0 : (1 << sensor);
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
    return ccgen_axis16_missing_bit(axis, counts, 0) | ccgen_axis16_missing_bit(axis, counts, 1) |
           ccgen_axis16_missing_bit(axis, counts, 2) | ccgen_axis16_missing_bit(axis, counts, 3) |
           ccgen_axis16_missing_bit(axis, counts, 4) | ccgen_axis16_missing_bit(axis, counts, 5) |
           ccgen_axis16_missing_bit(axis, counts, 6) | ccgen_axis16_missing_bit(axis, counts, 7);
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

/** \return count - zero of one sensor, 0 where the axis has no such sensor. */
CCGEN_INLINE int32_t ccgen_axis16_difference(const ccgen_axis16_t *const axis,
                                             const int16_t *const zero, const int16_t *const counts,
                                             const uint8_t sensor) {
    return (sensor < axis->sensors) ? ((int32_t)counts[sensor] - (int32_t)zero[sensor]) : 0;
}

/**
 * Adds the products of one pair of weights with the differences of sensors 2k and 2k + 1.
 * Sums modulo 2^32: sums that the proof covers are exact, and no input overflows a signed type.
 */
CCGEN_INLINE uint32_t ccgen_axis16_add_pair(const ccgen_axis16_t *const axis, const uint32_t sum,
                                            const uint32_t weights,
                                            const ccgen_differences16_t *const d, const uint8_t k) {
    const int32_t first = d->wide[2 * k];
    const int32_t second = d->wide[2 * k + 1];
    if (axis->narrow) {
        const int16_t first16 = ccgen_low16((uint32_t)first);
        const int16_t second16 = ccgen_low16((uint32_t)second);
#if defined(__ARM_FEATURE_SIMD32)
        return (uint32_t)__smlad((int16x2_t)ccgen_signed32(weights),
                                 (int16x2_t)ccgen_signed32(CCGEN_PAIR(first16, second16)),
                                 ccgen_signed32(sum));
#else
        const uint32_t half = sum + (uint32_t)((int32_t)ccgen_low16(weights) * first16);
        return ((2 * k + 1) < axis->sensors)
                   ? (half + (uint32_t)((int32_t)ccgen_high16(weights) * second16))
                   : half;
#endif
    }
    const uint32_t half = sum + (uint32_t)((int32_t)ccgen_low16(weights) * first);
    return ((2 * k + 1) < axis->sensors)
               ? (half + (uint32_t)((int32_t)ccgen_high16(weights) * second))
               : half;
}

/** \return one segment's angle from its row of the model. */
CCGEN_INLINE int16_t ccgen_axis16_angle(const ccgen_axis16_t *const axis, const uint32_t *const row,
                                        const ccgen_differences16_t *const d) {
    uint32_t sum = ccgen_axis16_add_pair(axis, row[0], row[1], d, 0);
    if (axis->sensors > 2u) {
        sum = ccgen_axis16_add_pair(axis, sum, row[2], d, 1);
    }
    if (axis->sensors > 4u) {
        sum = ccgen_axis16_add_pair(axis, sum, row[3], d, 2);
    }
    if (axis->sensors > 6u) {
        sum = ccgen_axis16_add_pair(axis, sum, row[4], d, 3);
    }
    int32_t angle = ccgen_signed32(sum) >> axis->shift;
    if (axis->saturates) {
        angle = (angle > CCGEN_ANGLE16_LIMIT) ? CCGEN_ANGLE16_LIMIT : angle;
        angle = (angle < -CCGEN_ANGLE16_LIMIT) ? -CCGEN_ANGLE16_LIMIT : angle;
    }
    return ccgen_low16((uint32_t)angle);
}

/**
 * Evaluates the model without checking anything: for counts that ccgen_axis16_complete() accepts,
 * so that a joint of two axes is checked as a whole before anything is written.
 * \param[in] axis     valid model
 * \param[in] zero     [sensors] counts at the straight pose, each within its sensor's range
 * \param[in] counts   [sensors] counts of one snapshot, each within its sensor's range
 * \param[out] angles  [segments] angles in steps of 2^-fraction_bits rad; may not overlap the
 * inputs
 */
CCGEN_INLINE void ccgen_axis16_evaluate(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                        const int16_t *const counts, int16_t *const angles) {
    const ccgen_differences16_t differences = {{
        ccgen_axis16_difference(axis, zero, counts, 0),
        ccgen_axis16_difference(axis, zero, counts, 1),
        ccgen_axis16_difference(axis, zero, counts, 2),
        ccgen_axis16_difference(axis, zero, counts, 3),
        ccgen_axis16_difference(axis, zero, counts, 4),
        ccgen_axis16_difference(axis, zero, counts, 5),
        ccgen_axis16_difference(axis, zero, counts, 6),
        ccgen_axis16_difference(axis, zero, counts, 7),
    }};
    const size_t words = 1u + ((size_t)axis->sensors + 1u) / 2u;
    const uint32_t *row = axis->rows;
    for (uint16_t i = 0; i < axis->segments; ++i) {
        angles[i] = ccgen_axis16_angle(axis, row, &differences);
        row += words;
    }
}

/**
 * Estimates the angles of all segments of one axis.
 * \param[in] axis     model
 * \param[in] zero     [sensors] counts at the straight pose, each within its sensor's range
 * \param[in] counts   [sensors] counts of one snapshot
 * \param[out] angles  [segments] angles in steps of 2^-fraction_bits rad; may not overlap the
 * inputs
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer or an invalid model;
 *         CCGEN_ERROR_MISSING when a count is outside its range. Nothing is written on error.
 */
CCGEN_INLINE int ccgen_axis16_estimate(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                       const int16_t *const counts, int16_t *const angles) {
    if (!ccgen_axis16_valid(axis) || (zero == NULL) || (counts == NULL) || (angles == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (!ccgen_axis16_complete(axis, counts)) {
        return CCGEN_ERROR_MISSING;
    }
    ccgen_axis16_evaluate(axis, zero, counts, angles);
    return CCGEN_OK;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_ESTIMATOR16_H */
