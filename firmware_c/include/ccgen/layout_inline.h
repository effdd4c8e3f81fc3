/**
 * \file layout_inline.h
 * \brief What layout.h describes, inline: where a joint's layout is known, it folds into the code.
 */
#ifndef CCGEN_LAYOUT_INLINE_H
#define CCGEN_LAYOUT_INLINE_H

#include "ccgen/e2e_inline.h"
#include "ccgen/flash.h"
#include "ccgen/integer.h"
#include "ccgen/layout.h"

#define CCGEN_LAYOUT_CLASSIC_LENGTH 8u
#define CCGEN_LAYOUT_FD_LENGTH 64u
#define CCGEN_LAYOUT_SINGLE_PAYLOAD 6u /* of TIP, STATUS and HEALTH; COMMAND has 2 */
#define CCGEN_LAYOUT_TURNS 16u
#define CCGEN_LAYOUT_TURN_SHIFT 4u
#define CCGEN_LAYOUT_OVER_COUNTERS 137u /* n / 15 = n 137 / 2^11, exactly, for n below 285 */
#define CCGEN_LAYOUT_OVER_COUNTERS_BITS 11u
#define CCGEN_LAYOUT_STANDARD_ID_MAX 0x7FFu
#define CCGEN_LAYOUT_EXTENDED_ID_MAX 0x1FFFFFFFu

/** \return the E2E profile of all frames. */
static inline ccgen_e2e_profile_t ccgen_layout_profile(const ccgen_layout_t *const layout) {
    return layout->fd ? CCGEN_E2E_P05 : CCGEN_E2E_P01;
}

/** \return bytes of the E2E header of all frames. */
static inline uint8_t ccgen_layout_header(const ccgen_layout_t *const layout) {
    return layout->fd ? CCGEN_E2E_P05_HEADER : CCGEN_E2E_P01_HEADER;
}

/** \return whether numbers have a turn beside the counter of P01. */
static inline bool ccgen_layout_has_turn(const ccgen_layout_t *const layout) {
    return !layout->fd && layout->turn;
}

/** \return index k of the TIP frame: identifier minus base. */
static inline uint16_t ccgen_layout_tip_index(const ccgen_layout_t *const layout) {
    return (uint16_t)(layout->lengths_frames + layout->angles_frames);
}

/** \return index k of the STATUS frame. */
static inline uint16_t ccgen_layout_status_index(const ccgen_layout_t *const layout) {
    return (uint16_t)(ccgen_layout_tip_index(layout) + 1u);
}

/** \return index k of the HEALTH frame. */
static inline uint16_t ccgen_layout_health_index(const ccgen_layout_t *const layout) {
    return (uint16_t)(ccgen_layout_tip_index(layout) + 2u);
}

/** \return index k of the COMMAND frame, which is the last. */
static inline uint16_t ccgen_layout_command_index(const ccgen_layout_t *const layout) {
    return (uint16_t)(ccgen_layout_tip_index(layout) + 3u);
}

/** \return bytes of data in frame k. */
static inline uint8_t ccgen_layout_frame_length(const ccgen_layout_t *const layout,
                                                const uint16_t index) {
    const uint16_t tip = ccgen_layout_tip_index(layout);
    if (index >= tip) {
        return layout->single_bytes;
    }
    if ((index + 1u) == tip) {
        return layout->last_angles_bytes;
    }
    return ((index + 1u) == layout->lengths_frames) ? layout->last_lengths_bytes
                                                    : layout->frame_bytes;
}

/** \return whether the node sends frame k, which is not LENGTHS, and not behind HEALTH. */
static inline bool ccgen_layout_publishes(const ccgen_layout_t *const layout,
                                          const uint16_t index) {
    const uint16_t tip = ccgen_layout_tip_index(layout);
    const uint16_t bit = (uint16_t)((index < tip) ? 0u : (index - tip + 1u));
    return (((uint32_t)layout->publish >> bit) & 1u) != 0u;
}

