#include "ccgen/health.h"

#define ABSENT 3u
#define BITS 2u

/** \return a state for every axis that is estimated, another for those that are not. */
static uint8_t states(const ccgen_layout_t *const layout, const uint8_t there,
                      const uint8_t elsewhere) {
    uint32_t mask = 0;
    for (uint8_t axis = 0; axis < CCGEN_AXES_MAX; ++axis) {
        const uint8_t state = (layout->rows[axis] > 0u) ? there : elsewhere;
        mask |= (uint32_t)state << (BITS * axis);
    }
    return (uint8_t)mask;
}

uint8_t ccgen_health_all_lost(const ccgen_layout_t *const layout) {
    return states(layout, CCGEN_AXIS_LOST, 0);
}

void ccgen_health_init(const ccgen_layout_t *const layout, ccgen_health_t *const health) {
    health->suspected = 0;
    health->axes = ccgen_health_all_lost(layout);
    health->zero = CCGEN_ZERO_MODEL;
    health->command = 0;
    health->result = CCGEN_RESULT_NONE;
    health->sent_us = 0;
    health->counter = 0;
    health->due = true;
}

bool ccgen_health_due(const ccgen_layout_t *const layout, const ccgen_health_t *const health,
                      const uint32_t now_us) {
    return ((layout->publish & CCGEN_PUBLISH_HEALTH) != 0u) &&
           (health->due || ((now_us - health->sent_us) >= CCGEN_HEALTH_US));
}

void ccgen_health_frame(const ccgen_layout_t *const layout, ccgen_health_t *const health,
                        const uint32_t now_us, ccgen_frame_t *const frame) {
    ccgen_layout_begin(layout, ccgen_layout_health_index(layout), frame);
    uint8_t *const payload = &frame->data[ccgen_e2e_header(ccgen_layout_profile(layout))];
    payload[0] = (uint8_t)(layout->fingerprint & 0xFFu);
    payload[1] = (uint8_t)(layout->fingerprint >> 8);
    payload[2] = (uint8_t)(health->suspected & 0xFFu);
    payload[3] = (uint8_t)(health->suspected >> 8);
    payload[4] = (uint8_t)(health->axes | states(layout, 0, ABSENT) | ((uint32_t)health->zero << 6));
    payload[5] = (uint8_t)(health->command | ((uint32_t)health->result << 4));
    (void)ccgen_layout_protect(layout, health->counter, frame);
    health->sent_us = now_us;
    health->due = false;
}

void ccgen_health_sent(const ccgen_layout_t *const layout, ccgen_health_t *const health) {
    const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    const uint16_t next = (uint16_t)(health->counter + 1u);
    health->counter = (uint8_t)((next < modulus) ? next : 0u);
}
