// The path in the plane and in space.

/** Points nearer than this to the last, pixels, are not drawn. */
const FINE = 0.6;
/** Setpoints are shown one by one where they are so far apart, pixels, and no more than so many. */
const SETPOINT_GAP = 4, MOST_SETPOINTS = 6000;
const AXIS_MARKS = ["X", "Y", "Z"];

class View {
  constructor(box, app, camera) {
    Object.assign(this, { app, camera });
    const { path, programmed } = app;
    this.xs = new Float32Array(path.count); this.ys = new Float32Array(path.count);
    this.px = new Float32Array(programmed.count); this.py = new Float32Array(programmed.count);
    this.hovered = -1;
    this.sheets = new Sheets(box, () => {
      this.camera.resize(this.sheets.w, this.sheets.h);
      this.draw(); this.drawTop();
    });
    Object.assign(camera, { w: this.sheets.w, h: this.sheets.h });
    this.seeAll();
    const redraw = () => app.later(this);
    const solid = camera instanceof SpaceCamera;
    gestures(box, {
      wheel: (x, y, e) => { camera.zoom(x, y, Math.exp(-e.deltaY * (e.deltaMode ? 0.05 : 0.0015))); redraw(); return true; },
      drag: (dx, dy, e) => {
        if (solid && !e.shiftKey && !(e.buttons & 6)) camera.turn(dx, dy); else camera.pan(dx, dy);
        redraw();
      },
      pinch: (x, y, factor, dx, dy) => { camera.pan(dx, dy); camera.zoom(x, y, factor); redraw(); },
      click: (x, y) => { const i = this.nearest(x, y); if (i >= 0) app.go(path.cycle[i]); },
      hover: (x, y) => { const i = this.nearest(x, y); if (i !== this.hovered) { this.hovered = i; this.drawTop(); app.note(i < 0 ? -1 : path.cycle[i]); } },
      leave: () => { this.hovered = -1; this.drawTop(); app.note(-1); },
    });
    box.addEventListener("dblclick", () => { this.seeAll(); redraw(); });
  }

  seeAll() { this.camera.fit(this.app.bounds); }

  nearest(x, y) {
    const { path } = this.app;
    return nearest(this.xs, this.ys, path.count, x, y, 14, lastAt(path.cycle, this.app.now));
  }

  /** Puts a cycle in the middle, with so many mm around. */
  show(cycle, mm) {
    const at = this.app.run.position(cycle);
    this.camera.centre = [at[0], at[1], at[2] ?? 0];
    if (mm > 0) this.camera.perMm = Math.min(this.camera.w, this.camera.h) / mm;
  }

  draw() {
    const { app, camera, sheets } = this, g = sheets.clear(sheets.base);
    project(camera, app.path, this.xs, this.ys);
    project(camera, app.programmed, this.px, this.py);
    if (camera instanceof SpaceCamera) this.floor(g); else this.grid(g);
    if (app.shows.programmed) this.drawProgrammed(g);
    this.drawPath(g);
    this.marks(g);
  }

  /** Lines of the plane with their coordinates. */
  grid(g) {
    const { w, h } = this.sheets, { centre, perMm } = this.camera, { style } = this.app;
    g.lineWidth = 1;
    const [x0, x1] = [-1, 1].map(k => centre[0] + k * w / 2 / perMm), [y0, y1] = [-1, 1].map(k => centre[1] + k * h / 2 / perMm);
    g.strokeStyle = style.grid; g.fillStyle = style.faint;
    g.textBaseline = "bottom"; g.textAlign = "left";
    g.beginPath();
    for (const x of ticks(x0, x1, w / 90)) {
      const p = w / 2 + (x - centre[0]) * perMm;
      g.moveTo(p, 0); g.lineTo(p, h); g.fillText(label(x), p + 3, h - 2);
    }
    g.textBaseline = "top";
    for (const y of ticks(y0, y1, h / 70)) {
      const p = h / 2 - (y - centre[1]) * perMm;
      g.moveTo(0, p); g.lineTo(w, p);
      if (p < h - 28) g.fillText(label(y), 3, p + 2);
    }
    g.stroke();
  }

