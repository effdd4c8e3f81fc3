/**
 * \file product.h
 * \brief Products of fixed-point numbers, exact and rounded down, as each kind of core does them.
 *
 * Same bits on every core; no division, no library call on Thumb-1. What a product must fit is the
 * caller's to prove.
 */
#ifndef CCGEN_PRODUCT_H
#define CCGEN_PRODUCT_H

#include "ccgen/check.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Whether a core multiplies 32 bits to 64 in few instructions: not Thumb-1, nor AVR. */
#ifndef CCGEN_LONG_PRODUCTS
#define CCGEN_LONG_PRODUCTS (!CCGEN_SMALL)
#endif

/** \return value, or the nearer of low and high where it lies outside of them. */
CCGEN_INLINE int32_t ccgen_limit32(const int32_t value, const int32_t low, const int32_t high) {
    return (value < low) ? low : (value > high) ? high : value;
}

/** \return a b; both fit 16 bits, and the product 32. */
CCGEN_INLINE int32_t ccgen_product16(const int32_t a, const int32_t b) {
    return CCGEN_CAST(int32_t, CCGEN_CAST(int16_t, a)) * CCGEN_CAST(int16_t, b);
}

/** \return a b / 2^16, rounded down; b fits 16 bits. */
CCGEN_INLINE int32_t ccgen_product_word(const int32_t a, const int32_t b) {
#if defined(__GNUC__) && defined(__thumb2__) && defined(__ARM_FEATURE_DSP)
    int32_t product;
    __asm__("smulwb %0, %1, %2" : "=r"(product) : "r"(a), "r"(b));
    return product;
#elif CCGEN_LONG_PRODUCTS
    /* The upper word alone: one instruction, for b x 2^16 serves all products with b. */
    return CCGEN_CAST(int32_t, (CCGEN_CAST(int64_t, a) * (b * INT32_C(65536))) >> 32);
#else
    const int32_t low = CCGEN_CAST(int32_t, CCGEN_CAST(uint32_t, a) & 0xFFFFu);
    return (a >> 16) * b + ((low * b) >> 16);
#endif
}

/** \return a b / 2^32, rounded down. */
CCGEN_INLINE int32_t ccgen_product_high(const int32_t a, const int32_t b) {
#if defined(__GNUC__) && defined(__thumb2__) && defined(__ARM_FEATURE_DSP)
    int32_t product;
    __asm__("smmul %0, %1, %2" : "=r"(product) : "r"(a), "r"(b));
    return product;
#elif CCGEN_LONG_PRODUCTS
    return CCGEN_CAST(int32_t, (CCGEN_CAST(int64_t, a) * b) >> 32);
#else
    /* Each sum of a product of halves and an upper half fits: 65535 x 32768 + 65535 < 2^31. */
    const int32_t a_high = a >> 16;
    const int32_t b_high = b >> 16;
    const uint32_t a_low = CCGEN_CAST(uint32_t, a) & 0xFFFFu;
    const uint32_t b_low = CCGEN_CAST(uint32_t, b) & 0xFFFFu;
    const int32_t lowest = CCGEN_CAST(int32_t, (a_low * b_low) >> 16);
    const int32_t first = a_high * CCGEN_CAST(int32_t, b_low) + lowest;
    const int32_t second = b_high * CCGEN_CAST(int32_t, a_low) + (first & 0xFFFF);
    return a_high * b_high + (first >> 16) + (second >> 16);
#endif
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_PRODUCT_H */
