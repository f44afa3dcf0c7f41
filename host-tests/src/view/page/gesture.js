// Mouse, fingers and wheel. One finger up and down always scrolls the page; across, it is a drag. Two fingers are the chart's.

/** Farther than this, pixels, is no click. */
const CLICK = 5;

/** Tells `to` of drags (`drag(dx, dy, event)`, `dragged(event)`), pinches (`pinch(x, y, factor, dx, dy)`), the wheel (`wheel(x, y, event)`),
 * clicks (`click(x, y)`) and the pointer (`hover(x, y)`, `leave()`). Places are in pixels of the element. */
function gestures(element, to) {
  const pointers = new Map();
  let moved = 0;
  const place = e => {
    const box = element.getBoundingClientRect();
    return { x: e.clientX - box.left, y: e.clientY - box.top };
  };
  element.style.touchAction = "pan-y";
  element.addEventListener("touchmove", e => { if (e.touches.length > 1 && e.cancelable) e.preventDefault(); }, { passive: false });
  element.addEventListener("contextmenu", e => e.preventDefault());
  element.addEventListener("wheel", e => {
    const { x, y } = place(e);
    if (to.wheel(x, y, e)) e.preventDefault();
  }, { passive: false });
  element.addEventListener("pointerdown", e => {
    if (e.button > 2) return;
    element.setPointerCapture(e.pointerId);
    if (!pointers.size) { moved = 0; to.down?.(place(e).x, e); }
    pointers.set(e.pointerId, place(e));
  });
  element.addEventListener("pointermove", e => {
    const before = pointers.get(e.pointerId), at = place(e);
    if (!before) { if (e.pointerType !== "touch") to.hover?.(at.x, at.y); return; }
    const [dx, dy] = [at.x - before.x, at.y - before.y];
    moved += Math.hypot(dx, dy);
    if (pointers.size === 2) {
      const other = [...pointers.entries()].find(([id]) => id !== e.pointerId)[1];
      const [d0, d1] = [before, at].map(p => Math.hypot(p.x - other.x, p.y - other.y));
      to.pinch((at.x + other.x) / 2, (at.y + other.y) / 2, d0 > 1 && d1 > 1 ? d1 / d0 : 1, dx / 2, dy / 2);
    } else if (moved > CLICK) to.drag(dx, e.pointerType === "touch" ? 0 : dy, e, at.x);
    pointers.set(e.pointerId, at);
  });
  const up = e => {
    if (!pointers.delete(e.pointerId) || pointers.size) return;
    const { x, y } = place(e);
    if (e.type === "pointerup" && moved <= CLICK && e.button === 0) to.click(x, y);
    else to.dragged?.(x, e.type === "pointercancel");
  };
  element.addEventListener("pointerup", up);
  element.addEventListener("pointercancel", up);
  element.addEventListener("pointerleave", () => { if (!pointers.size) to.leave?.(); });
}

/** Two canvases, one upon the other: what rarely changes, and what goes with the time. Sharp on any screen, and of the size of its box. */
class Sheets {
  constructor(box, resized) {
    this.box = box;
    this.base = document.createElement("canvas");
    this.top = document.createElement("canvas");
    this.top.className = "top";
    box.append(this.base, this.top);
    Object.assign(this, { w: 600, h: 400, ratio: 0 });
    new ResizeObserver(() => { if (this.measure()) resized(); }).observe(box);
    this.measure();
  }

  measure() {
    const ratio = Math.min(3, window.devicePixelRatio || 1), w = this.box.clientWidth, h = this.box.clientHeight;
    // Of no size for a moment, as in pages that are hidden or printed: what is seen stays as it is.
    if (w < 2 || h < 2) return false;
    if (w === this.w && h === this.h && ratio === this.ratio) return false;
    Object.assign(this, { w, h, ratio });
    for (const canvas of [this.base, this.top]) { canvas.width = Math.max(1, w * ratio); canvas.height = Math.max(1, h * ratio); }
    return true;
  }

  /** One of the two, empty. */
  clear(canvas) {
    const g = canvas.getContext("2d");
    g.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    g.clearRect(0, 0, this.w, this.h);
    g.font = "12px system-ui, sans-serif";
    g.lineJoin = g.lineCap = "round";
    return g;
  }
}
