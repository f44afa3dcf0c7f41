// Time: slider, animation, keys.

const RATES = [0.01, 0.1, 0.5, 1, 2, 5, 10, 50, 100, 500, 1000];

class Player {
  constructor(app, { slider, play, rate, time }) {
    Object.assign(this, { app, slider, play, time, playing: false });
    slider.max = String(app.run.cycles);
    slider.addEventListener("input", () => app.go(Number(slider.value)));
    play.addEventListener("click", () => this.toggle());
    // The whole in a minute or less, and no slower than it is.
    const wanted = RATES.find(x => x >= Math.max(1, app.run.seconds / 60)) ?? RATES[RATES.length - 1];
    for (const x of RATES) rate.append(element("option", { value: x, ...(x === wanted ? { selected: "" } : {}) }, `${x} ×`));
    this.rate = rate;
  }

  toggle(on = !this.playing) {
    const { app } = this;
    if (on && app.now >= app.run.cycles) app.go(0);
    this.playing = on;
    this.play.textContent = on ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) return;
    let before = performance.now();
    const step = now => {
      if (!this.playing) return;
      const cycles = (now - before) / 1000 * Number(this.rate.value) / app.run.cycle;
      before = now;
      app.go(Math.min(app.run.cycles, app.now + cycles), true);
      if (app.now >= app.run.cycles) this.toggle(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  show() {
    const { app } = this;
    this.slider.value = String(app.now);
    this.slider.setAttribute("aria-valuetext", hms(app.now * app.run.cycle));
    this.time.textContent = `${hms(app.now * app.run.cycle)} of ${hms(app.run.seconds)}`;
  }

  /** Keys, where no field has them. */
  key(e) {
    const { app } = this, typing = /^(SELECT|TEXTAREA)$/.test(e.target.tagName) || e.target.tagName === "INPUT" && e.target.type !== "range" && e.target.type !== "checkbox";
    if (typing || e.ctrlKey || e.altKey || e.metaKey) return;
    const onSlider = e.target === this.slider, [from, to] = app.window;
    const fast = e.shiftKey ? Math.max(1, Math.round((to - from) / 50)) : 1;
    const keys = {
      " ": () => e.target.tagName !== "BUTTON" && this.toggle(),
      ArrowLeft: () => app.go(Math.ceil(app.now - fast), true),
      ArrowRight: () => app.go(Math.floor(app.now + fast), true),
      Home: () => app.go(0, true),
      End: () => app.go(app.run.cycles, true),
      "+": () => app.zoomTime(0.5), "=": () => app.zoomTime(0.5), "-": () => app.zoomTime(2),
      0: () => app.seeAll(),
      ",": () => app.step(-1), ".": () => app.step(1),
    };
    if (!keys[e.key] || onSlider && e.key === " ") return;
    if (keys[e.key]() !== false) e.preventDefault();
  }
}
