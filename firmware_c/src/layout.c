#include "ccgen/layout.h"

#include "ccgen/integer.h"

#define CLASSIC_LENGTH 8u
#define FD_LENGTH 64u
#define TURNS 16u
#define TURN_SHIFT 4u
#define STANDARD_ID_MAX 0x7FFu
#define EXTENDED_ID_MAX 0x1FFFFFFFu

static bool axes_valid(const ccgen_layout_t *const layout) {
    bool valid = (layout->sensors >= 1u) && (layout->sensors <= CCGEN_SENSORS_MAX);
    for (uint8_t axis = 0; axis < CCGEN_AXES_MAX; ++axis) {
        valid = valid && (layout->rows[axis] <= CCGEN_SEGMENTS_MAX);
    }
    return valid && (ccgen_layout_values(layout) >= 1u);
}

static bool signals_valid(const ccgen_layout_t *const layout) {
    return (layout->count_bytes >= 2u) && (layout->count_bytes <= 4u) &&
           ((layout->angle_bytes == 2u) || (layout->angle_bytes == 4u));
}

static bool times_valid(const ccgen_layout_t *const layout) {
    return (layout->cycle_us >= 1u) && (layout->cycle_us <= CCGEN_PERIOD_MAX_US) &&
           (layout->window_us >= 1u) && (layout->window_us <= ccgen_layout_window_max_us(layout));
}

static bool identifiers_valid(const ccgen_layout_t *const layout) {
    const uint32_t last = layout->extended ? EXTENDED_ID_MAX : STANDARD_ID_MAX;
    return (layout->base_id <= last) &&
           ((uint32_t)ccgen_layout_command_index(layout) <= (last - layout->base_id));
}

bool ccgen_layout_valid(const ccgen_layout_t *const layout) {
    return (layout != NULL) && axes_valid(layout) && signals_valid(layout) && times_valid(layout) &&
           identifiers_valid(layout);
}

ccgen_e2e_profile_t ccgen_layout_profile(const ccgen_layout_t *const layout) {
    return layout->fd ? CCGEN_E2E_P05 : CCGEN_E2E_P01;
}

/** \return whether numbers have a turn beside the counter of P01. */
static bool has_turn(const ccgen_layout_t *const layout) {
    return !layout->fd && layout->turn;
}

uint16_t ccgen_layout_numbers(const ccgen_layout_t *const layout) {
    const uint16_t counters = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    return has_turn(layout) ? (uint16_t)(TURNS * counters) : counters;
}

uint32_t ccgen_layout_window_max_us(const ccgen_layout_t *const layout) {
    const bool counter_alone = !layout->fd && !layout->turn;
    const uint32_t cycles = counter_alone ? CCGEN_WINDOW_CYCLES_WITHOUT_TURN : CCGEN_WINDOW_CYCLES;
    const bool fits = layout->cycle_us <= (CCGEN_PERIOD_MAX_US / cycles);
    return fits ? (cycles * layout->cycle_us) : CCGEN_PERIOD_MAX_US;
}

uint8_t ccgen_layout_frame_length(const ccgen_layout_t *const layout) {
    return layout->fd ? FD_LENGTH : CLASSIC_LENGTH;
}

uint8_t ccgen_layout_slots(const ccgen_layout_t *const layout, const uint8_t bytes) {
    const size_t header = ccgen_e2e_header(ccgen_layout_profile(layout));
    return (uint8_t)((ccgen_layout_frame_length(layout) - header) / bytes);
}

/** \return frames that `signals` signals of `bytes` bytes need. */
static uint8_t frames_for(const ccgen_layout_t *const layout, const uint16_t signals,
                          const uint8_t bytes) {
    const uint16_t slots = ccgen_layout_slots(layout, bytes);
    return (uint8_t)((uint16_t)(signals + slots - 1u) / slots);
}

uint8_t ccgen_layout_lengths_frames(const ccgen_layout_t *const layout) {
    return frames_for(layout, layout->sensors, layout->count_bytes);
}

uint8_t ccgen_layout_values(const ccgen_layout_t *const layout) {
    uint8_t values = 0;
    for (uint8_t axis = 0; axis < CCGEN_AXES_MAX; ++axis) {
        values = (uint8_t)(values + layout->rows[axis]);
    }
    return values;
}

uint8_t ccgen_layout_angles_frames(const ccgen_layout_t *const layout) {
    return frames_for(layout, ccgen_layout_values(layout), layout->angle_bytes);
}

uint16_t ccgen_layout_tip_index(const ccgen_layout_t *const layout) {
    return (uint16_t)(ccgen_layout_lengths_frames(layout) + ccgen_layout_angles_frames(layout));
}

uint16_t ccgen_layout_status_index(const ccgen_layout_t *const layout) {
    return (uint16_t)(ccgen_layout_tip_index(layout) + 1u);
}

uint16_t ccgen_layout_health_index(const ccgen_layout_t *const layout) {
    return (uint16_t)(ccgen_layout_tip_index(layout) + 2u);
}

uint16_t ccgen_layout_command_index(const ccgen_layout_t *const layout) {
    return (uint16_t)(ccgen_layout_tip_index(layout) + 3u);
}

