// The page's scripts as a module: those that know numbers alone.

import { readFileSync } from "node:fs";
import vm from "node:vm";

const FOLDER = new URL("../../src/view/page/", import.meta.url);
const PURE = ["text", "decode", "run", "kinematics", "envelope", "outline", "colour", "camera", "overlay"];

/** All that they define. */
export function scripts() {
  const text = PURE.map(name => readFileSync(new URL(`${name}.js`, FOLDER), "utf8")).join("");
  const names = [...text.matchAll(/^(?:async )?(?:function|class|const) ([A-Za-z]\w*)/gm)].map(found => found[1]);
  const listed = ["POSITION", "VELOCITY", "ACCELERATION", "JERK", "NOTHING", "FEED", "AXIS_VELOCITY", "AXIS_ACCELERATION", "AXIS_JERK", "REST"];
  return vm.runInThisContext(`(() => { "use strict"; ${text}; return { ${[...new Set([...names, ...listed])].join(", ")} }; })()`);
}

/** What is between the tags of a part of a page. */
export function part(page, id) {
  const found = page.match(new RegExp(`<script type="[^"]*" id="${id}">([^<]*)</script>`));
  if (!found) throw new Error(`the page has no ${id}`);
  return found[1];
}

/** A page as its own scripts read it. */
export async function open(path) {
  const s = scripts(), page = readFileSync(path, "utf8"), head = JSON.parse(part(page, "head"));
  const columns = s.columnsOf(head, await s.unpack(part(page, "body")));
  const source = new TextDecoder().decode(await s.unpack(part(page, "source")));
  return { ...s, head, columns, source, page };
}

/** Rows of a CSV file of numbers, without its head. */
export function rows(path) {
  return readFileSync(path, "utf8").trim().split("\n").slice(1).map(line => line.split(",").map(Number));
}
