/**
 * \file axis32.h
 * \brief The model of one output axis with 32-bit counts, weights and angles.
 */
#ifndef CCGEN_AXIS32_H
#define CCGEN_AXIS32_H

#include "ccgen/check.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Largest angle; saturation clips to plus and minus this, the value below means "no reading". */
#define CCGEN_ANGLE32_LIMIT INT32_MAX

/** The model of one axis: lives in flash. */
typedef struct {
    uint16_t segments;      /**< 1 to CCGEN_SEGMENTS_MAX; of elongation: sections */
    uint8_t sensors;        /**< 1 to CCGEN_SENSORS_MAX */
    uint8_t shift;          /**< 0 to 63; 0 to 32 where `saturates` */
    uint8_t fraction_bits;  /**< an angle is in steps of 2^-fraction_bits rad */
    bool saturates;         /**< some readings in range exceed the angle's limit */
    int64_t bias;           /**< intercept and rounding half at the sum's scale */
    const int64_t *biases;  /**< [segments] what a segment adds to `bias`; NULL where none does */
    const int32_t *weights; /**< [segments][sensors] */
} ccgen_axis32_t;

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_AXIS32_H */
