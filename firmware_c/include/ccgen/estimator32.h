/**
 * \file estimator32.h
 * \brief The estimator of one bending axis with 32-bit counts, weights and angles.
 *
 *     angle_i = saturate((bias_i + sum_j W_ij (count_j - zero_j)) >> shift)
 *
 * Accumulates in 64 bits; there is no division, float, loop over sensors or function call. Called
 * with a `static const ccgen_axis32_t` that the compiler sees, everything that depends on the
 * number of sensors, the shift and the flags is decided at compile time. Time grows with segments
 * times sensors. Re-entrant; the state belongs to the caller.
 *
 * The exporter proves for every count within [minimum, maximum] and every zero within the same
 * bounds that differences fit 32 bits, that no intermediate sum leaves 64 bits and, where
 * `saturates` is false, that every angle fits 32 bits. A zero outside its bounds gives wrong
 * angles, never undefined behaviour.
 */
#ifndef CCGEN_ESTIMATOR32_H
#define CCGEN_ESTIMATOR32_H

#include "ccgen/check.h"
#include "ccgen/error.h"
#include "ccgen/integer.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Largest angle; saturation clips to plus and minus this, the value below means "no reading". */
#define CCGEN_ANGLE32_LIMIT INT32_MAX

/** The model of one axis: lives in flash. */
typedef struct {
    uint16_t segments;      /**< 1 to CCGEN_SEGMENTS_MAX */
    uint8_t sensors;        /**< 1 to CCGEN_AXIS_SENSORS_MAX */
    uint8_t shift;          /**< 0 to 63 */
    uint8_t fraction_bits;  /**< an angle is in steps of 2^-fraction_bits rad */
    bool saturates;         /**< some readings in range exceed the angle's limit */
    const int32_t *minimum; /**< [sensors] counts; above INT32_MIN, which means "no reading" */
    const int32_t *maximum; /**< [sensors] counts */
    const int32_t *zero;    /**< [sensors] counts at the straight pose, before any capture */
    const int64_t *bias;    /**< [segments] intercept and rounding half, at the sum's scale */
    const int32_t *weights; /**< [segments][sensors] */
} ccgen_axis32_t;

/** Differences count - zero of one snapshot, 0 for sensors that the axis has not. */
typedef struct {
    int32_t value[CCGEN_AXIS_SENSORS_MAX];
} ccgen_differences32_t;

/** \return whether the model can be evaluated; folds to a constant for a constant model. */
CCGEN_INLINE bool ccgen_axis32_valid(const ccgen_axis32_t *const axis) {
    return (axis != NULL) && (axis->sensors >= 1u) && (axis->sensors <= CCGEN_AXIS_SENSORS_MAX) &&
           (axis->segments >= 1u) && (axis->segments <= CCGEN_SEGMENTS_MAX) && (axis->shift < 64u);
}

/** \return whether a sensor's count is in range; true where the axis has no such sensor. */
CCGEN_INLINE bool ccgen_axis32_has(const ccgen_axis32_t *const axis, const int32_t *const counts,
                                   const uint8_t sensor) {
    return (sensor >= axis->sensors) ||
           ((counts[sensor] >= axis->minimum[sensor]) && (counts[sensor] <= axis->maximum[sensor]));
}

/** \return bit `sensor` where its count is out of range, 0 otherwise. */
CCGEN_INLINE int ccgen_axis32_missing_bit(const ccgen_axis32_t *const axis,
                                          const int32_t *const counts, const uint8_t sensor) {
    return ccgen_axis32_has(axis, counts, sensor) ? 0 : (1 << sensor);
}

/**
 * Tells which sensors' counts are outside their ranges.
 * \param[in] axis    model
 * \param[in] counts  [sensors] counts
 * \return mask of 8 bits, bit j for sensor j; or CCGEN_ERROR_ARGUMENT for a null pointer or an
 *         invalid model
 */
