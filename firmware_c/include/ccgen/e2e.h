/**
 * \file e2e.h
 * \brief End-to-end protection of frames: AUTOSAR E2E profiles P01 and P05.
 *
 * P01: byte 0 CRC-8 (polynomial 0x1D, start 0, no final xor) over the data ID (low byte, high byte;
 * mode BOTH) and bytes 1 to the end; low nibble of byte 1 the counter, 0 to 14.
 * P05: bytes 0-1 CRC-16 CCITT-FALSE, little-endian, over bytes 2 to the end and then the data ID
 * (low byte, high byte); byte 2 the counter, 0 to 255.
 * Time grows with the length. Re-entrant.
 */
#ifndef CCGEN_E2E_H
#define CCGEN_E2E_H

#include "ccgen/check.h"
#include "ccgen/error.h"

/** Values that the counter of P01 takes: 0 to 14; of P05: 0 to 255. */
#define CCGEN_E2E_P01_COUNTERS 15u
#define CCGEN_E2E_P05_COUNTERS 256u

/** Bytes of the headers. */
#define CCGEN_E2E_P01_HEADER 2u
#define CCGEN_E2E_P05_HEADER 3u

typedef enum {
    CCGEN_E2E_P01, /**< classic CAN */
    CCGEN_E2E_P05  /**< CAN FD */
} ccgen_e2e_profile_t;

#endif /* CCGEN_E2E_H */
