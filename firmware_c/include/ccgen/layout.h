/**
 * \file layout.h
 * \brief Which frames a joint has on the bus, and where the signals are in them.
 *
 * Frame k has identifier base_id + k: LENGTHS frames first (counts in the order of the joint's
 * sensors), then ANGLES frames (u segments, v segments, then elongations h of sections), then TIP,
 * STATUS, HEALTH and COMMAND; what a joint does not publish, or obey, keeps its identifier. A frame
 * is the E2E header, then as many little-endian two's complement signals as fit; unused bytes are 0.
 * It is 8 bytes long; on CAN FD as long as it needs to be: 12, 16, 20, 24, 32, 48 or 64. A receiver
 * takes no other length. A signal's most negative value means "no reading". The E2E data ID is the
 * low 16 bits of the identifier.
 *
 * Every sending of the sensors has a number, which LENGTHS, ANGLES and TIP carry. On CAN FD it is
 * the counter of P05, 0 to 255. On classic CAN the counter of P01 comes round after 15; the nibble
 * beside it, which P01 leaves to the payload, counts these turns: number = turn * 15 + counter,
 * 0 to 239. Without the turn the number is the counter alone. STATUS, HEALTH and COMMAND frames
 * have counters of their own, and turn 0.
 *
 * What can be told beforehand stands in the layout: nothing is divided out at run time. All
 * functions (layout_inline.h) are pure, take constant time and accept only layouts that
 * ccgen_layout_valid() accepts.
 */
#ifndef CCGEN_LAYOUT_H
#define CCGEN_LAYOUT_H

#include "ccgen/check.h"
#include "ccgen/e2e.h"
#include "ccgen/error.h"
#include "ccgen/frame.h"

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
    bool fd;             /**< CAN FD: frames of up to 64 bytes and E2E P05; else of 8 and P01 */
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

    /* What follows from all that, as it is generated: */
    uint16_t numbers;          /**< how many there are: 256 on CAN FD, else 240, or 15 without turn */
    uint8_t values;            /**< of all axes, one after the other in the ANGLES frames */
    uint8_t counts_per_frame;  /**< in a LENGTHS frame, but for the last */
    uint8_t angles_per_frame;  /**< in an ANGLES frame, but for the last */
    uint8_t lengths_frames;    /**< at most CCGEN_SENSORS_MAX */
    uint8_t angles_frames;
    uint8_t frame_bytes;       /**< of LENGTHS and ANGLES frames, but for the last: 8 or 64 */
    uint8_t last_lengths_bytes; /**< of the last LENGTHS frame */
    uint8_t last_angles_bytes; /**< of the last ANGLES frame */
    uint8_t single_bytes;      /**< of TIP, STATUS, HEALTH and COMMAND: 8 or 12 */
    const uint8_t *keys;        /**< on classic CAN: [frames] ccgen_e2e_key() of each data ID, in
                                     CCGEN_FLASH; without meaning on CAN FD */
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

#endif /* CCGEN_LAYOUT_H */
