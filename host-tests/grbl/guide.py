#!/usr/bin/env python3
"""Does what docs/first-axis.md says, with `splineway controller` in place of a board.

    host-tests/grbl/guide.py PROGRAM

Every command of the page is sent in its order, and must be answered with ok; in the end the axes must stand where homing leaves them.
"""

import pathlib
import re
import socket
import subprocess
import sys
import time

PAGE = pathlib.Path(__file__).absolute().parents[2] / "docs" / "first-axis.md"
SPEED = "20"
SWITCHES = ("X<-8", "Y<-8", "Z>5")
# $27 off their switches, which are at the end of the travel of $130 and of its default.
HOME = "MPos:-298.000,-498.000,-2.000"


def commands(text: str) -> list[str]:
    """Lines of the blocks marked as text, up to their remarks, and what stands in the text as a command."""
    found = []
    for block, code in re.findall(r"```text\n(.*?)```|`(\$J=[^`]*|\$H[XYZ]?|\$\d+=\d+|G10 [^`]*)`", text, re.DOTALL):
        found += [re.split(r"\s{2,}", line)[0] for line in block.splitlines()] if block else [code]
    return found


def answer(line: socket.socket, until: str) -> str:
    """What comes until a word."""
    heard = ""
    began = time.monotonic()
    while until not in heard:
        if time.monotonic() - began > 30:
            raise SystemExit(f"'{until}' does not come: {heard!r}")
        heard += line.recv(4096).decode()
    return heard


def wait_for_idle(line: socket.socket, command: str) -> str:
    """As one does who looks at the axis: the report when it rests."""
    report = ""
    began = time.monotonic()
    while "<Idle" not in report:
        if time.monotonic() - began > 60:
            raise SystemExit(f"{command}: the machine does not come to rest, {report}")
        line.sendall(b"?")
        report = answer(line, ">")
    return report


def main() -> None:
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    options = [word for place in SWITCHES for word in ("--switch", place)]
    controller = subprocess.Popen(
        [sys.argv[1], "controller", "--protocol", "grbl", "--tcp", "0", "--speed", SPEED, *options],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        port = int(re.search(r"(\d+)\s*$", controller.stdout.readline()).group(1))
        with socket.create_connection(("127.0.0.1", port), timeout=30) as line:
            line.sendall(b"\x18")
            answer(line, "Grbl 1.1")
            # It greets who comes, and once more behind the reset.
            wait_for_idle(line, "reset")
            sent = commands(PAGE.read_text())
            for command in sent:
                line.sendall(command.encode() + b"\n")
                heard = answer(line, "\r\n")
                while not re.search(r"^(ok|error|ALARM)", heard, re.MULTILINE):
                    heard += answer(line, "\r\n")
                if not re.search(r"^ok", heard, re.MULTILINE):
                    raise SystemExit(f"{command}: {heard.strip()}")
                report = wait_for_idle(line, command)
    finally:
        controller.kill()
    if HOME not in report:
        raise SystemExit(f"after {sent}: {report}")
    if len(sent) < 12:
        raise SystemExit(f"the page has only {sent}")
    print(f"{len(sent)} commands of {PAGE.name} taken, at last {report.strip()}")


if __name__ == "__main__":
    main()
