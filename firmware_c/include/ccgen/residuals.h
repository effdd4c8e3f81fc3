/**
 * \file residuals.h
 * \brief What sensors contradict each other by, from the parity values of their group.
 *
 *     q_i = p_i >> shift, so that all of them fit 16 bits,   z_j = sum_i B_ji q_i
 *
 * A snapshot alarms where some |z_j| of the first `kept` values exceeds its threshold; the alarm
 * names the sensor of the largest |z_j| of all values where that exceeds all others by more than
 * its margin. The exporter proves that no |z_j| reaches 2^31, and that none exceeds its threshold
 * while every kept value is at least -2^quiet_bits and below 2^quiet_bits: a quiet snapshot, the
 * common case, takes no more than these values.
 */
#ifndef CCGEN_RESIDUALS_H
#define CCGEN_RESIDUALS_H

#include "ccgen/flash.h"
#include "ccgen/integer.h"
#include "ccgen/watch.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The check of one group: lives in flash, tables CCGEN_FLASH. */
typedef struct {
    const int16_t *directions; /**< [sensors][sensors] B */
    const int32_t *threshold;  /**< [sensors] 0 or more */
    const int32_t *margin;     /**< [sensors] 0 or more */
    uint8_t sensors;           /**< 1 to CCGEN_SENSORS_MAX */
    uint8_t kept;              /**< parity values that decide on alarms, 1 to `sensors` */
    uint8_t quiet_bits;        /**< 0 to 30, with 32-bit counts to 62 */
    uint8_t shift;             /**< bits that parity values lose at least */
} ccgen_check_t;

/** Finds |z_j| of all sensors from the first parity values. */
static inline void ccgen_residuals(const ccgen_check_t *const check, const int16_t *const parity,
                                   const uint8_t values, uint32_t *const size) {
    const int16_t *row = check->directions;
    for (uint8_t j = 0; j < check->sensors; ++j) {
        uint32_t sum = 0;
        for (uint8_t i = 0; i < values; ++i) {
            sum += (uint32_t)((int32_t)CCGEN_FLASH_INT16(&row[i]) * parity[i]);
        }
        size[j] = (sum < 0x80000000u) ? sum : (0u - sum);
        row += check->sensors;
    }
}

/** \return whether some residual exceeds its threshold; parity values lost `more` bits. */
CCGEN_INLINE bool ccgen_alarms(const ccgen_check_t *const check, const uint32_t *const size,
                               const uint8_t more) {
    for (uint8_t j = 0; j < check->sensors; ++j) {
        if (size[j] > ((uint32_t)CCGEN_FLASH_INT32(&check->threshold[j]) >> more)) {
            return true;
        }
    }
    return false;
}

/** \return whom the residuals of a snapshot that alarms name; parity values lost `more` bits. */
CCGEN_INLINE uint8_t ccgen_named(const ccgen_check_t *const check, const uint32_t *const size,
                                 const uint8_t more) {
    uint32_t largest = size[0];
    uint32_t second = 0;
    uint8_t first = 0;
    for (uint8_t j = 1; j < check->sensors; ++j) {
        if (size[j] > largest) {
            second = largest;
            largest = size[j];
            first = j;
        } else if (size[j] > second) {
            second = size[j];
        }
    }
    const uint32_t margin = (uint32_t)CCGEN_FLASH_INT32(&check->margin[first]) >> more;
    return ((largest - second) > margin) ? first : CCGEN_VERDICT_UNNAMED;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_RESIDUALS_H */
