// From space to the screen and back. Sizes of the screen are in pixels; a camera keeps its place and scale when it is given another.

/** Straight from above: X to the right, Y up. */
class PlanCamera {
  constructor() { this.centre = [0, 0, 0]; this.perMm = 1; this.w = 1; this.h = 1; }

  /** Shows as much as before. */
  resize(w, h) {
    this.perMm *= Math.min(w / this.w, h / this.h);
    this.w = w; this.h = h;
  }

  fit(bounds) {
    this.centre = bounds.map(([low, high]) => (low + high) / 2);
    const [x, y] = bounds.map(([low, high]) => high - low);
    const room = 0.86, least = 1e-3;
    this.perMm = Math.min(this.w * room / Math.max(x, least), this.h * room / Math.max(y, least));
  }

  /** What goes right and up on the screen for one of each axis. */
  get rows() { return [[1, 0, 0], [0, 1, 0]]; }

  /** Pixels of a point. */
  at(x, y, z) {
    const [right, up] = this.rows, [cx, cy, cz] = this.centre;
    const [dx, dy, dz] = [x - cx, y - cy, z - cz];
    return [
      this.w / 2 + (right[0] * dx + right[1] * dy + right[2] * dz) * this.perMm,
      this.h / 2 - (up[0] * dx + up[1] * dy + up[2] * dz) * this.perMm,
    ];
  }

  /** Moves what is seen by pixels. */
  pan(dx, dy) {
    const [right, up] = this.rows;
    for (let n = 0; n < 3; n++) this.centre[n] -= (right[n] * dx - up[n] * dy) / this.perMm;
  }

  /** Makes things greater by a factor around a pixel. */
  zoom(px, py, factor) {
    const next = Math.min(1e7, Math.max(1e-6, this.perMm * factor)), k = next / this.perMm;
    this.pan((px - this.w / 2) * (1 / k - 1), (py - this.h / 2) * (1 / k - 1));
    this.perMm = next;
  }
}

/** From anywhere, without perspective. Z is up, always: the camera turns around it (yaw), and up and down (pitch). */
class SpaceCamera extends PlanCamera {
  constructor() { super(); this.home(); }

  home() { this.yaw = -Math.PI / 5; this.pitch = Math.PI / 6; }

  fit(bounds) {
    this.centre = bounds.map(([low, high]) => (low + high) / 2);
    let [w, h] = [1e-3, 1e-3];
    const [right, up] = this.rows;
    for (let corner = 0; corner < 8; corner++) {
      const d = bounds.map(([low, high], n) => ((corner >> n & 1) - 0.5) * (high - low));
      w = Math.max(w, 2 * Math.abs(right[0] * d[0] + right[1] * d[1] + right[2] * d[2]));
      h = Math.max(h, 2 * Math.abs(up[0] * d[0] + up[1] * d[1] + up[2] * d[2]));
    }
    this.perMm = Math.min(this.w * 0.84 / w, this.h * 0.84 / h);
  }

  get rows() {
    const [c, s] = [Math.cos(this.yaw), Math.sin(this.yaw)], [p, q] = [Math.cos(this.pitch), Math.sin(this.pitch)];
    // Looking from the side of -Y, from above: right of it is +X.
    return [[c, s, 0], [-s * q, c * q, p]];
  }

  /** Towards the eye. */
  get towards() {
    const [a, b] = this.rows;
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  }

  turn(dx, dy) {
    this.yaw -= dx * 0.008;
    this.pitch = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, this.pitch + dy * 0.008));
  }
}

/** All points of a path in pixels. */
function project(camera, path, xs, ys) {
  const [[a, b, c], [d, e, f]] = camera.rows, [cx, cy, cz] = camera.centre, k = camera.perMm;
  const [X, Y, Z] = path.xyz, [ox, oy] = [camera.w / 2, camera.h / 2];
  for (let i = 0; i < path.count; i++) {
    const x = X[i] - cx, y = Y[i] - cy, z = Z[i] - cz;
    xs[i] = ox + (a * x + b * y + c * z) * k;
    ys[i] = oy - (d * x + e * y + f * z) * k;
  }
}

/** The point of a path that is nearest to a pixel, within `reach` pixels; -1 if none is. Where the path passes there several times, the
 * one next to point `around`. */
function nearest(xs, ys, count, px, py, reach, around = 0) {
  let best = reach * reach;
  for (let i = 0; i < count; i++) best = Math.min(best, (xs[i] - px) ** 2 + (ys[i] - py) ** 2);
  const most = (Math.sqrt(best) + 1) ** 2;
  let at = -1;
  for (let i = 0; i < count; i++) {
    if ((xs[i] - px) ** 2 + (ys[i] - py) ** 2 < Math.min(most, reach * reach) && (at < 0 || Math.abs(i - around) < Math.abs(at - around))) at = i;
  }
  return at;
}