  /** The floor of what was run, so that one sees what is up. */
  floor(g) {
    const { bounds, style } = this.app, [xs, ys, [z]] = bounds, at = (x, y) => this.camera.at(x, y, z);
    if (!(xs[1] > xs[0]) && !(ys[1] > ys[0])) return;
    g.strokeStyle = style.grid; g.lineWidth = 1;
    g.beginPath();
    const line = (a, b) => { g.moveTo(...a); g.lineTo(...b); };
    const count = 8, size = Math.max(xs[1] - xs[0], ys[1] - ys[0]);
    for (const x of [...ticks(xs[0], xs[1], count * (xs[1] - xs[0]) / size), ...xs]) line(at(x, ys[0]), at(x, ys[1]));
    for (const y of [...ticks(ys[0], ys[1], count * (ys[1] - ys[0]) / size), ...ys]) line(at(xs[0], y), at(xs[1], y));
    g.stroke();
  }

  /** The programmed path; where it is wide enough to be seen, in its band. */
  drawProgrammed(g) {
    const { programmed, style } = this.app, { count, tolerance } = programmed, { px, py } = this;
    const stroke = (from, to) => {
      const { w, h } = this.sheets, room = g.lineWidth;
      let open = false, [x, y] = [0, 0];
      g.beginPath();
      for (let i = Math.max(1, from); i < to; i++) {
        if (outside(px[i - 1], py[i - 1], px[i], py[i], w, h, room)) { open = false; continue; }
        if (!open) g.moveTo(x = px[i - 1], y = py[i - 1]);
        open = true;
        if (i + 1 < to && Math.abs(px[i] - x) + Math.abs(py[i] - y) < FINE) continue;
        g.lineTo(x = px[i], y = py[i]);
      }
      g.stroke();
    };
    for (let from = 0; from < count;) {
      let to = from + 1;
      while (to < count && tolerance[to] === tolerance[from]) to++;
      const band = 2 * tolerance[from] * this.camera.perMm;
      if (band >= 2) { g.strokeStyle = style.band; g.lineWidth = band; stroke(from, to); }
      from = to;
    }
    g.strokeStyle = style.programmed; g.lineWidth = 1;
    stroke(0, count);
  }

  /** What was run: outside the stretch of time that is seen it is pale. */
  drawPath(g) {
    const { app, xs, ys } = this, { path, lists, palette, style, shows } = app, { w, h } = this.sheets;
    const [from, to] = app.window, first = lastAt(path.cycle, from), last = lastAt(path.cycle, to) + 1;
    const stroke = (list, low, high) => {
      let before = -2, [x, y] = [0, 0];
      g.beginPath();
      for (let k = low; k < high; k++) {
        const i = list ? list[k] : k;
        if (outside(xs[i], ys[i], xs[i + 1], ys[i + 1], w, h, 2)) { before = -2; continue; }
        if (before !== i) g.moveTo(x = xs[i], y = ys[i]);
        const next = k + 1 < high ? (list ? list[k + 1] : k + 1) : -1;
        before = i + 1;
        if (next === i + 1 && Math.abs(xs[i + 1] - x) + Math.abs(ys[i + 1] - y) < FINE) continue;
        g.lineTo(x = xs[i + 1], y = ys[i + 1]);
      }
      g.stroke();
    };
    const end = path.count - 1;
    if (first > 0 || last < end) {
      g.strokeStyle = style.pale; g.lineWidth = 1;
      stroke(null, 0, Math.min(first, end));
      stroke(null, Math.min(last, end), end);
    }
    g.lineWidth = 1.7;
    // What is slow, or bound, is drawn last.
    const order = app.mode === "share" ? [...lists.keys()].reverse() : [...lists.keys()];
    for (const level of order) {
      if (level === RAPID && !shows.rapids) continue;
      const list = lists[level];
      let low = 0, high = list.length;
      if (first > 0) { low = lastAt(list, first); if (list[low] < first) low++; }
      if (last < end) { high = lastAt(list, last) + (list.length && list[lastAt(list, last)] < last ? 1 : 0); }
      g.strokeStyle = palette[level];
      if (low < high) stroke(list, low, high);
    }
    this.setpoints(g);
  }

