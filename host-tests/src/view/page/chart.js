// Curves over time, or over the way.

const PAD = { left: 62, right: 10, top: 6, bottom: 20 };
/** No stretch is shown greater than this, servo cycles. */
const LEAST_WINDOW = 4;
/** A limit is shown by itself from this share of it on. */
const NEAR_LIMIT = 0.5;

class Chart {
  /** `curves` are named series with an axis or none, `limits(n)` the limits of the axis of curve `n`: least and greatest. */
  constructor(parent, app, { title, unit, curves, limits, feed = false, overlays = false }) {
    Object.assign(this, { app, title, unit, curves, limits, feed, withOverlays: overlays });
    this.figure = document.createElement("figure");
    this.caption = document.createElement("figcaption");
    this.box = document.createElement("div");
    this.box.className = "sheet chart";
    this.figure.append(this.caption, this.box);
    parent.append(this.figure);
    this.captions();
    this.sheets = new Sheets(this.box, () => { this.draw(); this.drawTop(); });
    this.chosen = null;
    gestures(this.box, {
      down: (x, e) => { this.start = x; this.selects = e.pointerType !== "touch" && e.button === 0 && !e.shiftKey; },
      wheel: (x, y, e) => this.wheel(x, e),
      drag: (dx, dy, e, x) => {
        if (this.selects) { this.chosen = [this.start, x]; this.drawTop(); }
        else this.pan(dx);
      },
      dragged: (x, cancelled) => {
        const chosen = this.chosen;
        this.chosen = null;
        if (chosen && !cancelled && Math.abs(chosen[1] - chosen[0]) > CLICK) {
          const [a, b] = chosen.map(p => this.cycle(p)).sort((a, b) => a - b);
          app.setWindow(a, b);
        } else this.drawTop();
      },
      pinch: (x, y, factor, dx) => { this.pan(dx); this.zoom(x, 1 / factor); },
      click: x => app.go(this.cycle(x)),
      hover: x => app.note(x >= PAD.left ? this.cycle(x) : -1),
      leave: () => app.note(-1),
    });
    this.box.addEventListener("dblclick", () => app.seeAllTime());
  }

  /** Title, and a switch for each curve. */
  captions() {
    const { app } = this;
    this.caption.replaceChildren();
    const title = document.createElement("b");
    title.textContent = `${this.title}, ${this.unit}`;
    this.caption.append(title);
    this.values = this.curves.map((curve, n) => {
      if (this.curves.length < 2) return null;
      const button = document.createElement("button");
      button.className = "chip";
      button.setAttribute("aria-pressed", String(app.axisShown(curve.axis)));
      button.style.setProperty("--ink", app.style.axes[curve.axis % app.style.axes.length]);
      button.title = `Shows or hides ${curve.name} in all charts`;
      const value = document.createElement("span");
      button.append(curve.name + " ", value);
      button.addEventListener("click", () => app.switchAxis(curve.axis));
      this.caption.append(button);
      return value;
    });
    this.single = document.createElement("span");
    if (this.curves.length < 2) this.caption.append(this.single);
  }

  get width() { return Math.max(1, this.sheets.w - PAD.left - PAD.right); }

  /** What is seen, in cycles. */
  get window() { return this.app.window; }

  cycle(x) {
    const [from, to] = this.window;
    return from + (x - PAD.left) / this.width * (to - from);
  }

  x(cycle) {
    const [from, to] = this.window;
    return PAD.left + (cycle - from) / (to - from) * this.width;
  }

  y(value) {
    const [low, high] = this.range;
    return this.sheets.h - PAD.bottom - (value - low) / (high - low) * (this.sheets.h - PAD.top - PAD.bottom);
  }

  wheel(x, e) {
    if (e.ctrlKey || e.shiftKey || e.metaKey) { this.zoom(x, Math.exp((e.deltaY || e.deltaX) * (e.deltaMode ? 0.05 : 0.002))); return true; }
    if (Math.abs(e.deltaX) > Math.abs(e.deltaY)) { this.pan(-e.deltaX); return true; }
    return false;
  }

