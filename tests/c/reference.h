/**
 * \file reference.h
 * \brief What an exported joint must answer, owing nothing to the runtime's own arithmetic.
 *
 * fuzz_reference.h, written for each joint, defines `reference`: the axes of its integer
 * reference model, and `reference_sensors`. FUZZ_LAYOUT names the joint's layout.
 */
#ifndef REFERENCE_H
#define REFERENCE_H

#include "ccgen/layout_inline.h"
#include "must.h"
#include "port_joint.h"

/** One output axis of the reference model. */
typedef struct {
    uint8_t first; /* of its sensors in the joint's list */
    uint8_t sensors;
    uint16_t rows;
    uint8_t shift;
    int64_t bias[CCGEN_SEGMENTS_MAX];
    int64_t weights[CCGEN_SEGMENTS_MAX][CCGEN_SENSORS_MAX];
    uint8_t place; /* 0 for u, 1 for v, 2 for h */
    bool serves[CCGEN_SENSORS_MAX]; /* whether there are rows without a sensor */
    int64_t without[CCGEN_SENSORS_MAX][CCGEN_SEGMENTS_MAX][CCGEN_SENSORS_MAX];
} reference_t;

/** One sensor: its counts, its differences count - zero, the zeros that are accepted. */
typedef struct {
    int64_t minimum;
    int64_t maximum;
    int64_t difference_minimum;
    int64_t difference_maximum;
    int64_t zero_minimum;
    int64_t zero_maximum;
    uint8_t bit; /* in a mask of missing sensors */
} reference_sensor_t;

#include "fuzz_reference.h" /* static const: reference[], reference_sensors[PORT_SENSORS] */

#define SENSORS PORT_SENSORS
#define LIMIT ((int64_t)((UINT64_C(1) << (PORT_PRECISION - 1)) - 1u))

static const ccgen_layout_t *const layout = &FUZZ_LAYOUT;

/** \return an integer of `bytes` bytes, written out so that it owes nothing to the runtime. */
static inline int64_t read_signed(const uint8_t *const data, const uint8_t bytes) {
    uint64_t word = 0;
    for (uint8_t i = 0; i < bytes; ++i) {
        word |= (uint64_t)data[i] << (8u * i);
    }
    const uint64_t sign = UINT64_C(1) << (8u * bytes - 1u);
    return (int64_t)(word ^ sign) - (int64_t)sign;
}

static inline int64_t lowest_of(const uint8_t bytes) {
    return -(int64_t)(UINT64_C(1) << (8u * bytes - 1u));
}

static inline const uint8_t *payload_of(const ccgen_frame_t *const frame) {
    return frame->data + (layout->fd ? 3 : 2);
}

/** \return whether a count is a reading with this zero. */
static inline bool is_reading(const uint8_t j, const int64_t count, const int64_t zero) {
    const reference_sensor_t *const sensor = &reference_sensors[j];
    const int64_t difference = count - zero;
    return (count >= sensor->minimum) && (count <= sensor->maximum) &&
           (difference >= sensor->difference_minimum) && (difference <= sensor->difference_maximum);
}

/** \return mask of sensors without a reading, as the node tells it. */
static inline int32_t missing_in(const int32_t *const counts, const int64_t *const zero) {
    int32_t mask = 0;
    for (uint8_t j = 0; j < SENSORS; ++j) {
        mask |= is_reading(j, counts[j], zero[j]) ? 0 : ((int32_t)1 << reference_sensors[j].bit);
    }
    return mask;
}

/** How many sensors of an axis have no reading, and one of them. */
static inline uint8_t lacking(const reference_t *const axis, const int32_t *const counts,
                              const int64_t *const zero, uint8_t *const which) {
    uint8_t number = 0;
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        const uint8_t sensor = (uint8_t)(axis->first + j);
        if (!is_reading(sensor, counts[sensor], zero[sensor])) {
            *which = j;
            ++number;
        }
    }
    return number;
}

/** \return 0: every sensor of an axis has a reading; 1: another serves in the place of one that
 * has none; 2: the axis is lost. */
