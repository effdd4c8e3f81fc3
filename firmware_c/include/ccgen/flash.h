/**
 * \file flash.h
 * \brief Tables that stay in flash on cores which do not read it as memory.
 *
 * On AVR a constant is copied to RAM before main(), unless it is placed in program memory and read
 * by instructions of its own, or copied where it is needed as memory. Elsewhere these are plain
 * constants.
 */
#ifndef CCGEN_FLASH_H
#define CCGEN_FLASH_H

#include "ccgen/check.h"

#if defined(__AVR__)
#include <avr/pgmspace.h>
#define CCGEN_FLASH PROGMEM
#define CCGEN_FLASH_APART 1
#define CCGEN_FLASH_BYTE(address) pgm_read_byte(address)
#define CCGEN_FLASH_WORD(address) pgm_read_word(address)
/* A number that the compiler knows is not read at all. */
#define CCGEN_FLASH_INT16(address) \
    (__builtin_constant_p(*(address)) ? *(address) : (int16_t)pgm_read_word(address))
#define CCGEN_FLASH_INT32(address) \
    (__builtin_constant_p(*(address)) ? *(address) : (int32_t)pgm_read_dword(address))
#define CCGEN_FLASH_POINTER(address) pgm_read_ptr(address)
#define CCGEN_FLASH_COPY(to, from, bytes) ((void)memcpy_P((to), (from), (bytes)))
#else
#define CCGEN_FLASH_APART 0
#define CCGEN_FLASH
#define CCGEN_FLASH_BYTE(address) (*(address))
#define CCGEN_FLASH_WORD(address) (*(address))
#define CCGEN_FLASH_INT16(address) (*(address))
#define CCGEN_FLASH_INT32(address) (*(address))
#define CCGEN_FLASH_POINTER(address) (*(address))
#endif

#endif /* CCGEN_FLASH_H */
