/**
 * \file command_inline.h
 * \brief What command.h describes, inline: where a joint's layout is known, it folds into the code.
 */
#ifndef CCGEN_COMMAND_INLINE_H
#define CCGEN_COMMAND_INLINE_H

#include "ccgen/command.h"
#include "ccgen/layout_inline.h"

static inline bool ccgen_command_is_known(const uint8_t command, const uint8_t snapshots) {
    return (command == (uint8_t)CCGEN_COMMAND_MODEL_ZERO) ||
           (command == (uint8_t)CCGEN_COMMAND_RESTORED_ZERO) ||
           ((command == (uint8_t)CCGEN_COMMAND_CAPTURE) && (snapshots > 0u));
}

/** \return whether a frame is a COMMAND of this joint, whole and unharmed. */
static inline bool ccgen_command_is(const ccgen_layout_t *const layout,
                                    const ccgen_frame_t *const frame) {
    return layout->commands && (ccgen_layout_kind(layout, frame, NULL) == CCGEN_FRAME_COMMAND) &&
           (ccgen_layout_check(layout, frame) >= 0);
}

/**
 * Takes one frame of the bus.
 * \param[in] layout
 * \param[in,out] health  takes the number; the result is BUSY, or UNKNOWN where nothing is to be
 *                        done; the caller changes BUSY with ccgen_command_end()
 * \param[in] frame       any frame
 * \param[out] snapshots  1 to 255 for a capture; written only then
 * \return what is to be done, once
 */
static inline ccgen_command_t ccgen_command_receive(const ccgen_layout_t *const layout,
                                                    ccgen_health_t *const health,
                                                    const ccgen_frame_t *const frame,
                                                    uint8_t *const snapshots) {
    if (!ccgen_command_is(layout, frame)) {
        return CCGEN_COMMAND_NOTHING;
    }
    const uint8_t *const payload = &frame->data[ccgen_layout_header(layout)];
    const uint8_t number = (uint8_t)(payload[0] & 0x0Fu);
    const uint8_t command = (uint8_t)(payload[0] >> 4);
    health->due = true;
    if ((health->result != CCGEN_RESULT_NONE) && (number == health->command)) {
        return CCGEN_COMMAND_NOTHING;
    }
    health->command = number;
    health->result = CCGEN_RESULT_BUSY;
    if (!ccgen_command_is_known(command, payload[1])) {
        health->result = CCGEN_RESULT_UNKNOWN;
        return CCGEN_COMMAND_NOTHING;
    }
    if (command == (uint8_t)CCGEN_COMMAND_CAPTURE) {
        *snapshots = payload[1];
        return CCGEN_COMMAND_CAPTURE;
    }
    return (command == (uint8_t)CCGEN_COMMAND_MODEL_ZERO) ? CCGEN_COMMAND_MODEL_ZERO
                                                          : CCGEN_COMMAND_RESTORED_ZERO;
}

/** Says what became of the command; HEALTH is due. */
static inline void ccgen_command_end(ccgen_health_t *const health, const ccgen_result_t result) {
    health->result = result;
    health->due = true;
}

#endif /* CCGEN_COMMAND_INLINE_H */
