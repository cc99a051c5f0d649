"""State spaces from and to the systems of scipy.signal and python-control, and without their descriptor.

A system is recognised by its attributes, not by its class: A, B, C, D; num, den; or zeros, poles, gain. So neither package is
imported to read one, and systems of other packages with these attributes are read too.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np

from ..ground.checks import counted, nearest, optional_package, real_array, real_number
from ..ground.errors import InputError
from ..ground.tolerances import CONJUGATE_ROOTS
from ..linalg.arrays import block_diag
from ..linalg.rank import Noisy
from .state_equations import StateEquations, roots_of, transfer_of

# Realizations of transfer functions as state spaces: E, A, B, C, D with C (s E - A)^-1 B + D = G(s).
#
# A proper b(s)/a(s) becomes the controllable canonical form, with the states w, w', ..., w^(n-1) of a(d/dt) w = u and
# y = b(d/dt) w. An improper one (or a constant) keeps its coefficients in a descriptor form: w, ..., w^(N) with
# N = max(m, n), N equations (w^(i))' = w^(i+1), and 0 = a(d/dt) w - u among the highest of them.

Matrices = tuple[np.ndarray | None, np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # E (None: identity), A, B, C, D


def rational_realization(numerator, denominator) -> Matrices:
    """Realization of b(s)/a(s), or of a matrix of them, numerator[output][input] and denominator[output][input].

    Every entry of a matrix is realized separately, so that common poles occur more than once.

    >>> E, A, B, C, D = rational_realization([1.0, 3.0], [1.0, 2.0])  # 1 + 1/(s + 2)
    >>> E, A.tolist(), C.tolist(), D.tolist()
    (None, [[-2.0]], [[1.0]], [[1.0]])
    """
    if not _is_matrix(numerator) and not _is_matrix(denominator):
        return _single(_coefficients(numerator, "numerator"), _coefficients(denominator, "denominator"))
    rows = _entries(numerator, denominator)
    return _block_realization(
        [[_single(_coefficients(b, "numerator"), _coefficients(a, "denominator")) for b, a in row] for row in rows]
    )


def _coefficients(value, what: str) -> np.ndarray:
    """Coefficients with the highest power first, without leading zeros, at least one; a denominator is not zero."""
    polynomial = real_array([value] if np.ndim(value) == 0 else value, what, shape=(None,))
    if not len(polynomial):
        raise InputError(f"{what}: found no coefficients; expected numbers, the highest power of s first")
    if polynomial.any():
        return polynomial[int((polynomial != 0).argmax()) :]
    if what == "denominator":
        raise InputError("denominator: found zero; expected a polynomial that is not zero")
    return np.zeros(1)


def _single(b: np.ndarray, a: np.ndarray) -> Matrices:
    n, m = len(a) - 1, len(b) - 1
    return _canonical(b[::-1], a[::-1]) if 1 <= n >= m else _descriptor(b[::-1], a[::-1], max(n, m))


def _canonical(b, a) -> Matrices:
    """Canonical realization; ascending powers, m <= n."""
    n = len(a) - 1
    b = np.pad(b, (0, n + 1 - len(b))) / a[-1]
    a = a / a[-1]
    A = np.diag(np.ones(n - 1), 1)
    A[-1] = -a[:n]
    return None, A, np.eye(n)[:, -1:], (b[:n] - b[n] * a[:n])[None, :], b[n:, None]


def _descriptor(b, a, highest: int) -> Matrices:
    """Descriptor realization; ascending powers, of any degree of the numerator."""
    size = highest + 1
    E, A = np.eye(size), np.diag(np.ones(highest), 1)
    E[-1, -1] = 0.0
    A[-1, : len(a)] = a
    return E, A, -np.eye(size)[:, -1:], np.pad(b, (0, size - len(b)))[None, :], np.zeros((1, 1))


def _is_matrix(value) -> bool:
    return _is_list(value) and len(value) > 0 and _is_list(value[0])


def _is_list(value) -> bool:
    return isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str) and getattr(value, "ndim", 1) > 0


def _entries(numerator, denominator) -> list[list[tuple]]:
    if not _is_matrix(numerator):
        raise InputError("numerator: found coefficients with a matrix of denominators; give numerator[output][input]")
    for table, what in ((numerator, "numerator"), (denominator, "denominator")):
        if _is_matrix(table) and any(_is_list(row) and not len(row) for row in table):
            raise InputError(f"{what}: found an empty list; expected a polynomial, or {what}[output][input]")
    if not _is_list(numerator[0][0]):  # one input, several outputs, as scipy.signal writes it
        numerator = [[row] for row in numerator]
    if not _is_matrix(denominator):
        denominator = [[denominator] * len(row) for row in numerator]
    sizes = [[len(row) if _is_list(row) else 0 for row in table] for table in (numerator, denominator)]
    if sizes[0] != sizes[1] or len(set(sizes[0])) != 1:
        raise InputError("numerator and denominator: expected a polynomial for every output and input in both; the sizes differ")
    return [list(zip(*rows)) for rows in zip(numerator, denominator)]


def _block_realization(table: list[list[Matrices]]) -> Matrices:
    """The realizations of all entries as one block diagonal system."""
    q, p = len(table), len(table[0])
    entries = [(i, j, *entry) for i, row in enumerate(table) for j, entry in enumerate(row)]
    E = block_diag(*(np.eye(len(A)) if own is None else own for _, _, own, A, *_ in entries))
    A = block_diag(*(A for _, _, _, A, *_ in entries))
    B = np.vstack([B @ np.eye(p)[[j]] for _, j, _, _, B, *_ in entries])
    C = np.hstack([np.eye(q)[:, [i]] @ C for i, *_, C, _ in entries])
    return (None if (E == np.eye(len(A))).all() else E), A, B, C, np.block([[entry[-1] for entry in row] for row in table])


def factored_realization(zeros, poles, gain) -> Matrices:
    """Realization of gain prod(s - zeros)/prod(s - poles) as a series of sections of at most second order, not multiplied out."""
    above, below = _quadratics(zeros, "zeros"), _quadratics(poles, "poles")
    gain = real_number(gain, "gain")
    if len(above) > len(below) or not below or sum(map(len, above)) - len(above) > sum(map(len, below)) - len(below):
        return _single(gain * _product(above), _product(below))
    above += [np.ones(1)] * (len(below) - len(above))
    above[0] = gain * above[0]
    chain = _single(above[0], below[0])
    for b, a in zip(above[1:], below[1:]):
        chain = _series(chain, _single(b, a))
    return chain


def _product(factors) -> np.ndarray:
    return reduce(np.convolve, factors, np.ones(1))


def _quadratics(roots, what: str) -> list[np.ndarray]:
    """Real factors of second order, and one of first order at the end where the degree is odd."""
    roots = _complex_numbers(roots, what)
    upper, lower = (sorted(roots[sign * roots.imag > 0], key=lambda z: (z.real, abs(z.imag))) for sign in (1, -1))
    if len(upper) != len(lower) or not np.allclose(upper, np.conj(lower), rtol=CONJUGATE_ROOTS, atol=0):
        raise InputError(f"{what}: found complex numbers without their conjugates; a real system has them in pairs")
    real = sorted(roots[roots.imag == 0].real, key=abs)
    factors = [np.array([1.0, -2 * z.real, abs(z) ** 2]) for z in upper]
    factors += [np.array([1.0, -(a + b), a * b]) for a, b in zip(real[::2], real[1::2])]
    return factors + ([np.array([1.0, -real[-1]])] if len(real) % 2 else [])


def _complex_numbers(roots, what: str) -> np.ndarray:
    try:
        numbers = np.atleast_1d(np.asarray(roots, dtype=complex))
        fits = np.asarray(roots).dtype.kind not in "US" and numbers.ndim == 1 and np.isfinite(numbers).all()
    except (TypeError, ValueError, OverflowError):  # other objects, uneven lists, numbers out of range
        fits = False
    if not fits:
        raise InputError(f"{what}: expected a list of finite numbers, real or complex")
    return numbers


def _series(first: Matrices, second: Matrices) -> Matrices:
    """Series connection: the output of the first is the input of the second; both without descriptor."""
    _, A1, B1, C1, D1 = first
    _, A2, B2, C2, D2 = second
    A = np.block([[A1, np.zeros((len(A1), len(A2)))], [B2 @ C1, A2]])
    return None, A, np.vstack([B1, B2 @ D1]), np.hstack([D2 @ C1, C2]), D2 @ D1


FORMS = ("state space", "transfer function", "zeros poles gain")

#: The arguments of a state space, in the order of a realization.
ARGUMENTS = ("descriptor", "A", "B", "C", "D")

_LABELS = {"states": "state_labels", "inputs": "input_labels", "outputs": "output_labels"}


def realization_of(system) -> dict:
    """The arguments of a ``StateSpace`` for a continuous-time system of scipy.signal or python-control, with its names."""
    _refuse_discrete(system)
    return arguments_of(system)


def arguments_of(system) -> dict:
    """The arguments of a state space for a system of other packages in continuous or discrete time, with its names."""
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
        "equations. mb.DiscreteStateSpace reads it; or give the continuous system that it was sampled from"
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
    highest = max((i for i in range(1, pairs.structure.highest_impulse + 1) if through(system, i).any()), default=0)
    if highest:
        raise InputError(
            f"the descriptor is singular and G(s) grows like s^{highest}: there are no A, B, C, D without descriptor; "
            "use the form transfer function"
        )
    finite = pairs.finite
    return OrdinaryForm(finite.J, finite.B @ system.B, system.C @ finite.C, system.D + through(system, 0))


def through(system: StateEquations, order: int) -> np.ndarray:
    """C H_order B, zero where it is rounding."""
    pairs = system.polynomial_matrix().jordan_pairs()
    scaling = pairs.form.companion.scaling
    H = pairs.form.laurent(order)
    left, right = Noisy.rounded(system.C * scaling.columns), Noisy.rounded(scaling.rows[:, None] * system.B)
    return (left @ H @ right).cleaned() / scaling.time**order