/** Writes a signal of 16 bits. */
static inline void ccgen_put16(uint8_t *const data, const int16_t value) {
    const uint16_t word = (uint16_t)value;
    data[0] = (uint8_t)(word & 0xFFu);
    data[1] = (uint8_t)(word >> 8);
}

/** Writes a signal of 32 bits. */
static inline void ccgen_put32(uint8_t *const data, const int32_t value) {
    const uint32_t word = (uint32_t)value;
    data[0] = (uint8_t)(word & 0xFFu);
    data[1] = (uint8_t)((word >> 8) & 0xFFu);
    data[2] = (uint8_t)((word >> 16) & 0xFFu);
    data[3] = (uint8_t)(word >> 24);
}

/** \return a count of a LENGTHS frame, of 2, 3 or 4 bytes; INT32_MIN for "no reading", whatever its
 * width. */
static inline int32_t ccgen_get_count(const uint8_t *const data, const uint8_t bytes) {
    uint32_t word = (uint32_t)data[0] << 16;
    word |= (uint32_t)data[1] << 24;
    if (bytes == 2u) {
        return (word == 0x80000000u) ? INT32_MIN : (ccgen_signed32(word) >> 16); /* MISRA 10.1 */
    }
    word = (word >> 8) | ((uint32_t)data[2] << 24);
    if (bytes == 3u) {
        return (word == 0x80000000u) ? INT32_MIN : (ccgen_signed32(word) >> 8); /* MISRA 10.1 */
    }
    return ccgen_signed32((word >> 8) | ((uint32_t)data[3] << 24));
}

/** \return whether there may be `sensors` sensors from number `first` on. */
static inline bool ccgen_sensors_exist(const uint8_t first, const uint8_t sensors) {
    return (first <= CCGEN_SENSORS_MAX) && (sensors <= (CCGEN_SENSORS_MAX - first));
}

/**
 * Puts readings of a joint of precision 16 into the list of all its counts.
 * \param[out] all     [CCGEN_SENSORS_MAX] in the joint's order; INT32_MIN: no reading
 * \param[in] first    the first sensor
 * \param[in] sensors  how many; first + sensors at most CCGEN_SENSORS_MAX
 * \param[in] counts   [sensors] INT16_MIN: no reading
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer or sensors that there are not
 */
static inline int ccgen_put_counts16(int32_t *const all, const uint8_t first,
                                     const uint8_t sensors, const int16_t *const counts) {
    if ((all == NULL) || (counts == NULL) || !ccgen_sensors_exist(first, sensors)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t j = 0; j < sensors; ++j) {
        all[first + j] = (counts[j] == INT16_MIN) ? INT32_MIN : (int32_t)counts[j];
    }
    return CCGEN_OK;
}

/** The same for a joint of precision 32; INT32_MIN: no reading. */
static inline int ccgen_put_counts32(int32_t *const all, const uint8_t first,
                                     const uint8_t sensors, const int32_t *const counts) {
    if ((all == NULL) || (counts == NULL) || !ccgen_sensors_exist(first, sensors)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t j = 0; j < sensors; ++j) {
        all[first + j] = counts[j];
    }
    return CCGEN_OK;
}

static inline bool ccgen_layout_axes_valid(const ccgen_layout_t *const layout) {
    bool valid = (layout->sensors >= 1u) && (layout->sensors <= CCGEN_SENSORS_MAX);
    for (uint8_t axis = 0; axis < CCGEN_AXES_MAX; ++axis) {
        valid = valid && (layout->rows[axis] <= CCGEN_SEGMENTS_MAX);
    }
    return valid && (layout->values >= 1u);
}

static inline bool ccgen_layout_signals_valid(const ccgen_layout_t *const layout) {
    return (layout->count_bytes >= 2u) && (layout->count_bytes <= 4u) &&
           ((layout->angle_bytes == 2u) || (layout->angle_bytes == 4u));
}

