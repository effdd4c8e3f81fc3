/**
 * \file estimator.c
 * \brief Proof driver: the estimator of a joint that obeys commands meets any counts, with any zero
 * offsets and whatever its checks have left out, without a fault; so do its zeros. It leaves the
 * node to node.c.
 */
#include "joint_any.h"

int main(void);

int main(void) {
    port_joint_t joint;
    port_counts_t counts;
    port_angles_t angles;
    float jacobian[6][PORT_VALUES];
    (void)port_init(&joint);
    any_joint(&joint);
    Frama_C_make_unknown((char *)&counts, sizeof counts);
    (void)port_missing(&joint, &counts);
    (void)port_estimate(&joint, &counts, &angles);
    (void)port_follow(&joint, &counts, &angles);
    any_joint(&joint);
    (void)port_check_zero(&counts);
    (void)port_capture_zero(&joint, &counts);
    (void)port_restore_zero(&joint, &counts);
    any_joint(&joint);
    (void)RESTORE_LAST(&joint);
    (void)port_zero(&joint, &counts);
    Frama_C_make_unknown((char *)&angles, sizeof angles);
    (void)port_tip_jacobian(&angles, jacobian);
    return 0;
}
