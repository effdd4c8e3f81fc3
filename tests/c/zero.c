/**
 * \file zero.c
 * \brief A node's zero for Python: what its functions restore and read out.
 */
#include "port_joint.h"

int zero_restore(port_node_t *node, const port_counts_t *counts);
int zero_read(const port_node_t *node, port_counts_t *counts);
int zero_axes(const port_node_t *node);

int zero_restore(port_node_t *const node, const port_counts_t *const counts) {
    return PORT_ZERO(restore_zero)(&node->joint, counts);
}

int zero_read(const port_node_t *const node, port_counts_t *const counts) {
    return PORT_ZERO(zero)(&node->joint, counts);
}

int zero_axes(const port_node_t *const node) {
    return PORT_ZERO(node_axes)(node);
}
