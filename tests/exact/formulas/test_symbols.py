"""Parameters as symbols: none of them is another one, or a name of the engine."""

import sympy

from mbconstrained.exact.closed_form import ClosedForm
from mbconstrained.exact.symbolic_equations import Symbols

NAMES = ("π", "s", "s_", "x_0", "k", "k_")


def test_no_name_is_another():
    symbols = Symbols(dict.fromkeys(NAMES, 1.0))
    engine = {symbol for name in NAMES for symbol in symbols._engine[name].free_symbols}
    assert len(engine) == len(NAMES)
    assert not {symbol.name for symbol in engine} & {*NAMES, "t", "pi", symbols.pi.name}


def test_names_come_back_with_their_signs():
    symbols = Symbols({"π": 2.0, "s": -3.0})
    inner, negative = symbols._engine["π"], symbols._engine["s"]
    found = symbols.finished(ClosedForm(("x",), (inner * symbols.pi + negative * symbols.time,), symbols.time))
    values = {**found.defaults, symbols.time: sympy.Integer(5)}
    assert [p.name for p in found.parameters] == ["π", "s"]
    assert found.values[0].xreplace(values) == 2 * sympy.pi - 15
