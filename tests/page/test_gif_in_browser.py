"""Animated GIFs of a motion: the encoder, and what a page saves, as Pillow reads them."""

import base64
import json
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from mbconstrained.page.html import _asset, page_html, write_page
from tests.page.browser import needs_chromium
from tests.page.mode_pages import two_modes
from tests.page.test_marks_in_browser import keep_what_is_saved, pictures_of, saved, swinging

pytestmark = [needs_chromium, pytest.mark.long]

PALETTE = np.array([[i, 7 * i % 256, 255 - i] for i in range(256)], dtype=np.uint8)
NOISE = np.random.default_rng(7)


def called(browser, expression: str):
    """The value of an expression of the encoder's functions; ``littleEndian`` is in the script of PNG frames."""
    return browser.evaluate(f"(async () => {{ {_asset('frames.js')} {_asset('gif.js')} return {expression}; }})()")


def encoded(browser, width: int, height: int, pictures) -> bytes:
    """A GIF of pictures of numbers of colours, each shown for 4/100 s."""
    given = json.dumps([np.ravel(picture).tolist() for picture in pictures])
    return base64.b64decode(
        called(
            browser,
            f"""(async () => {{
                const gif = new Gif({width}, {height}, {json.dumps(PALETTE.tolist())});
                for (const picture of {given}) gif.add(Uint8Array.from(picture), 4);
                const bytes = new Uint8Array(await new Blob(gif.parts()).arrayBuffer());
                return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
            }})()""",
        )
    )


def decoded(content: bytes) -> tuple[np.ndarray, np.ndarray]:
    """The pictures (T, height, width, 3) of a GIF that repeats for ever, and how long each is shown, in ms."""
    film = Image.open(BytesIO(content))
    assert film.format == "GIF" and film.info["version"] == b"GIF89a" and film.info["loop"] == 0
    pictures, delays = [], []
    for k in range(film.n_frames):
        film.seek(k)
        pictures.append(np.array(film.convert("RGB")))
        delays.append(film.info["duration"])
    return np.array(pictures), np.array(delays)


