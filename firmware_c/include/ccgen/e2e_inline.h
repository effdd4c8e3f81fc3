/**
 * \file e2e_inline.h
 * \brief What e2e.h describes, inline: where a joint's layout is known, it folds into the code.
 */
#ifndef CCGEN_E2E_INLINE_H
#define CCGEN_E2E_INLINE_H

#include "ccgen/crc.h"
#include "ccgen/e2e.h"

#define CCGEN_E2E_P05_START 0xFFFFu

/** \param[in] profile  \return number of counter values: 15 for P01, 256 for P05 */
static inline uint16_t ccgen_e2e_counter_modulus(const ccgen_e2e_profile_t profile) {
    return (profile == CCGEN_E2E_P01) ? CCGEN_E2E_P01_COUNTERS : CCGEN_E2E_P05_COUNTERS;
}

static inline uint8_t ccgen_e2e_p01_crc(const uint16_t key, const uint8_t *const data,
                                        const size_t length) {
    uint8_t crc = (uint8_t)key;
    for (size_t i = 1; i < length; ++i) {
        crc = ccgen_crc8(crc, data[i]);
    }
    return crc;
}

static inline uint16_t ccgen_e2e_p05_crc(const uint16_t key, const uint8_t *const data,
                                         const size_t length) {
    uint16_t crc = CCGEN_E2E_P05_START;
    for (size_t i = 2; i < length; ++i) {
        crc = ccgen_crc16(crc, data[i]);
    }
    crc = ccgen_crc16(crc, (uint8_t)(key & 0xFFu));
    return ccgen_crc16(crc, (uint8_t)(key >> 8));
}

static inline size_t ccgen_e2e_header(const ccgen_e2e_profile_t profile) {
    return (profile == CCGEN_E2E_P01) ? CCGEN_E2E_P01_HEADER : CCGEN_E2E_P05_HEADER;
}

/**
 * Prepares what a check value takes from the data ID, which need be done once for every identifier.
 * \param[in] profile
 * \param[in] data_id  identifies what is sent: the low 16 bits of the frame's identifier
 * \return for P01 the CRC-8 of its bytes, which come first; for P05 the ID, whose bytes come last
 */
static inline uint16_t ccgen_e2e_key(const ccgen_e2e_profile_t profile, const uint16_t data_id) {
    if (profile == CCGEN_E2E_P05) {
        return data_id;
    }
    return ccgen_crc8(ccgen_crc8(0, (uint8_t)(data_id & 0xFFu)), (uint8_t)(data_id >> 8));
}

/**
 * Writes counter and check value into the header.
 * \param[in] profile
 * \param[in] key         of the data ID, from ccgen_e2e_key()
 * \param[in] counter     below the profile's modulus
 * \param[in,out] data    [length]; the high nibble of byte 1 stays as it is in P01
 * \param[in] length      at least the header
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer or a counter out of range;
 *         CCGEN_ERROR_FORMAT when the header does not fit
 */
static inline int ccgen_e2e_protect(const ccgen_e2e_profile_t profile, const uint16_t key,
                                    const uint8_t counter, uint8_t *const data,
                                    const size_t length) {
    if ((data == NULL) || (counter >= ccgen_e2e_counter_modulus(profile))) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (length < ccgen_e2e_header(profile)) {
        return CCGEN_ERROR_FORMAT;
    }
    if (profile == CCGEN_E2E_P01) {
        data[1] = (uint8_t)((data[1] & 0xF0u) | counter);
        data[0] = ccgen_e2e_p01_crc(key, data, length);
    } else {
        data[2] = counter;
        const uint16_t crc = ccgen_e2e_p05_crc(key, data, length);
        data[0] = (uint8_t)(crc & 0xFFu);
        data[1] = (uint8_t)(crc >> 8);
    }
    return CCGEN_OK;
}

/**
 * Checks a protected frame.
 * \param[in] profile
 * \param[in] key     of the data ID that the sender used, from ccgen_e2e_key()
 * \param[in] data     [length]
 * \param[in] length
 * \return the counter; CCGEN_ERROR_ARGUMENT for a null pointer; CCGEN_ERROR_CRC when the check
 *         value differs; CCGEN_ERROR_FORMAT when the header does not fit or the counter is not
 * below the profile's modulus
 */
static inline int ccgen_e2e_check(const ccgen_e2e_profile_t profile, const uint16_t key,
                                  const uint8_t *const data, const size_t length) {
    if (data == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (length < ccgen_e2e_header(profile)) {
        return CCGEN_ERROR_FORMAT;
    }
    if (profile == CCGEN_E2E_P01) {
        if (data[0] != ccgen_e2e_p01_crc(key, data, length)) {
            return CCGEN_ERROR_CRC;
        }
        const uint8_t counter = (uint8_t)(data[1] & 0x0Fu);
        return (counter < CCGEN_E2E_P01_COUNTERS) ? (int)counter : CCGEN_ERROR_FORMAT;
    }
    const uint16_t crc = ccgen_e2e_p05_crc(key, data, length);
    if ((data[0] != (crc & 0xFFu)) || (data[1] != (crc >> 8))) {
        return CCGEN_ERROR_CRC;
    }
    return (int)data[2];
}

#endif /* CCGEN_E2E_INLINE_H */
