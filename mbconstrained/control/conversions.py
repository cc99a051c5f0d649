"""State spaces from and to the systems of scipy.signal and python-control, and without their descriptor.

A system is recognised by its attributes, not by its class: A, B, C, D; num, den; or zeros, poles, gain. So neither package is
imported to read one, and systems of other packages with these attributes are read too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..ground.checks import counted, nearest, optional_package
from ..ground.errors import InputError
from ..linalg.rank import Noisy
from .poles_and_zeros import roots_of, transfer_of
from .realization import factored_realization, rational_realization
from .state_equations import StateEquations

FORMS = ("state space", "transfer function", "zeros poles gain")

#: The arguments of a state space, in the order of a realization.
ARGUMENTS = ("descriptor", "A", "B", "C", "D")

_LABELS = {"states": "state_labels", "inputs": "input_labels", "outputs": "output_labels"}


def realization_of(system) -> dict:
    """The arguments of a ``StateSpace`` for a continuous-time system of scipy.signal or python-control, with its names."""
    _refuse_discrete(system)
    if _has(system, "A", "B", "C", "D"):
        if not np.size(system.A):
            return {**_static(np.asarray(system.D)), **_names(system, "inputs", "outputs")}
        return {**{name: getattr(system, name) for name in "ABCD"}, "descriptor": getattr(system, "E", None), **_names(system)}
    if _has(system, "num", "den"):
        matrices = rational_realization(_nested_lists(system.num), _nested_lists(system.den))
        return {**dict(zip(ARGUMENTS, matrices)), **_names(system, "inputs", "outputs")}
    if _has(system, "zeros", "poles", "gain") and not callable(system.zeros):
        return dict(zip(ARGUMENTS, factored_realization(system.zeros, system.poles, system.gain)))
    raise InputError(
        f"found {type(system).__name__}; expected a StateSpace, TransferFunction or ZerosPolesGain of scipy.signal, or a "
        "StateSpace or TransferFunction of python-control"
    )


def _static(D: np.ndarray) -> dict:
    """y = D u without any state: x = u, 0 = -x + u, y = D x."""
    p = D.shape[-1] if D.ndim else 0
    return {"A": -np.eye(p), "B": np.eye(p), "C": D, "descriptor": np.zeros((p, p))}


def _has(system, *names: str) -> bool:
    return all(hasattr(system, name) for name in names)


def _refuse_discrete(system) -> None:
    """Refuse discrete-time systems: python-control has dt = 0 for continuous time and None for either, scipy.signal None."""
    step = getattr(system, "dt", None)
    if step is None or (not isinstance(step, bool) and step == 0):
        return
    raise InputError(
        f"found a discrete-time system (dt = {step}); expected one in continuous time: here equations are differential "
        "equations. Give the continuous system that it was sampled from"
    )


def _names(system, *which: str) -> dict[str, list[str]]:
    """Names of the system, where they are distinct also between states and outputs."""
    labels = {key: list(getattr(system, label)) for key, label in _LABELS.items() if hasattr(system, label)}
    labels = {key: names for key, names in labels.items() if names and (not which or key in which)}
    together = [name for names in labels.values() for name in names]
    return labels if len(set(together)) == len(together) else {}


def _nested_lists(value):
    """Nested lists of coefficients: python-control keeps arrays in lists or in an array of objects."""
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value
    return [_nested_lists(entry) for entry in value] if isinstance(value, (list, tuple, np.ndarray)) else value


def to_scipy(system: StateEquations, form: str = "state space", output=None, input=None):
    """A ``scipy.signal`` system of one of the ``FORMS``."""
    import scipy.signal  # takes half a second

    _check_form(form, FORMS)
    if form == "state space":
        return scipy.signal.StateSpace(*ordinary_form(system))
    for key, names, what in ((output, system.outputs, "output"), (input, system.inputs, "input")):
        if key is None and len(names) != 1:
            raise InputError(f"{what}: the system has {len(names)} ({', '.join(names[:6])}); give {what} by name or number")
    transfer = transfer_of(system, 0 if output is None else output, 0 if input is None else input)
    if form == "transfer function":
        return scipy.signal.TransferFunction(transfer.numerator, transfer.denominator)
    return scipy.signal.ZerosPolesGain(roots_of(transfer.zeros), roots_of(transfer.poles), transfer.gain)


def to_control(system: StateEquations, form: str = "state space"):
    """A python-control system, with the names of inputs, outputs and, of a state space without descriptor, states."""
    _check_form(form, FORMS[:2])
    if not system.inputs or (form == "transfer function" and not system.outputs):
        raise InputError(
            f"the system has {counted(len(system.inputs), 'input')} and {counted(len(system.outputs), 'output')}; expected at "
            "least one input, and for a transfer function one output: give the state space B, and C"
        )
    control = optional_package("control", "to_control")
    names = {"inputs": list(system.inputs), "outputs": list(system.outputs)}
    if form == "state space":
        matrices = ordinary_form(system)
        kept = len(matrices.A) == len(system.A)
        return control.ss(*matrices, **names, **({"states": list(system.states)} if kept else {}))
    channels = [[transfer_of(system, output, input) for input in system.inputs] for output in system.outputs]
    numerators, denominators = ([[getattr(t, part) for t in row] for row in channels] for part in ("numerator", "denominator"))
    return control.tf(numerators, denominators, **names)


def _check_form(form, known) -> None:
    if form not in known:
        hint = nearest(form, known) if isinstance(form, str) else ""
        raise InputError(f"form: found {form!r}{hint}; expected one of {', '.join(known)}")


class OrdinaryForm(NamedTuple):
    """A, B, C, D of x' = A x + B u, y = C x + D u."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray


def ordinary_form(system: StateEquations) -> OrdinaryForm:
    """The ordinary form with the same transfer functions without E.

    Where E is regular the states stay, A becomes E^-1 A. Where it is singular, (s E - A)^-1 = C_F (s I - J)^-1 B_F + H_0 + s H_1
    + ... (Moysis et al., Theorem 2.8) gives A = J, B = B_F B, C = C C_F, D + C H_0 B; the states are those of the finite
    Jordan pair.
    """
    if (system.E == np.eye(len(system.E))).all():
        return OrdinaryForm(system.A, system.B, system.C, system.D)
    pairs = system.polynomial_matrix().jordan_pairs()
    if not any(pairs.structure.infinite_divisors):
        solution = np.linalg.solve(system.E, np.hstack([system.A, system.B]))
        n = len(system.A)
        return OrdinaryForm(solution[:, :n], solution[:, n:], system.C, system.D)
    highest = max((i for i in range(1, pairs.structure.highest_impulse + 1) if _through(system, i).any()), default=0)
    if highest:
        raise InputError(
            f"the descriptor is singular and G(s) grows like s^{highest}: there are no A, B, C, D without descriptor; "
            "use the form transfer function"
        )
    finite = pairs.finite
    return OrdinaryForm(finite.J, finite.B @ system.B, system.C @ finite.C, system.D + _through(system, 0))


def _through(system: StateEquations, order: int) -> np.ndarray:
    """C H_order B, zero where it is rounding."""
    pairs = system.polynomial_matrix().jordan_pairs()
    scaling = pairs.form.companion.scaling
    H = pairs.form.laurent(order)
    left, right = Noisy.rounded(system.C * scaling.columns), Noisy.rounded(scaling.rows[:, None] * system.B)
    return (left @ H @ right).cleaned() / scaling.time**order
