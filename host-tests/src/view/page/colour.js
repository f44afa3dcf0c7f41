// Colours of the path.

/** Steps of a ramp. */
const STEPS = 24;
/** Behind the ramp: rapids, motion off the path. */
const RAPID = STEPS, OFF_PATH = STEPS + 1, LEVELS = STEPS + 2;

const RAMPS = {
  light: {
    share: ["#b2182b", "#e8702a", "#c9a800", "#3f9b55", "#1f5fae"],
    speed: ["#5b2a86", "#3b63b0", "#1f9189", "#77a82f", "#d08a00"],
    deviation: ["#7d8b99", "#3f7fb5", "#c9a800", "#e8702a", "#b2182b"],
    binds: ["#9aa1a8", "#1f5fae", "#1f9189", "#e07b00", "#c8102e", "#555555"],
    extra: ["#8f8fb0", "#b05fb0"],
  },
  dark: {
    share: ["#ff5a5f", "#ff9a4d", "#f2dc4e", "#5fd38a", "#62b0ff"],
    speed: ["#b58cff", "#7aa2ff", "#3ccfc4", "#b4e04f", "#ffd24a"],
    deviation: ["#8895a3", "#62b0ff", "#f2dc4e", "#ff9a4d", "#ff5a5f"],
    binds: ["#7d8790", "#62b0ff", "#3ccfc4", "#ffa53d", "#ff5a5f", "#9aa1a8"],
    extra: ["#77779c", "#d68cd6"],
  },
};

function rgb(hex) { return [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16)); }

/** A colour of a ramp at a share. */
function ramp(stops, share) {
  const x = Math.min(1, Math.max(0, share)) * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(x));
  const [a, b] = [rgb(stops[k]), rgb(stops[k + 1])];
  return `rgb(${a.map((c, n) => Math.round(c + (b[n] - c) * (x - k))).join(",")})`;
}

/** The colours of a mode by level. */
function paletteOf(mode, theme) {
  const ramps = RAMPS[theme];
  if (mode === "binds") return ramps.binds;
  const steps = Array.from({ length: STEPS }, (_, k) => ramp(ramps[mode], k / (STEPS - 1)));
  return [...steps, ...ramps.extra];
}

/** The level of every stretch of a path between two of its points, and the scale of the ramp. */
function levelsOf(run, path, mode) {
  const levels = new Uint8Array(Math.max(0, path.count - 1));
  let most = 1e-9;
  const values = mode === "binds" || mode === "share" ? null : new Float32Array(levels.length);
  const step = (share) => Math.min(STEPS - 1, Math.max(0, Math.round(share * (STEPS - 1))));
  for (let i = 0; i < levels.length; i++) {
    const s = path.span[i + 1], n = run.begin[s + 1] - run.begin[s], h = n * run.cycle;
    const from = Math.max(run.begin[s], path.cycle[i]), u = ((from + path.cycle[i + 1]) / 2 - run.begin[s]) / n;
    if (mode === "binds") levels[i] = binding(run, s, u, h).code;
    else if (mode === "speed") most = Math.max(most, values[i] = speeds(run, s, u, h).all);
    else if (mode === "deviation") most = Math.max(most, values[i] = run.deviation[s]);
    else if (run.modeAt(run.begin[s]).activity === JOGGING) levels[i] = OFF_PATH;
    else {
      const { share, rapid } = feedShare(run, s, u, h);
      levels[i] = rapid ? RAPID : step(share);
    }
  }
  // A deviation is seen against the tolerance.
  if (mode === "deviation") most = Math.max(most, run.head.tolerance);
  if (values) for (let i = 0; i < levels.length; i++) levels[i] = step(values[i] / most);
  return { levels, most: mode === "share" ? 1 : most };
}

/** The stretches of each level, in order. */
function byLevel(levels, count) {
  const sizes = new Uint32Array(count);
  for (const level of levels) sizes[level]++;
  const lists = Array.from(sizes, size => new Uint32Array(size));
  sizes.fill(0);
  levels.forEach((level, i) => { lists[level][sizes[level]++] = i; });
  return lists;
}

/** What the colours mean: pairs of a colour and words. */
function legendOf(mode, scale, palette, lists) {
  const used = level => lists[level] && lists[level].length > 0;
  if (mode === "binds") return BINDS.map((words, code) => [palette[code], words]).filter((_, code) => used(code));
  const marks = [0, 0.25, 0.5, 0.75, 1].map(share => {
    const value = mode === "share" ? `${share * 100} %` : label(share * scale, 3) + (mode === "speed" ? " mm/s" : " mm");
    return [palette[Math.round(share * (STEPS - 1))], value];
  });
  if (used(RAPID)) marks.push([palette[RAPID], "rapid"]);
  if (used(OFF_PATH)) marks.push([palette[OFF_PATH], "jog"]);
  return marks;
}
