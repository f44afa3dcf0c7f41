#!/usr/bin/env python3
"""Lets grbl-streamer, a sender that others wrote, talk to `splineway controller --protocol grbl`.

    host-tests/grbl/run.py PROGRAM [LINES]

PROGRAM is the built `splineway`; LINES, how many short lines the file has (2000). The sender is installed
into a virtual environment of its own, beside PROGRAM; where it cannot be, this says so and ends well.
"""

import math
import pathlib
import subprocess
import sys
import threading
import time

PACKAGE = "grbl-streamer==2.0.2"
SPEED = 20
PATIENCE = 120


def environment(program: pathlib.Path) -> pathlib.Path:
    """A Python with the sender in it."""
    folder = program.parent / "grbl-venv"
    python = folder / "bin" / "python"
    try:
        if not python.exists():
            subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True, capture_output=True)
        subprocess.run(
            [str(python), "-m", "pip", "install", "--quiet", PACKAGE], check=True, capture_output=True, timeout=120
        )
    except (OSError, subprocess.SubprocessError) as error:
        print(f"skipped: {PACKAGE} cannot be installed ({error})")
        sys.exit(0)
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
    """A controller, and the sender."""

    def __init__(self, program: str):
        arguments = [program, "controller", "--protocol", "grbl", "--speed", str(SPEED)]
        self.controller = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
        first = self.controller.stdout.readline()
        self.port = first.removeprefix("port:").strip()
        # What else it says must not fill the pipe.
        threading.Thread(target=self.controller.stdout.read, daemon=True).start()
        self.seen: dict[str, int] = {}
        self.errors: list[tuple] = []
        self.mode, self.place = "", (0.0, 0.0, 0.0)

    def hear(self, event: str, *data) -> None:
        self.seen[event] = self.seen.get(event, 0) + 1
        if event in ("on_error", "on_alarm"):
            self.errors.append(data)
        if event == "on_stateupdate":
            self.mode, self.place = data[0], data[1]

    def wait(self, what: str, condition) -> None:
        began = time.monotonic()
        while not condition():
            if time.monotonic() - began > PATIENCE:
                raise SystemExit(f"{what} does not come: {self.mode} at {self.place}, {self.seen}, {self.errors}")
            time.sleep(0.02)

    def rests(self) -> bool:
        return self.mode == "Idle"

    def stands(self, *place: float) -> bool:
        return self.rests() and all(abs(a - b) < 1e-6 for a, b in zip(self.place, place))


def main() -> None:
    program = pathlib.Path(sys.argv[1]).absolute()
    lines = int(sys.argv[2]) if len(sys.argv) > 2 else 2000
    if "--inside" not in sys.argv:
        python = environment(program)
        sys.exit(subprocess.run([str(python), __file__, str(program), str(lines), "--inside"]).returncode)
    from grbl_streamer import GrblStreamer

    talk = Talk(str(program))
    try:
        grbl = GrblStreamer(talk.hear)
        grbl.poll_interval = 0.1
        grbl.cnect(talk.port, 115200)
        talk.wait("the banner", lambda: "on_boot" in talk.seen)
        grbl.poll_start()
        talk.wait("a report", talk.rests)
        talk.wait("the parameters", lambda: "on_hash_stateupdate" in talk.seen)

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
        talk.controller.terminate()
    print(f"grbl-streamer: jog, {lines} lines in {taken:.1f} s at {SPEED} times the clock, hold, start, reset: good")
    # Threads of the sender may wait for a port that is gone.
    sys.stdout.flush()
    import os

    os._exit(0)


if __name__ == "__main__":
    main()
