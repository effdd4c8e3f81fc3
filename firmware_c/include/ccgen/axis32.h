/**
 * \file axis32.h
 * \brief The model of one bending axis with 32-bit counts, weights and angles.
 */
#ifndef CCGEN_AXIS32_H
#define CCGEN_AXIS32_H

#include "ccgen/check.h"
#include "ccgen/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Largest angle; saturation clips to plus and minus this, the value below means "no reading". */
#define CCGEN_ANGLE32_LIMIT INT32_MAX

/** The model of one axis: lives in flash. */
typedef struct {
    uint16_t segments;      /**< 1 to CCGEN_SEGMENTS_MAX */
    uint8_t sensors;        /**< 1 to CCGEN_AXIS_SENSORS_MAX */
    uint8_t shift;          /**< 0 to 63; 0 to 32 where `saturates` */
    uint8_t fraction_bits;  /**< an angle is in steps of 2^-fraction_bits rad */
    bool saturates;         /**< some readings in range exceed the angle's limit */
    const int32_t *minimum; /**< [sensors] counts; above INT32_MIN, which means "no reading" */
    const int32_t *maximum; /**< [sensors] counts */
    const int32_t *zero;    /**< [sensors] counts at the straight pose, before any capture */
    int64_t bias;           /**< intercept and rounding half at the sum's scale */
    const int64_t *biases;  /**< [segments] what a segment adds to `bias`; NULL where none does */
    const int32_t *weights; /**< [segments][sensors] */
} ccgen_axis32_t;

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
    int mask = 0;
    for (uint8_t sensor = 0; sensor < axis->sensors; ++sensor) {
        mask |= ccgen_axis32_has(axis, counts, sensor) ? 0 : (1 << sensor);
    }
    return mask;
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

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_AXIS32_H */
