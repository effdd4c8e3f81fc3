/**
 * \file shortened.c
 * \brief Proof driver: any parity values of a group are shortened to 16 bits without a fault.
 *
 * Some value is the longest, and takes `bits` bits: it is at least 2^(bits - 1) or below
 * -2^(bits - 1), and no other is longer. Every number of bits and every place is looked at.
 */
#include CHECK_HEADER

#include "anything.h"

int main(void);

static PARITY any_parity(const PARITY lowest, const PARITY highest) {
    return (PARITY)Frama_C_long_long_interval(lowest, highest);
}

static void shorten(const uint8_t values, const uint8_t longest, const int bits,
                    const bool negative) {
    static const ccgen_check_t check = {NULL, NULL, NULL, CHECK_SENSORS, CHECK_KEPT, 0, CHECK_SHIFT};
    PARITY parity[CCGEN_SENSORS_MAX];
    int16_t shortened[CCGEN_SENSORS_MAX];
    const PARITY highest = (PARITY)(((uint64_t)1 << bits) - 1u);
    //@ loop unroll 16;
    for (uint8_t i = 0; i < values; ++i) {
        parity[i] = any_parity(-highest - 1, highest);
    }
    const PARITY lowest = (PARITY)(((uint64_t)1 << bits) / 2u);
    parity[longest] =
        negative ? any_parity(-highest - 1, -lowest - 1) : any_parity(lowest, highest);
    const uint8_t more = SHORTENED(&check, parity, values, shortened);
    //@ assert more <= SHORTENED_MOST;
    //@ assert \initialized(shortened + (0 .. values - 1));
}

int main(void) {
    const uint8_t values[] = {CHECK_KEPT, CHECK_SENSORS};
    //@ loop unroll 2;
    for (int k = 0; k < 2; ++k) {
        //@ loop unroll 16;
        for (uint8_t longest = 0; longest < values[k]; ++longest) {
            //@ loop unroll 64;
            for (int bits = 0; bits < (int)(8u * sizeof(PARITY)); ++bits) {
                shorten(values[k], longest, bits, false);
                shorten(values[k], longest, bits, true);
            }
        }
    }
    return 0;
}
