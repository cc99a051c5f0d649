"""State spaces from and to the systems of scipy.signal and python-control.

What is given is recognised by what it has, not by its class: A, B, C, D; num, den; or zeros, poles, gain. So neither package
is imported to read a system, and systems of others that are written the same way are read too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..checks import counted, nearest, optional_package
from ..errors import InputError
from .transfer import checked_single, roots_of

if TYPE_CHECKING:
    from .state_space import StateSpace

FORMS = ("state space", "transfer function", "zeros poles gain")

_LABELS = {"states": "state_labels", "inputs": "input_labels", "outputs": "output_labels"}


def state_space_of(system) -> StateSpace:
    """The state space of a system of scipy.signal or python-control, continuous in time; names are kept where it has some.

    Raises:
        InputError: a discrete-time system, or something else.

    >>> import scipy.signal
    >>> found = state_space_of(scipy.signal.TransferFunction([1.0], [1.0, 2.0]))
    >>> found(0).item()
    0.5
    """
    from .state_space import StateSpace

    _refuse_discrete(system)
    if _has(system, "A", "B", "C", "D"):
        if not np.size(system.A):
            return _static(np.asarray(system.D), _names(system, "inputs", "outputs"))
        return StateSpace(system.A, system.B, system.C, system.D, descriptor=getattr(system, "E", None), **_names(system))
    if _has(system, "num", "den"):
        return StateSpace.from_transfer_function(_plain(system.num), _plain(system.den), **_names(system, "inputs", "outputs"))
    if _has(system, "zeros", "poles", "gain") and not callable(system.zeros):
        return StateSpace.from_zeros_poles_gain(system.zeros, system.poles, system.gain)
    raise InputError(
        f"found {type(system).__name__}; expected a StateSpace, TransferFunction or ZerosPolesGain of scipy.signal, or a "
        "StateSpace or TransferFunction of python-control"
    )


def _static(D: np.ndarray, names) -> StateSpace:
    """y = D u without any state: x = u, 0 = -x + u, y = D x."""
    from .state_space import StateSpace

    p = D.shape[-1] if D.ndim else 0
    return StateSpace(-np.eye(p), np.eye(p), D, descriptor=np.zeros((p, p)), **names)


def _has(system, *names: str) -> bool:
    return all(hasattr(system, name) for name in names)


def _refuse_discrete(system) -> None:
    """python-control writes 0 for continuous time and None for either, scipy.signal None; all else is a sampling time."""
    step = getattr(system, "dt", None)
    if step is None or (not isinstance(step, bool) and step == 0):
        return
    raise InputError(
        f"found a discrete-time system (dt = {step}); expected one in continuous time: here equations are differential "
        "equations. Give the continuous system that it was sampled from"
    )


def _names(system, *which: str) -> dict[str, list[str]]:
    """Names that it has, where they are distinct also between states and outputs."""
    found = {key: list(getattr(system, label)) for key, label in _LABELS.items() if hasattr(system, label)}
    found = {key: names for key, names in found.items() if names and (not which or key in which)}
    together = [name for names in found.values() for name in names]
    return found if len(set(together)) == len(together) else {}


def _plain(value):
    """Nested lists of coefficients: python-control keeps arrays in lists or in an array of objects."""
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value
    return [_plain(entry) for entry in value] if isinstance(value, (list, tuple, np.ndarray)) else value


def to_scipy(system: StateSpace, form: str, output=None, input=None):
    """A ``scipy.signal`` system of one of the ``FORMS``.

    Args:
        form: "state space", "transfer function" or "zeros poles gain"; the latter two of one input and output.
        output, input: which, by name or number, where there are more.

    Raises:
        InputError: another form; no such form of this system.
    """
    import scipy.signal  # half a second: only for those who ask

    _check_form(form, FORMS)
    if form == "state space":
        return scipy.signal.StateSpace(*system.ordinary())
    for key, names, what in ((output, system.outputs, "output"), (input, system.inputs, "input")):
        if key is None:
            checked_single(names, what)
    found = system.transfer(0 if output is None else output, 0 if input is None else input)
    if form == "transfer function":
        return scipy.signal.TransferFunction(found.numerator, found.denominator)
    return scipy.signal.ZerosPolesGain(roots_of(found.zeros), roots_of(found.poles), found.gain)


def to_control(system: StateSpace, form: str):
    """A python-control system, with the names of inputs, outputs and, of a state space without descriptor, states.

    Raises:
        InputError: another form; no such form of this system.
        MissingPackage: python-control is not installed.
    """
    _check_form(form, FORMS[:2])
    if not system.inputs or (form == "transfer function" and not system.outputs):
        raise InputError(
            f"the system has {counted(len(system.inputs), 'input')} and {counted(len(system.outputs), 'output')}; expected at "
            "least one input, and for a transfer function one output: give the state space B, and C"
        )
    control = optional_package("control", "to_control")
    names = {"inputs": list(system.inputs), "outputs": list(system.outputs)}
    if form == "state space":
        matrices = system.ordinary()
        kept = len(matrices.A) == len(system.A)
        return control.ss(*matrices, **names, **({"states": list(system.states)} if kept else {}))
    channels = [[system.transfer(output, input) for input in system.inputs] for output in system.outputs]
    numerators, denominators = ([[getattr(t, part) for t in row] for row in channels] for part in ("numerator", "denominator"))
    return control.tf(numerators, denominators, **names)


def _check_form(form, known) -> None:
    if form not in known:
        hint = nearest(form, known) if isinstance(form, str) else ""
        raise InputError(f"form: found {form!r}{hint}; expected one of {', '.join(known)}")
