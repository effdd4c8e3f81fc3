/**
 * \file converter.c
 * \brief A board with a converter for the first example of an exported README.
 *
 * On the boards of ports/bare_metal: readings are drawn at random around the zeros, SLCAN lines on
 * the UART are the CAN bus, and the clock runs as fast as it is read. Compiled like loop.c, with
 * SENSORS, SNAPSHOTS, the zeros in ZEROS and how far readings lie from them in REACH.
 */
#include "board.h"
#include "ccgen/slcan.h"

void converter_read(OF(count_t) * counts, uint8_t number);
bool board_can_write(const ccgen_frame_t *frame);
uint32_t converter_time_us(void);

static uint32_t seed = 1u;
static uint32_t reads;
static uint32_t writes;
static uint32_t clock_us = 0u - 5000000u; /* wraps on the way */

/** One set of readings; every 50th begins with one that no transducer gives. */
void converter_read(OF(count_t) * const counts, const uint8_t number) {
    static const OF(count_t) zeros[SENSORS] = ZEROS;
    static uint8_t first;
    for (uint8_t j = 0; j < number; ++j) {
        seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
        const int32_t away = (int32_t)((seed >> 8) % (2u * REACH + 1u)) - (int32_t)REACH;
        counts[j] = (OF(count_t))(zeros[first + j] + away);
    }
    if ((first == 0u) && ((reads % 50u) == 49u)) {
        counts[0] = (OF(count_t))(sizeof(OF(count_t)) == 2u ? INT16_MAX : INT32_MAX);
    }
    first = (uint8_t)(first + number);
    if (first == SENSORS) {
        first = 0;
        ++reads;
    }
}

/** Every ninth frame finds no room at first; the program ends before an answer too many. */
bool board_can_write(const ccgen_frame_t *const frame) {
    uint8_t line[CCGEN_SLCAN_ENCODED_MAX];
    if (reads > SNAPSHOTS) {
        board_end(BOARD_DONE);
    }
    ++writes;
    if ((writes % 9u) == 0u) {
        return false;
    }
    const int length = ccgen_slcan_encode(frame, line, sizeof line);
    for (int i = 0; i < length; ++i) {
        board_write(line[i]);
    }
    return true;
}

/** Twenty looks a cycle. */
uint32_t converter_time_us(void) {
    clock_us += OF_CYCLE_US / 20u;
    return clock_us;
}
