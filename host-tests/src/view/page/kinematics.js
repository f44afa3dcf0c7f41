// What axes make of a motion: speed, the share of the feed, what binds.

const IDLE = 0, RUNNING = 1, DWELLING = 2, EVENT = 3, SET = 4, JOGGING = 5;
const ACTIVITIES = ["at rest", "running", "dwell", "event", "coordinates set", "jog"];

/** A limit counts as reached from this share of it on. */
const REACHED = 0.95;
/** A feed counts as reached from this share of it on. */
const AT_FEED = 0.98;
/** Below this speed, mm/s, the machine rests. */
const RESTS = 1e-3;

const NOTHING = 0, FEED = 1, AXIS_VELOCITY = 2, AXIS_ACCELERATION = 3, AXIS_JERK = 4, REST = 5;
const BINDS = ["nothing much", "feed", "velocity", "acceleration", "jerk", "at rest"];

/** Speeds at a place: over all axes, and over those that a feed word is for. */
function speeds(run, s, u, h, whole = false) {
  let all = 0, linear = 0;
  for (const axis of run.axes) {
    const v = axis.at(VELOCITY, s, u, h), square = v * v;
    all += square;
    if (!axis.rotary) linear += square;
  }
  all = Math.sqrt(all);
  return { all, fed: whole || linear === 0 ? all : Math.sqrt(linear) };
}

/** The share of the programmed feed at a place, and whether it is a rapid or no move at all. */
function feedShare(run, s, u, h) {
  const { kind, feed } = run.feedAt(run.begin[s] + u * (run.begin[s + 1] - run.begin[s]));
  const { fed } = speeds(run, s, u, h, kind === 1);
  return { share: feed > 0 ? fed / feed : 1, rapid: kind === 2, feed };
}

/** The greatest share of its limit that any axis or motor has of a quantity, and which. */
function limitShare(run, kind, s, u, h) {
  let share = 0, name = "";
  const see = (value, limit, whose) => {
    if (Math.abs(value) / limit > share) { share = Math.abs(value) / limit; name = whose; }
  };
  const limit = ["", "velocity", "acceleration", "jerk"][kind];
  const values = run.axes.map(axis => axis.at(kind, s, u, h));
  run.axes.forEach((axis, n) => see(values[n], axis[limit], axis.letter));
  for (const motor of run.head.motors) {
    see(motor.factors.reduce((sum, factor, n) => sum + factor * values[n], 0), motor[limit], motor.name);
  }
  return { share, name };
}

/** What holds the motion back at a place: its code, and the axis. */
function binding(run, s, u, h) {
  if (speeds(run, s, u, h).all < RESTS) return { code: REST, name: "" };
  // What is drawn is a little off what was run.
  const inside = Math.max(0.5, REACHED - run.head.curves_off[2]);
  const n = run.begin[s + 1] - run.begin[s], mid = Math.min(1 - 0.5 / n, Math.max(0.5 / n, u));
  const jerk = limitShare(run, JERK, s, mid, h);
  if (jerk.share >= inside) return { code: AXIS_JERK, name: jerk.name };
  const acceleration = limitShare(run, ACCELERATION, s, u, h);
  if (acceleration.share >= REACHED) return { code: AXIS_ACCELERATION, name: acceleration.name };
  const velocity = limitShare(run, VELOCITY, s, u, h);
  if (velocity.share >= AT_FEED) return { code: AXIS_VELOCITY, name: velocity.name };
  const mode = run.modeAt(run.begin[s]);
  if (feedShare(run, s, u, h).share >= AT_FEED * Math.min(1, mode.percent / 100)) return { code: FEED, name: "" };
  return { code: NOTHING, name: "" };
}
