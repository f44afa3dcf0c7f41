// Numbers as text.

/** A time as h:m:s; below a minute in seconds. */
function hms(seconds, digits = 3) {
  if (!(Math.abs(seconds) < Infinity)) return "-";
  const sign = seconds < 0 ? "-" : "";
  // Rounded first: 59.9996 s are a minute.
  const unit = 10 ** digits, whole = Math.round(Math.abs(seconds) * unit);
  if (whole < 60 * unit) return `${sign}${(whole / unit).toFixed(digits)} s`;
  const s = whole % (60 * unit), minutes = Math.round((whole - s) / (60 * unit));
  const text = (s / unit).toFixed(digits).padStart(digits ? digits + 3 : 2, "0");
  return `${sign}${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}:${text}`;
}

/** A number with as many digits as are of use. */
function label(value, digits = 6) {
  if (!Number.isFinite(value)) return "-";
  if (value !== 0 && (Math.abs(value) >= 1e7 || Math.abs(value) < 1e-5)) return value.toExponential(2);
  return String(parseFloat(value.toPrecision(digits)));
}

/** A speed over the feed that is asked for; an event or a dwell asks for none. */
function speedOf(speed, feed) { return `${label(speed, 3)} / ${feed > 0 ? label(feed, 3) : "-"}`; }

/** Even places for about `count` labels. */
function ticks(low, high, count) {
  if (!(high > low)) return [];
  const raw = (high - low) / Math.max(1, count), base = 10 ** Math.floor(Math.log10(raw));
  const step = base * ([1, 2, 5].find(k => k * base >= raw * 0.999) ?? 10);
  return places(low, high, step);
}

/** The same for times: whole minutes and hours where they are long. */
function timeTicks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  if (!(raw > 10)) return ticks(low, high, count);
  const step = [15, 20, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 43200, 86400].find(s => s >= raw);
  return step ? places(low, high, step) : ticks(low, high, count);
}

function places(low, high, step) {
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) out.push(k * step + 0);
  return out;
}

/** A time of such a place: no more digits than they differ by. */
function timeLabel(seconds, step) {
  if (step >= 1 && seconds < 60) return `${Math.round(seconds)} s`;
  return hms(seconds, step >= 1 ? 0 : Math.min(6, Math.ceil(-Math.log10(step) - 1e-9)));
}
