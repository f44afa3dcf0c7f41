#!/usr/bin/env python3
"""Runs every command that README and docs show in a block of kind `sh`, as a reader would type it.

    commands.py [--list] [WORD]

A block that begins with ```sh board needs a board, and is not run. Every other line is run as it stands, in the root of the
repository, with the installed `splineway` - but for those of INSTEAD, which take long or need a file, and are run in another
form, those of FOREVER, which must come up and be ended, and those of ELSEWHERE, which .ci/run runs itself. So a command that is
new is run, and fails if it does not work. --list says what would be done; WORD: only commands that contain it.
"""
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
INSTALLED = ROOT / "target" / "installed"

# Of a command the form in which it is run here.
INSTEAD = {
    "cargo install --path host-tests --locked":
        "cargo install --path host-tests --locked --root target/installed",
    "splineway simulate part.ngc --open": "splineway simulate host-tests/data/square.ngc --open",
    "splineway limit FILE ...": "splineway limit host-tests/data/zigzag.txt --rounds 2",
    "splineway reshape FILE ...": "splineway reshape host-tests/data/zigzag.txt",
    "cargo run --release -p splineway-host --example paths -- FOLDER":
        "cargo run --release -p splineway-host --example paths -- SCRATCH/paths 1000000",
    # Ten minutes with all paths of the table.
    "cargo run --release -p splineway-host --example others -- --plot others.html FILE ...":
        "cargo run --release -p splineway-host --example others -- --plot others.html host-tests/data/zigzag.txt",
    # Ten minutes and more with all paths.
    "cargo bench -p splineway-host --bench reference -- FOLDER":
        "mkdir -p SCRATCH/few && cp SCRATCH/paths/star_0.05.txt SCRATCH/few && "
        "cargo bench -p splineway-host --bench reference -- SCRATCH/few",
    # The folder is a filter of times, too: none are taken.
    "cargo bench -p splineway-host --bench cost -- FOLDER":
        "mkdir -p SCRATCH/few && cp SCRATCH/paths/star_0.05.txt SCRATCH/few && "
        "cargo bench -p splineway-host --bench cost -- SCRATCH/few",
    # As the tests are built anyway.
    "cargo test --release -p splineway-host --test runs feed -- --nocapture":
        "cargo test --workspace --test runs feed -- --nocapture",
}

# Commands that go on until they are ended, and what they say when they have come up.
FOREVER = {
    "splineway controller --protocol grbl": "port: ",
    "splineway controller --protocol grbl --tcp 8899": "port: ",
    "firmware/mps2/run.sh": "char device redirected",
}

# Commands that .ci/run runs, by a line of it.
ELSEWHERE = {
    "cargo test --workspace": "cargo test --workspace",
    "cargo bench -p splineway-host --bench paths": "cargo bench --package splineway-host --bench paths",
    "cargo bench -p splineway-host --bench target -- FOLDER":
        "cargo bench --package splineway-host --bench target",
    "cargo bench -p splineway-host --bench realtime -- FOLDER":
        "cargo bench --package splineway-host --bench realtime --locked -- --check",
    "cargo bench -p splineway-host --bench board -- --check":
        "cargo bench --package splineway-host --bench board --locked -- --check",
    "cargo bench -p splineway-host --bench board -- FILE [--feed F] [--lines N] [--tolerance T] [--client grbl-streamer]":
        "cargo bench --package splineway-host --bench board --locked -- --check",
    "cargo bench -p splineway-host --bench board -- tball-pocket.gcode --feed 30 --tolerance 0.05 --client grbl-streamer":
        "cargo bench --package splineway-host --bench board --locked -- --check",
    # For whatever toolchain there is for the target, or can be had.
    "rustup target add thumbv7em-none-eabihf": ".ci/thumb.sh build --release --package splineway --locked",
    # There with the flags of a Cortex-M7.
    "cargo build --profile firmware -p splineway-stm32h743 --features f64 --target thumbv7em-none-eabihf":
        "image stm32h743 --features f64",
    # There with folders of its own.
    "cmake -S splineway -B build -DSPLINEWAY_CONFIG=$PWD/splineway_config.h -DCMAKE_TOOLCHAIN_FILE=$PWD/arm.cmake -DCMAKE_INSTALL_PREFIX=$PWD/motion":
        "SPLINEWAY_REQUIRE_TARGET=1 .ci/c.sh",
    "cmake --build build && cmake --install build": "SPLINEWAY_REQUIRE_TARGET=1 .ci/c.sh",
    "cc main.c $(PKG_CONFIG_PATH=motion/lib/pkgconfig pkg-config --cflags --libs splineway)":
        "SPLINEWAY_REQUIRE_TARGET=1 .ci/c.sh",
}

# The longest that one may take, s.
LONGEST = 900