/** \return the widest window: CCGEN_WINDOW_CYCLES or CCGEN_WINDOW_CYCLES_WITHOUT_TURN cycles, at
 *          most CCGEN_PERIOD_MAX_US. */
static inline uint32_t ccgen_layout_window_max_us(const ccgen_layout_t *const layout) {
    const bool counter_alone = !layout->fd && !layout->turn;
    /* MISRA 10.6 */
    const uint32_t cycles = counter_alone ? CCGEN_WINDOW_CYCLES_WITHOUT_TURN : CCGEN_WINDOW_CYCLES;
    const bool fits = layout->cycle_us <= (CCGEN_PERIOD_MAX_US / cycles);
    return fits ? (cycles * layout->cycle_us) : CCGEN_PERIOD_MAX_US;
}

static inline bool ccgen_layout_times_valid(const ccgen_layout_t *const layout) {
    return (layout->cycle_us >= 1u) && (layout->cycle_us <= CCGEN_PERIOD_MAX_US) &&
           (layout->window_us >= 1u) && (layout->window_us <= ccgen_layout_window_max_us(layout));
}

static inline bool ccgen_layout_identifiers_valid(const ccgen_layout_t *const layout) {
    const uint32_t last =
        layout->extended ? CCGEN_LAYOUT_EXTENDED_ID_MAX : CCGEN_LAYOUT_STANDARD_ID_MAX;
    return (layout->base_id <= last) &&
           ((uint32_t)ccgen_layout_command_index(layout) <= (last - layout->base_id));
}

/** \return whether a frame holds a header and so many bytes of signals. */
static inline bool ccgen_layout_holds(const ccgen_layout_t *const layout, const uint8_t frame_bytes,
                                      const uint16_t payload) {
    return (frame_bytes <= layout->frame_bytes) &&
           ((uint16_t)(payload + ccgen_layout_header(layout)) <= frame_bytes);
}

/** Signals of one size that follow each other over several frames. */
typedef struct {
    uint8_t signals;
    uint8_t bytes; /* of a signal */
    uint8_t frames;
    uint8_t per_frame;
    uint8_t last_bytes; /* of the last frame */
} ccgen_layout_list_t;

/** \return whether these frames hold just these signals. */
static inline bool ccgen_layout_list_fits(const ccgen_layout_t *const layout,
                                          const ccgen_layout_list_t *const list) {
    const uint16_t places = (uint16_t)(list->frames * list->per_frame);
    const uint16_t spare = (uint16_t)(places - list->signals);
    const uint16_t last = (uint16_t)(list->per_frame - spare);
    return (places >= list->signals) && (spare < list->per_frame) &&
           ccgen_layout_holds(layout, layout->frame_bytes,
                              (uint16_t)(list->per_frame * list->bytes)) &&
           ccgen_layout_holds(layout, list->last_bytes, (uint16_t)(last * list->bytes));
}

/** \return whether what follows from the rest does. */
static inline bool ccgen_layout_rest_follows(const ccgen_layout_t *const layout) {
    const ccgen_layout_list_t counts = {layout->sensors, layout->count_bytes,
                                        layout->lengths_frames, layout->counts_per_frame,
                                        layout->last_lengths_bytes};
    const ccgen_layout_list_t angles = {layout->values, layout->angle_bytes, layout->angles_frames,
                                        layout->angles_per_frame, layout->last_angles_bytes};
    const uint16_t counters = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    const uint16_t turns = ccgen_layout_has_turn(layout) ? CCGEN_LAYOUT_TURNS : 1u;
    return (layout->numbers == (uint16_t)(turns * counters)) &&
           (layout->values == (layout->rows[0] + layout->rows[1] + layout->rows[2])) &&
           (layout->frame_bytes ==
            (layout->fd ? CCGEN_LAYOUT_FD_LENGTH : CCGEN_LAYOUT_CLASSIC_LENGTH)) &&
           (layout->fd || (layout->keys != NULL)) && ccgen_layout_list_fits(layout, &counts) &&
           ccgen_layout_list_fits(layout, &angles) &&
           ccgen_layout_holds(layout, layout->single_bytes, CCGEN_LAYOUT_SINGLE_PAYLOAD);
}

