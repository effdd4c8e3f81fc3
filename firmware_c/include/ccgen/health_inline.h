/**
 * \file health_inline.h
 * \brief What health.h describes, inline: where a joint's layout is known, it folds into the code.
 */
#ifndef CCGEN_HEALTH_INLINE_H
#define CCGEN_HEALTH_INLINE_H

#include "ccgen/health.h"
#include "ccgen/layout_inline.h"

#define CCGEN_HEALTH_ABSENT 3u
#define CCGEN_HEALTH_BITS 2u
#define CCGEN_HEALTH_PAYLOAD 6u

/** \return a state for every axis that is estimated, another for those that are not. */
static inline uint8_t ccgen_health_states(const ccgen_layout_t *const layout, const uint8_t there,
                                          const uint8_t elsewhere) {
    uint32_t mask = 0;
    for (uint8_t axis = 0; axis < CCGEN_AXES_MAX; ++axis) {
        const uint8_t state = (layout->rows[axis] > 0u) ? there : elsewhere;
        mask |= (uint32_t)state << (CCGEN_HEALTH_BITS * (uint32_t)axis);
    }
    return (uint8_t)mask;
}

/** \return the mask of axes that says that every axis that is estimated is lost. */
static inline uint8_t ccgen_health_all_lost(const ccgen_layout_t *const layout) {
    return ccgen_health_states(layout, CCGEN_AXIS_LOST, 0);
}

/** Sets the state to: no estimate yet, the model's zero, no command; a frame is due. */
static inline void ccgen_health_init(const ccgen_layout_t *const layout,
                                     ccgen_health_t *const health) {
    health->suspected = 0;
    health->axes = ccgen_health_all_lost(layout);
    health->zero = CCGEN_ZERO_MODEL;
    health->command = 0;
    health->result = CCGEN_RESULT_NONE;
    health->sent_us = 0;
    health->counter = 0;
    health->due = true;
}

/** \return whether a frame is due. */
static inline bool ccgen_health_due(const ccgen_layout_t *const layout,
                                    const ccgen_health_t *const health, const uint32_t now_us) {
    return ((layout->publish & CCGEN_PUBLISH_HEALTH) != 0u) &&
           (health->due || ((now_us - health->sent_us) >= CCGEN_HEALTH_US));
}

/** Writes the frame that is due. */
static inline void ccgen_health_frame(const ccgen_layout_t *const layout,
                                      ccgen_health_t *const health, const uint32_t now_us,
                                      ccgen_frame_t *const frame) {
    uint8_t *const payload = ccgen_layout_open(layout, ccgen_layout_health_index(layout), frame);
    payload[0] = (uint8_t)(layout->fingerprint & 0xFFu);
    payload[1] = (uint8_t)(layout->fingerprint >> 8);
    payload[2] = (uint8_t)(health->suspected & 0xFFu);
    payload[3] = (uint8_t)(health->suspected >> 8);
    payload[4] = (uint8_t)(health->axes | ccgen_health_states(layout, 0, CCGEN_HEALTH_ABSENT) |
                           ((uint32_t)health->zero << 6));
    payload[5] = (uint8_t)(health->command | ((uint32_t)health->result << 4));
    (void)ccgen_layout_close(layout, health->counter, CCGEN_HEALTH_PAYLOAD, frame);
    health->sent_us = now_us;
    health->due = false;
}

/** Takes note that the frame written last was sent. */
static inline void ccgen_health_sent(const ccgen_layout_t *const layout,
                                     ccgen_health_t *const health) {
    const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    const uint16_t next = (uint16_t)(health->counter + 1u);
    health->counter = (uint8_t)((next < modulus) ? next : 0u);
}

#endif /* CCGEN_HEALTH_INLINE_H */
