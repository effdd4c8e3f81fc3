/** Stand-in for Zephyr's header: atomic words. */
#ifndef FAKE_ZEPHYR_ATOMIC_H
#define FAKE_ZEPHYR_ATOMIC_H

typedef long atomic_t;
typedef atomic_t atomic_val_t;

atomic_val_t atomic_get(const atomic_t *target);
atomic_val_t atomic_set(atomic_t *target, atomic_val_t value);

#endif
