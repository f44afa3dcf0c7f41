// What was run: every axis at every servo cycle, as polynomials over spans.

/** What axes do at a place of a span. */
const POSITION = 0, VELOCITY = 1, ACCELERATION = 2, JERK = 3;

/** One axis. As in `span.rs`: accelerations from end to end with a bump between; velocity and position are their integrals, with what is
 * missing at the end spread evenly. */
class Axis {
  constructor(head, spans) {
    Object.assign(this, head);
    this.x = new Float64Array(spans + 1);
    this.v = new Float64Array(spans + 1);
    this.a = new Float64Array(spans + 1);
    this.bump = new Float64Array(spans);
    this.lackV = new Float64Array(spans);
    this.lackX = new Float64Array(spans);
  }

  decode(columns, n, cycles, cycle, count) {
    const [unitV, unitA] = this.counts, spans = cycles.length;
    const [as, bumps, vs, xs] = [0, 1, 2, 3].map(k => columns[`tape${2 + 4 * n + k}`]);
    let [x, v, a] = this.start;
    this.x[0] = x * count; this.v[0] = v * unitV; this.a[0] = a * unitA;
    for (let s = 0; s < spans; s++) {
      const h = cycles[s] * cycle, a0 = a * unitA, v0 = v * unitV, x0 = x * count;
      a += as.number();
      const a1 = a * unitA, bump = bumps.number() * unitA;
      // In the very steps in which it was written: what is expected must be the same.
      const endV = v0 + h * ((a0 + a1) * 0.5 + bump * (2 / 3));
      v = vs.number() + Math.floor(endV / unitV + 0.5);
      const lackV = v * unitV - endV;
      const endX = x0 + h * (v0 + lackV * 0.5 + h * (a0 / 3 + a1 / 6 + bump / 3));
      x = xs.number() + Math.floor(endX / count + 0.5);
      this.a[s + 1] = a1; this.v[s + 1] = v * unitV; this.x[s + 1] = x * count;
      this.bump[s] = bump; this.lackV[s] = lackV; this.lackX[s] = x * count - endX;
    }
  }

  /** Position, velocity, acceleration or jerk in span `s`, which is `h` seconds long, at its share `u`. */
  at(kind, s, u, h) {
    const a = this.a[s], d = this.a[s + 1] - a, b = this.bump[s];
    switch (kind) {
      case POSITION: {
        const twice = u * u * (a * 0.5 + u * (d / 6 + b * (2 / 3 - u / 3)));
        return this.x[s] + h * (this.v[s] * u + this.lackV[s] * 0.5 * u * u + h * twice) + this.lackX[s] * u;
      }
      case VELOCITY: return this.v[s] + h * (u * (a + u * (d * 0.5 + b * (2 - u * (4 / 3))))) + this.lackV[s] * u;
      case ACCELERATION: return a + d * u + 4 * b * u * (1 - u);
      default: return (d + 4 * b * (1 - 2 * u)) / h;
    }
  }
}

/** The last place in an ascending array, of which `length` count, that is not beyond a value; 0 if all are. */
function lastAt(array, value, length = array.length) {
  let low = 0, high = length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (array[middle] <= value) low = middle; else high = middle;
  }
  return low;
}

class Run {
  constructor(head, columns) {
    this.head = head;
    this.cycle = head.cycle;
    this.cycles = head.cycles;
    this.spans = head.spans;
    this.seconds = head.cycles * head.cycle;
    this.begin = new Float64Array(this.spans + 1);
    this.deviation = new Float64Array(this.spans);
    const lengths = new Uint16Array(this.spans);
    for (let s = 0; s < this.spans; s++) {
      lengths[s] = columns.tape0.count();
      this.begin[s + 1] = this.begin[s] + lengths[s];
      this.deviation[s] = columns.tape1.count() * head.count;
    }
    this.axes = head.axes.map((axis, n) => {
      const made = new Axis(axis, this.spans);
      made.decode(columns, n, lengths, this.cycle, head.count);
      return made;
    });
    this.decodeLines(columns);
    this.decodeModes(columns);
    this.decodeFeeds(columns);
  }

