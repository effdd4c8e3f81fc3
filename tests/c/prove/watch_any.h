/**
 * \file watch_any.h
 * \brief Stands for ccgen/watch.h where a joint is proven: any watch that watch.c shows to be kept,
 * and any one sensor left out or suspected, or none. watch.c proves the watch itself.
 */
#ifndef PROVE_WATCH_ANY_H
#define PROVE_WATCH_ANY_H

#include "anything.h"
#include "ccgen/watch.h"

static inline void any_watch(ccgen_watch_t *const watch) {
    Frama_C_make_unknown((char *)watch, sizeof *watch);
    watch->out = either();
}

static inline void any_followed(ccgen_watch_t *const watch, const uint8_t verdict) {
    if (verdict < CCGEN_VERDICT_UNNAMED) {
        //@ assert verdict < CCGEN_SENSORS_MAX;
    }
    any_watch(watch);
}

static inline uint16_t any_out(const ccgen_watch_t *const watch) {
    (void)watch;
    return either() ? (uint16_t)(UINT32_C(1) << Frama_C_interval(0, 15)) : 0u;
}

static inline uint16_t any_suspected(const ccgen_watch_t *const watch, const uint8_t verdict) {
    if (verdict < CCGEN_VERDICT_UNNAMED) {
        //@ assert verdict < CCGEN_SENSORS_MAX;
    }
    return any_out(watch);
}

#define ccgen_watch_init any_watch
#define ccgen_watch_incomplete any_watch
#define ccgen_watch_follow any_followed
#define ccgen_watch_out any_out
#define ccgen_watch_suspected any_suspected

#endif /* PROVE_WATCH_ANY_H */
