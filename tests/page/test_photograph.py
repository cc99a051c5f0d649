"""A still picture by a browser: what is wrong is said before one is started, what hangs is ended, what is taken is the model."""

import io
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mbconstrained.ground.errors import InputError, MbconstrainedError
from mbconstrained.page import photograph as module
from mbconstrained.page.animation import DrawnEvent, Overlay
from mbconstrained.page.photograph import photograph
from tests.page.browser import needs_chromium
from tests.page.contents import two_masses_content

ANIMATION = two_masses_content().animation


@pytest.mark.long
@needs_chromium
def test_the_picture_shows_the_model_at_its_time_and_tells_below_it_what_jumps():
    start = ANIMATION.values[:, 0]
    jumping = replace(ANIMATION, overlay=Overlay((DrawnEvent(0.0, ("at t = 0 s", "x1 jumps"), start, start),)))
    taken = [photograph(jumping, at, 480, 300) for at in (0, 0, 9.0)]
    first, again, later = (np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=int) for png in taken)
    assert first.shape == (300, 480, 3) and (first == again).all()
    models, words = zip(*((picture[:-40], picture[-40:].mean(axis=2)) for picture in (first, later)))
    assert np.abs(models[0] - models[1]).max() > 60
    assert len(np.unique(models[0].reshape(-1, 3), axis=0)) > 100  # shaded bodies, and no message in their place
    assert words[0][:, :150].min() < 100 < words[0][:, 150:].min()  # letters on the left, no shadow of the model behind them
    assert words[1][:, :150].min() > 100


@pytest.mark.parametrize("wrong", [-1.0, 51.0, float("nan"), "now"])
def test_a_time_outside_the_motion_is_refused(wrong):
    with pytest.raises(InputError, match="still picture, time: "):
        photograph(ANIMATION, wrong)


def test_without_a_browser_it_says_so(monkeypatch):
    monkeypatch.setattr(module, "BROWSERS", ("no-such-browser",))
    assert module.browser() is None
    with pytest.raises(MbconstrainedError, match=r"no Chromium or Chrome is installed.*install one"):
        photograph(ANIMATION, 0.0)


def fake(tmp_path, text):
    program = tmp_path / "browser"
    program.write_text(f"#!{sys.executable}\n{text}\n")
    program.chmod(0o755)
    return str(program)


def test_a_browser_that_takes_none_is_quoted(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "BROWSERS", (fake(tmp_path, "import sys; sys.exit('no display')"),))
    with pytest.raises(MbconstrainedError, match="browser failed: no display"):
        photograph(ANIMATION, 0.0)


def test_a_browser_that_hangs_is_ended_with_what_it_has_started(tmp_path, monkeypatch):
    alive = tmp_path / "alive"
    child = f"import time; [(open({str(alive)!r}, 'a').write('.'), time.sleep(0.05)) for _ in range(400)]"
    text = f"import subprocess, sys, time\nsubprocess.Popen([sys.executable, '-c', {child!r}])\ntime.sleep(60)"
    monkeypatch.setattr(module, "BROWSERS", (fake(tmp_path, text),))
    monkeypatch.setattr(module, "TIME_LIMIT", 1.5)
    with pytest.raises(MbconstrainedError, match=r"took longer than 1\.5 s"):
        photograph(ANIMATION, 0.0)
    written = alive.stat().st_size if alive.exists() else 0
    time.sleep(0.3)
    assert (alive.stat().st_size if alive.exists() else 0) == written


def test_the_browser_gets_a_home_of_its_own_and_no_profile(tmp_path, monkeypatch):
    told = tmp_path / "told"
    text = f"import os, sys; open({str(told)!r}, 'w').write(os.environ['XDG_CONFIG_HOME'] + '\\n' + '\\n'.join(sys.argv))"
    monkeypatch.setattr(module, "BROWSERS", (fake(tmp_path, text),))
    with pytest.raises(MbconstrainedError):
        photograph(replace(ANIMATION), 1.25)
    home, _, *arguments = told.read_text().splitlines()
    (profile,) = (word.split("=", 1)[1] for word in arguments if word.startswith("--user-data-dir="))
    assert profile.startswith(home) and arguments[-1].endswith("#t=1.25")
    assert not any("remote-debugging" in word or "http" in word for word in arguments)