static inline uint32_t state_of(const reference_t *const axis, const int32_t *const counts,
                                const int64_t *const zero) {
    uint8_t which = 0;
    const uint8_t number = lacking(axis, counts, zero, &which);
    return (number == 0u) ? 0u : ((number == 1u) && axis->serves[which]) ? 1u : 2u;
}

/** \return the states of all axes, two bits each. */
static inline uint32_t states_in(const int32_t *const counts, const int64_t *const zero) {
    uint32_t states = 0;
    for (size_t k = 0; k < (sizeof reference / sizeof reference[0]); ++k) {
        states |= state_of(&reference[k], counts, zero) << (2u * reference[k].place);
    }
    return states;
}

/** \return the states in which every axis is lost. */
static inline uint32_t all_lost(void) {
    uint32_t states = 0;
    for (size_t k = 0; k < (sizeof reference / sizeof reference[0]); ++k) {
        states |= 2u << (2u * reference[k].place);
    }
    return states;
}

/** The plain computation: acc, shift, saturation; of a value in the list of all axes'. */
static inline int64_t angle_of(const int32_t *const counts, const int64_t *const zero,
                               const uint16_t value) {
    uint16_t row = value;
    uint8_t which = 0;
    const reference_t *axis = reference;
    for (; row >= axis->rows; ++axis) {
        row = (uint16_t)(row - axis->rows);
    }
    const uint32_t state = state_of(axis, counts, zero);
    const bool whole = (lacking(axis, counts, zero, &which) == 0u);
    if (state == 2u) {
        return -LIMIT - 1;
    }
    int64_t acc = axis->bias[row];
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        const uint8_t sensor = (uint8_t)(axis->first + j);
        const int64_t weight = whole ? axis->weights[row][j] : axis->without[which][row][j];
        acc += weight * ((whole || (j != which)) ? ((int64_t)counts[sensor] - zero[sensor]) : 0);
    }
    const int64_t angle = acc >> axis->shift;
    return (angle > LIMIT) ? LIMIT : (angle < -LIMIT) ? -LIMIT : angle;
}

/** The zero offsets that a joint holds, as a list. */
static inline void read_zero(const port_joint_t *const joint, int64_t *const zero) {
    port_counts_t counts;
    port_count_t list[SENSORS];
    CHECK(port_zero(joint, &counts) == CCGEN_OK);
    port_pack_counts(&counts, list);
    for (uint8_t j = 0; j < SENSORS; ++j) {
        zero[j] = list[j];
    }
}

/** Bit by bit, most significant first, over one byte. */
static inline uint32_t crc_byte(uint32_t crc, const uint8_t byte, const uint8_t bits,
                                const uint32_t polynomial) {
    crc ^= (uint32_t)byte << (bits - 8u);
    for (uint8_t k = 0; k < 8u; ++k) {
        crc = (crc << 1) ^ ((((crc >> (bits - 1u)) & 1u) != 0u) ? polynomial : 0u);
    }
    return crc & ((1u << bits) - 1u);
}

/** \return the check value of a frame, at least as long as its header. */
static inline uint32_t check_value(const ccgen_frame_t *const frame) {
    const uint8_t id[2] = {(uint8_t)(frame->id & 0xFFu), (uint8_t)((frame->id >> 8) & 0xFFu)};
    uint32_t crc = 0xFFFFu;
    if (layout->fd) {
        for (uint8_t i = 2; i < frame->length; ++i) {
            crc = crc_byte(crc, frame->data[i], 16, 0x1021u);
        }
        return crc_byte(crc_byte(crc, id[0], 16, 0x1021u), id[1], 16, 0x1021u);
    }
    crc = crc_byte(crc_byte(0, id[0], 8, 0x1Du), id[1], 8, 0x1Du);
    for (uint8_t i = 1; i < frame->length; ++i) {
        crc = crc_byte(crc, frame->data[i], 8, 0x1Du);
    }
    return crc;
}

