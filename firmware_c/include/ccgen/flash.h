/**
 * \file flash.h
 * \brief Tables of bytes and words that stay in flash on cores which do not read it as memory.
 *
 * On AVR a constant is copied to RAM before main(), unless it is placed in program memory and read
 * by instructions of its own. Elsewhere these are plain constants.
 */
#ifndef CCGEN_FLASH_H
#define CCGEN_FLASH_H

#include "ccgen/check.h"

#if defined(__AVR__)
#include <avr/pgmspace.h>
#define CCGEN_FLASH PROGMEM
#define CCGEN_FLASH_BYTE(address) pgm_read_byte(address)
#define CCGEN_FLASH_WORD(address) pgm_read_word(address)
#else
#define CCGEN_FLASH
#define CCGEN_FLASH_BYTE(address) (*(address))
#define CCGEN_FLASH_WORD(address) (*(address))
#endif

#endif /* CCGEN_FLASH_H */
