/**
 * \file version.h
 * \brief Version of the runtime and of the interface that generated code relies on.
 *
 * Generated code asserts at compile time that CCGEN_FORMAT_VERSION is the one it was written for.
 */
#ifndef CCGEN_VERSION_H
#define CCGEN_VERSION_H

/** Version of the tool that this runtime ships with. */
#define CCGEN_VERSION "0.1.0"

/** Raised whenever generated code and runtime of different versions would not fit each other. */
#define CCGEN_FORMAT_VERSION 3

#endif /* CCGEN_VERSION_H */