def without_a_pair_twice(length: int) -> np.ndarray:
    """Each number is a code of its own: in steps of 1 through all 256, then in steps of 3, 5 ..."""
    return np.cumsum(1 + 2 * (np.arange(length) // 256)) % 256


@pytest.mark.parametrize(
    ("shape", "pictures"),
    [
        ((150, 200), [NOISE.integers(256, size=30000)]),  # 30000 codes: the dictionary restarts seven times
        ((150, 200), [NOISE.integers(2, size=30000)]),
        ((200, 300), [np.full(60000, 9)]),
        ((1, 1), [[255]]),
        ((16, 16), [np.arange(256)]),
        ((40, 50), [NOISE.integers(255, size=2000), NOISE.integers(255, size=2000), NOISE.integers(2, size=2000)]),
        ((3, 4), [np.zeros(12), np.zeros(12), np.arange(12) == 5, np.arange(12) == 5]),  # nothing or little changes
    ],
    ids=["noise", "two colours", "one colour", "1x1", "256 colours", "film", "still film"],
)
def test_what_is_encoded_is_decoded(browser, shape, pictures):
    read, delays = decoded(encoded(browser, shape[1], shape[0], pictures))
    assert np.array_equal(read, PALETTE[np.array(pictures, dtype=int)].reshape(-1, *shape, 3))
    assert set(delays) == {40}


def test_codes_become_wider_at_every_place_where_a_picture_can_end(browser):
    lengths = [middle + k for middle in (255, 767, 1791, 3839) for k in (-2, -1, 0, 1, 2)]  # 512, 1024, 2048, 4096 codes
    pages = json.dumps([without_a_pair_twice(length).tolist() for length in lengths])
    streams = called(browser, f"{pages}.map((picture) => Array.from(compressed(Uint8Array.from(picture))))")
    for length, stream in zip(lengths, streams):
        assert expanded(bytes(stream)) == without_a_pair_twice(length).tolist(), length


def expanded(stream: bytes) -> list[int]:
    """What blocks of LZW codes stand for, read code by code by appendix F of the GIF89a specification, to the end code."""
    codes, place = b"", 0
    while stream[place]:
        codes += stream[place + 1 : place + 1 + stream[place]]
        place += 1 + stream[place]
    assert place == len(stream) - 1
    number, bits, read, table, before = int.from_bytes(codes, "little"), 0, [], [], None
    while True:
        size = min(12, max(9, len(table).bit_length()))
        code, bits = number >> bits & (1 << size) - 1, bits + size
        if code == 256:
            table, before = [[k] for k in range(256)] + [[], []], None
        elif code == 257:
            assert 0 <= 8 * len(codes) - bits < 8
            return read
        else:
            if before is not None and len(table) < 4096:
                table.append([*before, (table[code] if code < len(table) else before)[0]])
            before = table[code]
            read += before


def test_the_palette_has_few_colours_exactly_and_rare_ones_among_many(browser):
    few = [[k, 255 - k, 3 * k % 256] for k in range(255)]
    counts = json.dumps([[red + 256 * green + 65536 * blue, 1 + red] for red, green, blue in few])
    assert sorted(called(browser, f"paletteOf(new Map({counts}))")) == sorted(few)
    background, red = [232, 237, 241], [200, 20, 60]
    shades = [[grey, (grey + k) % 256, (grey + 2 * k) % 256] for grey in range(60, 200) for k in range(40)]
    weighted = [(background, 10**7), (red, 30), *((shade, 400) for shade in shades)]
    counts = json.dumps([[color[0] + 256 * color[1] + 65536 * color[2], count] for color, count in weighted])
    palette = np.array(called(browser, f"paletteOf(new Map({counts}))"))
    assert len(palette) == 255 and background in palette.tolist()
    assert np.abs(palette - red).max(axis=1).min() <= 8


@pytest.fixture
def opened(browser, tmp_path):
    """In a window in which the picture is not drawn smaller."""
    browser.size(600, 900)
    yield browser.open(write_page(tmp_path / "page.html", swinging("Its text")))
    browser.call("Emulation.clearDeviceMetricsOverride")


def film_of(page, button: str = "gif") -> bytes:
    """What a button saves of the motion at the highest speed."""
    keep_what_is_saved(page)
    page.evaluate("(choice => (choice.selectedIndex = choice.options.length - 1))(document.getElementById('speed'))")
    page.click(f"#{button}")
    return saved(page)[2]


def test_a_gif_has_the_pictures_of_the_motion_in_its_time(opened):
    pictures, delays = decoded(film_of(opened))
    assert opened.evaluate("saved[0].type") == "image/gif" and opened.evaluate("saved[1]") == "A_film_of_an_arm.gif"
    assert (len(pictures), set(delays), sum(delays)) == (25, {40}, 1000)  # the motion takes 1 s
    assert opened.evaluate("document.getElementById('gif').textContent") == "Save GIF"
    frames = list(pictures_of(film_of(opened, "frames")).values())
    for picture, frame in zip(pictures[::5], frames[::6]):  # each 0.2 s, 25 and 30 pictures a second
        apart = np.abs(picture.astype(float) - np.array(Image.open(BytesIO(frame)).convert("RGB")))
        assert np.mean(apart) < 0.05 and apart.max() <= 8  # of 255 levels; found: 0.0016 and 4
    assert len(np.unique(pictures.reshape(-1, 3), axis=0)) <= 255
    assert opened.messages == [] and opened.state()["errors"] == []


def test_a_gif_of_a_mode_goes_on_from_its_last_picture_to_its_first(browser, tmp_path):
    (tmp_path / "page.html").write_text(page_html(two_modes()), encoding="utf-8")
    browser.open(tmp_path / "page.html")
    content = film_of(browser)
    pictures = decoded(content)[0].astype(float)
    cycle = browser.state()["cycle"] / float(browser.evaluate("document.getElementById('speed').value"))
    assert sum(decoded(content)[1]) == pytest.approx(1000 * cycle, abs=5)
    apart = [np.mean(np.abs(pictures[k] - pictures[-k])) for k in range(1, 5)]  # cos(2 pi t): the same forwards and backwards
    assert max(apart) < 0.1 < np.mean(np.abs(pictures[0] - pictures[1])) < np.mean(np.abs(pictures[0] - pictures[2]))
    browser.evaluate("mbconstrained.select(3)")  # does not move
    assert browser.evaluate("['frames', 'gif', 'record'].map((id) => document.getElementById(id).disabled)") == [True] * 3


def test_a_gif_that_is_stopped_has_the_pictures_so_far_and_nothing_else_records_meanwhile(opened):
    keep_what_is_saved(opened)
    opened.evaluate("document.getElementById('speed').selectedIndex = 0")  # 100 s: 1000 pictures, the most, 0.1 s each
    disabled = "['frames', 'gif', 'record'].map((id) => document.getElementById(id).disabled)"
    opened.click("#gif")
    opened.until("document.getElementById('gif').textContent === 'Stop at 1 %'")
    assert opened.evaluate(disabled) == [True, False, True]
    opened.evaluate("[1, 2].forEach(() => document.getElementById('gif').click())")  # while the colours are counted
    opened.until("document.getElementById('gif').textContent === 'Save GIF'")
    assert opened.evaluate(disabled) == [False] * 3 and opened.evaluate("saved") == []
    opened.click("#gif")
    opened.until("document.getElementById('gif').textContent === 'Stop at 5 %'")
    opened.click("#gif")
    kind, _, content = saved(opened)
    pictures, delays = decoded(content)
    assert kind == "image/gif" and 5 < len(pictures) < 900 and set(delays) == {100}
    assert opened.evaluate(disabled) == [False] * 3 and opened.messages == [] and opened.state()["errors"] == []
