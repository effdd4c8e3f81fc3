/**
 * \file socketcan_driver.c
 * \brief The SocketCAN port on an inherited socket that stands for a CAN interface.
 *
 * Includes the port's source to reach its loop behind the opening of the interface.
 */
int socketcan_main(int argc, char *argv[]);

#define main socketcan_main
#include "../../firmware_c/ports/socketcan/main.c"
#undef main

int main(int argc, char *argv[]) {
    port_node_t node;
    if (argc != 2) {
        return socketcan_main(argc, argv);
    }
    const int can = atoi(argv[1]);
    (void)fcntl(can, F_SETFL, O_NONBLOCK);
    catch_signals();
    (void)port_node_init(&node);
    (void)port_node_set_window(&node, 60000000u); /* a loaded machine may pause the sender */
    return (run(can, &node) < 0) ? EXIT_INTERFACE : EXIT_SUCCESS;
}
