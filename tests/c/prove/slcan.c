/**
 * \file slcan.c
 * \brief Proof driver: any stream of bytes is decoded and any frame encoded without a fault.
 */
#include "ccgen/slcan.h"

#include "anything.h"

int main(void);

int main(void) {
    ccgen_slcan_t slcan;
    ccgen_frame_t frame = {0};
    uint8_t text[CCGEN_SLCAN_ENCODED_MAX];
    uint8_t length = 0;
    (void)ccgen_slcan_init(&slcan);
    while (either()) {
        (void)ccgen_slcan_feed(&slcan, (uint8_t)Frama_C_interval(0, 255), &frame);
    }
    any_frame(&frame);
    //@ loop unroll 256;
    do { /* length by length, or else the analysis forgets which code belongs to which */
        frame.length = length;
        (void)ccgen_slcan_encode(&frame, text, sizeof text);
        ++length;
    } while (length != 0u);
    return 0;
}
