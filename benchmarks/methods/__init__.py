"""The integrators of the comparison: one file each, one line here."""

from benchmarks.methods.euler import EULER
from benchmarks.methods.ivp import IVP
from benchmarks.methods.method import Failed, Method, Work
from benchmarks.methods.moreau import MOREAU
from benchmarks.methods.ours import OURS
from benchmarks.methods.rk4 import RK4

METHODS = (OURS, RK4, EULER, MOREAU, *IVP)

__all__ = ["METHODS", "Failed", "Method", "Work"]
