// Puts the page together.

const $ = id => document.getElementById(id);

class App {
  constructor(head, columns, source) {
    this.head = head;
    this.run = new Run(head, columns);
    this.path = outlineOf(this.run);
    this.programmed = programmedOf(head, columns);
    this.bounds = boundsOf(this.path, this.programmed);
    this.overlays = head.overlays.map((overlay, n) => ({ ...overlayOf(overlay, columns[`overlay${n}`]), shown: true }));
    this.ways = this.overlays.length ? waysOf(this.run) : null;
    this.source = source;
    this.now = 0;
    this.hovered = -1;
    this.window = [0, this.total];
    this.mode = "share";
    this.shows = { programmed: true, rapids: true, limits: false };
    // Axes that stand still all the time would only be in the way.
    const moves = axis => axis.peaks[0][1] - axis.peaks[0][0] > head.count;
    this.hidden = new Set(this.run.axes.flatMap((axis, n) => moves(axis) || !this.run.axes.some(moves) ? [] : [n]));
    this.dirty = new Set();
  }

  /** Cycles of what there is to be seen: this run, or a slower law. */
  get total() {
    const others = this.overlays.filter(overlay => overlay.shown).map(overlay => overlay.seconds / this.run.cycle);
    return Math.max(LEAST_WINDOW, this.run.cycles, ...others);
  }

  build() {
    this.theme();
    this.words();
    if (this.source !== null) this.listing = new Listing($("code"), this, this.source);
    else $("code").append(element("p", { class: "faint" }, this.head.name.endsWith(".json") ? "A curve has no lines." : "The file is empty, or too long to be shown here."));
    this.views = [new View($("plan"), this, new PlanCamera()), new View($("space"), this, new SpaceCamera())];
    this.charts = this.makeCharts($("charts"));
    this.player = new Player(this, { slider: $("slider"), play: $("play"), rate: $("rate"), time: $("time") });
    $("slow").append(slowPlaces(this));
    $("figures").append(figures(this));
    const list = events(this);
    if (list) $("events").append(list); else $("events-part").remove();
    this.controls();
    this.drawAll();
    this.fromAddress();
  }

  makeCharts(parent) {
    const { run } = this, axes = kind => run.axes.map((axis, n) => ({ name: axis.letter, axis: n, series: Series.axis(run, n, kind) }));
    const both = name => n => [-run.axes[n][name], run.axes[n][name]];
    const unit = run.axes.some(axis => axis.rotary) ? (run.axes.every(axis => axis.rotary) ? "°" : "mm or °") : "mm";
    const speed = () => [{ name: "speed", series: Series.speed(run) }];
    const charts = [new Chart(parent, this, { title: "speed along the path", unit: "mm/s", curves: speed(), feed: true, overlays: true })];
    if (this.overlays.length) charts.push(new WayChart(parent, this, { title: "speed over the way", unit: "mm/s", curves: speed(), feed: true, overlays: true }));
    charts.push(
      new Chart(parent, this, { title: "position", unit, curves: axes(POSITION), limits: n => [run.axes[n].least, run.axes[n].greatest] }),
      new Chart(parent, this, { title: "velocity", unit: `${unit}/s`, curves: axes(VELOCITY), limits: both("velocity") }),
      new Chart(parent, this, { title: "acceleration", unit: `${unit}/s²`, curves: axes(ACCELERATION), limits: both("acceleration") }),
      new Chart(parent, this, { title: "jerk", unit: `${unit}/s³`, curves: axes(JERK), limits: both("jerk") }),
      new Chart(parent, this, { title: "deviation from the programmed path", unit: "mm", curves: [{ name: "deviation", series: Series.deviation(run) }], limits: () => [null, this.head.tolerance] }),
    );
    return charts;
  }

