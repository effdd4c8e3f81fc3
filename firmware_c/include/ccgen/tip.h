/**
 * \file tip.h
 * \brief The tip position as signals of the TIP frame, from integers.
 */
#ifndef CCGEN_TIP_H
#define CCGEN_TIP_H

#include "ccgen/check.h"

/** Largest signal; its negative is the least, and "no reading" lies below. */
#define CCGEN_TIP_LIMIT 32767

/**
 * Rounds a coordinate to the steps of the signal, halves up.
 * \param[in] position  in steps of a pose's position
 * \param[in] shift     a signal's step is 2^shift of them; 1 to 31
 * \return clipped to +-CCGEN_TIP_LIMIT
 */
CCGEN_INLINE int16_t ccgen_tip_signal(const int32_t position, const uint8_t shift) {
    const int32_t doubled = position >> (shift - 1u); /* MISRA 10.1 */
    /* MISRA 10.1 */
    const int32_t steps = (doubled >> 1) + (doubled & 1); /* adding the half first may overflow */
    if (steps > CCGEN_TIP_LIMIT) {
        return CCGEN_TIP_LIMIT;
    }
    return (steps < -CCGEN_TIP_LIMIT) ? CCGEN_CAST(int16_t, -CCGEN_TIP_LIMIT)
                                      : CCGEN_CAST(int16_t, steps);
}

#endif /* CCGEN_TIP_H */
