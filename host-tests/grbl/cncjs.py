#!/usr/bin/env python3
"""Lets CNCjs, a sender that others wrote, run a machine from its page in a browser.

    host-tests/grbl/cncjs.py PROGRAM

PROGRAM is the built `splineway`, whose `controller --protocol grbl` is opened, homed, jogged, given a file, held, resumed, stopped and run
to the end by clicks on the page (`cncjs.js`). Screenshots lie in `target/cncjs` afterwards. The server and what drives the browser are
installed there from npm; where they cannot be, or there is no chromium, this says so and ends well.
"""

import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).absolute().parents[2]
FOLDER = ROOT / "target" / "cncjs"
PACKAGES = ["cncjs@1.11.5", "puppeteer-core@24.43.1"]
BROWSERS = ["chromium", "chromium-browser", "google-chrome"]
# Home switches at the upper ends; homing on, 2 mm off the switch, 3000 and 600 mm/min.
SWITCHES = ["X>12", "Y>9", "Z>5"]
SETTINGS = ["$22=1", "$27=2", "$25=3000", "$24=600"]
PATIENCE = 300


def skipped(why: str) -> None:
    print(f"skipped: {why}")
    sys.exit(0)


def installed() -> pathlib.Path:
    """The server, and the browser that opens its page."""
    if not shutil.which("node") or not shutil.which("npm"):
        skipped("CNCjs needs node and npm")
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        skipped("there is no chromium")
    FOLDER.mkdir(parents=True, exist_ok=True)
    try:
        if not (FOLDER / "node_modules" / "cncjs").exists():
            (FOLDER / "package.json").write_text('{"private": true}\n')
            install = ["npm", "install", "--no-audit", "--no-fund", "--silent", *PACKAGES]
            subprocess.run(install, cwd=FOLDER, check=True, capture_output=True, timeout=PATIENCE)
    except (OSError, subprocess.SubprocessError) as error:
        skipped(f"CNCjs cannot be installed ({error})")
    return pathlib.Path(browser)


def told(port: str, lines: list[str]) -> None:
    """Sends settings before the sender comes."""
    line = os.open(port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, ("\n".join(lines) + "\n").encode())
    heard, began = b"", time.monotonic()
    while heard.count(b"ok\r\n") < len(lines):
        heard += os.read(line, 4096)
        if b"error" in heard or time.monotonic() - began > 30:
            raise SystemExit(f"settings are not taken: {heard}")
    os.close(line)


def main() -> None:
    program = str(pathlib.Path(sys.argv[1]).absolute())
    browser = installed()
    switches = [word for place in SWITCHES for word in ("--switch", place)]
    controller = subprocess.Popen(
        [program, "controller", "--protocol", "grbl", *switches], stdout=subprocess.PIPE, text=True
    )
    server = None
    try:
        port = controller.stdout.readline().removeprefix("port:").strip()
        log = open(FOLDER / "controller.log", "w")
        subprocess.Popen(["cat"], stdin=controller.stdout, stdout=log)
        told(port, SETTINGS)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            web = free.getsockname()[1]
        home = FOLDER / "home"
        shutil.rmtree(home, ignore_errors=True)
        home.mkdir()
        known = {"ports": [{"path": port, "manufacturer": "splineway"}], "state": {"checkForUpdates": False}}
        (home / ".cncrc").write_text(json.dumps(known))
        cncjs = [FOLDER / "node_modules" / ".bin" / "cncjs", "-p", str(web), "-H", "127.0.0.1", "--controller", "Grbl"]
        server = subprocess.Popen(
            cncjs,
            env={**os.environ, "HOME": str(home)},
            stdout=open(FOLDER / "server.log", "w"),
            stderr=subprocess.STDOUT,
        )
        driver = ["node", str(ROOT / "host-tests" / "grbl" / "cncjs.js"), str(browser), str(web), port, str(FOLDER)]
        environment = {**os.environ, "NODE_PATH": str(FOLDER / "node_modules")}
        sys.exit(subprocess.run(driver, env=environment, timeout=PATIENCE).returncode)
    finally:
        for process in filter(None, (server, controller)):
            process.kill()


if __name__ == "__main__":
    main()