  /** What is said above the views. */
  words() {
    const { head, run } = this, facts = [
      ["time", hms(head.time)], ["length", `${label(head.length, 7)} mm`], ["mean speed", `${label(head.mean_speed, 4)} mm/s`],
      ["deviation", `${label(head.deviation, 4)} of ${label(head.tolerance)} mm`],
    ];
    $("facts").append(...facts.map(([name, value]) => element("span", {}, element("i", {}, name), ` ${value}`)));
    const notes = [];
    if (head.broken.length) notes.push(["bad", `The run broke limits: ${head.broken.join("; ")}.`]);
    if (head.starved) notes.push(["bad", `It stopped ${head.starved} times for want of blocks.`]);
    const curves = `velocity, acceleration and jerk within ${head.curves_off.map(x => `${label(x * 100, 2)} %`).join(", ")} of their limits`;
    const within = `positions within ${label(head.off, 3)} mm`;
    const thinned = head.level ? "Thinned, because the run is long: " : "Drawn: every servo cycle, ";
    notes.push([head.off > head.part * 1.02 ? "bad" : "faint",
      `${thinned}${within} (${label(head.off / Math.max(head.tolerance, 1e-12) * 100, 2)} % of the tolerance), ${curves}.`]);
    if (!(head.tolerance > 0)) notes[notes.length - 1][1] = `${thinned}${within}, ${curves}.`;
    if (!run.spans || this.path.count < 2) notes.push(["faint", "Nothing moved."]);
    $("notes").append(...notes.map(([kind, text]) => element("p", { class: kind }, text)));
  }

  controls() {
    const bind = (id, set) => $(id).addEventListener("change", e => { set(e.target); });
    bind("colour", e => this.colour(e.value));
    bind("programmed", e => { this.shows.programmed = e.checked; this.views.forEach(v => this.later(v)); });
    bind("rapids", e => { this.shows.rapids = e.checked; this.views.forEach(v => this.later(v)); });
    bind("limits", e => { this.shows.limits = e.checked; this.charts.forEach(c => this.later(c)); });
    $("all").addEventListener("click", () => this.seeAll());
    $("zoom-in").addEventListener("click", () => this.zoomTime(0.5));
    $("zoom-out").addEventListener("click", () => this.zoomTime(2));
    $("top-view").addEventListener("click", () => { this.turn(0, Math.PI / 2); });
    $("front-view").addEventListener("click", () => { this.turn(0, 0); });
    $("side-view").addEventListener("click", () => { this.turn(Math.PI / 2, 0); });
    $("home-view").addEventListener("click", () => { this.views[1].camera.home(); this.views[1].seeAll(); this.later(this.views[1]); });
    const modes = ["auto", "light", "dark"], theme = $("theme");
    theme.addEventListener("click", () => {
      this.asked = modes[(modes.indexOf(this.asked ?? "auto") + 1) % 3];
      theme.textContent = { auto: "◐", light: "☀", dark: "☾" }[this.asked];
      theme.title = `Colours of the page: ${this.asked}`;
      this.theme(); this.recolour();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.theme(); this.recolour(); });
    document.addEventListener("keydown", e => this.player.key(e));
    this.overlays.forEach((overlay, n) => {
      const box = element("input", { type: "checkbox", checked: "", onchange: e => { overlay.shown = e.target.checked; this.fitTime(); } });
      const chip = element("label", {}, box, ` ${overlay.name}: ${hms(overlay.seconds)}`);
      chip.style.setProperty("--ink", this.style.overlays[n % this.style.overlays.length]);
      $("overlays").append(chip);
    });
  }

  /** Colours, as the page or the reader wants them. */
  theme() {
    const root = document.documentElement;
    if (!this.asked || this.asked === "auto") delete root.dataset.theme; else root.dataset.theme = this.asked;
    const css = getComputedStyle(root), value = name => css.getPropertyValue(`--${name}`).trim();
    this.dark = value("theme") === "dark";
    const names = ["text", "faint", "grid", "band", "programmed", "pale", "limit", "chosen", "now", "tool", "speed"];
    this.style = Object.fromEntries(names.map(name => [name, value(name)]));
    this.style.axes = value("axes").split(" ");
    this.style.overlays = value("laws").split(" ");
    this.levels();
  }

