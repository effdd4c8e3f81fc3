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

/**
 * Whether products are written in AVR's assembly; as plain C with CCGEN_PLAIN_PRODUCTS. They are
 * functions there, for each takes some hundred bytes.
 */
#if defined(__AVR_HAVE_MUL__) && !defined(CCGEN_PLAIN_PRODUCTS)
#define CCGEN_AVR_PRODUCTS 1
#else
#define CCGEN_AVR_PRODUCTS 0
#endif
#if defined(__AVR__)
#define CCGEN_PRODUCT static __attribute__((noinline, unused))
#else
#define CCGEN_PRODUCT CCGEN_INLINE
#endif

/*
 * Products of halves of two numbers: signed, signed with unsigned, unsigned. Where int has 16 bits
 * they are functions, each a call of the compiler's own product of 16 bits; one that has the number
 * in 32 bits, for several products, would multiply that.
 */
#if UINT_MAX < 0xFFFFFFFFu /* MISRA 20.9 */
CCGEN_PRODUCT int32_t ccgen_halves(const int16_t a, const int16_t b) {
    return CCGEN_CAST(int32_t, a) * b;
}

CCGEN_PRODUCT int32_t ccgen_halves_mixed(const int16_t a, const uint16_t b) {
    return CCGEN_CAST(int32_t, a) * CCGEN_CAST(int32_t, b);
}

CCGEN_PRODUCT uint32_t ccgen_halves_low(const uint16_t a, const uint16_t b) {
    return CCGEN_CAST(uint32_t, a) * b;
}

#define CCGEN_SIGNED(a) CCGEN_CAST(int16_t, a)
#define CCGEN_UNSIGNED(a) CCGEN_CAST(uint16_t, a)
#else
CCGEN_INLINE int32_t ccgen_halves(const int32_t a, const int32_t b) { return a * b; }

CCGEN_INLINE int32_t ccgen_halves_mixed(const int32_t a, const uint32_t b) {
    return a * CCGEN_CAST(int32_t, b);
}

CCGEN_INLINE uint32_t ccgen_halves_low(const uint32_t a, const uint32_t b) { return a * b; }

#define CCGEN_SIGNED(a) (a)
#define CCGEN_UNSIGNED(a) (CCGEN_CAST(uint32_t, a) & 0xFFFFu)
#endif

/** \return value, or the nearer of low and high where it lies outside of them. */
CCGEN_INLINE int32_t ccgen_limit32(const int32_t value, const int32_t low, const int32_t high) {
    return (value < low) ? low : (value > high) ? high : value;
}

#if CCGEN_AVR_PRODUCTS
/* Halves of 4, 3, 2 and 1 bytes, where what lies above are copies of the sign. */
#define CCGEN_HALVE_4 "asr %D0\n\tror %C0\n\tror %B0\n\tror %A0\n\t"
#define CCGEN_HALVE_3 "asr %C0\n\tror %B0\n\tror %A0\n\t"
#define CCGEN_HALVE_2 "asr %B0\n\tror %A0\n\t"
#define CCGEN_HALVE_1 "asr %A0\n\t"

/* As often as the low three of `bits` say, without a loop. */
#define CCGEN_HALVE(result, bits, once)                          \
    do {                                                         \
        if (((bits) & 4) != 0) {                                 \
            __asm__(once once once once : "+r"(result));         \
        }                                                        \
        if (((bits) & 2) != 0) {                                 \
            __asm__(once once : "+r"(result));                   \
        }                                                        \
        if (((bits) & 1) != 0) {                                 \
            __asm__(once : "+r"(result));                        \
        }                                                        \
    } while (0)
#endif

/**
 * \return a / 2^bits, rounded down; bits below 32 and known to the compiler.
 *
 * AVR shifts by a bit at a time in a loop; here by bytes first, then the rest without a loop, and
 * without the bytes that hold the sign alone. One bit short of bytes is doubled instead.
 */
