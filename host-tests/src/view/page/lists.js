// Lists beside the charts: G-code, slow places, events, figures.

const ROW = 20;

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/** The lines of the file: those in sight are in the page, and no others. */
class Listing {
  constructor(box, app, text) {
    this.app = app;
    this.lines = text.split("\n");
    this.box = box;
    this.space = element("div", { class: "space" });
    this.space.style.height = `${this.lines.length * ROW}px`;
    box.append(this.space);
    box.addEventListener("scroll", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(box);
    this.space.addEventListener("click", e => {
      const row = e.target.closest("[data-line]");
      if (!row) return;
      const cycle = app.run.cycleOfLine(Number(row.dataset.line));
      if (cycle >= 0) app.go(cycle, true);
    });
    this.current = -1;
    this.draw();
  }

  text(line) { return this.lines[line - 1] ?? ""; }

  show(line) {
    if (line === this.current) return;
    this.current = line;
    const top = (line - 1) * ROW, { scrollTop, clientHeight } = this.box;
    if (top < scrollTop + ROW || top > scrollTop + clientHeight - 3 * ROW) this.box.scrollTop = top - clientHeight / 2 + ROW / 2;
    this.draw();
  }

  draw() {
    const { scrollTop, clientHeight } = this.box, first = Math.max(0, Math.floor(scrollTop / ROW) - 2);
    const last = Math.min(this.lines.length, first + Math.ceil(clientHeight / ROW) + 5);
    this.space.replaceChildren(...this.lines.slice(first, last).map((text, k) => {
      const line = first + k + 1;
      const row = element("div", { class: line === this.current ? "row now" : "row", "data-line": line }, element("i", {}, String(line)), text);
      row.style.top = `${(line - 1) * ROW}px`;
      return row;
    }));
  }
}

/** A table whose rows lead to a time. */
function tableOf(heads, rows) {
  const body = element("tbody");
  for (const { cells, go } of rows) {
    const row = element("tr", go ? { tabindex: 0, role: "button", onclick: go, onkeydown: e => { if (e.key === "Enter") go(); } } : {});
    row.append(...cells.map(cell => element("td", {}, String(cell))));
    body.append(row);
  }
  return element("table", {}, element("thead", {}, element("tr", {}, ...heads.map(head => element("th", {}, head)))), body);
}

/** Where time was lost. */
function slowPlaces(app) {
  const { slow } = app.head;
  if (!slow.length) return element("p", { class: "faint" }, "No place loses time.");
  return tableOf(["line", "lost", "slowest / feed, mm/s", "why"], slow.map(place => ({
    cells: [
      place.line, hms(place.lost),
      speedOf(place.slowest, place.feed),
      place.cause + (app.listing ? `: ${app.listing.text(place.line).trim()}` : ""),
    ],
    go: () => app.visit(app.run.cycleAt(place.time)),
  })));
}

/** What the program asked of the machine, and what the operator did. */
function events(app) {
  const program = app.head.events.map((event, n) => ({ ...event, who: `line ${app.head.event_lines[n]}` }));
  const all = [...program, ...app.head.commands.map(command => ({ ...command, who: "operator" }))];
  if (!all.length) return null;
  all.sort((a, b) => a.time - b.time);
  return tableOf(["time", "", "what"], all.map(event => ({
    cells: [hms(event.time), event.who, event.text], go: () => app.visit(app.run.cycleAt(event.time)),
  })));
}

/** Figures: how near to its limits each axis came. */
function figures(app) {
  const { head, run } = app, most = ends => Math.max(-ends[0], ends[1], 0);
  const share = (peak, limit) => `${label(peak, 4)} (${Math.round(peak / limit * 1000) / 10} %)`;
  // Less than what is recorded is nothing.
  const place = x => label(Math.abs(x) < head.count ? 0 : x, 6);
  const rows = run.axes.map(axis => ({
    cells: [
      axis.letter, `${place(axis.peaks[0][0])} to ${place(axis.peaks[0][1])}`,
      share(most(axis.peaks[1]), axis.velocity), share(most(axis.peaks[2]), axis.acceleration), share(most(axis.peaks[3]), axis.jerk),
    ],
  }));
  return tableOf(["axis", "from, to", "velocity (of its limit)", "acceleration", "jerk"], rows);
}
