/**
 * \file frame.h
 * \brief One CAN or CAN FD frame, independent of any controller's registers.
 */
#ifndef CCGEN_FRAME_H
#define CCGEN_FRAME_H

#include "ccgen/check.h"

/** Most bytes of data in a frame (CAN FD). */
#define CCGEN_FRAME_CAPACITY 64u

/** Zero-initialised it is an empty classic data frame with standard identifier 0. */
typedef struct {
    uint32_t id;      /**< 11 bits, or 29 when `extended` */
    bool extended;    /**< 29-bit identifier */
    bool fd;          /**< CAN FD frame */
    bool remote;      /**< remote request: `length` says what is asked for, there is no data */
    bool rate_switch; /**< CAN FD with the faster data phase */
    uint8_t length;   /**< bytes of data: 0 to 8; FD also 12, 16, 20, 24, 32, 48, 64 */
    uint8_t data[CCGEN_FRAME_CAPACITY];
} ccgen_frame_t;

#endif /* CCGEN_FRAME_H */
