/**
 * \file sensors16.h
 * \brief What the sensors of a joint may count, in 16 bits: a table in flash, and what holds it.
 *
 * The estimator works with differences count - zero. Where a zero may lie anywhere that leaves the
 * range of motion within the counts, differences have a range of their own: a count farther from its
 * zero than a sound joint can bring it is no reading.
 */
#ifndef CCGEN_SENSORS16_H
#define CCGEN_SENSORS16_H

#include "ccgen/check.h"
#include "ccgen/error.h"
#include "ccgen/flash.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Sensors that stand next to each other in the joint's list: lives in flash, tables CCGEN_FLASH. */
typedef struct {
    uint8_t sensors;             /**< 1 to CCGEN_SENSORS_MAX */
    const int16_t *minimum;      /**< [sensors] counts; above INT16_MIN, which means "no reading" */
    const int16_t *maximum;      /**< [sensors] counts */
    const int16_t *zero;         /**< [sensors] counts at the straight pose, before any capture */
    const int32_t *difference_minimum;      /**< [sensors] lowest count - zero that is a reading, 0 or less; NULL
                                      where every count in range is one, with any zero in range */
    const int32_t *difference_maximum;     /**< [sensors] highest count - zero; NULL as `difference_minimum` */
    const int16_t *zero_minimum; /**< [sensors] zeros that leave the range of motion its counts */
    const int16_t *zero_maximum; /**< [sensors] */
} ccgen_sensors16_t;

/** Lowest and highest values of some sensors: lives in flash, tables CCGEN_FLASH. */
typedef struct {
    const int16_t *minimum; /**< [sensors] */
    const int16_t *maximum; /**< [sensors] */
} ccgen_range16_t;

/** \return whether a sensor's count is in range; true where there is no such sensor. */
CCGEN_INLINE bool ccgen_sensors16_within(const ccgen_sensors16_t *const sensors,
                                         const int16_t *const counts, const uint8_t j) {
    if (j >= sensors->sensors) {
        return true;
    }
    const int32_t minimum = CCGEN_FLASH_INT16(&sensors->minimum[j]);
    const int32_t maximum = CCGEN_FLASH_INT16(&sensors->maximum[j]);
    return (uint32_t)(counts[j] - minimum) <= (uint32_t)(maximum - minimum); /* MISRA 10.8 */
}

/** \return whether a sensor gives a reading; true where there is no such sensor. */
CCGEN_INLINE bool ccgen_sensors16_has(const ccgen_sensors16_t *const sensors,
                                      const int16_t *const zero, const int16_t *const counts,
                                      const uint8_t j) {
    const bool within = ccgen_sensors16_within(sensors, counts, j);
    if (!within || (j >= sensors->sensors) || (sensors->difference_minimum == NULL)) {
        return within;
    }
    const int32_t difference = (int32_t)counts[j] - zero[j];
    return (difference >= CCGEN_FLASH_INT32(&sensors->difference_minimum[j])) &&
           (difference <= CCGEN_FLASH_INT32(&sensors->difference_maximum[j]));
}

/**
 * Tells which sensors give no reading.
 * \param[in] sensors  valid table
 * \param[in] zero     [sensors] counts at the straight pose
 * \param[in] counts   [sensors] counts of one snapshot
 * \return mask, bit j for sensor j of the table
 */
CCGEN_INLINE uint16_t ccgen_sensors16_missing(const ccgen_sensors16_t *const sensors,
                                              const int16_t *const zero,
                                              const int16_t *const counts) {
    uint16_t mask = 0;
    for (uint8_t j = 0; j < sensors->sensors; ++j) {
        const bool has = ccgen_sensors16_has(sensors, zero, counts, j);
        mask = (uint16_t)(mask | (has ? 0u : (UINT32_C(1) << j)));
    }
    return mask;
}

/** Whether every sensor gives a reading; the cheap form of ccgen_sensors16_missing() == 0. */
CCGEN_INLINE bool ccgen_sensors16_complete(const ccgen_sensors16_t *const sensors,
                                           const int16_t *const zero,
                                           const int16_t *const counts) {
    if (sensors->sensors > CCGEN_UNROLLED_MAX) {
        return ccgen_sensors16_missing(sensors, zero, counts) == 0u;
    }
    return ccgen_sensors16_has(sensors, zero, counts, 0) &&
           ccgen_sensors16_has(sensors, zero, counts, 1) &&
           ccgen_sensors16_has(sensors, zero, counts, 2) &&
           ccgen_sensors16_has(sensors, zero, counts, 3) &&
           ccgen_sensors16_has(sensors, zero, counts, 4) &&
           ccgen_sensors16_has(sensors, zero, counts, 5) &&
           ccgen_sensors16_has(sensors, zero, counts, 6) &&
           ccgen_sensors16_has(sensors, zero, counts, 7);
}

/**
 * Tells which of some values are outside their ranges, such as zeros that are not accepted.
 * \param[in] range    valid range
 * \param[in] values   [sensors]
 * \param[in] sensors  1 to CCGEN_SENSORS_MAX
 * \return mask, bit j for value j
 */
CCGEN_INLINE uint16_t ccgen_outside16(const ccgen_range16_t *const range, const int16_t *const values,
                                      const uint8_t sensors) {
    uint32_t mask = 0;
    for (uint8_t j = sensors; j > 0u; --j) {
        const int16_t value = values[j - 1]; /* MISRA 10.4 */
        /* MISRA 10.4 */
        const bool inside = (value >= CCGEN_FLASH_INT16(&range->minimum[j - 1])) &&
                            (value <= CCGEN_FLASH_INT16(&range->maximum[j - 1])); /* MISRA 10.4 */
        mask = (mask << 1) | (inside ? 0u : 1u);
    }
    return (uint16_t)mask;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_SENSORS16_H */
