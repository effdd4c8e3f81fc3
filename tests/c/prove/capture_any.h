/**
 * \file capture_any.h
 * \brief Whether a capture goes on, for the proof of a node: capture_any.c keeps it.
 */
#ifndef PROVE_CAPTURE_ANY_H
#define PROVE_CAPTURE_ANY_H

#include <stdbool.h>

/** Whether ccgen_capture_take() and ccgen_capture_wait() may be called. */
extern bool capture_goes_on;

#endif /* PROVE_CAPTURE_ANY_H */
