"""Transfer functions and state spaces as tables, facts and plain data: zeros, gains, the mechanical normal form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ....control.state_equations import roots_of
from ....ground.checks import counted
from ....ground.display import TextTable, number_text, with_unit
from ....polynomial.structure import polynomial_text

if TYPE_CHECKING:
    from ....control.state_equations import Transfer
    from ...build.control_model import ControlScene

MOST_CHANNELS = 16  # pairs of inputs and outputs that are listed; JSON has all
MOST_ZEROS = 8  # of one channel that are listed

HIDDEN, NOT_LOOKED_FOR, POLE_AT_ZERO, NOT_KNOWN = "hidden by rounding", "not looked for", "none: a pole at 0", "not known"


def control_tables(control: ControlScene) -> list[TextTable]:
    """Transfer functions and the normal form."""
    return [_transfer_table(control), *([_form_table(control)] if control.form is not None else [])]


def control_facts(control: ControlScene) -> tuple[tuple[str, str], ...]:
    """The transfer function as given; nothing for a state space."""
    if control.transfer_function is None:
        return ()
    fraction = control.transfer_function.fraction
    return (("transfer function", f"({polynomial_text(fraction.numerator)}) / ({polynomial_text(fraction.denominator)})"),)


def control_json(control: ControlScene) -> dict:
    """Inputs, outputs, transfer functions and normal form as plain data."""
    data: dict[str, Any] = {key: getattr(control, key).as_json() for key in ("inputs", "outputs")}
    data["transfer_functions"] = [
        {"input": u, "output": y, "dc_gain": _dc_gain(control, u, y, G), **_transfer_json(G)} for u, y, G in control.transfers
    ]
    return data | ({"normal_form": _form_json(control.form)} if control.form is not None else {})


def _transfer_json(G: Transfer | None) -> dict:
    if G is None:
        return {"zeros": None, "poles": None, "gain": None}
    roots = {key: [[z.real, z.imag] for z in roots_of(of_key)] for key, of_key in (("zeros", G.zeros), ("poles", G.poles))}
    return {**roots, "gain": G.gain}


def _form_json(form) -> dict:
    matrices = ("transformation", "stiffness", "damping", "input_matrix", "output_matrix", "feedthrough")
    data = {key: None if getattr(form, key) is None else getattr(form, key).tolist() for key in matrices}
    return {**data, "condition": form.condition, "unique": form.is_unique, "freedom": form.freedom}


def _transfer_table(control: ControlScene) -> TextTable:
    """Zeros and gains by input and output."""
    units = {name: unit for names in (control.inputs, control.outputs) for name, unit in zip(names.names, names.units)}
    rows = [(u, y, *_cells(control, u, y, G, _quotient(units[y], units[u]))) for u, y, G in control.transfers[:MOST_CHANNELS]]
    note = "G(s) = gain times the product of s - zeros over that of s - poles; the DC gain is G(0)."
    if len(control.transfers) > MOST_CHANNELS:
        note += f" The first {MOST_CHANNELS} of {len(control.transfers)} are shown."
    return TextTable("Transfer functions", ("from", "to", "zeros (1/s)", "gain", "DC gain"), tuple(rows), note)


def _cells(control: ControlScene, input: str, output: str, G: Transfer | None, unit: str) -> tuple[str, str, str]:
    dc = _dc_gain(control, input, output, G)
    gain = with_unit(dc, unit) if dc is not None else POLE_AT_ZERO if G is not None else NOT_KNOWN
    if G is None:
        return HIDDEN if control.looks_for_zeros else NOT_LOOKED_FOR, "", gain
    return (_roots(G.zeros), number_text(G.gain), gain) if G.gain else ("G(s) = 0", "0", "0")


def _dc_gain(control: ControlScene, input: str, output: str, G: Transfer | None) -> float | None:
    """G(0), also where the zeros of G are unknown."""
    if G is not None:
        return G.dc_gain
    gains = control.dc_gains
    return None if gains is None else float(gains[control.outputs.names.index(output), control.inputs.names.index(input)])


def _roots(zeros: Sequence) -> str:
    texts = [_root(complex(zero.value)) + (f" ({zero.multiplicity} times)" if zero.multiplicity > 1 else "") for zero in zeros]
    more = [f"{len(texts) - MOST_ZEROS} more"] if len(texts) > MOST_ZEROS else []
    return ", ".join(texts[:MOST_ZEROS] + more) or "none"


def _root(value: complex) -> str:
    if not value.imag:
        return number_text(value.real)
    return f"{number_text(value.real)} ± {number_text(value.imag)} i" if value.real else f"± {number_text(value.imag)} i"


def _quotient(above: str, below: str) -> str:
    """The unit of a ratio, as printed.

    >>> _quotient("m", "V"), _quotient("m", "1"), _quotient("m", "m"), _quotient("rad", "N*m")
    ('m/V', 'm', '1', 'rad/(N*m)')
    """
    if below in ("1", above):
        return above if below == "1" else "1"
    return f"{above}/({below})" if {"*", "/"} & set(below) else f"{above}/{below}"


def _form_table(control: ControlScene) -> TextTable:
    """Relation of the states to displacements and velocities."""
    form = control.form
    choice = "there is no other" if form.is_unique else f"one of a family of {form.freedom} dimensions, of small condition"
    rows = [("transformation", f"{2 * form.size} states to {counted(form.size, 'displacement')} and as many velocities; {choice}")]
    rows += [(item.name, f"{item.value:.2g}: {item.text}") for item in form.evidence]
    return TextTable("Mechanical normal form", ("what", "value"), tuple(rows))
