/**
 * \file reference.h
 * \brief What an exported joint must answer, owing nothing to the runtime's own arithmetic.
 *
 * fuzz_reference.h, written for each joint, defines `reference`: the two axes of its integer
 * reference model. FUZZ_LAYOUT names the joint's layout.
 */
#ifndef REFERENCE_H
#define REFERENCE_H

#include "must.h"
#include "port_joint.h"

/** One axis of the reference model. */
typedef struct {
    uint8_t sensors;
    uint8_t shift;
    int64_t minimum[CCGEN_AXIS_SENSORS_MAX];
    int64_t maximum[CCGEN_AXIS_SENSORS_MAX];
    int64_t bias[PORT_SEGMENTS];
    int64_t weights[PORT_SEGMENTS][CCGEN_AXIS_SENSORS_MAX];
} reference_t;

#include "fuzz_reference.h" /* static const reference_t reference[2] */

#define SENSORS (PORT_SENSORS_U + PORT_SENSORS_V)
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

/** \return the axis of a sensor, and its place there. */
static inline const reference_t *axis_of(const uint8_t j, uint8_t *const sensor) {
    const bool is_v = (j >= PORT_SENSORS_U);
    *sensor = (uint8_t)(is_v ? (j - PORT_SENSORS_U) : j);
    return &reference[is_v ? 1 : 0];
}

/** \return mask of sensors out of range, as the node tells it. */
static inline int missing_in(const int32_t *const counts) {
    int mask = 0;
    for (uint8_t j = 0; j < SENSORS; ++j) {
        uint8_t sensor = 0;
        const reference_t *const axis = axis_of(j, &sensor);
        const bool inside =
            (counts[j] >= axis->minimum[sensor]) && (counts[j] <= axis->maximum[sensor]);
        mask |= inside ? 0 : (1 << (sensor + ((j >= PORT_SENSORS_U) ? 8 : 0)));
    }
    return mask;
}

/** The plain computation: acc, shift, saturation. */
static inline int64_t angle_of(const int32_t *const counts, const int64_t *const zero,
                               const int which, const uint16_t segment) {
    const reference_t *const axis = &reference[which];
    const uint8_t first = (which == 0) ? 0u : PORT_SENSORS_U;
    int64_t acc = axis->bias[segment];
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        acc += axis->weights[segment][j] * ((int64_t)counts[first + j] - zero[first + j]);
    }
    const int64_t angle = acc >> axis->shift;
    return (angle > LIMIT) ? LIMIT : (angle < -LIMIT) ? -LIMIT : angle;
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

/** \return the number of a frame that a receiver must take; negative: why it must not. */
static inline int verdict(const ccgen_frame_t *const frame) {
    if (frame->remote || (frame->fd != layout->fd) || (frame->length != (layout->fd ? 64u : 8u))) {
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
    const uint8_t per_frame = ccgen_layout_slots(layout, bytes);
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
    const uint8_t per_frame = ccgen_layout_slots(layout, layout->count_bytes);
    const uint16_t before = (uint16_t)(place * per_frame);
    const uint16_t left = (uint16_t)(SENSORS - before);
    return (uint8_t)(((left < per_frame) ? left : per_frame) * layout->count_bytes);
}

#endif /* REFERENCE_H */
