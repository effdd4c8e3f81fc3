"""Recordings of a joint: read, laid on one clock, and turned into shapes."""
