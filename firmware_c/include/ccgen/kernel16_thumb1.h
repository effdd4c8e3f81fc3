/**
 * \file kernel16_thumb1.h
 * \brief All segments of an axis on Cortex-M0, M0+ and M1 (Thumb-1), in assembly.
 *
 * Eight low registers are too few for a compiler to hold row, factors and limits; laid out by hand
 * a pair of sensors takes seven instructions and a segment seven more. It needs the layout of
 * combined pairs and a model that the compiler sees; in any other case kernel16.h does it in C.
 */
#ifndef CCGEN_KERNEL16_THUMB1_H
#define CCGEN_KERNEL16_THUMB1_H

#include "ccgen/factors16.h"
#include "ccgen/load.h"

/** Whether this core and compiler have the loop. */
#if defined(__GNUC__) && defined(__OPTIMIZE__) && CCGEN_THUMB1 && !CCGEN_HALVES
#define CCGEN_HAS_THUMB1_LOOP 1
#else
#define CCGEN_HAS_THUMB1_LOOP 0
#endif

#if CCGEN_HAS_THUMB1_LOOP

/* clang-format off */
/*
 * Where the factors stand: gcc addresses each from the stack pointer and keeps none beyond the
 * axis's sensors; clang takes a register for their address.
 */
#if defined(__clang__)
#define CCGEN_THUMB1_FACTORS uint32_t factors[CCGEN_UNROLLED_MAX]
#define CCGEN_THUMB1_FACTOR(k) factors[k]
#define CCGEN_THUMB1_AT(k) "[%[factors], #4*" #k "]"
#define CCGEN_THUMB1_OPERANDS [factors] "l"(factors)
#define CCGEN_THUMB1_GET "mov"
#define CCGEN_THUMB1_END "h"
#define CCGEN_THUMB1_FROM "h"
#define CCGEN_THUMB1_SHIFT_STORED(value) (void)0
#define CCGEN_THUMB1_SHIFT_FROM CCGEN_THUMB1_FROM(known ? start : axis->shift)
#else
#define CCGEN_THUMB1_FACTORS uint32_t f0, f1, f2, f3, f4, f5, f6, f7
#define CCGEN_THUMB1_FACTOR(k) f##k
#define CCGEN_THUMB1_AT(k) "%[f" #k "]"
#define CCGEN_THUMB1_OPERAND(k) [f##k] "m"(*((axis->sensors > (k)) ? &f##k : &f0))
#define CCGEN_THUMB1_OPERANDS                                                             \
    CCGEN_THUMB1_OPERAND(0), CCGEN_THUMB1_OPERAND(1), CCGEN_THUMB1_OPERAND(2),            \
        CCGEN_THUMB1_OPERAND(3), CCGEN_THUMB1_OPERAND(4), CCGEN_THUMB1_OPERAND(5),        \
        CCGEN_THUMB1_OPERAND(6), CCGEN_THUMB1_OPERAND(7)
#if defined(__OPTIMIZE_SIZE__) /* gcc then leaves r8 to r11 alone */
#define CCGEN_THUMB1_GET "ldr"
#define CCGEN_THUMB1_END "l"
#define CCGEN_THUMB1_FROM "m"
#define CCGEN_THUMB1_SHIFT_STORED(value) const uint32_t shift = (value)
#define CCGEN_THUMB1_SHIFT_FROM "m"(*(known ? &start : &shift))
#else
#define CCGEN_THUMB1_GET "mov"
#define CCGEN_THUMB1_END "rh"
#define CCGEN_THUMB1_FROM "rh"
#define CCGEN_THUMB1_SHIFT_STORED(value) (void)0
#define CCGEN_THUMB1_SHIFT_FROM CCGEN_THUMB1_FROM(known ? start : axis->shift)
#endif
#endif

/* Adds the products of sensors a and b, whose weights `word` holds, to the sum in r5; r6 is lost. */
/* MISRA 20.7 */
#define CCGEN_THUMB1_PAIR(word, a, b)        \
    ".if %c[sensors] > " #a "\n"             \
    "ldr  r6, " CCGEN_THUMB1_AT(a) "\n"      \
    "muls r6, " word ", r6\n"                \
    "adds r5, r5, r6\n"                      \
    ".endif\n"                               \
    ".if %c[sensors] > " #b "\n"             \
    "asrs " word ", " word ", #16\n"         \
    "ldr  r6, " CCGEN_THUMB1_AT(b) "\n"      \
    "muls r6, " word ", r6\n"                \
    "adds r5, r5, r6\n"                      \
    ".endif\n"

/* Shifts the sum in r5 by a number of bits that the compiler knows, or that a register holds. */
/* MISRA 20.7 */
#define CCGEN_THUMB1_SHIFT(operation)       \
    ".if %c[known]\n"                       \
    ".if %c[bits]\n"                        \
    operation " r5, r5, #%c[bits]\n"        \
    ".endif\n"                              \
    ".else\n"                               \
    CCGEN_THUMB1_GET " r6, %[shift]\n"      \
    operation " r5, r5, r6\n"               \
    ".endif\n"

