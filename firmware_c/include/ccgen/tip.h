/**
 * \file tip.h
 * \brief The tip position as signals of the TIP frame.
 *
 * The only float in the runtime; leave it out where the kinematics are left out.
 */
#ifndef CCGEN_TIP_H
#define CCGEN_TIP_H

#include "ccgen/check.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Converts one coordinate to steps of 2^-fraction_bits m, rounded to nearest, halves away from 0.
 * \param[in] metres
 * \param[in] fraction_bits  0 to 30
 * \return clipped to +-32767; INT16_MIN, "no reading", for what is not a number or for more
 *         fraction bits
 */
int16_t ccgen_tip_signal(float metres, uint8_t fraction_bits);

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_TIP_H */