  /** Every setpoint by itself, where there is room. */
  setpoints(g) {
    const { run, path, style } = this.app, { w, h } = this.sheets, { xs, ys } = this, spans = [];
    let count = 0;
    for (let i = 1; i < path.count; i++) {
      const s = path.span[i], cycles = path.cycle[i] - path.cycle[i - 1];
      if (outside(xs[i - 1], ys[i - 1], xs[i], ys[i], w, h, 0)) continue;
      if (Math.hypot(xs[i] - xs[i - 1], ys[i] - ys[i - 1]) < SETPOINT_GAP * cycles) continue;
      if (spans[spans.length - 1] !== s) { spans.push(s); count += run.begin[s + 1] - run.begin[s]; }
      if (count > MOST_SETPOINTS) return;
    }
    g.fillStyle = style.text;
    for (const s of spans) {
      const n = run.begin[s + 1] - run.begin[s];
      for (let k = 1; k <= n; k++) {
        const [x, y] = this.camera.at(...[0, 1, 2].map(axis => run.axes[axis]?.at(POSITION, s, k / n, n * run.cycle) ?? 0));
        g.fillRect(x - 1.25, y - 1.25, 2.5, 2.5);
      }
    }
  }

  /** Directions of the axes in a corner, and a measure. */
  marks(g) {
    const { rows, perMm } = this.camera, { h, w } = this.sheets, { style } = this.app;
    const solid = this.camera instanceof SpaceCamera, [ox, oy] = solid ? [40, h - 40] : [44, h - 48];
    g.lineWidth = 2; g.textAlign = "center"; g.textBaseline = "middle";
    AXIS_MARKS.forEach((name, n) => {
      const [dx, dy] = [rows[0][n] * 26, -rows[1][n] * 26];
      if (!solid && n === 2) return;
      g.strokeStyle = g.fillStyle = style.axes[n];
      g.beginPath(); g.moveTo(ox, oy); g.lineTo(ox + dx, oy + dy); g.stroke();
      g.fillText(name, ox + dx * 1.4, oy + dy * 1.4);
    });
    const size = ticks(0, Math.max(1e-9, w * 0.22 / perMm), 1)[1] ?? ticks(0, w * 0.22 / perMm, 2)[1];
    if (!size) return;
    g.strokeStyle = g.fillStyle = style.faint; g.lineWidth = 1.5;
    const [x1, y] = [w - 12, 14];
    g.beginPath(); g.moveTo(x1 - size * perMm, y - 3); g.lineTo(x1 - size * perMm, y); g.lineTo(x1, y); g.lineTo(x1, y - 3); g.stroke();
    g.textAlign = "right"; g.textBaseline = "top";
    g.fillText(`${label(size)} mm`, x1, y + 3);
  }

  /** The tool, those of other laws, and the place under the pointer. */
  drawTop() {
    const { app, sheets } = this, g = sheets.clear(sheets.top), { run, style } = app;
    const at = cycle => { const p = run.position(cycle); return this.camera.at(p[0], p[1], p[2] ?? 0); };
    const dot = ([x, y], size, colour) => { g.beginPath(); g.strokeStyle = colour; g.lineWidth = 2; g.arc(x, y, size, 0, 7); g.stroke(); };
    app.overlays.forEach((overlay, n) => { if (overlay.shown) dot(at(ghostCycle(run, app.ways, overlay, app.now * run.cycle)), 6, style.overlays[n % style.overlays.length]); });
    if (this.hovered >= 0) dot([this.xs[this.hovered], this.ys[this.hovered]], 5, style.faint);
    const [x, y] = at(app.now);
    g.strokeStyle = style.text; g.fillStyle = style.tool; g.lineWidth = 1.4;
    if (this.camera instanceof SpaceCamera) {
      // A cutter that stands on its point.
      const [dx, dy] = [this.camera.rows[0][2] * 26, -this.camera.rows[1][2] * 26];
      g.beginPath(); g.moveTo(x, y); g.lineTo(x + dx * 0.45 - 5, y + dy * 0.45); g.lineTo(x + dx - 5, y + dy);
      g.lineTo(x + dx + 5, y + dy); g.lineTo(x + dx * 0.45 + 5, y + dy * 0.45); g.closePath(); g.fill(); g.stroke();
    }
    g.beginPath(); g.arc(x, y, 4, 0, 7); g.fill(); g.stroke();
    if (!(this.camera instanceof SpaceCamera)) {
      g.beginPath(); g.moveTo(x - 11, y); g.lineTo(x - 4, y); g.moveTo(x + 4, y); g.lineTo(x + 11, y);
      g.moveTo(x, y - 11); g.lineTo(x, y - 4); g.moveTo(x, y + 4); g.lineTo(x, y + 11); g.stroke();
    }
  }
}

/** Whether a line is beyond one edge of the sheet. */
function outside(x0, y0, x1, y1, w, h, room) {
  return x0 < -room && x1 < -room || x0 > w + room && x1 > w + room || y0 < -room && y1 < -room || y0 > h + room && y1 > h + room;
}
