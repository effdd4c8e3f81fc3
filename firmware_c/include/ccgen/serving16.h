/**
 * \file serving16.h
 * \brief What serves a 16-bit axis of which sensors are absent: without a reading, or left out.
 *
 * Rows that were fitted without sensor j serve while j alone is absent; they share bias, shift and
 * fraction bits of the axis, and their weight of j is 0, so that any count of j adds nothing. Where
 * two or more are absent the axis is lost, and all its values are "no reading".
 */
#ifndef CCGEN_SERVING16_H
#define CCGEN_SERVING16_H

#include "ccgen/axis16.h"
#include "ccgen/flash.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Chooses what serves an axis.
 * \param[in] own      the axis
 * \param[in] without  [sensors] what serves without each of its sensors, `rows` NULL where nothing
 *                     does
 * \param[in] absent   mask, bit j for sensor j of the axis
 * \return NULL: the axis is lost
 */
CCGEN_INLINE const ccgen_axis16_t *ccgen_serving16(const ccgen_axis16_t *const own,
                                                   const ccgen_axis16_t *const without,
                                                   const uint32_t absent) {
    const ccgen_axis16_t *one = without;
    if (absent == 0u) {
        return own;
    }
    if ((absent & (absent - 1u)) != 0u) {
        return NULL;
    }
    for (uint32_t rest = absent; rest > 1u; rest >>= 1) {
        ++one;
    }
    return (CCGEN_FLASH_POINTER(&one->rows) != NULL) ? one : NULL;
}

/** Writes "no reading" for every value of a lost axis. */
CCGEN_INLINE void ccgen_blank16(const uint16_t segments, int16_t *const angles) {
    for (uint16_t i = 0; i < segments; ++i) {
        angles[i] = INT16_MIN;
    }
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_SERVING16_H */