/** \return whether every field is within the bounds above and all identifiers exist. */
static inline bool ccgen_layout_valid(const ccgen_layout_t *const layout) {
    return (layout != NULL) && ccgen_layout_axes_valid(layout) &&
           ccgen_layout_signals_valid(layout) && ccgen_layout_times_valid(layout) &&
           ccgen_layout_rest_follows(layout) && ccgen_layout_identifiers_valid(layout);
}

/** What follows TIP, one frame each. */
static inline ccgen_frame_kind_t ccgen_layout_kind_behind_tip(const uint16_t behind) {
    if (behind == 1u) {
        return CCGEN_FRAME_STATUS;
    }
    return (behind == 2u) ? CCGEN_FRAME_HEALTH : CCGEN_FRAME_COMMAND;
}

/**
 * Tells what a frame is from its identifier alone.
 * \param[in] layout
 * \param[in] frame
 * \param[out] slot  which of its kind, from 0; may be NULL; not written for a foreign frame
 */
static inline ccgen_frame_kind_t ccgen_layout_kind(const ccgen_layout_t *const layout,
                                                   const ccgen_frame_t *const frame,
                                                   uint16_t *const slot) {
    const uint32_t index = frame->id - layout->base_id;
    const uint16_t lengths = layout->lengths_frames;
    const uint16_t tip = ccgen_layout_tip_index(layout);
    ccgen_frame_kind_t kind = CCGEN_FRAME_TIP;
    uint16_t first = tip;
    if ((frame->extended != layout->extended) || (frame->id < layout->base_id) ||
        (index > ccgen_layout_command_index(layout))) {
        return CCGEN_FRAME_FOREIGN;
    }
    if (index > tip) {
        kind = ccgen_layout_kind_behind_tip((uint16_t)(index - tip));
        first = (uint16_t)index;
    } else if (index < lengths) {
        kind = CCGEN_FRAME_LENGTHS;
        first = 0;
    } else if (index < tip) {
        kind = CCGEN_FRAME_ANGLES;
        first = lengths;
    } else {
        /* TIP itself */
    }
    if (slot != NULL) {
        *slot = (uint16_t)(index - first);
    }
    return kind;
}

/**
 * Starts a frame: identifier, kind and length.
 * \param[in] layout
 * \param[in] index   0 to ccgen_layout_command_index()
 * \param[out] frame
 * \return where its signals go
 */
static inline uint8_t *ccgen_layout_open(const ccgen_layout_t *const layout, const uint16_t index,
                                         ccgen_frame_t *const frame) {
    frame->id = layout->base_id + index;
    frame->extended = layout->extended;
    frame->fd = layout->fd;
    frame->remote = false;
    frame->rate_switch = layout->fd && layout->rate_switch;
    frame->length = ccgen_layout_frame_length(layout, index);
    return &frame->data[ccgen_layout_header(layout)];
}

/** Clears the bytes of a frame from one on. */
static inline void ccgen_layout_clear_from(ccgen_frame_t *const frame, const uint8_t first) {
    for (uint8_t i = first; i < frame->length; ++i) {
        frame->data[i] = 0;
    }
}

/** Starts a frame as ccgen_layout_open(), and clears all bytes of its length. */
static inline void ccgen_layout_begin(const ccgen_layout_t *const layout, const uint16_t index,
                                      ccgen_frame_t *const frame) {
    (void)ccgen_layout_open(layout, index, frame);
    ccgen_layout_clear_from(frame, 0);
}

