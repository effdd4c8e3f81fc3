/**
 * \file can_timing.c
 * \brief See can_timing.h.
 */
#include "can_timing.h"

enum { PERMILLE_MIN = 700, PERMILLE_MAX = 900 };

static uint32_t wanted_permille(const uint32_t bitrate) {
    if (bitrate > 800000u) {
        return 750u;
    }
    return (bitrate > 500000u) ? 800u : 875u;
}

static uint32_t limited(const uint32_t value, const uint32_t least, const uint32_t most) {
    if (value < least) {
        return least;
    }
    return (value > most) ? most : value;
}

/**
 * Divides a bit of `quanta` at the sample point.
 * \return by how much that is off, in permille; 1000: the limits do not allow it
 */
static uint32_t divide(const uint32_t quanta, const uint32_t permille,
                       const can_timing_limits_t *const limits, can_timing_t *const timing) {
    const uint32_t most = 1u + (uint32_t)limits->segment1_max + limits->segment2_max;
    if ((quanta > most) || (quanta < 4u)) {
        return 1000u;
    }
    const uint32_t before = ((quanta * permille) + 500u) / 1000u; /* synchronisation, segment 1 */
    const uint32_t wanted = limited(quanta - before, limits->segment2_min, limits->segment2_max);
    const uint32_t segment1 = limited((wanted + 1u < quanta) ? quanta - 1u - wanted : 0u,
                                      limits->segment1_min, limits->segment1_max);
    const uint32_t segment2 = (segment1 + 1u < quanta) ? quanta - 1u - segment1 : 0u;
    if ((segment2 < limits->segment2_min) || (segment2 > limits->segment2_max)) {
        return 1000u;
    }
    const uint32_t sampled = ((1u + segment1) * 1000u) / quanta;
    if ((sampled < PERMILLE_MIN) || (sampled > PERMILLE_MAX)) {
        return 1000u;
    }
    timing->segment1 = (uint16_t)segment1;
    timing->segment2 = (uint16_t)segment2;
    timing->jump = (uint16_t)limited(segment2, 1u, limits->jump_max);
    return (sampled > permille) ? sampled - permille : permille - sampled;
}

bool can_timing_find(const uint32_t clock_hz, const uint32_t bitrate,
                     const can_timing_limits_t *const limits, can_timing_t *const timing) {
    uint32_t least = 1000u;
    if ((bitrate == 0u) || (clock_hz % bitrate != 0u)) {
        return false;
    }
    const uint32_t clocks = clock_hz / bitrate; /* of a bit */
    for (uint32_t prescaler = 1u; prescaler <= limits->prescaler_max; ++prescaler) {
        can_timing_t tried = {(uint16_t)prescaler, 0u, 0u, 0u};
        if (clocks % prescaler == 0u) {
            const uint32_t off =
                divide(clocks / prescaler, wanted_permille(bitrate), limits, &tried);
            if (off < least) {
                least = off;
                *timing = tried;
            }
        }
    }
    return least < 1000u;
}