CCGEN_INLINE int32_t ccgen_right(const int32_t a, const uint8_t bits) {
#if CCGEN_AVR_PRODUCTS
    int32_t result = a;
    if (bits == 7) {
        __asm__("lsl %A0\n\trol %B0\n\trol %C0\n\trol %D0\n\t"
                "mov %A0, %B0\n\tmov %B0, %C0\n\tmov %C0, %D0\n\tsbc %D0, %D0"
                : "+r"(result));
        return result;
    }
    if (bits == 15) {
        __asm__("lsl %B0\n\trol %C0\n\trol %D0\n\t"
                "movw %A0, %C0\n\tsbc %C0, %C0\n\tmov %D0, %C0"
                : "+r"(result));
        return result;
    }
    if (bits == 23) {
        __asm__("lsl %C0\n\trol %D0\n\t"
                "mov %A0, %D0\n\tsbc %B0, %B0\n\tmov %C0, %B0\n\tmov %D0, %B0"
                : "+r"(result));
        return result;
    }
    result = a >> (bits & ~7);
    if (bits < 8) {
        CCGEN_HALVE(result, bits, CCGEN_HALVE_4);
    } else if (bits < 16) {
        CCGEN_HALVE(result, bits, CCGEN_HALVE_3);
    } else if (bits < 24) {
        CCGEN_HALVE(result, bits, CCGEN_HALVE_2);
    } else {
        CCGEN_HALVE(result, bits, CCGEN_HALVE_1);
    }
    return result;
#elif UINT_MAX < 0xFFFFFFFFu /* MISRA 20.9 */
    return (bits < 16) ? a >> bits : CCGEN_CAST(int16_t, a >> 16) >> (bits - 16); /* MISRA 10.1 */
#else
    return a >> bits;
#endif
}

/** \return a b; both fit 16 bits, and the product 32. */
CCGEN_INLINE int32_t ccgen_product16(const int32_t a, const int32_t b) {
#if CCGEN_AVR_PRODUCTS
    const int16_t first = CCGEN_CAST(int16_t, a);
    const int16_t second = CCGEN_CAST(int16_t, b);
    int32_t product;
    uint8_t zero;
    __asm__(
        "clr %[zero]\n\t"
        "mul %A[a], %A[b]\n\t"
        "movw %A[p], r0\n\t"
        "muls %B[a], %B[b]\n\t"
        "movw %C[p], r0\n\t"
        "mulsu %B[a], %A[b]\n\t"
        "sbc %D[p], %[zero]\n\t"
        "add %B[p], r0\n\t"
        "adc %C[p], r1\n\t"
        "adc %D[p], %[zero]\n\t"
        "mulsu %B[b], %A[a]\n\t"
        "sbc %D[p], %[zero]\n\t"
        "add %B[p], r0\n\t"
        "adc %C[p], r1\n\t"
        "adc %D[p], %[zero]\n\t"
        "clr r1"
        : [p] "=&r"(product), [zero] "=&r"(zero)
        : [a] "a"(first), [b] "a"(second)
        : "r0");
    return product;
#else
    return CCGEN_CAST(int32_t, CCGEN_CAST(int16_t, a)) * CCGEN_CAST(int16_t, b);
#endif
}

/** \return a b; b fits 16 bits, and the product 32. */
CCGEN_INLINE int32_t ccgen_product_half(const int32_t a, const int32_t b) {
#if CCGEN_AVR_PRODUCTS
    /* Bytes 0 to 3 of the product of unsigned numbers; then less what b's sign counts too much. */
    const int16_t half = CCGEN_CAST(int16_t, b);
    int32_t product;
    uint8_t zero;
    __asm__(
        "clr %[zero]\n\t"
        "mul %A[a], %A[b]\n\t"
        "movw %A[p], r0\n\t"
        "mul %B[a], %B[b]\n\t"
        "movw %C[p], r0\n\t"
        "mul %C[a], %A[b]\n\t"
        "add %C[p], r0\n\t"
        "adc %D[p], r1\n\t"
        "mul %D[a], %A[b]\n\t"
        "add %D[p], r0\n\t"
        "mul %C[a], %B[b]\n\t"
        "add %D[p], r0\n\t"
        "mul %A[a], %B[b]\n\t"
        "add %B[p], r0\n\t"
        "adc %C[p], r1\n\t"
        "adc %D[p], %[zero]\n\t"
        "mul %B[a], %A[b]\n\t"
        "add %B[p], r0\n\t"
        "adc %C[p], r1\n\t"
        "adc %D[p], %[zero]\n\t"
        "clr r1\n\t"
        "sbrs %B[b], 7\n\t"
        "rjmp 1f\n\t"
        "sub %C[p], %A[a]\n\t"
        "sbc %D[p], %B[a]\n\t"
        "1:\n\t"
        : [p] "=&r"(product), [zero] "=&r"(zero)
        : [a] "r"(a), [b] "r"(half)
        : "r0");
    return product;
#else
    return a * b;
#endif
}