/** \return what the check value of one of the joint's frames takes from its identifier. */
static inline uint16_t ccgen_layout_key_of(const ccgen_layout_t *const layout,
                                           const ccgen_frame_t *const frame) {
    return layout->fd ? (uint16_t)(frame->id & 0xFFFFu)
                      : CCGEN_FLASH_BYTE(&layout->keys[frame->id - layout->base_id]);
}

/**
 * Numbers and protects a frame that ccgen_layout_begin() started and whose signals are in place.
 * \param[in] layout
 * \param[in] number     below `numbers`; the own counter of a STATUS, HEALTH or COMMAND
 *                       frame, which is below that of the E2E profile
 * \param[in,out] frame
 * \return as ccgen_e2e_protect(); CCGEN_ERROR_ARGUMENT for a number out of range
 */
static inline int ccgen_layout_protect(const ccgen_layout_t *const layout, const uint8_t number,
                                       ccgen_frame_t *const frame) {
    uint8_t counter = number;
    if (number >= layout->numbers) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (!layout->fd) {
        const uint8_t turn =
            /* MISRA 12.2 */
            (uint8_t)((number * CCGEN_LAYOUT_OVER_COUNTERS) >> CCGEN_LAYOUT_OVER_COUNTERS_BITS);
        counter = (uint8_t)(number - turn * CCGEN_E2E_P01_COUNTERS);
        frame->data[1] =
            (uint8_t)(turn << CCGEN_LAYOUT_TURN_SHIFT); /* the header's other bits come below */
    }
    return ccgen_e2e_protect(ccgen_layout_profile(layout), ccgen_layout_key_of(layout, frame),
                             counter, frame->data, frame->length);
}

/**
 * Ends a frame that ccgen_layout_open() started: clears what is behind its signals and protects it.
 * \param[in] layout
 * \param[in] number     as ccgen_layout_protect()
 * \param[in] payload    bytes of signals, from where ccgen_layout_open() said
 * \param[in,out] frame
 * \return as ccgen_layout_protect()
 */
static inline int ccgen_layout_close(const ccgen_layout_t *const layout, const uint8_t number,
                                     const uint8_t payload, ccgen_frame_t *const frame) {
    ccgen_layout_clear_from(frame, (uint8_t)(ccgen_layout_header(layout) + payload));
    return ccgen_layout_protect(layout, number, frame);
}

/**
 * Checks one of the joint's frames as a receiver does.
 * \param[in] layout
 * \param[in] frame   with an identifier of the joint
 * \return its number; CCGEN_ERROR_FORMAT for a wrong kind, length or counter; CCGEN_ERROR_CRC
 */
static inline int ccgen_layout_check(const ccgen_layout_t *const layout,
                                     const ccgen_frame_t *const frame) {
    const uint16_t index = (uint16_t)(frame->id - layout->base_id);
    if (frame->remote || (frame->fd != layout->fd) ||
        (frame->length != ccgen_layout_frame_length(layout, index))) {
        return CCGEN_ERROR_FORMAT;
    }
    const int counter =
        ccgen_e2e_check(ccgen_layout_profile(layout), ccgen_layout_key_of(layout, frame),
                        frame->data, frame->length);
    if ((counter < 0) || !ccgen_layout_has_turn(layout)) {
        return counter;
    }
    /* MISRA 10.8 */
    return (int)((frame->data[1] >> CCGEN_LAYOUT_TURN_SHIFT) * CCGEN_E2E_P01_COUNTERS) + counter;
}

/** Writes the low `bytes` bytes (1 to 4) of `value`, little-endian: a count. */
static inline void ccgen_put_signed(uint8_t *const data, const uint8_t bytes, const int32_t value) {
    uint32_t word = (uint32_t)value;
    for (uint8_t i = 0; i < bytes; ++i) {
        data[i] = (uint8_t)(word & 0xFFu);
        word >>= 8;
    }
}

#endif /* CCGEN_LAYOUT_INLINE_H */