bool ccgen_layout_publishes(const ccgen_layout_t *const layout, const uint16_t index) {
    const uint16_t tip = ccgen_layout_tip_index(layout);
    if ((index < ccgen_layout_lengths_frames(layout)) || (index > (tip + 2u))) {
        return false;
    }
    const uint8_t bit = (index < tip) ? 0u : (uint8_t)(index - tip + 1u);
    return (((uint32_t)layout->publish >> bit) & 1u) != 0u;
}

/** What follows TIP, one frame each. */
static ccgen_frame_kind_t kind_behind_tip(const uint16_t behind) {
    if (behind == 1u) {
        return CCGEN_FRAME_STATUS;
    }
    return (behind == 2u) ? CCGEN_FRAME_HEALTH : CCGEN_FRAME_COMMAND;
}

ccgen_frame_kind_t ccgen_layout_kind(const ccgen_layout_t *const layout,
                                     const ccgen_frame_t *const frame, uint16_t *const slot) {
    const uint32_t index = frame->id - layout->base_id;
    const uint16_t lengths = ccgen_layout_lengths_frames(layout);
    const uint16_t tip = ccgen_layout_tip_index(layout);
    ccgen_frame_kind_t kind = CCGEN_FRAME_TIP;
    uint16_t first = tip;
    if ((frame->extended != layout->extended) || (frame->id < layout->base_id) ||
        (index > ccgen_layout_command_index(layout))) {
        return CCGEN_FRAME_FOREIGN;
    }
    if (index > tip) {
        kind = kind_behind_tip((uint16_t)(index - tip));
        first = (uint16_t)index;
    } else if (index < lengths) {
        kind = CCGEN_FRAME_LENGTHS;
        first = 0;
    } else if (index < tip) {
        kind = CCGEN_FRAME_ANGLES;
        first = lengths;
    }
    if (slot != NULL) {
        *slot = (uint16_t)(index - first);
    }
    return kind;
}

void ccgen_layout_begin(const ccgen_layout_t *const layout, const uint16_t index,
                        ccgen_frame_t *const frame) {
    frame->id = layout->base_id + index;
    frame->extended = layout->extended;
    frame->fd = layout->fd;
    frame->remote = false;
    frame->rate_switch = layout->fd && layout->rate_switch;
    frame->length = ccgen_layout_frame_length(layout);
    for (uint8_t i = 0; i < frame->length; ++i) {
        frame->data[i] = 0;
    }
}

static uint16_t data_id(const ccgen_frame_t *const frame) {
    return (uint16_t)(frame->id & 0xFFFFu);
}

int ccgen_layout_protect(const ccgen_layout_t *const layout, const uint8_t number,
                         ccgen_frame_t *const frame) {
    const ccgen_e2e_profile_t profile = ccgen_layout_profile(layout);
    uint8_t counter = number;
    if (number >= ccgen_layout_numbers(layout)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (has_turn(layout)) {
        const uint8_t turn = (uint8_t)(number / CCGEN_E2E_P01_COUNTERS);
        counter = (uint8_t)(number - turn * CCGEN_E2E_P01_COUNTERS);
        frame->data[1] = (uint8_t)(turn << TURN_SHIFT); /* the header's other bits come below */
    }
    return ccgen_e2e_protect(profile, data_id(frame), counter, frame->data, frame->length);
}

int ccgen_layout_check(const ccgen_layout_t *const layout, const ccgen_frame_t *const frame) {
    if (frame->remote || (frame->fd != layout->fd) ||
        (frame->length != ccgen_layout_frame_length(layout))) {
        return CCGEN_ERROR_FORMAT;
    }
    const int counter =
        ccgen_e2e_check(ccgen_layout_profile(layout), data_id(frame), frame->data, frame->length);
    if ((counter < 0) || !has_turn(layout)) {
        return counter;
    }
    return (int)((frame->data[1] >> TURN_SHIFT) * CCGEN_E2E_P01_COUNTERS) + counter;
}

void ccgen_put_signed(uint8_t *const data, const uint8_t bytes, const int32_t value) {
    uint32_t word = (uint32_t)value;
    for (uint8_t i = 0; i < bytes; ++i) {
        data[i] = (uint8_t)(word & 0xFFu);
        word >>= 8;
    }
}

/** \return whether a signal may have so many bytes. */
static bool bytes_valid(const uint8_t bytes) {
    return (bytes >= 1u) && (bytes <= 4u);
}

int32_t ccgen_get_signed(const uint8_t *const data, const uint8_t bytes) {
    uint32_t word = 0;
    if (!bytes_valid(bytes)) {
        return 0;
    }
    for (uint8_t i = bytes; i > 0u; --i) {
        word = (word << 8) | data[i - 1u];
    }
    const uint32_t sign = (uint32_t)1u << (8u * bytes - 1u);
    return ccgen_signed32((word ^ sign) - sign);
}

int32_t ccgen_no_reading(const uint8_t bytes) {
    if (!bytes_valid(bytes)) {
        return 0;
    }
    const uint32_t sign = (uint32_t)1u << (8u * bytes - 1u);
    return ccgen_signed32(0u - sign);
}
