/**
 * \file anything.h
 * \brief Inputs for Frama-C's value analysis: every value that their type has.
 */
#ifndef PROVE_ANYTHING_H
#define PROVE_ANYTHING_H

#include "__fc_builtin.h"
#include "ccgen/frame.h"

static inline bool either(void) {
    return Frama_C_interval(0, 1) != 0;
}

/** Any frame; its flags are true or false, as C wants them. */
static inline void any_frame(ccgen_frame_t *const frame) {
    Frama_C_make_unknown((char *)frame, sizeof *frame);
    frame->extended = either();
    frame->fd = either();
    frame->remote = either();
    frame->rate_switch = either();
}

#endif /* PROVE_ANYTHING_H */
