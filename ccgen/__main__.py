"""`python -m ccgen` is `ccgen`."""

from ccgen.cli.start import start

start()
