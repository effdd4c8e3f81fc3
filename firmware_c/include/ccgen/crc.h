/**
 * \file crc.h
 * \brief Cyclic redundancy checks byte by byte, by tables of remainders.
 *
 * CRC-8 SAE J1850 (polynomial 0x1D) and CRC-16 CCITT (0x1021), most significant bit first.
 * CCGEN_CRC_TABLE tells how many entries a table has: 256, one look-up a byte, or 16, two look-ups;
 * by default 256. On AVR the tables lie in program memory.
 */
#ifndef CCGEN_CRC_H
#define CCGEN_CRC_H

#include "ccgen/flash.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifndef CCGEN_CRC_TABLE
#define CCGEN_CRC_TABLE 256
#endif

#if (CCGEN_CRC_TABLE != 16) && (CCGEN_CRC_TABLE != 256)
#error "CCGEN_CRC_TABLE: a table has 16 or 256 entries"
#endif

/** Remainders of all bytes, or half bytes. */
extern const uint8_t ccgen_crc8_table[CCGEN_CRC_TABLE];
extern const uint16_t ccgen_crc16_table[CCGEN_CRC_TABLE];

/** \return the CRC-8 of what it was of and one byte more. */
CCGEN_INLINE uint8_t ccgen_crc8(const uint8_t crc, const uint8_t byte) {
    uint8_t value = CCGEN_CAST(uint8_t, crc ^ byte);
#if CCGEN_CRC_TABLE == 256
    return CCGEN_FLASH_BYTE(&ccgen_crc8_table[value]);
#else
    for (uint8_t half = 0; half < 2u; ++half) {
        const uint8_t low = CCGEN_CAST(uint8_t, (value << 4) & 0xF0);
        value = CCGEN_CAST(uint8_t, low ^ CCGEN_FLASH_BYTE(&ccgen_crc8_table[value >> 4]));
    }
    return value;
#endif
}

/** \return the CRC-16 of what it was of and one byte more. */
CCGEN_INLINE uint16_t ccgen_crc16(const uint16_t crc, const uint8_t byte) {
#if CCGEN_CRC_TABLE == 256
    const uint8_t first = CCGEN_CAST(uint8_t, (crc >> 8) ^ byte);
    const uint16_t rest = CCGEN_CAST(uint16_t, (crc & 0xFFu) << 8);
    return CCGEN_CAST(uint16_t, rest ^ CCGEN_FLASH_WORD(&ccgen_crc16_table[first]));
#else
    uint16_t value = CCGEN_CAST(uint16_t, crc ^ (CCGEN_CAST(uint16_t, byte) << 8));
    for (uint8_t half = 0; half < 2u; ++half) {
        const uint16_t rest = CCGEN_CAST(uint16_t, (value & 0xFFFu) << 4);
        value = CCGEN_CAST(uint16_t, rest ^ CCGEN_FLASH_WORD(&ccgen_crc16_table[value >> 12]));
    }
    return value;
#endif
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_CRC_H */
