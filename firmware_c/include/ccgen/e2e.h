/**
 * \file e2e.h
 * \brief End-to-end protection of frames: AUTOSAR E2E profiles P01 and P05.
 *
 * P01: byte 0 CRC-8 (polynomial 0x1D, start 0, no final xor) over the data ID (low byte, high byte;
 * mode BOTH) and bytes 1 to the end; low nibble of byte 1 the counter, 0 to 14.
 * P05: bytes 0-1 CRC-16 CCITT-FALSE, little-endian, over bytes 2 to the end and then the data ID
 * (low byte, high byte); byte 2 the counter, 0 to 255.
 * Bit by bit, without tables: time grows with the length, 8 steps a byte. Re-entrant.
 */
#ifndef CCGEN_E2E_H
#define CCGEN_E2E_H

#include "ccgen/check.h"
#include "ccgen/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Values that the counter of P01 takes: 0 to 14. */
#define CCGEN_E2E_P01_COUNTERS 15u

typedef enum {
    CCGEN_E2E_P01, /**< classic CAN */
    CCGEN_E2E_P05  /**< CAN FD */
} ccgen_e2e_profile_t;

/** \param[in] profile  \return bytes of the header: 2 for P01, 3 for P05 */
size_t ccgen_e2e_header(ccgen_e2e_profile_t profile);

/** \param[in] profile  \return number of counter values: 15 for P01, 256 for P05 */
uint16_t ccgen_e2e_counter_modulus(ccgen_e2e_profile_t profile);

/**
 * Writes counter and check value into the header.
 * \param[in] profile
 * \param[in] data_id     identifies what is sent: the low 16 bits of the frame's identifier
 * \param[in] counter     below the profile's modulus
 * \param[in,out] data    [length]; the high nibble of byte 1 stays as it is in P01
 * \param[in] length      at least the header
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer or a counter out of range;
 *         CCGEN_ERROR_FORMAT when the header does not fit
 */
int ccgen_e2e_protect(ccgen_e2e_profile_t profile, uint16_t data_id, uint8_t counter, uint8_t *data,
                      size_t length);

/**
 * Checks a protected frame.
 * \param[in] profile
 * \param[in] data_id  the one that the sender used
 * \param[in] data     [length]
 * \param[in] length
 * \return the counter; CCGEN_ERROR_ARGUMENT for a null pointer; CCGEN_ERROR_CRC when the check
 *         value differs; CCGEN_ERROR_FORMAT when the header does not fit or the counter is not
 * below the profile's modulus
 */
int ccgen_e2e_check(ccgen_e2e_profile_t profile, uint16_t data_id, const uint8_t *data,
                    size_t length);

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_E2E_H */
