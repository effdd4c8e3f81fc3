/**
 * \file watch.c
 * \brief Proof driver: a watch that names one of its sensors while it leaves one out does so after
 * any verdict too, and after none; so it begins.
 */
#include "ccgen/watch.h"

#include "anything.h"

int main(void);

/** \return any sensor that a group may have. */
static uint8_t any_sensor(void) {
    return (uint8_t)Frama_C_interval(0, (int)CCGEN_SENSORS_MAX - 1);
}

/** \return any verdict. */
static uint8_t any_verdict(void) {
    return either() ? any_sensor() : (uint8_t)Frama_C_interval(CCGEN_VERDICT_UNNAMED, 0xFF);
}

/** Uses a watch, and shows that it is as it was taken for granted. */
static void hold(const ccgen_watch_t *const watch) {
    (void)ccgen_watch_out(watch);
    (void)ccgen_watch_suspected(watch, any_verdict());
    //@ assert watch->out ==> watch->sensor < CCGEN_SENSORS_MAX;
}

int main(void) {
    ccgen_watch_t watch;
    ccgen_watch_init(&watch);
    hold(&watch);
    Frama_C_make_unknown((char *)&watch, sizeof watch);
    if (either()) {
        watch.out = true;
        watch.sensor = any_sensor();
    } else {
        watch.out = false;
    }
    hold(&watch);
    if (either()) {
        ccgen_watch_incomplete(&watch);
    } else {
        ccgen_watch_follow(&watch, any_verdict());
    }
    hold(&watch);
    return 0;
}
