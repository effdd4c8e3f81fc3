/**
 * \file layout.h
 * \brief Which frames a joint has on the bus, and where the signals are in them.
 *
 * Frame k has identifier base_id + k: LENGTHS frames first (counts in the order of the joint's
 * sensors), then ANGLES frames (u segments, v segments, then elongations h of sections), then TIP,
 * STATUS, HEALTH and COMMAND; what a joint does not publish, or obey, keeps its identifier. Every
 * frame is 8 bytes long (64 on CAN FD): the E2E header, then as many little-endian two's complement
 * signals as fit; unused bytes are 0. A signal's most negative value means "no reading". The E2E
 * data ID is the low 16 bits of the identifier.
 *
 * Every sending of the sensors has a number, which LENGTHS, ANGLES and TIP carry. On CAN FD it is
 * the counter of P05, 0 to 255. On classic CAN the counter of P01 comes round after 15; the nibble
 * beside it, which P01 leaves to the payload, counts these turns: number = turn * 15 + counter,
 * 0 to 239. Without the turn the number is the counter alone. STATUS, HEALTH and COMMAND frames
 * have counters of their own, and turn 0.
 *
 * All functions are pure, take constant time and accept only layouts that ccgen_layout_valid()
 * accepts.
 */
#ifndef CCGEN_LAYOUT_H
#define CCGEN_LAYOUT_H

#include "ccgen/check.h"
#include "ccgen/e2e.h"
#include "ccgen/error.h"
#include "ccgen/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Longest cycle and window, so that sums of times stay far from the clock's wrap. */
#define CCGEN_PERIOD_MAX_US 300000000u

/** Widest window in cycles: a frame may be late by half the numbers, and a window must fit into the
 * rest of them. */
#define CCGEN_WINDOW_CYCLES 100u

/** The same where the number is the counter of P01 alone. */
#define CCGEN_WINDOW_CYCLES_WITHOUT_TURN 6u

/** Kinds of frames that a node may send: bits of `publish`. */
enum {
    CCGEN_PUBLISH_ANGLES = 0x01,
    CCGEN_PUBLISH_TIP = 0x02,
    CCGEN_PUBLISH_STATUS = 0x04,
    CCGEN_PUBLISH_HEALTH = 0x08
};

/** The layout of one joint: lives in flash. */
typedef struct {
    uint32_t base_id;    /**< identifier of the first LENGTHS frame */
    bool extended;       /**< 29-bit identifiers */
    bool fd;             /**< CAN FD: 64-byte frames and E2E P05; else 8-byte frames and P01 */
    bool turn;           /**< on classic CAN: the number has a turn; without meaning on CAN FD */
    uint8_t sensors;     /**< 1 to CCGEN_SENSORS_MAX */
    uint8_t rows[CCGEN_AXES_MAX]; /**< values of u, v and h: each 0 to CCGEN_SEGMENTS_MAX, not all 0 */
    uint8_t count_bytes; /**< of a count on the bus: 2, 3 or 4 */
    uint8_t angle_bytes; /**< of an angle on the bus: 2 or 4 */
    uint32_t cycle_us;   /**< period of snapshots and of the status; 1 to CCGEN_PERIOD_MAX_US */
    uint32_t window_us;  /**< a snapshot's frames arrive within this time of its first; 1 to
                              ccgen_layout_window_max_us() */
    uint16_t fingerprint; /**< of the model, for HEALTH */
    uint8_t publish;      /**< CCGEN_PUBLISH_... of what the node sends */
    bool rate_switch;     /**< CAN FD frames have the faster data phase */
    bool commands;        /**< COMMAND frames are obeyed */
} ccgen_layout_t;

typedef enum {
    CCGEN_FRAME_LENGTHS,
    CCGEN_FRAME_ANGLES,
    CCGEN_FRAME_TIP,
    CCGEN_FRAME_STATUS,
    CCGEN_FRAME_HEALTH,
    CCGEN_FRAME_COMMAND,
    CCGEN_FRAME_FOREIGN /**< not one of the joint's */
} ccgen_frame_kind_t;

/** \return whether every field is within the bounds above and all identifiers exist. */
bool ccgen_layout_valid(const ccgen_layout_t *layout);

