#!/usr/bin/env python3
"""Lets bCNC, a sender that others wrote, run a machine.

    host-tests/grbl/bcnc.py PROGRAM

PROGRAM is the built `splineway`, whose `controller --protocol grbl` is opened, homed, jogged, given a file, held, resumed, run to the end
and stopped, by the commands of bCNC's pendant, while its window is on a display that nobody sees. A picture of the window lies in
`target/bcnc`. The sender is installed there from PyPI; where it cannot be, or there is no Xvfb or tkinter, this says so and ends well.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import time
import urllib.parse
import urllib.request

from homing import HOME, JOB, Controller, free_port, skipped

FOLDER = pathlib.Path(__file__).absolute().parents[2] / "target" / "bcnc"
PACKAGE = "bCNC==0.9.16"
PATIENCE = 90


def installed() -> pathlib.Path:
    """A Python with tkinter and the sender in it."""
    if not shutil.which("Xvfb"):
        skipped("bCNC needs Xvfb")
    pythons = [path for path in ("/usr/bin/python3", sys.executable) if os.path.exists(path)]
    has_tk = lambda python: subprocess.run([python, "-c", "import tkinter"], capture_output=True).returncode == 0
    python = next(filter(has_tk, pythons), None)
    if python is None:
        skipped("bCNC needs tkinter")
    own = FOLDER / "venv" / "bin" / "python"
    try:
        if not own.exists():
            subprocess.run([python, "-m", "venv", str(FOLDER / "venv")], check=True, capture_output=True)
        install = [str(own), "-m", "pip", "install", "--quiet", PACKAGE]
        subprocess.run(install, check=True, capture_output=True, timeout=300)
    except (OSError, subprocess.SubprocessError) as error:
        skipped(f"bCNC cannot be installed ({error})")
    return own


class Machine:
    """What the controller says of itself, and the sender's pendant."""

    def __init__(self, web: int):
        self.web = f"http://127.0.0.1:{web}"

    def ask(self, page: str) -> bytes:
        with urllib.request.urlopen(f"{self.web}/{page}", timeout=10) as answer:
            return answer.read()

    def send(self, **what: str) -> None:
        self.ask("send?" + urllib.parse.urlencode(what))

    def shown(self) -> tuple[str, tuple[float, float, float]]:
        try:
            state = json.loads(self.ask("state"))
        except OSError:
            return "", (float("nan"),) * 3
        return state["state"], tuple(float(state[axis]) for axis in ("mx", "my", "mz"))

    def until(self, what: str, holds):
        began = time.monotonic()
        while True:
            state, place = self.shown()
            if holds(state, place):
                print(f"{what}: {state} at {place}", flush=True)
                return place
            if time.monotonic() - began > PATIENCE:
                raise SystemExit(f"{what} does not come: {state} at {place}")
            time.sleep(0.1)


def near(place, goal) -> bool:
    return all(abs(a - b) < 0.0015 for a, b in zip(place, goal))


def drive(machine: Machine, job: pathlib.Path, picture) -> None:
    # The handshake: banner, parser state, parameters, then reports.
    machine.until("connected", lambda state, _: state.startswith(("Idle", "Alarm")))
    machine.send(cmd="HOME")
    machine.until("homed", lambda state, place: state == "Idle" and near(place, HOME))
    machine.send(gcode="$J=G91 X-3 F1000")
    jogged = (HOME[0] - 3, *HOME[1:])
    machine.until("jogged", lambda state, place: state == "Idle" and near(place, jogged))
    # Work zero is here.
    machine.send(gcode="G10 L20 P1 X0 Y0 Z0")
    machine.send(cmd=f"LOAD {job}")
    time.sleep(2)
    machine.send(cmd="RUN")
    machine.until("runs", lambda state, place: state.startswith("Run") and place[1] > 0)
    machine.send(cmd="FEEDHOLD")
    held = machine.until("holds", lambda state, _: state == "Hold:0")
    time.sleep(1)
    if not near(machine.shown()[1], held):
        raise SystemExit("it moves in a hold")
    picture()
    machine.send(cmd="RESUME")
    machine.until("resumed", lambda state, place: state.startswith("Run") and not near(place, held))
    machine.until("ended", lambda state, place: state == "Idle" and near(place, jogged))
    time.sleep(2)
    machine.send(cmd="RUN")
    machine.until("runs again", lambda state, place: state.startswith("Run") and place[1] > 0)
    machine.send(cmd="STOP")
    machine.until("stopped", lambda state, _: state.startswith(("Idle", "Alarm", "Hold:0")))
    time.sleep(1)
    rest = machine.shown()[1]
    time.sleep(1.5)
    if not near(machine.shown()[1], rest):
        raise SystemExit("it moves after a stop")
    # It resets once more when its job has ended, whatever has been sent meanwhile.
    for _ in range(10):
        machine.send(cmd="UNLOCK")
        time.sleep(1)
        machine.send(gcode="$J=G53 G90 X-5 Y-2 F1000")
        time.sleep(3)
        if near(machine.shown()[1], jogged):
            break
    machine.until("back", lambda state, place: state == "Idle" and near(place, jogged))


def main() -> None:
    python = installed()
    processes = []

    def started(*command, **how) -> subprocess.Popen:
        processes.append(subprocess.Popen(command, **how))
        return processes[-1]

    try:
        processes.append(controller := Controller(sys.argv[1], FOLDER / "controller.log"))
        web = free_port()
        ini = FOLDER / "bCNC.ini"
        ini.write_text(
            f"[Connection]\nport = {controller.port}\nbaud = 115200\ncontroller = GRBL1\nopenserial = 1\npendant = 1\npendantport = {web}\n"
            "[bCNC]\ncheckdates = 0\n[Warning]\nstop = 0\n"
        )
        job = FOLDER / "job.ngc"
        job.write_text("\n".join(JOB))
        seen, shows = os.pipe()
        started("Xvfb", "-displayfd", str(shows), "-screen", "0", "1400x1000x24", pass_fds=[shows], stderr=subprocess.DEVNULL)
        display = ":" + os.read(seen, 16).decode().strip()
        environment = {**os.environ, "DISPLAY": display, "HOME": str(FOLDER)}
        log = open(FOLDER / "bcnc.log", "w")
        started(str(python), "-m", "bCNC", "-i", str(ini), cwd=FOLDER, env=environment, stdout=log, stderr=log)

        def picture() -> None:
            if shutil.which("scrot"):
                subprocess.run(["scrot", "--overwrite", str(FOLDER / "held.png")], env=environment, check=False)

        drive(Machine(web), job, picture)
        print("bCNC: done")
    finally:
        for process in reversed(processes):
            process.kill()


if __name__ == "__main__":
    main()
