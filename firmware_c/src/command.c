#include "ccgen/command.h"

static bool is_known(const uint8_t command, const uint8_t snapshots) {
    return (command == (uint8_t)CCGEN_COMMAND_MODEL_ZERO) ||
           (command == (uint8_t)CCGEN_COMMAND_RESTORED_ZERO) ||
           ((command == (uint8_t)CCGEN_COMMAND_CAPTURE) && (snapshots > 0u));
}

bool ccgen_command_is(const ccgen_layout_t *const layout, const ccgen_frame_t *const frame) {
    return layout->commands && (ccgen_layout_kind(layout, frame, NULL) == CCGEN_FRAME_COMMAND) &&
           (ccgen_layout_check(layout, frame) >= 0);
}

ccgen_command_t ccgen_command_receive(const ccgen_layout_t *const layout,
                                      ccgen_health_t *const health,
                                      const ccgen_frame_t *const frame, uint8_t *const snapshots) {
    if (!ccgen_command_is(layout, frame)) {
        return CCGEN_COMMAND_NOTHING;
    }
    const uint8_t *const payload = &frame->data[ccgen_e2e_header(ccgen_layout_profile(layout))];
    const uint8_t number = (uint8_t)(payload[0] & 0x0Fu);
    const uint8_t command = (uint8_t)(payload[0] >> 4);
    health->due = true;
    if ((health->result != CCGEN_RESULT_NONE) && (number == health->command)) {
        return CCGEN_COMMAND_NOTHING;
    }
    health->command = number;
    health->result = CCGEN_RESULT_BUSY;
    if (!is_known(command, payload[1])) {
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

void ccgen_command_end(ccgen_health_t *const health, const ccgen_result_t result) {
    health->result = result;
    health->due = true;
}
