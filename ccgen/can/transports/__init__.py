"""Ways to a node: this process, another one, an emulator's UART, a bus."""

WINDOW_MS = 10_000
"""Time that a snapshot's frames may take where no bus keeps the time: a busy machine may hold up
sender or node between two frames for longer than a cycle."""