  zoom(x, factor) {
    const at = this.cycle(x), [from, to] = this.window;
    this.app.setWindow(at + (from - at) * factor, at + (to - at) * factor);
  }

  pan(dx) {
    const [from, to] = this.window, step = -dx / this.width * (to - from);
    this.app.setWindow(from + step, to + step, true);
  }

  shown() { return this.curves.map((curve, n) => n).filter(n => this.curves.length < 2 || this.app.axisShown(this.curves[n].axis)); }

  /** What a curve comes to in each column of pixels. */
  columns(curve, width) { return envelope(curve.series, ...this.window, width); }

  /** What is to be seen, up and down. */
  measure(drawn) {
    let low = Infinity, high = -Infinity;
    for (const { columns, n } of drawn) {
      for (let k = 0; k < columns.low.length; k++) {
        if (columns.low[k] < low) low = columns.low[k];
        if (columns.high[k] > high) high = columns.high[k];
      }
    }
    for (const { columns, n } of drawn) {
      const ends = (this.limits?.(n) ?? []).filter(limit => limit !== null);
      // Both or none, as near as the curve comes in sight; of a position only what is asked for.
      const reach = columns.low.reduce((most, x, k) => Math.max(most, -x || 0, columns.high[k] || 0), 0);
      if (this.app.shows.limits || this.title !== "position" && ends.some(limit => reach >= NEAR_LIMIT * Math.abs(limit))) {
        low = Math.min(low, ...ends); high = Math.max(high, ...ends);
      }
    }
    for (const overlay of this.overlays()) { low = Math.min(low, 0); high = Math.max(high, overlay.speed.reduce((a, b) => Math.max(a, b), 0)); }
    if (this.feed || this.title !== "position") { low = Math.min(low, 0); high = Math.max(high, 0); }
    if (!(low <= high)) [low, high] = [0, 1];
    const room = (high - low) * 0.06 || Math.max(1e-6, Math.abs(high) * 0.1);
    this.range = [low - (low < 0 || this.title === "position" ? room : 0), high + room];
  }

  overlays() { return this.withOverlays ? this.app.overlays.filter(overlay => overlay.shown) : []; }

  draw() {
    const { app, sheets } = this, { style } = app, g = sheets.clear(sheets.base), { w, h } = sheets;
    if (w <= PAD.left + PAD.right) return;
    const fine = Math.min(2, sheets.ratio), width = Math.round(this.width * fine);
    const drawn = this.shown().map(n => ({ n, columns: this.columns(this.curves[n], width) }));
    this.measure(drawn);
    this.frame(g);
    g.save();
    g.beginPath(); g.rect(PAD.left, PAD.top, this.width, h - PAD.top - PAD.bottom); g.clip();
    if (this.feed) this.programmedFeed(g);
    this.limitLines(g, drawn);
    // What was run is on top of what others would do.
    this.overlays().forEach(overlay => this.overlay(g, overlay));
    for (const { n, columns } of drawn) {
      g.strokeStyle = g.fillStyle = this.curves[n].axis === undefined ? style.speed : style.axes[this.curves[n].axis % style.axes.length];
      this.curve(g, columns, fine);
    }
    g.restore();
    this.beyond(g, drawn);
  }

  frame(g) {
    const { style } = this.app, { w, h } = this.sheets;
    g.strokeStyle = style.grid; g.fillStyle = style.faint; g.lineWidth = 1;
    g.textAlign = "right"; g.textBaseline = "middle";
    g.beginPath();
    for (const value of ticks(...this.range, h / 34)) {
      const y = this.y(value);
      g.moveTo(PAD.left, y); g.lineTo(w - PAD.right, y);
      g.fillText(label(value, 4), PAD.left - 6, y);
    }
    g.textBaseline = "top";
    const marks = this.ticks();
    for (const { x, text } of marks) {
      g.moveTo(x, PAD.top); g.lineTo(x, h - PAD.bottom);
      const wide = g.measureText(text).width;
      g.textAlign = "left";
      g.fillText(text, Math.min(w - wide - 1, Math.max(PAD.left - 20, x - wide / 2)), h - PAD.bottom + 5);
    }
    g.stroke();
  }

