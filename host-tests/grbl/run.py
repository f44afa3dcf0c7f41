#!/usr/bin/env python3
"""Lets grbl-streamer, a sender that others wrote, talk to a controller.

    host-tests/grbl/run.py PROGRAM [LINES]
    host-tests/grbl/run.py --port PORT FILE

PROGRAM is the built `splineway`, whose `controller --protocol grbl` is jogged, streamed to, held and reset; LINES, how many short
lines the file has (2000). With --port it streams FILE to whatever is at PORT, to the end. The sender is installed into a virtual
environment of its own, `target/grbl-venv`; where it cannot be, this says so, and ends well or, with --port, with code 77.
"""

import math
import os
import pathlib
import subprocess
import sys
import threading
import time

PACKAGE = "grbl-streamer==2.0.2"
SPEED = 20
PATIENCE = 120


def environment(skipped: int) -> pathlib.Path:
    """A Python with the sender in it; `skipped` is the code to end with where there is none."""
    folder = pathlib.Path(__file__).absolute().parents[2] / "target" / "grbl-venv"
    python = folder / "bin" / "python"
    try:
        if not python.exists():
            subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True, capture_output=True)
        subprocess.run(
            [str(python), "-m", "pip", "install", "--quiet", PACKAGE], check=True, capture_output=True, timeout=120
        )
    except (OSError, subprocess.SubprocessError) as error:
        print(f"skipped: {PACKAGE} cannot be installed ({error})")
        sys.exit(skipped)
    return python


def rose(lines: int) -> list[str]:
    """A rose of short lines, up and down."""
    text = ["G21", "G90", "G17", "M3 S8000"]
    for k in range(lines):
        angle = 2 * math.pi * k / (lines - 1)
        radius = 40 * math.cos(3 * angle)
        x, y, z = radius * math.cos(angle), radius * math.sin(angle), math.sin(angle)
        text.append(f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} F4000")
    return text + ["M5", "G0 X1.5 Y-2.5 Z3"]


class Talk:
    """What the sender says of a controller."""

    def __init__(self):
        self.seen: dict[str, int] = {}
        self.errors: list[tuple] = []
        self.mode, self.place = "", (0.0, 0.0, 0.0)

    def hear(self, event: str, *data) -> None:
        self.seen[event] = self.seen.get(event, 0) + 1
        if event in ("on_error", "on_alarm"):
            self.errors.append(data)
        if event == "on_stateupdate":
            self.mode, self.place = data[0], data[1]

    def wait(self, what: str, condition, patience: float = PATIENCE) -> None:
        began = time.monotonic()
        while not condition():
            if time.monotonic() - began > patience:
                raise SystemExit(f"{what} does not come: {self.mode} at {self.place}, {self.seen}, {self.errors}")
            time.sleep(0.02)

    def rests(self) -> bool:
        return self.mode == "Idle"

    def stands(self, *place: float) -> bool:
        return self.rests() and all(abs(a - b) < 1e-6 for a, b in zip(self.place, place))


class Controller:
    """`splineway controller`."""

    def __init__(self, program: str):
        arguments = [program, "controller", "--protocol", "grbl", "--speed", str(SPEED)]
        self.process = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
        first = self.process.stdout.readline()
        self.port = first.removeprefix("port:").strip()
        # What else it says must not fill the pipe.
        threading.Thread(target=self.process.stdout.read, daemon=True).start()


def connected(talk: Talk, port: str):
    """The sender, connected."""
    from grbl_streamer import GrblStreamer

    grbl = GrblStreamer(talk.hear)
    grbl.poll_interval = 0.1
    grbl.cnect(port, 115200)
    talk.wait("the banner", lambda: "on_boot" in talk.seen)
    grbl.poll_start()
    talk.wait("a report", talk.rests)
    talk.wait("the parameters", lambda: "on_hash_stateupdate" in talk.seen)
    # After every banner it asks for them again: what comes while the machine moves is refused, as grbl does.
    asked = -1
    while asked != talk.seen["on_hash_stateupdate"]:
        asked = talk.seen["on_hash_stateupdate"]
        time.sleep(1.0)
    return grbl


def end(code: int = 0) -> None:
    """Threads of the sender may wait for a port that is gone."""
    sys.stdout.flush()
    os._exit(code)


def stream(port: str, file: pathlib.Path) -> None:
    """A file, to whatever is at the port."""
    talk = Talk()
    try:
        grbl = connected(talk, port)
        lines = file.read_text().splitlines()
        grbl.incremental_streaming = False
        grbl.write("\n".join(lines))
        grbl.job_run()
        talk.wait("motion", lambda: talk.mode == "Run")
        finished = lambda: talk.errors or ("on_job_completed" in talk.seen and talk.rests())
        talk.wait("the end of the file", finished, 36_000)
        assert not talk.errors, talk.errors
    except (AssertionError, SystemExit) as error:
        print(f"grbl-streamer: {error}", file=sys.stderr)
        end(1)
    print(f"grbl-streamer: {len(lines)} lines, to {talk.place}")
    grbl.disconnect()
    end()


def main() -> None:
    if "--inside" not in sys.argv:
        python = environment(77 if "--port" in sys.argv else 0)
        sys.exit(subprocess.run([str(python), __file__, *sys.argv[1:], "--inside"]).returncode)
    if sys.argv[1] == "--port":
        stream(sys.argv[2], pathlib.Path(sys.argv[3]))
    lines = int(sys.argv[2]) if sys.argv[2] != "--inside" else 2000
    talk = Talk()
    controller = Controller(str(pathlib.Path(sys.argv[1]).absolute()))
    try:
        grbl = connected(talk, controller.port)

        grbl.send_immediately("$J=G91 X5 F3000")
        talk.wait("the jog's end", lambda: talk.stands(5, 0, 0))
        grbl.send_immediately("G0 X0")
        talk.wait("the way back", lambda: talk.stands(0, 0, 0))

        # The whole file, with the room for lines kept full.
        grbl.incremental_streaming = False
        grbl.write("\n".join(rose(lines)))
        began = time.monotonic()
        grbl.job_run()
        talk.wait("motion", lambda: talk.mode == "Run")
        grbl.hold()
        talk.wait("the hold", lambda: talk.mode.startswith("Hold:0"))
        held = talk.place
        time.sleep(0.5)
        assert talk.place == held, (talk.place, held)
        grbl.resume()
        talk.wait("the end of the file", lambda: talk.stands(1.5, -2.5, 3))
        taken = time.monotonic() - began
        assert not talk.errors, talk.errors

        # Stopped in the middle: the machine rests, and knows where.
        grbl.job_new()
        grbl.write("\n".join(rose(lines)))
        grbl.job_run()
        talk.wait("motion", lambda: talk.mode == "Run")
        time.sleep(0.5)
        boots = talk.seen["on_boot"]
        grbl.abort()
        talk.wait("the banner after a reset", lambda: talk.seen["on_boot"] > boots)
        talk.wait("rest", talk.rests)
        grbl.job_new()
        grbl.send_immediately("G0 X0 Y0 Z0")
        talk.wait("the way home", lambda: talk.stands(0, 0, 0))
        assert not talk.errors, talk.errors
        grbl.disconnect()
    finally:
        controller.process.terminate()
    print(f"grbl-streamer: jog, {lines} lines in {taken:.1f} s at {SPEED} times the clock, hold, start, reset: good")
    end()


if __name__ == "__main__":
    main()
