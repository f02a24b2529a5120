"""The integrators of the comparison: one file each, one line here."""

from pathlib import Path

from benchmarks.methods.euler import EULER
from benchmarks.methods.ivp import IVP
from benchmarks.methods.method import Failed, Method, Work
from benchmarks.methods.moreau import MOREAU
from benchmarks.methods.ours import OURS
from benchmarks.methods.rk4 import RK4
from rig import kernels

METHODS = (OURS, RK4, EULER, MOREAU, *IVP)

__all__ = ["METHODS", "Failed", "Method", "Work"]

kernels.drop_stale(Path(__file__).parent, Path(kernels.__file__).parent)
