// Pointers, wheel, fingers and keys upon the picture.

const STEP = 1.5; // of the zoom
const STILL = 4; // pixels that a pointer may travel in a click
const LINE = 20; // pixels, for wheels that count lines
const WHEEL = 0.0018;
const TOUCH_PAD = 0.01; // a pinch there comes as a wheel of small steps, with the control key
const SETTLED = 250; // milliseconds after which a page that was scrolled is at rest
const ARROWS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

class Pointers {
  constructor(viewer) {
    const { canvas } = viewer;
    this.viewer = viewer;
    this.down = new Map(); // places by the pointers' ids
    this.scrolled = -Infinity;
    addEventListener("scroll", () => (this.scrolled = performance.now()));
    canvas.addEventListener("pointerdown", (event) => this.pressed(event));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    canvas.addEventListener("pointerup", (event) => this.released(event, true));
    canvas.addEventListener("pointercancel", (event) => this.released(event, false));
    canvas.addEventListener("pointerleave", () => viewer.tell(null));
    canvas.addEventListener("wheel", (event) => this.wheeled(event), { passive: false });
    canvas.addEventListener("dblclick", (event) => viewer.zoom(2, ...this.place(event)));
  }

  place(event) {
    const { canvas } = this.viewer;
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left - canvas.clientLeft, event.clientY - box.top - canvas.clientTop];
  }

  pressed(event) {
    if (event.isTrusted) this.viewer.canvas.setPointerCapture(event.pointerId);
    this.down.set(event.pointerId, this.place(event));
    this.travelled = this.down.size > 1 ? Infinity : 0;
  }

  moved(event) {
    const before = this.down.get(event.pointerId);
    const now = this.place(event);
    if (!before) {
      this.viewer.tell(now);
      return;
    }
    this.viewer.tell(null);
    this.down.set(event.pointerId, now);
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    this.travelled += Math.hypot(dx, dy);
    if (this.down.size === 1) this.drag(dx, dy);
    else if (this.down.size === 2) this.pinch(event.pointerId, before, now);
  }

  drag(dx, dy) {
    if (this.travelled < STILL) return;
    this.viewer.canvas.classList.add("dragged");
    this.viewer.pan(dx, dy);
  }

  pinch(id, before, now) {
    const [other] = [...this.down].filter(([key]) => key !== id).map(([, place]) => place);
    const apart = (place) => Math.max(Math.hypot(place[0] - other[0], place[1] - other[1]), 1);
    this.viewer.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
    this.viewer.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  }

  released(event, done) {
    const clicked = done && this.down.size === 1 && this.travelled < STILL;
    this.down.delete(event.pointerId);
    this.viewer.canvas.classList.remove("dragged");
    if (clicked) this.viewer.select(this.viewer.picture.at(...this.place(event)));
  }

  wheeled(event) {
    if (performance.now() - this.scrolled < SETTLED) return; // the reader scrolls the page, and the picture came along
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? LINE : 1);
    this.viewer.zoom(Math.exp(-pixels * (event.ctrlKey ? TOUCH_PAD : WHEEL)), ...this.place(event));
  }
}

function listenToKeys(viewer) {
  const { canvas, camera } = viewer;
  const actions = {
    "+": () => viewer.zoom(STEP),
    "=": () => viewer.zoom(STEP),
    "-": () => viewer.zoom(1 / STEP),
    0: () => viewer.fit(),
    Home: () => viewer.fit(),
    Enter: () => viewer.selectMiddle(),
    " ": () => viewer.selectMiddle(),
    Escape: () => viewer.select(-1),
    n: () => viewer.showWorst(viewer.worst + 1),
    p: () => viewer.showWorst(viewer.worst - 1),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const way = ARROWS[event.key];
    const share = event.shiftKey ? 0.5 : 0.1;
    if (way) viewer.pan(way[0] * share * camera.width, way[1] * share * camera.height);
    else if (actions[event.key]) actions[event.key]();
    else return;
    event.preventDefault();
  });
  for (const kind of ["focus", "blur"]) canvas.addEventListener(kind, () => viewer.redraw());
}
