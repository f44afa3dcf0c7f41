#!/usr/bin/env python3
"""The controller of `firmware/mps2` in double precision on a Cortex-M7 that QEMU emulates (mps2-an500): jogged, and a rose is run.

    host-tests/grbl/emulated_m7.py IMAGE

Every line must be answered with ok, and the axes must stand at the end of the program. It says nothing of times: QEMU's M7 has no caches, and
issues one instruction at a time.
"""

import math
import socket
import subprocess
import sys
import time

QEMU = "qemu-system-arm -M mps2-an500 -icount shift=3 -nographic -monitor none".split()
LINES = 60
PATIENCE = 120


class Line:
    """The sender's end of the line."""

    def __init__(self, port: int):
        began = time.monotonic()
        while True:
            try:
                self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
                break
            except OSError:
                if time.monotonic() - began > 10:
                    raise SystemExit("QEMU does not open its line")
                time.sleep(0.1)
        self.heard = b""

    def send(self, text: bytes) -> None:
        self.socket.sendall(text)

    def until(self, word: bytes) -> str:
        """What comes, with a word at its end."""
        while word not in self.heard:
            more = self.socket.recv(4096)
            if not more:
                raise SystemExit(f"{word} does not come: {self.heard}")
            self.heard += more
        text, self.heard = self.heard.split(word, 1)
        return text.decode()

    def run(self, blocks: list[str]) -> str:
        """Lines that are taken, and the report when the machine rests."""
        for block in blocks:
            self.send(block.encode() + b"\n")
            # What a report leaves of its line is empty.
            while not (answer := self.until(b"\n").strip()):
                pass
            if answer != "ok":
                raise SystemExit(f"{block}: {answer}")
        began, report = time.monotonic(), ""
        while "<Idle" not in report:
            if time.monotonic() - began > PATIENCE:
                raise SystemExit(f"the machine does not come to rest: {report}")
            self.send(b"?")
            report = self.until(b">")
        return report


def main() -> None:
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    serial = f"tcp:127.0.0.1:{port},server=on,wait=on,nodelay=on"
    board = subprocess.Popen(
        [*QEMU, "-serial", serial, *["-serial", "null"] * 3, "-kernel", sys.argv[1]],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        line = Line(port)
        line.until(b"Grbl 1.1h")
        line.until(b"\n")
        text = []
        for k in range(LINES):
            angle = 2 * math.pi * k / (LINES - 1)
            radius = 10 * math.cos(3 * angle)
            text.append(f"G1 X{radius * math.cos(angle):.3f} Y{radius * math.sin(angle):.3f} F3000")
        line.run(["$J=G91 X5 F1200"])
        report = line.run([*text, "G0 X1.5 Y-2.5 Z3"])
        if "MPos:1.500,-2.500,3.000" not in report:
            raise SystemExit(f"it stands elsewhere: {report}")
        print(f"a jog and {len(text) + 1} lines in double precision on an emulated Cortex-M7, at last {report.strip()}>")
    finally:
        board.kill()


if __name__ == "__main__":
    main()
