"""What a server of processes loads once for all runs of ccgen that it starts."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as many processes as processors, no more

import casadi  # noqa: F401
import matplotlib.figure  # noqa: F401
import numpy as np  # noqa: F401
import scipy.optimize  # noqa: F401

import ccgen.cli.main
import ccgen.export.package
import ccgen.figures.case_study
import ccgen.fixedpoint
import ccgen.placement
import ccgen.recordings.reading
import ccgen.shapes.loads.library  # noqa: F401
