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

#include "ccgen/axis16.h"

/** Whether this core and compiler have the loop. */
#if defined(__GNUC__) && defined(__thumb__) && !defined(__thumb2__) && !CCGEN_HALVES
#define CCGEN_HAS_THUMB1_LOOP 1
#else
#define CCGEN_HAS_THUMB1_LOOP 0
#endif

#if CCGEN_HAS_THUMB1_LOOP

/* clang-format off */
/* Adds the products of pair k, whose weights `word` holds, to the sum in r5; r6 is lost. */
#define CCGEN_THUMB1_PAIR(word, k)                 \
    ".if %c[sensors] > 2*" k "\n"                  \
    "ldr  r6, [%[factors], #4+8*" k "]\n"          \
    "muls r6, " word ", r6\n"                      \
    "adds r5, r5, r6\n"                            \
    ".endif\n"                                     \
    ".if %c[sensors] > 2*" k "+1\n"                \
    "asrs " word ", " word ", #16\n"               \
    "ldr  r6, [%[factors], #8+8*" k "]\n"          \
    "muls r6, " word ", r6\n"                      \
    "adds r5, r5, r6\n"                            \
    ".endif\n"

/**
 * Estimates all segments; `sensors`, `shift`, `saturates` and `turn` must be constants once this
 * is inlined.
 * \param[in] row        rows of the model
 * \param[out] angle     [segments] angles
 * \param[in] factors    what sums begin with, two factors of every pair, the end of the angles
 * \param[in] end        offset of that end in `factors`, bytes
 * \param[in] turn       segments a turn of the loop, 1 to 4, a divisor of their number
 */
CCGEN_INLINE void ccgen_thumb1_loop16(const uint32_t *row, int16_t *angle, const void *factors,
                                      const size_t end, const uint8_t sensors, const uint8_t shift,
                                      const bool saturates, const uint16_t turn) {
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
        "ldr  r5, [%[factors]]\n"
        CCGEN_THUMB1_PAIR("r2", "0")
        CCGEN_THUMB1_PAIR("r3", "1")
        ".if %c[sensors] > 6\n"
        "ldmia %[row]!, {r2, r3}\n"
        ".elseif %c[sensors] > 4\n"
        "ldmia %[row]!, {r2}\n"
        ".endif\n"
        CCGEN_THUMB1_PAIR("r2", "2")
        CCGEN_THUMB1_PAIR("r3", "3")
        ".if %c[saturates]\n"
        ".if %c[shift]\n"
        "lsrs r5, r5, #%c[shift]\n"
        ".endif\n"
        "cmp  r5, r12\n"
        "bhi  .Lccgen_clip_%=_\\i\n"
        ".Lccgen_store_%=_\\i:\n"
        "add  r5, lr\n"
        ".elseif %c[shift]\n"
        "asrs r5, r5, #%c[shift]\n"
        ".endif\n"
        "strh r5, [%[angle], #2*\\i]\n"
        ".endif\n"
        ".endr\n"
        "adds %[angle], %[angle], #2*%c[turn]\n"
        "ldr  r6, [%[factors], #%c[end]]\n"
        "cmp  %[angle], r6\n"
        "beq  2f\n"
        "b    1b\n"
        ".if %c[saturates]\n"
        ".irp i, 0, 1, 2, 3\n"
        ".if \\i < %c[turn]\n"
        ".Lccgen_clip_%=_\\i:\n" /* the sum's sign without its offset tells which end it left */
        "add  r5, lr\n"
        "lsls r5, r5, #%c[shift]\n"
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
        : [factors] "l"(factors), [end] "i"(end), [sensors] "i"(sensors), [shift] "i"(shift),
          [saturates] "i"(saturates), [turn] "i"(turn)
        : "r2", "r3", "r5", "r6", "r12", "lr", "cc", "memory");
}
/* clang-format on */

#endif /* CCGEN_HAS_THUMB1_LOOP */

#endif /* CCGEN_KERNEL16_THUMB1_H */
