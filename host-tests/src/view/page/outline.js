// Paths in space as points: what was run, and what was programmed.

/** Points of one span at most. */
const MOST_PARTS = 32;
/** Speeds that differ by this part of the greatest are drawn in colours of their own. */
const SPEED_PARTS = 16;

/** What was run, as points near enough: their coordinates, the span each is in, and its cycle. */
function outlineOf(run) {
  const off = Math.max(run.head.part / 4, 1e-9), axes = run.axes.slice(0, 3);
  const speed = s => Math.hypot(...axes.map(axis => axis.v[s]));
  let fastest = 1e-9;
  for (let s = 0; s <= run.spans; s++) fastest = Math.max(fastest, speed(s));
  const parts = new Uint8Array(run.spans);
  let count = 1;
  for (let s = 0; s < run.spans; s++) count += parts[s] = partsOf(run, axes, s, off, fastest, speed);
  const path = { count, xyz: [0, 1, 2].map(() => new Float64Array(count)), cycle: new Float64Array(count), span: new Uint32Array(count) };
  axes.forEach((axis, n) => path.xyz[n][0] = axis.x[0]);
  for (let s = 0, i = 1; s < run.spans; s++) {
    const h = run.duration(s);
    for (let k = 1; k <= parts[s]; k++, i++) {
      const u = k / parts[s];
      for (let n = 0; n < axes.length; n++) path.xyz[n][i] = axes[n].at(POSITION, s, u, h);
      path.cycle[i] = run.begin[s] + u * (run.begin[s + 1] - run.begin[s]);
      path.span[i] = s;
    }
  }
  return path;
}

/** Into how many chords a span is cut: none where nothing moves. */
function partsOf(run, axes, s, off, fastest, speed) {
  const h = run.duration(s), from = speed(s), to = speed(s + 1);
  const way = axes.reduce((sum, axis) => sum + (axis.x[s + 1] - axis.x[s]) ** 2, 0);
  if (way < off * off * 1e-4 && Math.max(from, to) < RESTS) return 0;
  // What bends the path is the acceleration across it, at most what there is.
  let across = 0;
  for (const u of [0, 0.5, 1]) {
    let aa = 0, vv = 0, av = 0;
    for (const axis of axes) {
      const a = axis.at(ACCELERATION, s, u, h), v = axis.at(VELOCITY, s, u, h);
      aa += a * a; vv += v * v; av += a * v;
    }
    across = Math.max(across, vv > 1e-12 ? aa - av * av / vv : aa);
  }
  const bend = Math.sqrt(h * h * Math.sqrt(Math.max(0, across)) / (8 * off));
  const change = Math.abs(to - from) / fastest * SPEED_PARTS;
  const cycles = run.begin[s + 1] - run.begin[s];
  return Math.max(1, Math.min(MOST_PARTS, cycles, Math.ceil(Math.max(bend, change))));
}

/** The programmed path: vertices, and the tolerance at each, mm. */
function programmedOf(head, columns) {
  const count = head.vertices, unit = head.outline_count;
  const path = { count, xyz: [0, 1, 2].map(() => new Float64Array(count)), tolerance: new Float64Array(count) };
  path.xyz.forEach((to, n) => {
    const column = columns[`outline${n}`];
    for (let k = 0, at = 0; k < count && !column.done; k++) to[k] = (at += column.number()) * unit;
  });
  for (let k = 0; !columns.tolerances.done;) {
    const run = columns.tolerances.count(), tolerance = columns.tolerances.count() * unit;
    path.tolerance.fill(tolerance, k, k += run);
  }
  return path;
}

/** Least and greatest coordinates of paths, each axis. */
function boundsOf(...paths) {
  return [0, 1, 2].map(n => {
    let low = Infinity, high = -Infinity;
    for (const path of paths) for (let k = 0; k < path.count; k++) {
      const x = path.xyz[n][k];
      if (x < low) low = x;
      if (x > high) high = x;
    }
    return low <= high ? [low, high] : [0, 0];
  });
}
