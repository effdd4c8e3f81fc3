"""Polynomials in integers: CasADi functions as plans with a proven error, and their C."""

from ccgen.polynomial.c_text import c_files
from ccgen.polynomial.compiler import Compiled, compile_function
from ccgen.polynomial.specification import Input, Output

__all__ = ["Compiled", "Input", "Output", "c_files", "compile_function"]
