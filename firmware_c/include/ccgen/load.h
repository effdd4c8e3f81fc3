/**
 * \file load.h
 * \brief Reads a table in flash word by word, with addresses that advance by themselves.
 *
 * On Thumb-2 one instruction loads two words and moves on. The compiler does not reorder these
 * loads, which also keeps it from interleaving segments until it runs out of registers.
 */
#ifndef CCGEN_LOAD_H
#define CCGEN_LOAD_H

#include "ccgen/check.h"

/** Whether loads are written in assembly. */
#if defined(__GNUC__) && defined(__thumb2__)
#define CCGEN_HAS_THUMB2_LOAD 1
#else
#define CCGEN_HAS_THUMB2_LOAD 0
#endif

/**
 * Hides from the compiler how a value came about: it keeps multiply-accumulates together instead
 * of adding constants up elsewhere, and values in registers instead of making them anew.
 */
#if defined(__GNUC__) && defined(__arm__)
#define CCGEN_OPAQUE(value) __asm__("" : "+r"(value))
#else
#define CCGEN_OPAQUE(value)
#endif

/** A condition that seldom holds: the code for it need not stand in the way. */
#if defined(__GNUC__)
#define CCGEN_RARELY(condition) (__builtin_expect((condition) ? 1 : 0, 0) != 0)
#else
#define CCGEN_RARELY(condition) (condition)
#endif

/**
 * Tells how many segments one turn of a loop estimates. More save the loop's own instructions,
 * which long segments hide anyway, and take flash.
 * \param[in] segments  1 or more
 * \param[in] products  of 32 bits that one segment takes
 * \return 1 to 4, a divisor of `segments`
 */
CCGEN_INLINE uint16_t ccgen_turn(const uint16_t segments, const uint8_t products) {
    /* MISRA 10.6 */
    const uint16_t small = !CCGEN_THUMB1 ? 1u : (products <= 3u) ? 4u : (products <= 6u) ? 2u : 1u;
    const uint16_t most = CCGEN_SMALL ? small : 4u;
    if ((most >= 4u) && ((segments % 4u) == 0u)) {
        return 4u;
    }
    if ((most >= 3u) && ((segments % 3u) == 0u)) {
        return 3u;
    }
    return ((most >= 2u) && ((segments % 2u) == 0u)) ? 2u : 1u;
}

/** \return the word at *from, which moves on by one. */
CCGEN_INLINE uint32_t ccgen_load(const uint32_t **const from) {
#if CCGEN_HAS_THUMB2_LOAD
    const uint32_t *next = *from;
    uint32_t word;
    __asm__ volatile("ldr %0, [%1], #4" : "=&r"(word), "+&r"(next) : : "memory");
    *from = next;
    return word;
#else
    return *(*from)++;
#endif
}

/** Loads two words from *from, which moves on by two. */
CCGEN_INLINE void ccgen_load_two(const uint32_t **const from, uint32_t *const first,
                                 uint32_t *const second) {
#if CCGEN_HAS_THUMB2_LOAD
    const uint32_t *next = *from;
    uint32_t low;
    uint32_t high;
    __asm__ volatile("ldrd %0, %1, [%2], #8"
                     : "=&r"(low), "=&r"(high), "+&r"(next)
                     :
                     : "memory");
    *from = next;
    *first = low;
    *second = high;
#else
    *first = ccgen_load(from);
    *second = ccgen_load(from);
#endif
}

#endif /* CCGEN_LOAD_H */
