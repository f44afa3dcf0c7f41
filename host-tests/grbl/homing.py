"""A controller with home switches, for senders that others wrote."""

import os
import pathlib
import socket
import subprocess
import sys
import time

# At the upper ends; homing on, 2 mm off the switch, 3000 and 600 mm/min.
SWITCHES = ["X>12", "Y>9", "Z>5"]
SETTINGS = ["$22=1", "$27=2", "$25=3000", "$24=600"]
# Where the axes stand then.
HOME = (-2.0, -2.0, -2.0)
# A circle and lines, back to the start.
JOB = ["G21 G90", "G1 X10 Y0 F1000", "G2 X20 Y10 I0 J10", "G1 X30 Y30", "G1 X0 Y30", "G1 X0 Y0", "M2", ""]


def skipped(why: str) -> None:
    print(f"skipped: {why}")
    sys.exit(0)


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


class Controller:
    """`splineway controller`; what it says goes into a file."""

    def __init__(self, program: str, log: pathlib.Path):
        switches = [word for place in SWITCHES for word in ("--switch", place)]
        command = [str(pathlib.Path(program).absolute()), "controller", "--protocol", "grbl", *switches]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.port = self.process.stdout.readline().removeprefix("port:").strip()
        self.reader = subprocess.Popen(["cat"], stdin=self.process.stdout, stdout=open(log, "w"))
        self.tell(SETTINGS)

    def tell(self, lines: list[str]) -> None:
        """Lines before a sender comes, which must be taken."""
        line = os.open(self.port, os.O_RDWR | os.O_NOCTTY)
        os.write(line, ("\n".join(lines) + "\n").encode())
        heard, began = b"", time.monotonic()
        while heard.count(b"ok\r\n") < len(lines):
            heard += os.read(line, 4096)
            if b"error" in heard or time.monotonic() - began > 30:
                raise SystemExit(f"settings are not taken: {heard}")
        os.close(line)

    def kill(self) -> None:
        self.process.kill()
        self.reader.kill()