  /** Lines by the cycle in which they begin. */
  decodeLines({ lines }) {
    const at = [0], number = [0];
    for (let cycle = 0, line = 0; !lines.done;) {
      cycle += lines.count();
      line += lines.number();
      at.push(cycle); number.push(line);
    }
    this.lines = { at: Float64Array.from(at), number: Float64Array.from(number) };
  }

  /** Activities and overrides by the cycle in which they begin. */
  decodeModes({ modes }) {
    const at = [], activity = [], percent = [];
    for (let cycle = 0; !modes.done;) {
      cycle += modes.count();
      at.push(cycle); activity.push(modes.count()); percent.push(modes.count());
    }
    if (!at.length) { at.push(0); activity.push(0); percent.push(100); }
    this.modes = { at: Float64Array.from(at), activity: Uint8Array.from(activity), percent: Uint8Array.from(percent) };
  }

  /** Feeds by the cycle from which on they hold. */
  decodeFeeds({ feeds }) {
    const at = [0], kind = [2], feed = [0];
    for (let cycle = 0; !feeds.done;) {
      cycle += feeds.count();
      at.push(cycle); kind.push(feeds.count()); feed.push(feeds.count() * this.head.feed_count);
    }
    this.feeds = { at: Float64Array.from(at), kind: Uint8Array.from(kind), feed: Float64Array.from(feed) };
  }

  /** The servo cycle of a time at which something happened. */
  cycleAt(seconds) { return Math.min(this.cycles, Math.max(0, Math.round(seconds / this.cycle))); }

  /** The span of a cycle, and the place in it. */
  place(cycle) {
    if (!this.spans) return null;
    const s = lastAt(this.begin, cycle, this.spans), n = this.begin[s + 1] - this.begin[s];
    return { s, u: Math.min(1, Math.max(0, (cycle - this.begin[s]) / n)), h: n * this.cycle };
  }

  /** Seconds of a span. */
  duration(s) { return (this.begin[s + 1] - this.begin[s]) * this.cycle; }

  /** A quantity of an axis at a cycle. */
  value(axis, kind, cycle) {
    const place = this.place(cycle);
    if (!place) return kind === POSITION ? this.axes[axis].x[0] : 0;
    return this.axes[axis].at(kind, place.s, place.u, place.h);
  }

  /** Where the tool is. */
  position(cycle) { return this.axes.map((_, n) => this.value(n, POSITION, cycle)); }

  /** The line of the file. */
  lineAt(cycle) { return this.lines.number[lastAt(this.lines.at, cycle)]; }

  /** The first cycle on a line, or on the next that is run; -1 if there is none. */
  cycleOfLine(line) {
    const { at, number } = this.lines;
    let best = -1, least = Infinity;
    for (let k = 1; k < at.length; k++) {
      if (number[k] >= line && number[k] < least) { least = number[k]; best = k; }
    }
    return best < 0 ? -1 : at[best];
  }

  /** What is asked for in a cycle: the kind of its feed, and the feed, mm/s. */
  feedAt(cycle) {
    const k = lastAt(this.feeds.at, cycle);
    return { kind: this.feeds.kind[k], feed: this.feeds.feed[k] };
  }

  /** Stretches of one feed times override, cycles and mm/s; 0 where there is none to keep, in rapids. */
  *askedFeeds(from, to) {
    const { feeds, modes } = this;
    let k = lastAt(feeds.at, from), mode = lastAt(modes.at, from), begin = from;
    while (begin < to) {
      const next = [feeds.at[k + 1] ?? Infinity, modes.at[mode + 1] ?? Infinity, to], end = Math.min(...next);
      if (end > begin) yield { begin, end, feed: feeds.kind[k] === 2 ? 0 : feeds.feed[k] * modes.percent[mode] / 100 };
      if (end === next[0]) k++;
      if (end === next[1]) mode++;
      begin = end;
    }
  }

  /** Activity and override. */
  modeAt(cycle) {
    const k = lastAt(this.modes.at, cycle);
    return { activity: this.modes.activity[k], percent: this.modes.percent[k] };
  }
}
