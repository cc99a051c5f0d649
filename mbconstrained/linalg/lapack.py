"""The compiled routines of LAPACK by name, e.g. ``lapack.dgeev``, without ``scipy.linalg``.

That package takes longer to import than a small scene to run: it loads the testing tools, the masked arrays and the compiler of NumPy.
"""

from __future__ import annotations

import os
import sys
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from typing import Any

import scipy

_FILE = "scipy.linalg._flapack"


def __getattr__(name: str) -> Any:
    if _FILE not in sys.modules:
        spec = PathFinder.find_spec(_FILE, [os.path.join(os.path.dirname(scipy.__file__), "linalg")])
        if spec is None or spec.loader is None:  # another build of SciPy
            return getattr(scipy.linalg.lapack, name)
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        sys.modules[_FILE] = module
    globals()[name] = routine = getattr(sys.modules[_FILE], name)
    return routine
