/**
 * \file integer.h
 * \brief Conversions without implementation-defined behaviour, and sums in their order.
 *
 * A conversion gives the value whose two's complement pattern is the argument's. Compilers emit a
 * sign extension (sxth, asr) or nothing at all.
 */
#ifndef CCGEN_INTEGER_H
#define CCGEN_INTEGER_H

#include "ccgen/check.h"

/** \param[in] word any value  \return the same bits as a signed number */
CCGEN_INLINE int16_t ccgen_signed16(const uint16_t word) {
    return (word <= 0x7FFFu) ? CCGEN_CAST(int16_t, word)
                             /* MISRA 10.8 */
                             : CCGEN_CAST(int16_t, -CCGEN_CAST(int16_t, 0xFFFFu - word) - 1);
}

/** \param[in] word any value  \return the same bits as a signed number */
CCGEN_INLINE int32_t ccgen_signed32(const uint32_t word) {
    /* MISRA 10.8 */
    return (word <= 0x7FFFFFFFu) ? CCGEN_CAST(int32_t, word) : (-CCGEN_CAST(int32_t, ~word) - 1);
}

/** \param[in] word any value  \return the same bits as a signed number */
CCGEN_INLINE int64_t ccgen_signed64(const uint64_t word) {
    return (word <= UINT64_C(0x7FFFFFFFFFFFFFFF)) ? CCGEN_CAST(int64_t, word)
                                                /* MISRA 10.8 */
                                                : (-CCGEN_CAST(int64_t, ~word) - 1);
}

/** \param[in] word any value  \return its bits 0 to 15 as a signed number */
CCGEN_INLINE int16_t ccgen_low16(const uint32_t word) {
    return ccgen_signed16(CCGEN_CAST(uint16_t, word & 0xFFFFu));
}

/** \param[in] word any value  \return its bits 16 to 31 as a signed number */
CCGEN_INLINE int16_t ccgen_high16(const uint32_t word) {
    return CCGEN_CAST(int16_t, ccgen_signed32(word) >> 16); /* MISRA 10.1 */
}

#endif /* CCGEN_INTEGER_H */
