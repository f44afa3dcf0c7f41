// A page that was written, beside the setpoints of the same run: `node run.mjs PAGE CSV TOLERANCE`.

import assert from "node:assert/strict";
import test from "node:test";
import { open, rows } from "./load.mjs";

const [page, csv, tolerance] = process.argv.slice(2);
const s = await open(page), run = new s.Run(s.head, s.columns), setpoints = rows(csv), axes = run.axes.length;
const { POSITION, VELOCITY, ACCELERATION, JERK } = s;

test("every setpoint comes back within a tenth of the tolerance", () => {
  assert.equal(run.cycles + 1, setpoints.length);
  let worst = 0;
  setpoints.forEach((row, k) => {
    const at = run.position(k);
    assert.equal(at.length, axes);
    worst = Math.max(worst, Math.hypot(...at.map((x, n) => x - row[n + 1])));
  });
  assert.ok(worst <= Math.max(0.1 * tolerance, 1.1e-6), `${worst} mm`);
  assert.ok(worst <= s.head.off, `${worst} mm, and the page says ${s.head.off}`);
});

test("velocity, acceleration and jerk are those of the setpoints", () => {
  const t = run.cycle, [offV, offA, offJ] = s.head.curves_off;
  for (let n = 0; n < axes; n++) {
    const x = k => setpoints[Math.min(setpoints.length - 1, Math.max(0, k))][n + 1], axis = run.axes[n];
    for (let k = 2; k + 2 < setpoints.length; k++) {
      // Differences are means over two cycles: jerk may have changed in them.
      const v = (x(k + 1) - x(k - 1)) / (2 * t), a = (x(k + 1) - 2 * x(k) + x(k - 1)) / (t * t);
      const slackV = axis.jerk * t * t, slackA = axis.jerk * t, rounding = 1e-11 * (1 + Math.abs(x(k)));
      assert.ok(Math.abs(run.value(n, VELOCITY, k) - v) <= 1.05 * offV * axis.velocity + slackV + rounding / t, `velocity of ${axis.letter} at ${k}`);
      assert.ok(Math.abs(run.value(n, ACCELERATION, k) - a) <= 1.05 * offA * axis.acceleration + slackA + 4 * rounding / (t * t), `acceleration of ${axis.letter} at ${k}`);
    }
    const [low, high] = axis.peaks[JERK], series = s.Series.axis(run, n, JERK).range;
    const slack = (high - low) * 1e-6;
    assert.ok(series[0] >= low - slack && series[1] <= high + slack, "what is drawn of the jerk is not beyond what was run");
    assert.ok(series[1] - series[0] >= (high - low) * 0.9 - 2 * offJ * axis.jerk, `jerk of ${axis.letter}: ${series} of ${low} ${high}`);
  }
});

test("envelopes hold all that was run, and no more", () => {
  for (let n = 0; n < axes; n++) for (const kind of [POSITION, VELOCITY, ACCELERATION, JERK]) {
    const series = s.Series.axis(run, n, kind);
    for (const [from, to, width] of [[0, run.cycles, 300], [run.cycles * 0.3, run.cycles * 0.7, 97], [run.cycles * 0.5, run.cycles * 0.5 + 40, 200]]) {
      if (!(to > from)) continue;
      const { low, high } = s.envelope(series, from, to, width), [least, most] = series.range, slack = (most - least) * 1e-3 + 1e-6;
      for (let k = 0; k < width; k++) {
        const place = run.place(Math.min(run.cycles, from + (k + 0.5) / width * (to - from)));
        if (!place || from + (k + 0.5) / width * (to - from) > run.cycles) continue;
        const value = series.at(place.s, place.u, place.h);
        assert.ok(low[k] <= value + slack && high[k] >= value - slack, `${run.axes[n].letter} ${kind}, column ${k}: ${value} is not in ${low[k]} ${high[k]}`);
        assert.ok(low[k] >= least - slack && high[k] <= most + slack);
      }
    }
  }
});