  levels() {
    this.cache ??= {};
    this.cache[this.mode] ??= levelsOf(this.run, this.path, this.mode);
    const { levels, most } = this.cache[this.mode];
    this.palette = paletteOf(this.mode, this.dark ? "dark" : "light");
    this.lists = byLevel(levels, this.palette.length);
    $("legend").replaceChildren(...legendOf(this.mode, most, this.palette, this.lists).map(([colour, words]) => {
      const mark = element("i");
      mark.style.background = colour;
      return element("span", {}, mark, words);
    }));
  }

  colour(mode) {
    this.mode = mode;
    $("colour").value = mode;
    this.levels();
    this.views.forEach(view => this.later(view));
  }

  recolour() {
    this.charts.forEach(chart => chart.captions());
    [...$("overlays").children].forEach((chip, n) => chip.style.setProperty("--ink", this.style.overlays[n % this.style.overlays.length]));
    this.drawAll();
  }

  /** Draws before the next frame. */
  later(part) {
    if (!this.dirty.size) requestAnimationFrame(() => {
      const parts = [...this.dirty];
      this.dirty.clear();
      for (const each of parts) if (each === "top") this.drawTops(); else { each.draw(); each.drawTop(); }
    });
    this.dirty.add(part);
  }

  drawAll() { for (const part of [...this.views, ...this.charts]) this.later(part); this.later("top"); }

  drawTops() {
    for (const part of [...this.views, ...this.charts]) part.drawTop();
    this.player.show();
    this.tell();
  }

  /** What goes on now, in words. */
  tell() {
    const { run } = this, cycle = this.hovered >= 0 ? this.hovered : this.now, place = run.place(cycle), line = run.lineAt(cycle);
    if (this.hovered < 0) this.listing?.show(line);
    $("line").textContent = line ? `line ${line}` : "before the first line";
    $("words").textContent = this.listing?.text(line).trim() ?? "";
    if (!place) { $("values").textContent = ""; return; }
    const values = run.axes.map((axis, n) => `${axis.letter} ${run.value(n, POSITION, cycle).toFixed(axis.rotary ? 3 : 4)}`);
    const { all } = speeds(run, place.s, place.u, place.h), { share, rapid, feed } = feedShare(run, place.s, place.u, place.h);
    const { code, name } = binding(run, place.s, place.u, place.h), mode = run.modeAt(cycle);
    values.push(`${label(all, 4)} mm/s`);
    if (rapid) values.push("rapid"); else if (feed > 0 && all >= RESTS) values.push(`${Math.round(share * 1000) / 10} % of F ${label(feed * 60, 5)}`);
    values.push(code === REST || mode.activity !== RUNNING ? (ACTIVITIES[mode.activity] === "running" ? "at rest" : ACTIVITIES[mode.activity]) : `binds: ${BINDS[code]} ${name}`.trim());
    if (mode.percent !== 100) values.push(`override ${mode.percent} %`);
    values.push(`${label(run.deviation[place.s], 2)} mm off`);
    $("values").replaceChildren(...values.map(text => element("span", {}, text)));
    $("when").textContent = hms(cycle * run.cycle);
  }

  /** To a cycle; `follow` keeps it in sight. */
  go(cycle, follow = false) {
    this.now = Math.min(this.run.cycles, Math.max(0, cycle));
    const [from, to] = this.window;
    if (follow && (this.now < from || this.now > to)) {
      const middle = this.now + (to - from) * 0.4;
      this.setWindow(middle - (to - from) / 2, middle + (to - from) / 2, true);
    }
    this.later("top");
  }

  /** To a place: near enough to see what goes on there. */
  visit(cycle) {
    const half = Math.max(LEAST_WINDOW, Math.min(this.total / 2, 0.25 / this.run.cycle));
    this.go(cycle);
    this.setWindow(this.now - half, this.now + half, true);
    const [from, to] = this.window, near = { count: 0, xyz: [[], [], []] };
    for (let k = 0; k <= 40; k++) {
      const at = this.run.position(from + (Math.min(to, this.run.cycles) - from) * k / 40);
      near.xyz.forEach((list, n) => list.push(at[n] ?? 0));
      near.count++;
    }
    const size = Math.max(...boundsOf(near).map(([low, high]) => high - low));
    for (const view of this.views) { view.show(this.now, Math.max(size * 1.3, this.head.tolerance * 20, 1e-3)); this.later(view); }
  }