/** \return sum + a b modulo 2^32. */
CCGEN_INLINE uint32_t ccgen_add_product16(const uint32_t sum, const int16_t a, const int16_t b) {
#if CCGEN_AVR_PRODUCTS
    uint32_t result = sum;
    uint8_t zero;
    __asm__(
        "clr %[zero]\n\t"
        "mul %A[a], %A[b]\n\t"
        "add %A[s], r0\n\t"
        "adc %B[s], r1\n\t"
        "adc %C[s], %[zero]\n\t"
        "adc %D[s], %[zero]\n\t"
        "muls %B[a], %B[b]\n\t"
        "add %C[s], r0\n\t"
        "adc %D[s], r1\n\t"
        "mulsu %B[a], %A[b]\n\t"
        "sbc %D[s], %[zero]\n\t"
        "add %B[s], r0\n\t"
        "adc %C[s], r1\n\t"
        "adc %D[s], %[zero]\n\t"
        "mulsu %B[b], %A[a]\n\t"
        "sbc %D[s], %[zero]\n\t"
        "add %B[s], r0\n\t"
        "adc %C[s], r1\n\t"
        "adc %D[s], %[zero]\n\t"
        "clr r1"
        : [s] "+r"(result), [zero] "=&r"(zero)
        : [a] "a"(a), [b] "a"(b)
        : "r0");
    return result;
#else
    return sum + CCGEN_CAST(uint32_t, CCGEN_CAST(int32_t, a) * b); /* MISRA 10.8 */
#endif
}

#if CCGEN_AVR_PRODUCTS
static __attribute__((noinline, unused)) int32_t ccgen_avr_word(const int32_t a, const int16_t b) {
    /*
     * Bytes 1 to 5 of the product of unsigned numbers, a byte behind the point and the result; then
     * less what a sign counts too much.
     */
    int32_t product;
    uint8_t behind;
    uint8_t zero;
    __asm__(
        "clr %[zero]\n\t"
        "mul %C[a], %A[b]\n\t"
        "movw %A[p], r0\n\t"
        "mul %D[a], %B[b]\n\t"
        "movw %C[p], r0\n\t"
        "mul %A[a], %A[b]\n\t"
        "mov %[behind], r1\n\t"
        "mul %D[a], %A[b]\n\t"
        "add %B[p], r0\n\t"
        "adc %C[p], r1\n\t"
        "adc %D[p], %[zero]\n\t"
        "mul %C[a], %B[b]\n\t"
        "add %B[p], r0\n\t"
        "adc %C[p], r1\n\t"
        "adc %D[p], %[zero]\n\t"
        "mul %B[a], %A[b]\n\t"
        "add %[behind], r0\n\t"
        "adc %A[p], r1\n\t"
        "adc %B[p], %[zero]\n\t"
        "adc %C[p], %[zero]\n\t"
        "adc %D[p], %[zero]\n\t"
        "mul %A[a], %B[b]\n\t"
        "add %[behind], r0\n\t"
        "adc %A[p], r1\n\t"
        "adc %B[p], %[zero]\n\t"
        "adc %C[p], %[zero]\n\t"
        "adc %D[p], %[zero]\n\t"
        "mul %B[a], %B[b]\n\t"
        "add %A[p], r0\n\t"
        "adc %B[p], r1\n\t"
        "adc %C[p], %[zero]\n\t"
        "adc %D[p], %[zero]\n\t"
        "clr r1\n\t"
        "sbrs %D[a], 7\n\t"
        "rjmp 1f\n\t"
        "sub %C[p], %A[b]\n\t"
        "sbc %D[p], %B[b]\n\t"
        "1:\n\t"
        "sbrs %B[b], 7\n\t"
        "rjmp 2f\n\t"
        "sub %A[p], %A[a]\n\t"
        "sbc %B[p], %B[a]\n\t"
        "sbc %C[p], %C[a]\n\t"
        "sbc %D[p], %D[a]\n\t"
        "2:\n\t"
        : [p] "=&r"(product), [behind] "=&r"(behind), [zero] "=&r"(zero)
        : [a] "r"(a), [b] "r"(b)
        : "r0");
    return product;
}
#endif

