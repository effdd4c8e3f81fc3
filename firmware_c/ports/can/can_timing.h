/**
 * \file can_timing.h
 * \brief Bit timing from a controller's clock and a bit rate.
 */
#ifndef CAN_TIMING_H
#define CAN_TIMING_H

#include <stdbool.h>
#include <stdint.h>

/** What a controller can be set to; segments in time quanta. */
typedef struct {
    uint16_t prescaler_max;
    uint16_t segment1_min; /**< propagation and phase segment 1 together */
    uint16_t segment1_max;
    uint16_t segment2_min;
    uint16_t segment2_max;
    uint16_t jump_max;
} can_timing_limits_t;

/** A bit lasts 1 + segment1 + segment2 quanta of `prescaler` clocks; sampled after segment 1. */
typedef struct {
    uint16_t prescaler;
    uint16_t segment1;
    uint16_t segment2;
    uint16_t jump;
} can_timing_t;

/**
 * Finds the timing whose sample point is nearest to 75 % of the bit above 800 kbit/s, 80 % above
 * 500 kbit/s, 87.5 % below (CiA 301); of several the one with the smallest prescaler.
 * \param[in] clock_hz
 * \param[in] bitrate  met exactly
 * \param[in] limits
 * \param[out] timing
 * \return false: no timing gives that bit rate and samples between 70 % and 90 % of the bit
 */
bool can_timing_find(uint32_t clock_hz, uint32_t bitrate, const can_timing_limits_t *limits,
                     can_timing_t *timing);

#endif /* CAN_TIMING_H */
