"""The integrators compared: one file each, one line here."""

from pathlib import Path

from rig import kernels
from rig.benchmarks.methods.euler import EULER
from rig.benchmarks.methods.ivp import IVP
from rig.benchmarks.methods.method import Failed, Method, Work
from rig.benchmarks.methods.moreau import MOREAU
from rig.benchmarks.methods.ours import OURS
from rig.benchmarks.methods.rk4 import RK4

METHODS = (OURS, RK4, EULER, MOREAU, *IVP)

__all__ = ["METHODS", "Failed", "Method", "Work"]

kernels.drop_stale(Path(__file__).parent, Path(kernels.__file__).parent)
