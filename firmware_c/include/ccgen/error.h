/**
 * \file error.h
 * \brief Results that every function of the runtime shares.
 *
 * Zero and positive values mean success; what a positive value says stands at each function.
 * A function that returns an error has written nothing through its pointers, unless its own
 * documentation names what it counts.
 */
#ifndef CCGEN_ERROR_H
#define CCGEN_ERROR_H

enum {
    CCGEN_OK = 0,
    CCGEN_ERROR_ARGUMENT = -1, /**< a null pointer or a value that the function excludes */
    CCGEN_ERROR_MISSING = -2,  /**< a sensor's count is outside its transducer's range */
    CCGEN_ERROR_FORMAT = -3,   /**< a frame or line of the wrong kind, length or characters */
    CCGEN_ERROR_CRC = -4,      /**< the check value does not fit the data */
    CCGEN_ERROR_RANGE = -5     /**< a buffer is too small, or a value does not fit its field */
};

#endif /* CCGEN_ERROR_H */
