/**
 * \file joint_any.h
 * \brief Any state of a joint that obeys commands; its flags are true or false, as C wants them.
 */
#ifndef PROVE_JOINT_ANY_H
#define PROVE_JOINT_ANY_H

#include "port_joint.h"
#ifdef CHECK_HEADER
#include "watch_any.h"
#else
#include "anything.h"
#endif

/** A function of the joint that ports do not know. */
#define OF_JOINT(name) JOINED(JOINT, name)
#define JOINED(joint, name) JOINED_(joint, name)
#define JOINED_(joint, name) joint##_##name

static inline void any_joint(port_joint_t *const joint) {
    Frama_C_make_unknown((char *)joint, sizeof *joint);
    joint->has_restored = either();
#ifdef CHECK_HEADER
    joint->watched = either();
    for (uint8_t k = 0; k < sizeof joint->watch / sizeof joint->watch[0]; ++k) {
        any_watch(&joint->watch[k]);
    }
#endif
}

#endif /* PROVE_JOINT_ANY_H */
