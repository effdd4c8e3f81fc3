/**
 * \file input.h
 * \brief What the fuzzing drivers share: an input taken piece by piece.
 */
#ifndef FUZZ_INPUT_H
#define FUZZ_INPUT_H

#include <stddef.h>
#include <stdint.h>

#include "../must.h"

/** What is left of the fuzzer's input; zeros once it is used up. */
typedef struct {
    const uint8_t *at;
    size_t left;
} input_t;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline uint8_t take8(input_t *const input) {
    if (input->left == 0u) {
        return 0;
    }
    --input->left;
    return *input->at++;
}

static inline uint16_t take16(input_t *const input) {
    const uint8_t low = take8(input);
    return (uint16_t)(low | ((uint16_t)take8(input) << 8));
}

static inline uint32_t take32(input_t *const input) {
    const uint32_t low = take16(input);
    return low | ((uint32_t)take16(input) << 16);
}

static inline uint64_t take64(input_t *const input) {
    const uint64_t low = take32(input);
    return low | ((uint64_t)take32(input) << 32);
}

#endif /* FUZZ_INPUT_H */