/** \return a b / 2^16, rounded down; b fits 16 bits. */
CCGEN_PRODUCT int32_t ccgen_product_word(const int32_t a, const int32_t b) {
#if defined(__GNUC__) && defined(__thumb2__) && defined(__ARM_FEATURE_DSP)
    int32_t product;
    __asm__("smulwb %0, %1, %2" : "=r"(product) : "r"(a), "r"(b));
    return product;
#elif CCGEN_AVR_PRODUCTS
    return ccgen_avr_word(a, CCGEN_CAST(int16_t, b));
#elif CCGEN_LONG_PRODUCTS
    /* The upper word alone: one instruction, for b x 2^16 serves all products with b. */
    return CCGEN_CAST(int32_t, (CCGEN_CAST(int64_t, a) * (b * INT32_C(65536))) >> 32);
#else
    return ccgen_halves(CCGEN_SIGNED(a >> 16), CCGEN_SIGNED(b)) + /* MISRA 10.1 */
           (ccgen_halves_mixed(CCGEN_SIGNED(b), CCGEN_UNSIGNED(a)) >> 16); /* MISRA 10.1 */
#endif
}

/** \return a b / 2^32, rounded down. */
CCGEN_PRODUCT int32_t ccgen_product_high(const int32_t a, const int32_t b) {
#if defined(__GNUC__) && defined(__thumb2__) && defined(__ARM_FEATURE_DSP)
    int32_t product;
    __asm__("smmul %0, %1, %2" : "=r"(product) : "r"(a), "r"(b));
    return product;
#elif CCGEN_AVR_PRODUCTS
    /* Of unsigned numbers, a byte of b after the other; then less what a sign counts too much. */
    int32_t product;
    uint8_t x;
    uint8_t y;
    uint8_t w;
    uint8_t zero;
    __asm__(
        "clr %[zero]\n\t"
        "mul %A[a], %A[b]\n\t"
        "mov %[x], r1\n\t"
        "clr %[y]\n\t"
        "clr %[w]\n\t"
        "clr %A[p]\n\t"
        "mul %B[a], %A[b]\n\t"
        "add %[x], r0\n\t"
        "adc %[y], r1\n\t"
        "adc %[w], %[zero]\n\t"
        "mul %C[a], %A[b]\n\t"
        "add %[y], r0\n\t"
        "adc %[w], r1\n\t"
        "adc %A[p], %[zero]\n\t"
        "mul %D[a], %A[b]\n\t"
        "add %[w], r0\n\t"
        "adc %A[p], r1\n\t"
        "clr %B[p]\n\t"
        "mul %A[a], %B[b]\n\t"
        "add %[x], r0\n\t"
        "adc %[y], r1\n\t"
        "adc %[w], %[zero]\n\t"
        "adc %A[p], %[zero]\n\t"
        "adc %B[p], %[zero]\n\t"
        "mul %B[a], %B[b]\n\t"
        "add %[y], r0\n\t"
        "adc %[w], r1\n\t"
        "adc %A[p], %[zero]\n\t"
        "adc %B[p], %[zero]\n\t"
        "mul %C[a], %B[b]\n\t"
        "add %[w], r0\n\t"
        "adc %A[p], r1\n\t"
        "adc %B[p], %[zero]\n\t"
        "mul %D[a], %B[b]\n\t"
        "add %A[p], r0\n\t"
        "adc %B[p], r1\n\t"
        "clr %C[p]\n\t"
        "mul %A[a], %C[b]\n\t"
        "add %[y], r0\n\t"
        "adc %[w], r1\n\t"
        "adc %A[p], %[zero]\n\t"
        "adc %B[p], %[zero]\n\t"
        "adc %C[p], %[zero]\n\t"
        "mul %B[a], %C[b]\n\t"
        "add %[w], r0\n\t"
        "adc %A[p], r1\n\t"
        "adc %B[p], %[zero]\n\t"
        "adc %C[p], %[zero]\n\t"
        "mul %C[a], %C[b]\n\t"
        "add %A[p], r0\n\t"
        "adc %B[p], r1\n\t"
        "adc %C[p], %[zero]\n\t"
        "mul %D[a], %C[b]\n\t"
        "add %B[p], r0\n\t"
        "adc %C[p], r1\n\t"
        "clr %D[p]\n\t"
        "mul %A[a], %D[b]\n\t"
        "add %[w], r0\n\t"
        "adc %A[p], r1\n\t"
        "adc %B[p], %[zero]\n\t"
        "adc %C[p], %[zero]\n\t"
        "adc %D[p], %[zero]\n\t"
        "mul %B[a], %D[b]\n\t"
        "add %A[p], r0\n\t"
        "adc %B[p], r1\n\t"
        "adc %C[p], %[zero]\n\t"
        "adc %D[p], %[zero]\n\t"
        "mul %C[a], %D[b]\n\t"
        "add %B[p], r0\n\t"
        "adc %C[p], r1\n\t"
        "adc %D[p], %[zero]\n\t"
        "mul %D[a], %D[b]\n\t"
        "add %C[p], r0\n\t"
        "adc %D[p], r1\n\t"
        "sbrs %D[a], 7\n\t"
        "rjmp 1f\n\t"
        "sub %A[p], %A[b]\n\t"
        "sbc %B[p], %B[b]\n\t"
        "sbc %C[p], %C[b]\n\t"
        "sbc %D[p], %D[b]\n\t"
        "1:\n\t"
        "sbrs %D[b], 7\n\t"
        "rjmp 2f\n\t"
        "sub %A[p], %A[a]\n\t"
        "sbc %B[p], %B[a]\n\t"
        "sbc %C[p], %C[a]\n\t"
        "sbc %D[p], %D[a]\n\t"
        "2:\n\t"
        "clr r1"
        : [p] "=&r"(product), [x] "=&r"(x), [y] "=&r"(y), [w] "=&r"(w), [zero] "=&r"(zero)
        : [a] "r"(a), [b] "r"(b)
        : "r0");
    return product;
#elif CCGEN_LONG_PRODUCTS
    return CCGEN_CAST(int32_t, (CCGEN_CAST(int64_t, a) * b) >> 32);
#else
    /* Each sum of a product of halves and an upper half fits: 65535 x 32768 + 65535 < 2^31. */
    const int32_t lowest =
        CCGEN_CAST(int32_t, ccgen_halves_low(CCGEN_UNSIGNED(a), CCGEN_UNSIGNED(b)) >> 16);
    const int32_t first =
        ccgen_halves_mixed(CCGEN_SIGNED(a >> 16), CCGEN_UNSIGNED(b)) + lowest; /* MISRA 10.1 */
    const int32_t second =
        /* MISRA 10.1 */
        ccgen_halves_mixed(CCGEN_SIGNED(b >> 16), CCGEN_UNSIGNED(a)) + (first & 0xFFFF);
    /* MISRA 10.1 */
    return ccgen_halves(CCGEN_SIGNED(a >> 16), CCGEN_SIGNED(b >> 16)) + (first >> 16) +
           (second >> 16); /* MISRA 10.1 */
#endif
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_PRODUCT_H */
