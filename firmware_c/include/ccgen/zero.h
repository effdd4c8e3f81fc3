/**
 * \file zero.h
 * \brief Whose zero offsets an estimator works with.
 */
#ifndef CCGEN_ZERO_H
#define CCGEN_ZERO_H

typedef enum { CCGEN_ZERO_MODEL, CCGEN_ZERO_CAPTURED, CCGEN_ZERO_RESTORED } ccgen_zero_t;

#endif /* CCGEN_ZERO_H */
