#!/usr/bin/env python3
"""Lets CNCjs, a sender that others wrote, run a machine from its page in a browser.

    host-tests/grbl/cncjs.py PROGRAM

PROGRAM is the built `splineway`, whose `controller --protocol grbl` is opened, homed, jogged, given a file, held, resumed, stopped and run
to the end by clicks on the page (`cncjs.js`). Screenshots lie in `target/cncjs` afterwards. The server and what drives the browser are
installed there from npm; where they cannot be, or there is no chromium or udevadm, this says so and ends well.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys

from homing import JOB, Controller, free_port, skipped

ROOT = pathlib.Path(__file__).absolute().parents[2]
FOLDER = ROOT / "target" / "cncjs"
PACKAGES = ["cncjs@1.11.5", "puppeteer-core@24.43.1"]
BROWSERS = ["chromium", "chromium-browser", "google-chrome"]
PATIENCE = 300


def installed() -> pathlib.Path:
    """The server, and the browser that opens its page."""
    if not shutil.which("node") or not shutil.which("npm"):
        skipped("CNCjs needs node and npm")
    if not shutil.which("udevadm"):
        skipped("CNCjs lists no port without udevadm")
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


def main() -> None:
    browser = installed()
    controller, server = Controller(sys.argv[1], FOLDER / "controller.log"), None
    port = controller.port
    try:
        (FOLDER / "job.nc").write_text("\n".join(JOB))
        web = free_port()
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
