// Curves over time, as least and greatest values for each column of pixels where they are dense.

/** Spans of a block, which is looked at as a whole where it is narrower than a pixel. */
const BLOCK = 64;

/** A curve: its value at a place, and what it comes to in each span. */
class Series {
  /** `value(s, u, h)`; `ends` are the least and greatest value that were run: what is drawn never goes beyond. */
  constructor(run, value, ends = [-Infinity, Infinity]) {
    this.run = run;
    this.raw = value;
    this.ends = ends;
    this.extremes = null;
  }

  static axis(run, n, kind) {
    const axis = run.axes[n];
    if (kind !== JERK) return new Series(run, (s, u, h) => axis.at(kind, s, u, h), axis.peaks[kind]);
    // A jerk is the difference of two cycles: there is none at the very end of a span.
    const value = (s, u, h) => {
      const half = 0.5 * run.cycle / h;
      return axis.at(JERK, s, Math.min(1 - half, Math.max(half, u)), h);
    };
    return new Series(run, value, axis.peaks[JERK]);
  }

  static speed(run) { return new Series(run, (s, u, h) => speeds(run, s, u, h).all); }

  static deviation(run) { return new Series(run, s => run.deviation[s]); }

  at(s, u, h) { return Math.min(this.ends[1], Math.max(this.ends[0], this.raw(s, u, h))); }

  /** Least and greatest of each span, then of each block. */
  get bounds() {
    if (this.extremes) return this.extremes;
    const { spans } = this.run, blocks = Math.ceil(spans / BLOCK);
    const low = new Float32Array(spans), high = new Float32Array(spans);
    const blockLow = new Float32Array(blocks).fill(Infinity), blockHigh = new Float32Array(blocks).fill(-Infinity);
    for (let s = 0; s < spans; s++) {
      const h = this.run.duration(s), n = Math.min(8, this.run.begin[s + 1] - this.run.begin[s]);
      const [least, most] = leastAndMost(k => this.at(s, k / n, h), n, this.ends);
      low[s] = least; high[s] = most;
      const b = s / BLOCK | 0;
      if (least < blockLow[b]) blockLow[b] = least;
      if (most > blockHigh[b]) blockHigh[b] = most;
    }
    return this.extremes = { low, high, blockLow, blockHigh };
  }

  /** Least and greatest of all. */
  get range() {
    const { blockLow, blockHigh } = this.bounds;
    let low = Infinity, high = -Infinity;
    for (const x of blockLow) low = Math.min(low, x);
    for (const x of blockHigh) high = Math.max(high, x);
    return low <= high ? [low, high] : [0, 0];
  }
}

/** Least and greatest value of a curve of which `n` + 1 places are looked at; a peak between them is that of the parabola through three. */
function leastAndMost(at, n, [lowest, highest]) {
  let before = NaN, here = at(0), least = here, most = here;
  for (let k = 1; k <= n; k++) {
    const after = at(k);
    if (after < least) least = after;
    if (after > most) most = after;
    const rise = here - before, fall = here - after;
    if (rise * fall > 0) {
      const peak = here + (rise - fall) ** 2 / (8 * (rise + fall));
      least = Math.min(least, Math.max(lowest, peak)); most = Math.max(most, Math.min(highest, peak));
    }
    before = here; here = after;
  }
  return [least, most];
}

/** Least and greatest value in each of `width` columns from cycle `from` to `to`; NaN where nothing was run. */
function envelope(series, from, to, width) {
  const low = new Float32Array(width).fill(Infinity), high = new Float32Array(width).fill(-Infinity);
  const run = series.run, { begin, spans } = run, scale = width / (to - from);
  const { low: spanLow, high: spanHigh, blockLow, blockHigh } = series.bounds;
  const put = (column, least, most) => {
    if (column < 0 || column >= width) return;
    if (least < low[column]) low[column] = least;
    if (most > high[column]) high[column] = most;
  };
  let s = spans ? lastAt(begin, from, spans) : 0;
  while (s < spans && begin[s] <= to) {
    const x0 = (begin[s] - from) * scale;
    const after = Math.min(spans, s + BLOCK);
    if (s % BLOCK === 0 && (begin[after] - begin[s]) * scale <= 1) {
      const b = s / BLOCK;
      put(Math.floor(x0), blockLow[b], blockHigh[b]);
      put(Math.floor((begin[after] - from) * scale), blockLow[b], blockHigh[b]);
      s = after;
      continue;
    }
    const x1 = (begin[s + 1] - from) * scale;
    if (x1 - x0 <= 1) {
      put(Math.floor(x0), spanLow[s], spanHigh[s]);
      put(Math.floor(x1), spanLow[s], spanHigh[s]);
    } else {
      // Twice in every column, and at its edges, where the curve passes to the next.
      const h = run.duration(s), wide = x1 - x0;
      const first = Math.max(0, Math.floor(x0)), last = Math.min(width - 1, Math.floor(x1));
      for (let column = first; column <= last; column++) {
        for (let k = 0; k <= 2; k++) {
          const value = series.at(s, Math.min(1, Math.max(0, (column + k / 2 - x0) / wide)), h);
          put(column, value, value);
        }
      }
    }
    s++;
  }
  for (let k = 0; k < width; k++) if (low[k] > high[k]) low[k] = high[k] = NaN;
  return { low, high };
}

/** Least and greatest value between two cycles. */
function extremes(series, from, to) {
  const run = series.run, { begin, spans } = run, { low, high } = series.bounds;
  let [least, most] = [Infinity, -Infinity];
  for (let s = spans ? lastAt(begin, from, spans) : 0; s < spans && begin[s] <= to; s++) {
    if (begin[s] >= from && begin[s + 1] <= to) {
      least = Math.min(least, low[s]); most = Math.max(most, high[s]);
      continue;
    }
    const n = begin[s + 1] - begin[s], h = n * run.cycle;
    const [a, b] = [from, to].map(cycle => Math.min(1, Math.max(0, (cycle - begin[s]) / n)));
    const ends = leastAndMost(k => series.at(s, a + (b - a) * k / 4, h), 4, series.ends);
    least = Math.min(least, ends[0]); most = Math.max(most, ends[1]);
  }
  return least <= most ? [least, most] : [NaN, NaN];
}
