"""Shapes of a joint under loads: large-deflection statics in space, solved for many at once."""