  ticks() {
    const { cycle } = this.app.run, [from, to] = this.window.map(c => c * cycle);
    const times = timeTicks(from, to, this.width / 95), step = times.length > 1 ? times[1] - times[0] : 1;
    return times.map(t => ({ x: this.x(t / cycle), text: timeLabel(t, step) }));
  }

  curve(g, { low, high }, fine) {
    g.lineWidth = 1.3;
    g.beginPath();
    let open = false;
    for (let k = 0; k < low.length; k++) {
      if (Number.isNaN(low[k])) { open = false; continue; }
      const x = PAD.left + (k + 0.5) / fine, y0 = this.y(low[k]), y1 = this.y(high[k]);
      // From the end that is nearer to where the column before left off.
      const [a, b] = open && Math.abs(this.lastY - y1) < Math.abs(this.lastY - y0) ? [y1, y0] : [y0, y1];
      if (open) g.lineTo(x, a); else g.moveTo(x, a);
      if (y0 - y1 > 0.3) g.lineTo(x, b);
      this.lastY = y0 - y1 > 0.3 ? b : a;
      open = true;
    }
    g.stroke();
  }

  limitLines(g, drawn) {
    if (!this.limits) return;
    const { style } = this.app, { w } = this.sheets, seen = new Set();
    g.setLineDash([5, 4]); g.lineWidth = 1;
    for (const { n } of drawn) for (const limit of this.limits(n)) {
      if (limit === null || seen.has(limit)) continue;
      seen.add(limit);
      g.strokeStyle = style.limit;
      const y = this.y(limit);
      g.beginPath(); g.moveTo(PAD.left, y); g.lineTo(w - PAD.right, y); g.stroke();
    }
    g.setLineDash([]);
  }

  /** Limits that are not in sight, in words. */
  beyond(g, drawn) {
    if (!this.limits) return;
    const { style } = this.app, { w } = this.sheets, [low, high] = this.range, words = new Set();
    for (const { n } of drawn) for (const limit of this.limits(n)) {
      if (limit !== null && limit > high) words.add(label(limit));
      else if (limit !== null && limit < low) words.add(label(limit));
    }
    if (!words.size) return;
    const texts = [...words], pairs = texts.filter(t => !t.startsWith("-")).map(t => words.has("-" + t) ? "±" + t : t);
    const rest = texts.filter(t => t.startsWith("-") && !words.has(t.slice(1)));
    g.fillStyle = style.limit; g.textAlign = "right"; g.textBaseline = "top";
    g.fillText(`limit ${[...pairs, ...rest].join(", ")} out of sight`, w - PAD.right - 4, PAD.top + 2);
  }

  /** What is asked for: feed times override. */
  programmedFeed(g) {
    const { run, style } = this.app, [from, to] = this.window;
    g.strokeStyle = style.programmed; g.lineWidth = 1;
    g.beginPath();
    let lastX = -1, open = false;
    for (const { begin, end, feed } of run.askedFeeds(from, to)) {
      const x0 = this.x(Math.max(begin, from)), x1 = this.x(Math.min(end, to));
      if (x1 - lastX < 0.4) continue;
      if (feed > 0) {
        const y = this.y(feed);
        if (open) g.lineTo(x0, y); else g.moveTo(x0, y);
        g.lineTo(x1, y);
      }
      open = feed > 0; lastX = x1;
    }
    g.stroke();
  }

  overlay(g, overlay) {
    const { style, overlays, run } = this.app, n = overlays.indexOf(overlay);
    const [from, to] = this.window, last = overlay.time.length;
    g.strokeStyle = style.overlays[n % style.overlays.length]; g.lineWidth = 1.1;
    g.beginPath();
    polyline(g, overlay.time, overlay.speed, last, t => this.x(t / run.cycle), v => this.y(v), PAD.left, this.sheets.w, from * run.cycle, to * run.cycle);
    g.stroke();
  }