CCGEN_INLINE int ccgen_axis32_missing(const ccgen_axis32_t *const axis,
                                      const int32_t *const counts) {
    if (!ccgen_axis32_valid(axis) || (counts == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    return ccgen_axis32_missing_bit(axis, counts, 0) | ccgen_axis32_missing_bit(axis, counts, 1) |
           ccgen_axis32_missing_bit(axis, counts, 2) | ccgen_axis32_missing_bit(axis, counts, 3) |
           ccgen_axis32_missing_bit(axis, counts, 4) | ccgen_axis32_missing_bit(axis, counts, 5) |
           ccgen_axis32_missing_bit(axis, counts, 6) | ccgen_axis32_missing_bit(axis, counts, 7);
}

/**
 * Tells whether every count is in its range; the cheap form of ccgen_axis32_missing() == 0.
 * \param[in] axis    valid model
 * \param[in] counts  [sensors] counts
 */
CCGEN_INLINE bool ccgen_axis32_complete(const ccgen_axis32_t *const axis,
                                        const int32_t *const counts) {
    return ccgen_axis32_has(axis, counts, 0) && ccgen_axis32_has(axis, counts, 1) &&
           ccgen_axis32_has(axis, counts, 2) && ccgen_axis32_has(axis, counts, 3) &&
           ccgen_axis32_has(axis, counts, 4) && ccgen_axis32_has(axis, counts, 5) &&
           ccgen_axis32_has(axis, counts, 6) && ccgen_axis32_has(axis, counts, 7);
}

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
                                       const int32_t *const weights,
                                       const ccgen_differences32_t *const d, const uint8_t sensor) {
    return (sensor < axis->sensors)
               ? (sum + (uint64_t)((int64_t)weights[sensor] * d->value[sensor]))
               : sum;
}

/** \return one segment's angle from its bias and its row of weights. */
CCGEN_INLINE int32_t ccgen_axis32_angle(const ccgen_axis32_t *const axis, const int64_t bias,
                                        const int32_t *const weights,
                                        const ccgen_differences32_t *const d) {
    uint64_t sum = (uint64_t)bias;
    sum = ccgen_axis32_add(axis, sum, weights, d, 0);
    sum = ccgen_axis32_add(axis, sum, weights, d, 1);
    sum = ccgen_axis32_add(axis, sum, weights, d, 2);
    sum = ccgen_axis32_add(axis, sum, weights, d, 3);
    sum = ccgen_axis32_add(axis, sum, weights, d, 4);
    sum = ccgen_axis32_add(axis, sum, weights, d, 5);
    sum = ccgen_axis32_add(axis, sum, weights, d, 6);
    sum = ccgen_axis32_add(axis, sum, weights, d, 7);
    int64_t angle = ccgen_signed64(sum) >> axis->shift;
    if (axis->saturates) {
        angle = (angle > CCGEN_ANGLE32_LIMIT) ? CCGEN_ANGLE32_LIMIT : angle;
        angle = (angle < -CCGEN_ANGLE32_LIMIT) ? -CCGEN_ANGLE32_LIMIT : angle;
    }
    return ccgen_signed32((uint32_t)((uint64_t)angle & 0xFFFFFFFFu));
}

/**
 * Evaluates the model without checking anything: for counts that ccgen_axis32_complete() accepts,
 * so that a joint of two axes is checked as a whole before anything is written.
 * \param[in] axis     valid model
 * \param[in] zero     [sensors] counts at the straight pose, each within its sensor's range
 * \param[in] counts   [sensors] counts of one snapshot, each within its sensor's range
 * \param[out] angles  [segments] angles in steps of 2^-fraction_bits rad; may not overlap the
 * inputs
 */
CCGEN_INLINE void ccgen_axis32_evaluate(const ccgen_axis32_t *const axis, const int32_t *const zero,
                                        const int32_t *const counts, int32_t *const angles) {
    const ccgen_differences32_t differences = {{
        ccgen_axis32_difference(axis, zero, counts, 0),
        ccgen_axis32_difference(axis, zero, counts, 1),
        ccgen_axis32_difference(axis, zero, counts, 2),
        ccgen_axis32_difference(axis, zero, counts, 3),
        ccgen_axis32_difference(axis, zero, counts, 4),
        ccgen_axis32_difference(axis, zero, counts, 5),
        ccgen_axis32_difference(axis, zero, counts, 6),
        ccgen_axis32_difference(axis, zero, counts, 7),
    }};
    const int32_t *weights = axis->weights;
    for (uint16_t i = 0; i < axis->segments; ++i) {
        angles[i] = ccgen_axis32_angle(axis, axis->bias[i], weights, &differences);
        weights += axis->sensors;
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
CCGEN_INLINE int ccgen_axis32_estimate(const ccgen_axis32_t *const axis, const int32_t *const zero,
                                       const int32_t *const counts, int32_t *const angles) {
    if (!ccgen_axis32_valid(axis) || (zero == NULL) || (counts == NULL) || (angles == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (!ccgen_axis32_complete(axis, counts)) {
        return CCGEN_ERROR_MISSING;
    }
    ccgen_axis32_evaluate(axis, zero, counts, angles);
    return CCGEN_OK;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_ESTIMATOR32_H */
