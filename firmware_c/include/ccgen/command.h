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

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    CCGEN_COMMAND_NOTHING,      /**< nothing is to be done */
    CCGEN_COMMAND_CAPTURE,      /**< capture the zero from the next snapshots */
    CCGEN_COMMAND_MODEL_ZERO,   /**< back to the zero of the model */
    CCGEN_COMMAND_RESTORED_ZERO /**< back to the zero that was restored last */
} ccgen_command_t;

/**
 * Takes one frame of the bus.
 * \param[in] layout
 * \param[in,out] health  takes the number; the result is BUSY, or UNKNOWN where nothing is to be
 *                        done; the caller changes BUSY with ccgen_command_end()
 * \param[in] frame       any frame
 * \param[out] snapshots  1 to 255 for a capture; written only then
 * \return what is to be done, once
 */
ccgen_command_t ccgen_command_receive(const ccgen_layout_t *layout, ccgen_health_t *health,
                                      const ccgen_frame_t *frame, uint8_t *snapshots);

/** \return whether a frame is a COMMAND of this joint, whole and unharmed. */
bool ccgen_command_is(const ccgen_layout_t *layout, const ccgen_frame_t *frame);

/** Says what became of the command; HEALTH is due. */
void ccgen_command_end(ccgen_health_t *health, ccgen_result_t result);

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_COMMAND_H */