/** \return the length that a frame has by what it carries. */
static inline uint8_t length_of(const uint16_t index) {
    static const uint8_t lengths[] = {12, 16, 20, 24, 32, 48, 64};
    const uint16_t counts = (uint16_t)(61u / layout->count_bytes);
    const uint16_t angles = (uint16_t)(61u / layout->angle_bytes);
    const uint16_t lengths_frames = (uint16_t)((SENSORS + counts - 1u) / counts);
    const bool is_lengths = (index < lengths_frames);
    const uint16_t slot = (uint16_t)(is_lengths ? index : (index - lengths_frames));
    const uint16_t per_frame = is_lengths ? counts : angles;
    const uint16_t all = is_lengths ? SENSORS : PORT_VALUES;
    const uint16_t bytes = is_lengths ? layout->count_bytes : layout->angle_bytes;
    uint16_t payload = 6;
    uint8_t k = 0;
    if (!layout->fd) {
        return 8;
    }
    if ((slot * per_frame) < all) {
        const uint16_t left = (uint16_t)(all - slot * per_frame);
        payload = (uint16_t)(((left < per_frame) ? left : per_frame) * bytes);
    }
    while (lengths[k] < (3u + payload)) {
        ++k;
    }
    return lengths[k];
}

/** \return the number of a frame that a receiver must take; negative: why it must not. */
static inline int verdict(const ccgen_frame_t *const frame) {
    if (frame->remote || (frame->fd != layout->fd) ||
        (frame->length != length_of((uint16_t)(frame->id - layout->base_id)))) {
        return CCGEN_ERROR_FORMAT;
    }
    const uint32_t crc = check_value(frame);
    const uint32_t told =
        layout->fd ? (frame->data[0] | ((uint32_t)frame->data[1] << 8)) : frame->data[0];
    const int counter = layout->fd ? frame->data[2] : (frame->data[1] & 0x0F);
    const int turn = (!layout->fd && layout->turn) ? (frame->data[1] >> 4) : 0;
    if (crc != told) {
        return CCGEN_ERROR_CRC;
    }
    return (layout->fd || (counter < 15)) ? (15 * turn + counter) : CCGEN_ERROR_FORMAT;
}

/** \return how many numbers the joint's snapshots have. */
static inline int numbers_of_joint(void) {
    return layout->fd ? 256 : (layout->turn ? 240 : 15);
}

/** Fills in number and check value of a frame. */
static inline void protect(ccgen_frame_t *const frame, const int number) {
    if (layout->fd) {
        frame->data[2] = (uint8_t)number;
    } else {
        frame->data[1] = (uint8_t)((number / 15 * 16) + number % 15);
    }
    const uint32_t crc = check_value(frame);
    frame->data[0] = (uint8_t)(crc & 0xFFu);
    if (layout->fd) {
        frame->data[1] = (uint8_t)(crc >> 8);
    }
}

/** The LENGTHS frame of a place that a sound sender would send. */
static inline void make_lengths(const int32_t *const counts, const uint16_t place, const int number,
                                ccgen_frame_t *const frame) {
    const uint8_t bytes = layout->count_bytes;
    const uint8_t per_frame = layout->counts_per_frame;
    uint8_t *const payload = frame->data + (layout->fd ? 3 : 2);
    memset(frame, 0, sizeof *frame);
    ccgen_layout_begin(layout, place, frame);
    for (uint8_t i = 0; i < per_frame; ++i) {
        const size_t index = (size_t)place * per_frame + i;
        if (index < SENSORS) {
            ccgen_put_signed(&payload[i * bytes], bytes, counts[index]);
        }
    }
    protect(frame, number);
}

/** \return bytes that the counts of a LENGTHS frame take. */
static inline uint8_t counts_length(const uint16_t place) {
    const uint8_t per_frame = layout->counts_per_frame;
    const uint16_t before = (uint16_t)(place * per_frame);
    const uint16_t left = (uint16_t)(SENSORS - before);
    return (uint8_t)(((left < per_frame) ? left : per_frame) * layout->count_bytes);
}

#endif /* REFERENCE_H */
