#include "ccgen/e2e.h"

#define CRC8_J1850_POLYNOMIAL 0x1Du
#define CRC16_CCITT_POLYNOMIAL 0x1021u
#define CRC16_CCITT_START 0xFFFFu

#define P01_HEADER 2u
#define P05_HEADER 3u
#define P05_COUNTERS 256u

static uint8_t crc8_byte(const uint8_t crc, const uint8_t byte) {
    uint8_t value = (uint8_t)(crc ^ byte);
    for (uint8_t bit = 0; bit < 8u; ++bit) {
        const uint8_t carry = ((value & 0x80u) != 0u) ? CRC8_J1850_POLYNOMIAL : 0u;
        value = (uint8_t)((uint8_t)(value << 1) ^ carry);
    }
    return value;
}

static uint16_t crc16_byte(const uint16_t crc, const uint8_t byte) {
    uint16_t value = (uint16_t)(crc ^ ((uint16_t)byte << 8));
    for (uint8_t bit = 0; bit < 8u; ++bit) {
        const uint16_t carry = ((value & 0x8000u) != 0u) ? CRC16_CCITT_POLYNOMIAL : 0u;
        value = (uint16_t)((uint16_t)(value << 1) ^ carry);
    }
    return value;
}

static uint8_t p01_crc(const uint16_t data_id, const uint8_t *const data, const size_t length) {
    uint8_t crc = crc8_byte(0, (uint8_t)(data_id & 0xFFu));
    crc = crc8_byte(crc, (uint8_t)(data_id >> 8));
    for (size_t i = 1; i < length; ++i) {
        crc = crc8_byte(crc, data[i]);
    }
    return crc;
}

static uint16_t p05_crc(const uint16_t data_id, const uint8_t *const data, const size_t length) {
    uint16_t crc = CRC16_CCITT_START;
    for (size_t i = 2; i < length; ++i) {
        crc = crc16_byte(crc, data[i]);
    }
    crc = crc16_byte(crc, (uint8_t)(data_id & 0xFFu));
    return crc16_byte(crc, (uint8_t)(data_id >> 8));
}

size_t ccgen_e2e_header(const ccgen_e2e_profile_t profile) {
    return (profile == CCGEN_E2E_P01) ? P01_HEADER : P05_HEADER;
}

uint16_t ccgen_e2e_counter_modulus(const ccgen_e2e_profile_t profile) {
    return (profile == CCGEN_E2E_P01) ? CCGEN_E2E_P01_COUNTERS : P05_COUNTERS;
}

int ccgen_e2e_protect(const ccgen_e2e_profile_t profile, const uint16_t data_id,
                      const uint8_t counter, uint8_t *const data, const size_t length) {
    if ((data == NULL) || (counter >= ccgen_e2e_counter_modulus(profile))) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (length < ccgen_e2e_header(profile)) {
        return CCGEN_ERROR_FORMAT;
    }
    if (profile == CCGEN_E2E_P01) {
        data[1] = (uint8_t)((data[1] & 0xF0u) | counter);
        data[0] = p01_crc(data_id, data, length);
    } else {
        data[2] = counter;
        const uint16_t crc = p05_crc(data_id, data, length);
        data[0] = (uint8_t)(crc & 0xFFu);
        data[1] = (uint8_t)(crc >> 8);
    }
    return CCGEN_OK;
}

int ccgen_e2e_check(const ccgen_e2e_profile_t profile, const uint16_t data_id,
                    const uint8_t *const data, const size_t length) {
    if (data == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (length < ccgen_e2e_header(profile)) {
        return CCGEN_ERROR_FORMAT;
    }
    if (profile == CCGEN_E2E_P01) {
        if (data[0] != p01_crc(data_id, data, length)) {
            return CCGEN_ERROR_CRC;
        }
        const uint8_t counter = (uint8_t)(data[1] & 0x0Fu);
        return (counter < CCGEN_E2E_P01_COUNTERS) ? (int)counter : CCGEN_ERROR_FORMAT;
    }
    const uint16_t crc = p05_crc(data_id, data, length);
    if ((data[0] != (crc & 0xFFu)) || (data[1] != (crc >> 8))) {
        return CCGEN_ERROR_CRC;
    }
    return (int)data[2];
}