test("the path that is drawn passes all setpoints", () => {
  const path = s.outlineOf(run), off = s.head.off + s.head.part / 2;
  for (let k = 0, i = 0; k < setpoints.length; k += Math.max(1, Math.floor(setpoints.length / 5000))) {
    while (i + 1 < path.count && path.cycle[i + 1] < k) i++;
    let best = Infinity;
    for (let j = Math.max(0, i - 1); j <= Math.min(path.count - 1, i + 1); j++) {
      const [a, b] = [j, Math.min(path.count - 1, j + 1)].map(m => path.xyz.map(list => list[m]));
      const d = b.map((x, n) => x - a[n]), x = [1, 2, 3].map(n => setpoints[k][n] ?? 0);
      const t = Math.min(1, Math.max(0, d.reduce((sum, w, n) => sum + w * (x[n] - a[n]), 0) / (d.reduce((sum, w) => sum + w * w, 0) || 1)));
      best = Math.min(best, Math.hypot(...x.map((c, n) => c - a[n] - t * d[n])));
    }
    assert.ok(best <= off * 1.01, `setpoint ${k} is ${best} mm beside the drawn path`);
  }
});

test("what was run is in the band of the programmed path that is drawn", () => {
  const programmed = s.programmedOf(s.head, s.columns), last = programmed.count - 1, end = run.position(run.cycles);
  assert.ok(Math.abs(programmed.tolerance[last] - tolerance) <= s.head.outline_count || s.head.commands.length);
  if (s.head.commands.length) return;
  const gap = Math.hypot(...[0, 1, 2].map(n => programmed.xyz[n][last] - end[n]));
  assert.ok(gap <= 2 * s.head.part, `the ends are ${gap} mm apart`);
  for (let k = 0; k <= 300; k++) {
    const x = run.position(run.cycles * k / 300);
    let best = Infinity;
    for (let j = 0; j <= last; j++) {
      const [a, b] = [j, Math.min(last, j + 1)].map(m => programmed.xyz.map(list => list[m])), d = b.map((c, n) => c - a[n]);
      const t = d.reduce((sum, w, n) => sum + w * (x[n] - a[n]), 0) / (d.reduce((sum, w) => sum + w * w, 0) || 1), u = Math.min(1, Math.max(0, t));
      best = Math.min(best, Math.hypot(...d.map((w, n) => x[n] - a[n] - u * w)));
    }
    assert.ok(best <= Number(tolerance) * 1.001 + 2 * s.head.part, `${best} mm off at ${k}`);
  }
});

test("lines come in the order of the run, and colours for every stretch", () => {
  const { at, number } = run.lines;
  for (let k = 1; k < at.length; k++) assert.ok(at[k] >= at[k - 1] && Number.isInteger(number[k]) && number[k] >= 0);
  const path = s.outlineOf(run);
  for (const mode of ["share", "speed", "binds", "deviation"]) {
    const { levels, most } = s.levelsOf(run, path, mode), palette = s.paletteOf(mode, "light");
    assert.equal(levels.length, Math.max(0, path.count - 1));
    assert.ok(levels.every(level => level < palette.length) && most > 0);
    const lists = s.byLevel(levels, palette.length);
    assert.equal(lists.reduce((sum, list) => sum + list.length, 0), levels.length);
    assert.ok(s.legendOf(mode, most, palette, lists).every(([colour, words]) => colour && words));
  }
  for (const place of s.head.slow) {
    assert.ok(place.lost > 0 && place.time >= 0 && place.time <= run.seconds + 1e-9);
    assert.equal(run.lineAt(run.cycleAt(place.time)), place.line);
  }
});

test("what is asked for covers the run once", () => {
  let end = 0;
  for (const stretch of run.askedFeeds(0, run.cycles)) {
    assert.equal(stretch.begin, end);
    assert.ok(stretch.end > stretch.begin && stretch.feed >= 0);
    end = stretch.end;
  }
  assert.equal(end, run.cycles);
});

test("other laws end at the end", () => {
  const ways = s.waysOf(run);
  s.head.overlays.forEach((head, n) => {
    const overlay = s.overlayOf(head, s.columns[`overlay${n}`]);
    assert.ok(Math.abs(overlay.time[overlay.time.length - 1] - head.time) < 1e-6);
    assert.ok(s.ghostCycle(run, ways, overlay, 0) < run.cycles * 0.01 + 1);
    assert.ok(s.ghostCycle(run, ways, overlay, head.time) > run.cycles * 0.99 - 1);
  });
  if (process.env.OVERLAYS) assert.equal(s.head.overlays.length, Number(process.env.OVERLAYS));
});
