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
    static link_t link; /* zero */
    if (argc != 2) {
        return socketcan_main(argc, argv);
    }
    link.can = atoi(argv[1]);
    (void)fcntl(link.can, F_SETFL, O_NONBLOCK);
    catch_signals();
    (void)port_node_init(&link.node);
    be_patient(&link); /* a loaded machine may pause the sender */
    return (run(&link) < 0) ? EXIT_INTERFACE : EXIT_SUCCESS;
}