/**
 * Estimates all segments; number of sensors and segments and whether an angle may saturate must be
 * constants once this is inlined.
 * \param[in] axis     valid model of at most CCGEN_UNROLLED_MAX sensors, without biases of single
 *                     segments
 * \param[in] zero     [sensors] counts at the straight pose
 * \param[in] counts   [sensors] counts
 * \param[in] known    whether the shift is a constant too; a constant itself
 * \param[out] angles  [segments] angles
 */
CCGEN_INLINE void ccgen_thumb1_evaluate16(const ccgen_axis16_t *const axis,
                                          const int16_t *const zero, const int16_t *const counts,
                                          const bool known, int16_t *const angles) {
    uint32_t start = ccgen_start16(axis);
    CCGEN_THUMB1_FACTORS;
    ccgen_combine16(axis, zero, counts, 0, &start, &CCGEN_THUMB1_FACTOR(0), &CCGEN_THUMB1_FACTOR(1));
    ccgen_combine16(axis, zero, counts, 1, &start, &CCGEN_THUMB1_FACTOR(2), &CCGEN_THUMB1_FACTOR(3));
    ccgen_combine16(axis, zero, counts, 2, &start, &CCGEN_THUMB1_FACTOR(4), &CCGEN_THUMB1_FACTOR(5));
    ccgen_combine16(axis, zero, counts, 3, &start, &CCGEN_THUMB1_FACTOR(6), &CCGEN_THUMB1_FACTOR(7));
    const uint16_t turn = ccgen_turn(axis->segments, axis->sensors);
    CCGEN_THUMB1_SHIFT_STORED(axis->shift);
    const uint32_t *row = axis->rows;
    int16_t *angle = angles;
    __asm__ volatile(
        ".syntax unified\n"
        ".if %c[saturates]\n"
        "movs r5, #1\n"
        "lsls r5, r5, #16\n"
        "subs r5, r5, #2\n"
        "mov  r12, r5\n" /* most steps above the lowest angle: 65534 */
        "lsrs r5, r5, #1\n"
        "negs r5, r5\n"
        "mov  lr, r5\n" /* the lowest angle: -32767 */
        ".endif\n"
        "1:\n"
        ".irp i, 0, 1, 2, 3\n"
        ".if \\i < %c[turn]\n"
        ".if %c[sensors] > 2\n"
        "ldmia %[row]!, {r2, r3}\n"
        ".else\n"
        "ldmia %[row]!, {r2}\n"
        ".endif\n"
        CCGEN_THUMB1_GET " r5, %[start]\n"
        CCGEN_THUMB1_PAIR("r2", 0, 1)
        CCGEN_THUMB1_PAIR("r3", 2, 3)
        ".if %c[sensors] > 6\n"
        "ldmia %[row]!, {r2, r3}\n"
        ".elseif %c[sensors] > 4\n"
        "ldmia %[row]!, {r2}\n"
        ".endif\n"
        CCGEN_THUMB1_PAIR("r2", 4, 5)
        CCGEN_THUMB1_PAIR("r3", 6, 7)
        ".if %c[saturates]\n"
        CCGEN_THUMB1_SHIFT("lsrs")
        "cmp  r5, r12\n"
        "bhi  .Lccgen_clip_%=_\\i\n"
        ".Lccgen_store_%=_\\i:\n"
        "add  r5, lr\n"
        ".else\n"
        CCGEN_THUMB1_SHIFT("asrs")
        ".endif\n"
        "strh r5, [%[angle], #2*\\i]\n"
        ".endif\n"
        ".endr\n"
        "adds %[angle], %[angle], #2*%c[turn]\n"
        "cmp  %[angle], %[end]\n"
        ".if %c[turn]*(5+4*%c[sensors]) < 116\n" /* words of code that a condition jumps over */
        "bne  1b\n"
        ".if %c[saturates]\n"
        "b    2f\n"
        ".endif\n"
        ".else\n"
        "beq  2f\n"
        "b    1b\n"
        ".endif\n"
        ".if %c[saturates]\n"
        ".irp i, 0, 1, 2, 3\n"
        ".if \\i < %c[turn]\n"
        ".Lccgen_clip_%=_\\i:\n" /* the sum's sign without its offset tells which end it left */
        "add  r5, lr\n"
        CCGEN_THUMB1_SHIFT("lsls")
        "asrs r5, r5, #31\n"
        "mvns r5, r5\n"
        "mov  r6, r12\n"
        "ands r5, r5, r6\n"
        "b    .Lccgen_store_%=_\\i\n"
        ".endif\n"
        ".endr\n"
        ".endif\n"
        "2:\n"
        : [row] "+l"(row), [angle] "+l"(angle)
        : CCGEN_THUMB1_OPERANDS, [start] CCGEN_THUMB1_FROM(start),
          [end] CCGEN_THUMB1_END(angles + axis->segments),
          [shift] CCGEN_THUMB1_SHIFT_FROM, [known] "i"(known),
          [bits] "i"(known ? axis->shift : 0), [sensors] "i"(axis->sensors),
          [saturates] "i"(axis->saturates), [turn] "i"(turn)
        : "r2", "r3", "r5", "r6", "r12", "lr", "cc", "memory");
}
/* clang-format on */

#endif /* CCGEN_HAS_THUMB1_LOOP */

#endif /* CCGEN_KERNEL16_THUMB1_H */
