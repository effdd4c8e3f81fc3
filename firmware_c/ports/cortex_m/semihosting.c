/**
 * \file semihosting.c
 * \brief board_end() for an emulator or a debugger: the status becomes the emulator's own.
 *
 * Semihosting is a request to the debugger: a breakpoint with a number in r0 and its arguments in
 * r1. Without a debugger the breakpoint is a fault, and the processor locks up: a product would
 * reset instead.
 */
#include "board.h"

#define SYS_EXIT_EXTENDED 0x20u
#define APPLICATION_EXIT 0x20026u

BOARD_NO_RETURN void board_end(const int status) {
    const uint32_t arguments[2] = {APPLICATION_EXIT, (uint32_t)status};
    for (;;) {
        register uint32_t operation __asm("r0") = SYS_EXIT_EXTENDED;
        register const uint32_t *block __asm("r1") = arguments;
        __asm volatile("bkpt 0xAB" : "+r"(operation) : "r"(block) : "memory");
    }
}
