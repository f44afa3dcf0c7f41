// Other speed laws on the same path.

/** The way that was run at the end of each span, mm. */
function waysOf(run) {
  const ways = new Float64Array(run.spans + 1);
  for (let s = 0; s < run.spans; s++) {
    const h = run.duration(s);
    // Simpson's rule, twice: speeds are smooth within a span.
    let sum = 0;
    for (const [u, weight] of [[0, 1], [0.25, 4], [0.5, 2], [0.75, 4], [1, 1]]) sum += weight * speeds(run, s, u, h).all;
    ways[s + 1] = ways[s] + sum * h / 12;
  }
  return ways;
}

/** A law's speeds over its way, and the time at each of its points. */
function overlayOf(head, column) {
  const way = [], speed = [], time = [];
  let [x, y] = [0, 0];
  while (!column.done) {
    x += column.number(); y += column.number();
    const [s, v] = [x * head.counts[0], y * head.counts[1]], k = way.length;
    const mean = k ? (speed[k - 1] + v) / 2 : 0;
    time.push(k ? time[k - 1] + (mean > 0 ? (s - way[k - 1]) / mean : 0) : 0);
    way.push(s); speed.push(v);
  }
  const { name, time: seconds } = head, last = time[time.length - 1] || 1;
  // Dwells are no points of the curve: the times are stretched to the whole.
  return { name, seconds, way: Float64Array.from(way), speed: Float64Array.from(speed), time: Float64Array.from(time, t => t * seconds / last) };
}

/** Between the points of a curve. */
function between(xs, ys, x) {
  if (!xs.length) return 0;
  const k = lastAt(xs, x), next = Math.min(xs.length - 1, k + 1), step = xs[next] - xs[k];
  return step > 0 ? ys[k] + (ys[next] - ys[k]) * Math.min(1, Math.max(0, (x - xs[k]) / step)) : ys[k];
}

/** Where a law's tool is at a time: the cycle in which this run was there. */
function ghostCycle(run, ways, overlay, seconds) {
  const length = overlay.way[overlay.way.length - 1] || 1, whole = ways[run.spans];
  const way = between(overlay.time, overlay.way, seconds) / length * whole;
  return between(ways, run.begin, way);
}
