"""What an exported folder costs on a microcontroller: flash, RAM, stack and instructions."""