/** \return the E2E profile of all frames. */
ccgen_e2e_profile_t ccgen_layout_profile(const ccgen_layout_t *layout);

/** \return how many numbers there are: 256 on CAN FD, else 240, or 15 without the turn. */
uint16_t ccgen_layout_numbers(const ccgen_layout_t *layout);

/** \return the widest window: CCGEN_WINDOW_CYCLES or CCGEN_WINDOW_CYCLES_WITHOUT_TURN cycles, at
 *          most CCGEN_PERIOD_MAX_US. */
uint32_t ccgen_layout_window_max_us(const ccgen_layout_t *layout);

/** \return bytes of data in every frame: 8, or 64 on CAN FD. */
uint8_t ccgen_layout_frame_length(const ccgen_layout_t *layout);

/** \return how many signals of `bytes` bytes fit one frame. */
uint8_t ccgen_layout_slots(const ccgen_layout_t *layout, uint8_t bytes);

/** \return number of LENGTHS frames, at most CCGEN_SENSORS_MAX. */
uint8_t ccgen_layout_lengths_frames(const ccgen_layout_t *layout);

/** \return values of all axes, one after the other in the ANGLES frames. */
uint8_t ccgen_layout_values(const ccgen_layout_t *layout);

/** \return number of ANGLES frames. */
uint8_t ccgen_layout_angles_frames(const ccgen_layout_t *layout);

/** \return index k of the TIP frame: identifier minus base. */
uint16_t ccgen_layout_tip_index(const ccgen_layout_t *layout);

/** \return index k of the STATUS frame. */
uint16_t ccgen_layout_status_index(const ccgen_layout_t *layout);

/** \return index k of the HEALTH frame. */
uint16_t ccgen_layout_health_index(const ccgen_layout_t *layout);

/** \return index k of the COMMAND frame, which is the last. */
uint16_t ccgen_layout_command_index(const ccgen_layout_t *layout);

/** \return whether the node sends frame k. */
bool ccgen_layout_publishes(const ccgen_layout_t *layout, uint16_t index);

/**
 * Tells what a frame is from its identifier alone.
 * \param[in] layout
 * \param[in] frame
 * \param[out] slot  which of its kind, from 0; may be NULL; not written for a foreign frame
 */
ccgen_frame_kind_t ccgen_layout_kind(const ccgen_layout_t *layout, const ccgen_frame_t *frame,
                                     uint16_t *slot);

/**
 * Starts a frame: identifier, kind and length set, all bytes of that length 0.
 * \param[in] layout
 * \param[in] index   0 to ccgen_layout_command_index()
 * \param[out] frame
 */
void ccgen_layout_begin(const ccgen_layout_t *layout, uint16_t index, ccgen_frame_t *frame);

/**
 * Numbers and protects a frame that ccgen_layout_begin() started and whose signals are in place.
 * \param[in] layout
 * \param[in] number     below ccgen_layout_numbers(); the own counter of a STATUS, HEALTH or COMMAND
 *                       frame, which is below that of the E2E profile
 * \param[in,out] frame
 * \return as ccgen_e2e_protect(); CCGEN_ERROR_ARGUMENT for a number out of range
 */
int ccgen_layout_protect(const ccgen_layout_t *layout, uint8_t number, ccgen_frame_t *frame);

/**
 * Checks one of the joint's frames as a receiver does.
 * \param[in] layout
 * \param[in] frame   with an identifier of the joint
 * \return its number; CCGEN_ERROR_FORMAT for a wrong kind, length or counter; CCGEN_ERROR_CRC
 */
int ccgen_layout_check(const ccgen_layout_t *layout, const ccgen_frame_t *frame);

/** Writes the low `bytes` bytes (1 to 4) of `value`, little-endian. */
void ccgen_put_signed(uint8_t *data, uint8_t bytes, int32_t value);

/** \return the little-endian two's complement value of `bytes` bytes (1 to 4); 0 for any other
 * number. */
int32_t ccgen_get_signed(const uint8_t *data, uint8_t bytes);

/** \return the most negative value of a signal of `bytes` bytes (1 to 4): "no reading"; 0
 * otherwise. */
int32_t ccgen_no_reading(uint8_t bytes);

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_LAYOUT_H */