  drawTop() {
    const { app, sheets } = this, g = sheets.clear(sheets.top), { h, w } = sheets, { style } = app;
    if (this.chosen) {
      g.fillStyle = style.chosen;
      const [a, b] = [...this.chosen].sort((a, b) => a - b);
      g.fillRect(a, PAD.top, b - a, h - PAD.top - PAD.bottom);
    }
    const line = (cycle, colour, width) => {
      const x = this.x(cycle);
      if (x < PAD.left - 1 || x > w - PAD.right + 1) return;
      g.strokeStyle = colour; g.lineWidth = width;
      g.beginPath(); g.moveTo(x, PAD.top); g.lineTo(x, h - PAD.bottom); g.stroke();
    };
    if (app.hovered >= 0) line(app.hovered, style.faint, 1);
    line(app.now, style.now, 1.5);
    const place = app.run.place(app.hovered >= 0 ? app.hovered : app.now);
    this.curves.forEach((curve, n) => {
      const text = place ? label(curve.series.at(place.s, place.u, place.h), 5) : "";
      if (this.values[n]) this.values[n].textContent = text;
      else this.single.textContent = " " + text;
    });
  }
}

/** Speeds over the way: all laws at the same place. */
class WayChart extends Chart {
  get window() { return this.app.window; }

  way(cycle) { return between(this.app.run.begin, this.app.ways, cycle); }

  /** Of the way: in equal steps. */
  get ends() { return this.window.map(cycle => this.way(cycle)); }

  cycle(x) {
    const [from, to] = this.ends;
    return between(this.app.ways, this.app.run.begin, from + (x - PAD.left) / this.width * (to - from));
  }

  x(cycle) { return this.xOfWay(this.way(cycle)); }

  xOfWay(way) {
    const [from, to] = this.ends;
    return PAD.left + (to > from ? (way - from) / (to - from) : 0) * this.width;
  }

  columns(curve, width) {
    const low = new Float32Array(width), high = new Float32Array(width), { run } = this.app, [from, to] = this.ends;
    let before = this.window[0];
    for (let k = 0; k < width; k++) {
      const next = between(this.app.ways, run.begin, from + (k + 1) / width * (to - from));
      [low[k], high[k]] = extremes(curve.series, before, next);
      before = next;
    }
    return { low, high };
  }

  ticks() { return ticks(...this.ends, this.width / 95).map(way => ({ x: this.xOfWay(way), text: `${label(way)} mm` })); }

  programmedFeed() {}

  overlay(g, overlay) {
    const { style, overlays, ways, run } = this.app, n = overlays.indexOf(overlay), whole = ways[run.spans];
    const stretch = whole / (overlay.way[overlay.way.length - 1] || 1), [from, to] = this.ends;
    g.strokeStyle = style.overlays[n % style.overlays.length]; g.lineWidth = 1.1;
    g.beginPath();
    polyline(g, overlay.way, overlay.speed, overlay.way.length, s => this.xOfWay(s * stretch), v => this.y(v), PAD.left, this.sheets.w, from / stretch, to / stretch);
    g.stroke();
  }
}

/** A curve by its points: least and greatest of what falls into one column. */
function polyline(g, xs, ys, count, toX, toY, left, right, from, to) {
  let k = lastAt(xs, from, count), open = false;
  while (k < count) {
    const x = toX(xs[k]), column = Math.floor(x);
    let [least, most, last] = [ys[k], ys[k], ys[k]];
    const first = ys[k];
    while (k + 1 < count && Math.floor(toX(xs[k + 1])) === column) {
      k++;
      least = Math.min(least, ys[k]); most = Math.max(most, ys[k]); last = ys[k];
    }
    if (open) g.lineTo(x, toY(first)); else g.moveTo(x, toY(first));
    open = true;
    if (most > least) { g.lineTo(x, toY(least)); g.lineTo(x, toY(most)); g.lineTo(x, toY(last)); }
    if (xs[k] > to) break;
    k++;
  }
}
