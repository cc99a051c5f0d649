"""The compiled routines of LAPACK by name, e.g. ``lapack.dgeev``, without ``scipy.linalg``.

That package takes longer to import than a small scene to run: it loads the testing tools, the masked arrays and the compiler of NumPy.
"""

from __future__ import annotations

import os
import sys
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from types import ModuleType
from typing import Any

import scipy

_FILE = "scipy.linalg._flapack"


def __getattr__(name: str) -> Any:
    globals()[name] = routine = getattr(_routines(), name)
    return routine


@cache
def _routines() -> ModuleType:
    """SciPy's file of routines alone, or ``scipy.linalg.lapack`` where it has no such file."""
    spec = PathFinder.find_spec(_FILE, [os.path.join(os.path.dirname(scipy.__file__), "linalg")])
    if _FILE in sys.modules or spec is None or spec.loader is None:
        return scipy.linalg.lapack
    sys.modules[_FILE] = module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
