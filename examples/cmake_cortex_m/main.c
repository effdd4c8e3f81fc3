/*
 * Estimates one snapshot and prints the u angles, in steps, over the board's UART. The exit status
 * of the emulator is 0 if the estimate succeeded.
 */
#include "board.h"
#include "shoulder.h"

/** \param[in] text  without its end, which is written as a new line */
static void print_line(const char *text) {
    for (; *text != '\0'; ++text) {
        board_write((uint8_t)*text);
    }
    board_write('\n');
}

static void print_number(int32_t number) {
    char text[12];
    char *digit = &text[sizeof text - 1u];
    uint32_t rest = number < 0 ? 0u - (uint32_t)number : (uint32_t)number;
    *digit = '\0';
    do {
        *--digit = (char)('0' + rest % 10u);
        rest /= 10u;
    } while (rest > 0u);
    if (number < 0) {
        *--digit = '-';
    }
    print_line(digit);
}

int main(void) {
    static const shoulder_counts_t counts = {{1500, 1200, 900}, {0, 0, 0}};
    shoulder_t joint;
    shoulder_angles_t angles;
    board_init();
    if (shoulder_init(&joint) != CCGEN_OK ||
        shoulder_estimate(&joint, &counts, &angles) != CCGEN_OK) {
        board_end(BOARD_WRONG);
    }
    for (int i = 0; i < SHOULDER_SEGMENTS; ++i) {
        print_number(angles.u[i]);
    }
    board_end(BOARD_DONE);
}
