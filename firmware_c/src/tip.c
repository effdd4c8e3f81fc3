#include "ccgen/tip.h"

#define TIP_LIMIT 32767
#define FRACTION_BITS_MAX 30u

int16_t ccgen_tip_signal(const float metres, const uint8_t fraction_bits) {
    if ((metres != metres) || (fraction_bits > FRACTION_BITS_MAX)) {
        return INT16_MIN;
    }
    const float steps = metres * (float)((uint32_t)1u << fraction_bits);
    if (steps >= (float)TIP_LIMIT) {
        return TIP_LIMIT;
    }
    if (steps <= -(float)TIP_LIMIT) {
        return -TIP_LIMIT;
    }
    const int16_t whole = (int16_t)steps;
    const float rest = steps - (float)whole; /* exact, unlike adding the half before truncation */
    if (rest >= 0.5f) {
        return (int16_t)(whole + 1);
    }
    return (rest <= -0.5f) ? (int16_t)(whole - 1) : whole;
}
