"""The commands sweep and optimise."""

import json
import socket
import threading

import pytest

SCENE = "examples/tuned_mass_damper.toml"


@pytest.fixture
def scene():
    from pathlib import Path

    return Path(__file__).parents[2] / SCENE


@pytest.mark.long
def test_a_grid_is_tabulated(command, scene):
    code, text, _ = command("sweep", scene, "--vary", "zeta=0.1..0.2:3", "--out", "out")
    assert code == 0
    assert "3 samples" in text and "zeta" in text
    assert max(map(len, text.splitlines())) <= 80


@pytest.mark.long
def test_json_has_statistics_and_probabilities(command, scene):
    arguments = (
        "--vary",
        "m=normal(100 kg, 5 %)",
        "--samples",
        "64",
        "--keep",
        "frequencies",
        "--limit",
        "frequency 1=4.4 Hz",
        "--json",
    )
    code, text, _ = command("sweep", scene, *arguments, "--out", "out")
    assert code == 0
    data = json.loads(text)
    assert "frequency 1" in json.dumps(data) and "0.05" in json.dumps(data)


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "no parameter is varied"),
        (("--vary", "zeda=0.1..0.2:3"), "zeta"),
        (("--vary", "m=1..2 N:3"), "N"),
        (("--vary", "zeta"), "NAME=VALUE"),
        (("--vary", "zeta=0.2..0.1:3"), "zeta"),
        (("--vary", "zeta=0.1..0.2:3", "--dask", "tcp://127.0.0.1:1"), "127.0.0.1:1"),
    ],
)
def test_what_is_wrong_is_named(command, scene, arguments, message):
    code, _, errors = command("sweep", scene, *arguments)
    assert code in (1, 2)
    assert message in " ".join(errors.split()) and "Traceback" not in errors


@pytest.mark.long
def test_the_command_optimise(command, scene):
    code, text, _ = command(
        "optimise", scene, "--vary", "zeta=0.1..0.2", "--minimise", "response peak machine by machine", "--out", "out"
    )
    assert code == 0
    assert "0.133" in text
    assert max(map(len, text.splitlines())) <= 80


@pytest.mark.long
def test_an_address_where_another_program_answers(command, scene):
    """Its greeting is no length of a message that memory must hold."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def greet():
            connection, _ = server.accept()
            with connection:
                connection.sendall(b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n")

        thread = threading.Thread(target=greet, daemon=True)
        thread.start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        code, _, errors = command("sweep", scene, "--vary", "zeta=0.1..0.2:3", "--dask", address)
        thread.join()
    assert code == 1
    assert f"no Dask cluster answers at {address}" in errors