  /** To the next or last line that is run. */
  step(by) {
    const { at } = this.run.lines, k = lastAt(at, this.now) + by;
    if (k >= 0 && k < at.length) this.go(at[k], true);
  }

  note(cycle) {
    const next = cycle < 0 ? -1 : Math.min(this.run.cycles, Math.max(0, cycle));
    if (next === this.hovered) return;
    this.hovered = next;
    this.later("top");
  }

  /** What is seen of the time, cycles; `keep`: as much as was asked for, moved to where there is any. */
  setWindow(from, to, keep = false) {
    const total = this.total;
    let size = Math.min(total, Math.max(LEAST_WINDOW, to - from));
    if (keep || size > to - from) {
      const middle = (from + to) / 2;
      from = Math.min(total - size, Math.max(0, middle - size / 2));
      to = from + size;
    }
    this.window = [Math.max(0, from), Math.min(total, to)];
    if (this.window[1] - this.window[0] < LEAST_WINDOW) this.window = [Math.max(0, this.window[1] - LEAST_WINDOW), Math.max(LEAST_WINDOW, this.window[1])];
    this.shownWindow();
    for (const part of [...this.charts, ...this.views]) this.later(part);
  }

  shownWindow() {
    const [from, to] = this.window.map(c => hms(c * this.run.cycle)), whole = this.window[0] <= 0 && this.window[1] >= this.total;
    $("shown").textContent = whole ? "" : `seen: ${from} to ${to}`;
  }

  zoomTime(factor) {
    const [from, to] = this.window, at = this.now >= from && this.now <= to ? this.now : (from + to) / 2;
    this.setWindow(at + (from - at) * factor, at + (to - at) * factor);
  }

  fitTime() { this.setWindow(0, this.total); this.later("top"); }

  seeAllTime() { this.fitTime(); }

  seeAll() {
    this.views.forEach(view => { view.seeAll(); });
    this.fitTime();
  }

  turn(yaw, pitch) {
    const { camera } = this.views[1];
    Object.assign(camera, { yaw, pitch });
    this.views[1].seeAll();
    this.later(this.views[1]);
  }

  axisShown(axis) { return !this.hidden.has(axis); }

  switchAxis(axis) {
    if (!this.hidden.delete(axis)) this.hidden.add(axis);
    for (const chart of this.charts) { chart.captions(); this.later(chart); }
  }

  /** `#t=12.5&from=10&to=20&colour=binds&theme=dark`: a place to be shown to others. */
  fromAddress() {
    const asked = new URLSearchParams(location.hash.slice(1)), time = name => Number(asked.get(name)) / this.run.cycle;
    if (["light", "dark"].includes(asked.get("theme"))) { this.asked = asked.get("theme"); this.theme(); this.recolour(); }
    if (["share", "speed", "binds", "deviation"].includes(asked.get("colour"))) this.colour(asked.get("colour"));
    if (asked.has("t")) this.go(time("t"));
    if (asked.has("from") && asked.has("to")) this.setWindow(time("from"), time("to"));
    if (asked.has("visit")) this.visit(time("visit"));
    if (asked.has("slow")) { const place = this.head.slow[Number(asked.get("slow")) - 1]; if (place) this.visit(this.run.cycleAt(place.time)); }
  }
}

async function start() {
  const began = performance.now();
  try {
    const head = JSON.parse($("head").textContent);
    const [bytes, text] = await Promise.all([unpack($("body").textContent), unpack($("source").textContent)]);
    const app = new App(head, columnsOf(head, bytes), head.source ? new TextDecoder().decode(text) : null);
    document.body.classList.remove("loading");
    window.app = app;
    app.build();
    // When all of it has been drawn, ms after the script began.
    requestAnimationFrame(() => requestAnimationFrame(() => { document.documentElement.dataset.ready = Math.round(performance.now() - began); }));
  } catch (error) {
    $("notes").append(element("p", { class: "bad" }, `This page could not be shown: ${error}. It needs a browser of 2023 or later.`));
    throw error;
  }
}

start();
