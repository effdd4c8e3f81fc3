/**
 * \file board.c
 * \brief A board's clock, which goes on while the program works, and its converter.
 */
#include "board.h"

#include "bus.h"
#include "must.h"

void board_start(void) {
}

uint32_t board_time_us(void) {
    bus_pass(10u);
    return bus_time_us();
}

/** The middle, a little off for each input. */
uint16_t board_convert(const uint8_t input) {
    return (uint16_t)(2047u + input);
}

void board_rest(void) {
    bus_pass(200u);
}

void board_end(const int status) {
    CHECK(status == 0);
    abort();
}
