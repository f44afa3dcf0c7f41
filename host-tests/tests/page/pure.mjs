// Functions of the page that need no page.

import assert from "node:assert/strict";
import test from "node:test";
import { scripts } from "./load.mjs";

const s = scripts();
const near = (a, b, off = 1e-9) => assert.ok(Math.abs(a - b) <= off, `${a} is not ${b}`);

test("times are h:m:s", () => {
  const cases = [[0, "0.000 s"], [59.9994, "59.999 s"], [59.9996, "0:01:00.000"], [61.5, "0:01:01.500"], [3599.9999, "1:00:00.000"],
    [7322.25, "2:02:02.250"], [-75, "-0:01:15.000"], [NaN, "-"]];
  for (const [seconds, text] of cases) assert.equal(s.hms(seconds), text);
  assert.equal(s.hms(3661, 0), "1:01:01");
  assert.equal(s.timeLabel(90, 30), "0:01:30");
  assert.equal(s.timeLabel(0.25, 0.05), "0.25 s");
  assert.equal(s.timeLabel(75.25, 0.05), "0:01:15.25");
});

test("a speed is told over the feed", () => {
  assert.equal(s.speedOf(12.345, 50), "12.3 / 50");
  assert.equal(s.speedOf(0, 50), "0 / 50");
  assert.equal(s.speedOf(0, 0), "0 / -");
});

test("ticks are even and inside", () => {
  for (const [low, high] of [[0, 1], [-3, 1e5], [0.123, 0.124], [-1e-4, 2e-4]]) {
    const all = s.ticks(low, high, 6), step = all[1] - all[0];
    assert.ok(all.length >= 3 && all.length <= 14, `${low} ${high}: ${all}`);
    for (const x of all) { assert.ok(x >= low - step * 1e-6 && x <= high + step * 1e-6); near(x / step, Math.round(x / step), 1e-6); }
  }
  assert.deepEqual([...s.ticks(1, 1, 5)], []);
  assert.deepEqual([...s.timeTicks(0, 600, 10)], [0, 60, 120, 180, 240, 300, 360, 420, 480, 540, 600]);
});

test("a peak between the places that are looked at is seen, and no more than was run", () => {
  const wave = k => 3 + Math.sin(k * 0.9 + 0.5), [low, high] = s.leastAndMost(wave, 8, [-Infinity, Infinity]);
  near(low, 2, 0.02); near(high, 4, 0.02);
  const parabola = s.leastAndMost(k => 5 - (k - 2.4) ** 2, 4, [-Infinity, Infinity]);
  near(parabola[1], 5); near(parabola[0], 5 - 2.4 ** 2);
  assert.deepEqual([...s.leastAndMost(k => 5 - (k - 2.4) ** 2, 4, [0, 4.9])], [5 - 2.4 ** 2, 4.9]);
  assert.deepEqual([...s.leastAndMost(k => 2 - k, 3, [-9, 9])], [-1, 2]);
  assert.deepEqual([...s.leastAndMost(() => 7, 0, [-9, 9])], [7, 7]);
});

test("numbers of seven bits a byte", () => {
  const read = new s.Numbers(Uint8Array.from([0, 1, 2, 126, 0x80, 0x01, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x0f]));
  assert.deepEqual([0, 1, 2, 3].map(() => read.number()), [0, -1, 1, 63]);
  assert.equal(read.count(), 128);
  assert.equal(read.count(), 2 ** 53 - 1);
  assert.ok(read.done);
});

test("the plan has X to the right and Y up, and zoom keeps the place under the pointer", () => {
  const plan = Object.assign(new s.PlanCamera(), { w: 400, h: 300 });
  plan.fit([[0, 10], [0, 5], [0, 1]]);
  const at = (...p) => plan.at(...p);
  assert.ok(at(10, 0, 0)[0] > at(0, 0, 0)[0] && at(0, 5, 0)[1] < at(0, 0, 0)[1]);
  for (const factor of [1.7, 0.2, 30]) {
    const [px, py] = at(7, 4, 0);
    plan.zoom(px, py, factor);
    near(at(7, 4, 0)[0], px, 1e-6); near(at(7, 4, 0)[1], py, 1e-6);
  }
});

test("space is right-handed with Z up, wherever it is seen from", () => {
  const space = Object.assign(new s.SpaceCamera(), { w: 500, h: 400 });
  for (let k = 0; k < 40; k++) {
    const [right, up] = space.rows, towards = space.towards;
    const dot = (a, b) => a.reduce((sum, x, n) => sum + x * b[n], 0);
    near(dot(right, right), 1); near(dot(up, up), 1); near(dot(right, up), 0);
    // X, Y and Z as they are seen keep their order: right x up is towards the eye, and X x Y is Z in that frame.
    const columns = [0, 1, 2].map(n => [right[n], up[n], towards[n]]);
    const [x, y, z] = columns, cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    cross.forEach((c, n) => near(c, z[n]));
    near(right[2], 0);
    assert.ok(up[2] >= -1e-12, "Z is never down");
    space.turn(37, k % 3 ? 11 : -29);
  }
  // From the front, slightly from above: X to the right, Y away, Z up.
  Object.assign(space, { yaw: 0, pitch: 0.3 });
  assert.ok(space.rows[0][0] > 0.99 && space.rows[1][2] > 0.9 && space.rows[1][1] > 0 && space.towards[1] < 0);
});

test("a camera shows the same after it was given another size", () => {
  for (const camera of [new s.PlanCamera(), new s.SpaceCamera()]) {
    Object.assign(camera, { w: 800, h: 400 });
    camera.fit([[0, 100], [0, 50], [-3, 0]]);
    camera.zoom(100, 100, 5);
    const { centre, perMm } = camera;
    camera.resize(400, 200);
    near(camera.perMm, perMm / 2);
    assert.deepEqual(camera.centre, centre);
    camera.resize(800, 400);
    near(camera.perMm, perMm);
  }
});

test("the nearest point, and of several passes the one that is on", () => {
  const xs = Float32Array.from([0, 10, 20, 10, 0]), ys = new Float32Array(5);
  assert.equal(s.nearest(xs, ys, 5, 11, 1, 14, 0), 1);
  assert.equal(s.nearest(xs, ys, 5, 11, 1, 14, 4), 3);
  assert.equal(s.nearest(xs, ys, 5, 11, 40, 14, 0), -1);
  assert.equal(s.nearest(xs, ys, 0, 0, 0, 14, 0), -1);
});

test("the last place that is not beyond", () => {
  const all = Float64Array.from([0, 2, 5, 9]);
  assert.deepEqual([-1, 0, 1.9, 2, 8, 9, 99].map(x => s.lastAt(all, x)), [0, 0, 0, 1, 2, 3, 3]);
});

test("ramps have colours of their own at their ends", () => {
  for (const theme of ["light", "dark"]) for (const mode of ["share", "speed", "deviation", "binds"]) {
    const palette = s.paletteOf(mode, theme);
    assert.equal(palette.length, mode === "binds" ? s.BINDS.length : s.STEPS + 2);
    assert.equal(new Set(palette).size, palette.length, `${theme} ${mode}`);
  }
});

test("stretches by their level, each once", () => {
  const lists = s.byLevel(Uint8Array.from([1, 0, 1, 3]), 4);
  assert.deepEqual(lists.map(list => [...list]), [[1], [0, 2], [], [3]]);
});
