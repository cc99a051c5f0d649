"""Texts as the page shows them: only units have powers, only complex numbers are kept together."""

import pytest

from mbconstrained.page.content import typeset


@pytest.mark.parametrize(
    "text, shown",
    [
        ("", ""),
        ("m/s^2", "m/s²"),
        ("kg m^2/s^-10", "kg m²/s⁻¹⁰"),
        ("x^2", "x^2"),
        ("x_m^2", "x_m^2"),
        ("δ^(4)", "δ^(4)"),
        ("m^2a", "m^2a"),
        ("± 1 i", "±\xa01\xa0i"),
        ("-1 ± 1e-05 i", "-1\xa0±\xa01e-05\xa0i"),
        ("at 3 in all", "at 3 in all"),
        ("a ± b", "a ± b"),
        ("<b>", "&lt;b&gt;"),
    ],
)
def test_a_text_is_typeset(text, shown):
    assert typeset(text) == shown
