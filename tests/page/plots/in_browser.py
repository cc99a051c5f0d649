"""What a reader does with the plots of an open page."""

import re

from tests.page.plots.pages import _SIGNS

_POWER = {ord(sign): digit for sign, digit in _SIGNS.items()}


def pointed(browser, number: int, across: float, up: float) -> None:
    """The mouse in a plot, at shares of its axes."""
    browser.mouse("mouseMoved", *browser.place("svg.plot", across, up, number))
    browser.wait(0.02)


def wheel(browser, number: int, across: float, up: float, delta: float) -> tuple[float, float]:
    """A turn of the wheel in a plot, and where it was."""
    place = browser.place("svg.plot", across, up, number)
    browser.mouse("mouseWheel", *place, deltaX=0, deltaY=delta)
    browser.wait(0.1)
    return place


def tables(browser) -> list[str]:
    """The tables that the plots save."""
    browser.evaluate("""
        window.saved = [];
        URL.createObjectURL = (blob) => (saved.push(blob), "blob:none");
        HTMLAnchorElement.prototype.click = () => {};
        document.querySelectorAll(".csv").forEach((button) => button.click());
    """)
    return browser.evaluate("Promise.all(saved.map((blob) => blob.text()))")


def number_of(text: str) -> float:
    """The number of a text such as "−1.5·10⁻³ m"."""
    number = re.match(r"[−\d.]+(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?", text)[0].replace("−", "-")
    factor, _, power = number.partition("·10")
    return float(factor) * 10.0 ** int(power.translate(_POWER) or 0)