def fail(words):
    print(f"commands.py: {words}", flush=True)
    sys.exit(1)


def blocks():
    """Page, number of the line, marks of the block, command."""
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        kind, joined = None, ""
        for number, line in enumerate(page.read_text().splitlines(), 1):
            if line.startswith("```"):
                words = line[3:].split()
                kind = None if kind is not None else words or ["text"]
            elif kind and kind[0] in ("sh", "bash", "shell", "console"):
                text = joined + line.split("  #")[0].strip()
                if text.endswith("\\"):
                    joined = text[:-1]
                    continue
                joined = ""
                if text and not text.startswith("#"):
                    yield page.relative_to(ROOT), number, kind[1:], text
        if kind is not None:
            fail(f"{page.name}: a block has no end")


def form(command, scratch):
    """What is run for a command."""
    if "thumbv7em-none-eabihf" in command and "cargo " in command:
        # Whatever toolchain there is for the target.
        command = command.replace("--target thumbv7em-none-eabihf", "")
        return command.replace("cargo ", ".ci/thumb.sh ", 1)
    command = INSTEAD.get(command, command)
    # Pictures of the documents stay as they are.
    command = command.replace("-- docs/", "-- SCRATCH/docs/").replace(" docs/", " SCRATCH/docs/")
    for option in ("--plot ", "--report ", "--setpoints ", "--out "):
        command = command.replace(option, option + "SCRATCH/")
    return command.replace(" > ", " > SCRATCH/").replace("SCRATCH", scratch)


def environment(scratch):
    """What a user has, and an opener of pages that only notes what it is to open."""
    tools = Path(scratch) / "tools"
    tools.mkdir()
    opener = tools / "xdg-open"
    opener.write_text(f'#!/bin/sh\necho "opened $1"\ntest -s "$1" && echo "$1" >> {scratch}/opened\n')
    opener.chmod(0o755)
    (Path(scratch) / "docs").mkdir()
    path = f"{tools}:{INSTALLED}/bin:{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "TMPDIR": scratch, "DEFMT_LOG": "info"}


def comes(file):
    """Whether a file is there soon: who opens a page does not wait for it."""
    for _ in range(200):
        if file.exists():
            return True
        time.sleep(0.1)
    return False


def forever(command, sign, env):
    """Runs a command until it has said a word."""
    process = subprocess.Popen(
        ["bash", "-c", "exec " + command], cwd=ROOT, env=env, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
    said = ""
    try:
        for line in process.stdout:
            said += line
            if sign in line:
                return True, said
        return False, said
    finally:
        os.killpg(process.pid, 15)
        process.wait()


def run(command, env, scratch):
    if command in FOREVER:
        return forever(form(command, scratch), FOREVER[command], env)
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", form(command, scratch)], cwd=ROOT, env=env, text=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=LONGEST)
    return done.returncode == 0, done.stdout


def main():
    words = [word for word in sys.argv[1:] if word != "--list"]
    listing = "--list" in sys.argv
    known = {*INSTEAD, *FOREVER, *ELSEWHERE}
    seen, script = {}, (ROOT / ".ci" / "run").read_text()
    for page, number, marks, command in blocks():
        if set(marks) - {"board"}:
            fail(f"{page}:{number}: {marks} is no mark; a block is `sh`, or `sh board` if it needs one")
        known.discard(command)
        seen.setdefault(command, (f"{page}:{number}", "board" in marks))
    if known:
        fail(f"no page has these any more: {sorted(known)}")
    scratch = tempfile.mkdtemp(prefix="splineway-commands-")
    env = environment(scratch) if not listing else None
    ran = boards = elsewhere = 0
    # What installs and what writes the paths comes first.
    order = sorted(seen, key=lambda command: ("install" not in command, "--example paths" not in command))
    for command in order:
        place, board = seen[command]
        if not all(word in command for word in words):
            continue
        if board:
            boards += 1
            how = "needs a board"
        elif command in ELSEWHERE:
            if ELSEWHERE[command] not in script:
                fail(f"{place}: .ci/run has no `{ELSEWHERE[command]}` for `{command}`")
            elsewhere += 1
            how = f".ci/run: {ELSEWHERE[command]}"
        else:
            how = form(command, "SCRATCH")
        print(f"{place}: {command}" + (f"\n    {how}" if how != command else ""), flush=True)
        if listing or board or command in ELSEWHERE:
            continue
        fine, said = run(command, env, scratch)
        if not fine:
            fail(f"{place}: this did not work: {command}\n{said[-4000:]}")
        if "--open" in command and not comes(Path(scratch, "opened")):
            fail(f"{place}: {command}: nothing was opened\n{said}")
        ran += 1
    shutil.rmtree(scratch, ignore_errors=True)
    print(f"{ran} commands run, {elsewhere} by .ci/run, {boards} need a board")


main()
