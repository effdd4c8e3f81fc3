/**
 * \file slcan.h
 * \brief SLCAN: CAN frames as lines of text over a byte stream, as serial CAN adapters speak it.
 *
 * Lawicel's commands with the CAN FD dialect of CANable. A line ends with CR; LF is ignored.
 *
 *     tIIIL.. TIIIIIIIIL..   data frame, 11-bit or 29-bit identifier; r R: remote, no data
 *     dIIIL.. DIIIIIIIIL..   CAN FD frame; b B: with the faster data phase; L from 0 to F
 *     O C L                  open, close, open for listening only
 *     S0-S8 sXXXX Y0-Y5      bit rates: accepted while closed; this end has no bit rate of its own
 *     V N F Z0               versions, serial number, status flags, no time stamps
 *
 * The answer is CR, the value asked for and CR, or BEL for what is malformed, unknown or not
 * possible now. Closing while closed, opening while open and an empty line are fine.
 *
 * State belongs to the caller. Feeding a byte takes constant time, the end of a line time in
 * proportion to its length.
 */
#ifndef CCGEN_SLCAN_H
#define CCGEN_SLCAN_H

#include "ccgen/check.h"
#include "ccgen/error.h"
#include "ccgen/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Longest line without CR: a CAN FD frame with extended identifier and 64 bytes. */
#define CCGEN_SLCAN_LINE_MAX (1u + 8u + 1u + (2u * CCGEN_FRAME_CAPACITY))

/** A buffer of this size holds any encoded frame. */
#define CCGEN_SLCAN_ENCODED_MAX (CCGEN_SLCAN_LINE_MAX + 1u)

/** A buffer of this size holds any answer. */
#define CCGEN_SLCAN_REPLY_MAX 6u

/** State, owned by the caller; zero-initialised it is closed. */
typedef struct {
    uint8_t reply[CCGEN_SLCAN_REPLY_MAX]; /**< what to answer after the last byte */
    uint8_t reply_length;                 /**< 0: nothing to answer */
    bool open;                            /**< frames of the bus are to be handed on */
    bool listen_only;                     /**< opened with L: frames to the bus are refused */

    uint8_t length;
    bool overlong;
    uint8_t line[CCGEN_SLCAN_LINE_MAX];
} ccgen_slcan_t;

/**
 * Sets the state to closed, with an empty line.
 * \param[out] slcan
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer
 */
int ccgen_slcan_init(ccgen_slcan_t *slcan);

/**
 * Takes one byte of the stream.
 * \param[in,out] slcan  `reply` and `reply_length` hold the answer to this byte
 * \param[in] byte
 * \param[out] frame     written only with result 1
 * \return 1: `frame` is decoded, hand it to the node; 0: nothing, or a command was carried out;
 *         CCGEN_ERROR_FORMAT: the line was malformed, unknown or not possible now (answer BEL);
 *         CCGEN_ERROR_ARGUMENT for a null pointer
 */
int ccgen_slcan_feed(ccgen_slcan_t *slcan, uint8_t byte, ccgen_frame_t *frame);

/**
 * Writes a frame as a line with its CR.
 * \param[in] frame
 * \param[out] buffer   [capacity]; written only on success
 * \param[in] capacity  CCGEN_SLCAN_ENCODED_MAX is always enough
 * \return number of bytes; CCGEN_ERROR_ARGUMENT for a null pointer; CCGEN_ERROR_FORMAT for a length
 *         or kind of frame that does not exist; CCGEN_ERROR_RANGE for an identifier of too many
 *         bits or too small a buffer
 */
int ccgen_slcan_encode(const ccgen_frame_t *frame, uint8_t *buffer, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_SLCAN_H */
