/**
 * \file axis16.h
 * \brief The model of one bending axis with 16-bit counts, weights and angles.
 */
#ifndef CCGEN_AXIS16_H
#define CCGEN_AXIS16_H

#include "ccgen/check.h"
#include "ccgen/error.h"

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

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_AXIS16_H */
