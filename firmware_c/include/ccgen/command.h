/**
 * \file command.h
 * \brief COMMAND frames: a zero that is captured, or gone back to, over the bus.
 *
 * Behind the E2E header: number of the command (4 bits), command (4), snapshots (8). A command acts
 * when its number is not that of the last one, which HEALTH tells with its result; one that comes
 * again is acknowledged by another HEALTH frame and does nothing. A new command ends a capture that
 * still goes on. Frames that fail their check are ignored.
 *
 * NAME_can.c carries commands out where the joint has `commands = true`.
 */
#ifndef CCGEN_COMMAND_H
#define CCGEN_COMMAND_H

#include "ccgen/health.h"

typedef enum {
    CCGEN_COMMAND_NOTHING,      /**< nothing is to be done */
    CCGEN_COMMAND_CAPTURE,      /**< capture the zero from the next snapshots */
    CCGEN_COMMAND_MODEL_ZERO,   /**< back to the zero of the model */
    CCGEN_COMMAND_RESTORED_ZERO /**< back to the zero that was restored last */
} ccgen_command_t;

#endif /* CCGEN_COMMAND_H */
