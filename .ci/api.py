#!/usr/bin/env python3
"""The public interface of every crate that is published, a line for each item, held against what is written down in .ci/api.

    api.py [--update]

A line that goes or changes breaks somebody's program: it is a new minor version before 1.0, and a new major one after, and it belongs
in CHANGELOG under Changed or Removed. A line that comes is an addition. Either way the commit shows it: --update writes the lists.
Lists are made from what rustdoc says of a crate with all its features. Its output is not stable, so another compiler than the one that
is named in a list is not asked.
"""
import difflib
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FORMAT = 57  # of rustdoc's output: rustc 1.93 to 1.95
CRATES = {
    "splineway": "c,defmt,gcode,grbl,home,jog,kinematics,limits,nurbs,outputs,probe,reshape,shaping,travel,wire",
    "splineway-splines": "defmt",
    "splineway-controller": "grbl",
}


def described(crate, features):
    command = ["cargo", "rustdoc", "--quiet", "--locked", "--package", crate, "--lib", "--features",
               features, "--", "-Z", "unstable-options", "--output-format", "json"]
    env = {**os.environ, "RUSTC_BOOTSTRAP": "1", "CARGO_TARGET_DIR": str(ROOT / "target" / "api")}
    subprocess.run(command, cwd=ROOT, env=env, check=True)
    return json.loads((ROOT / "target" / "api" / "doc" / f"{crate.replace('-', '_')}.json").read_text())


class Listing:
    def __init__(self, data):
        self.index, self.lines, self.sources = data["index"], set(), {}
        root = self.item(data["root"])
        self.module(root, root["name"], set())

    def item(self, number):
        return self.index.get(str(number))

    def text(self, item):
        """An item as it stands in its source, in one line, without its body."""
        span = item["span"]
        if span is None:
            return item["name"] or ""
        lines = self.sources.setdefault(span["filename"], (ROOT / span["filename"]).read_text().splitlines())
        (first, column), (last, end) = span["begin"], span["end"]
        part = lines[first - 1:last]
        part[-1] = part[-1][:end - 1]
        part[0] = part[0][column - 1:]
        words = " ".join(" ".join(line.split("//")[0].split()) for line in part)
        depth, out = 0, ""
        for k, letter in enumerate(words):
            if letter == "{" and depth == 0 or letter == ";" and depth == 0:
                break
            depth += (letter in "([") - (letter in ")]")
            out += letter
        return out.strip().replace("( ", "(").replace(", )", ")").removeprefix("pub ")

    def add(self, path, words):
        self.lines.add(f"{path}: {words}")

    def module(self, module, path, seen):
        if module["id"] in seen:
            return
        for number in module["inner"]["module"]["items"]:
            item = self.item(number)
            if item is not None:
                self.export(item, path, item["name"], seen | {module["id"]})

    def export(self, item, path, name, seen):
        (kind, inner), = item["inner"].items()
        if kind == "use":
            target = self.item(inner["id"]) if inner["id"] is not None else None
            if target is None or target["crate_id"] != 0:
                self.add(f"{path}::{inner['name']}", f"use {inner['source']}")
            elif inner["is_glob"]:
                (target_kind, target_inner), = target["inner"].items()
                members = target_inner.get("items") or target_inner.get("variants") or []
                for number in members:
                    member = self.item(number)
                    if member is not None:
                        self.export(member, path, member["name"], seen)
            else:
                self.export(target, path, inner["name"], seen)
            return
        here = f"{path}::{name}"
        if kind == "module":
            self.add(here, "module")
            self.module(item, here, seen)
            return
        marks = "non_exhaustive " if "non_exhaustive" in json.dumps(item["attrs"]) else ""
        words = self.text(item)
        if kind in ("struct", "union", "enum", "trait"):
            # A tuple's fields are told one by one.
            words = words.split("(")[0] if kind == "struct" else words
        if kind == "constant" or kind == "assoc_const":
            words = words.split(" = ")[0]
        self.add(here, marks + words)
        if kind == "struct":
            fields = inner["kind"]
            numbers = fields.get("plain", {}).get("fields", []) if isinstance(fields, dict) else []
            numbers = fields.get("tuple", numbers) if isinstance(fields, dict) else numbers
            for number in numbers:
                field = self.item(number) if number is not None else None
                if field is not None and field["visibility"] == "public":
                    self.add(f"{here}.{field['name']}", self.text(field).split(": ", 1)[-1])
        if kind == "enum":
            for number in inner["variants"]:
                variant = self.item(number)
                if variant is not None:
                    self.variant(here, variant)
        if kind == "trait":
            for number in inner["items"]:
                member = self.item(number)
                if member is not None:
                    self.add(f"{here}::{member['name']}", self.text(member))
        for number in inner.get("impls", []) if isinstance(inner, dict) else []:
            self.implementation(here, self.item(number))

    def variant(self, path, variant):
        here = f"{path}::{variant['name']}"
        fields = variant["inner"]["variant"]["kind"]
        self.add(here, "variant" if not isinstance(fields, dict) or "struct" in fields else self.text(variant))
        if isinstance(fields, dict) and "struct" in fields:
            for number in fields["struct"]["fields"]:
                field = self.item(number)
                if field is not None:
                    self.add(f"{here}.{field['name']}", self.text(field).split(": ", 1)[-1])

    def implementation(self, path, item):
        if item is None:
            return
        inner = item["inner"]["impl"]
        derived = inner["trait"] is not None and inner["trait"]["path"].endswith("StructuralPartialEq")
        if derived or inner["is_synthetic"] or inner["blanket_impl"] is not None:
            return
        if inner["trait"] is not None:
            # A derive's place is the derive itself.
            own = self.text(item)
            name = inner["trait"]["path"].split("::")[-1]
            self.add(path, own if own.startswith("impl") else f"impl {name}")
            return
        for number in inner["items"]:
            member = self.item(number)
            if member is not None and member["visibility"] == "public":
                words = self.text(member)
                words = words.split(" = ")[0] if "assoc_const" in member["inner"] else words
                self.add(f"{path}::{member['name']}", words)


def main():
    update, broken = "--update" in sys.argv, False
    for crate, features in CRATES.items():
        data = described(crate, features)
        if data["format_version"] != FORMAT:
            print(f"skipped: rustdoc's format is {data['format_version']}; lists are made from {FORMAT}")
            return
        lines = sorted(Listing(data).lines)
        path = ROOT / ".ci" / "api" / f"{crate}.txt"
        if update:
            path.parent.mkdir(exist_ok=True)
            path.write_text("\n".join(lines) + "\n")
        kept = path.read_text().splitlines() if path.exists() else []
        print(f"{crate}: {len(lines)} public items")
        for line in difflib.unified_diff(kept, lines, "as written down", "as it is", lineterm="", n=0):
            print(line)
            broken = True
    if broken:
        sys.exit("the public interface has changed: .ci/api.py --update, and a line in CHANGELOG")


main()
