/**
 * \file checked.c
 * \brief A joint with checks, as joint.c proves it: its watches stand for themselves as watch_any.h
 * says, and of shortened parity values it knows what shortened.c proves.
 */
#include "watch_any.h"

#include CHECK_HEADER

/*@ requires values == CHECK_KEPT || values == CHECK_SENSORS;
    requires check->shift == CHECK_SHIFT;
    requires \initialized(parity + (0 .. values - 1));
    requires \valid(shortened + (0 .. values - 1));
    assigns \result \from parity[0 .. values - 1], check->shift;
    assigns shortened[0 .. values - 1] \from parity[0 .. values - 1], check->shift;
    ensures \initialized(shortened + (0 .. values - 1));
    ensures 0 <= \result <= SHORTENED_MOST; */
static inline uint8_t SHORTENED(const ccgen_check_t *check, const PARITY *parity, uint8_t values,
                                int16_t *shortened);

#include JOINT_SOURCE
