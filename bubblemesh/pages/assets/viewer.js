// What can be done with the picture, whatever asks for it: a pointer, a key or a button.

const LEAST_HEIGHT = 280; // pixels
const EDGES_ACROSS = 14; // on the screen, where a place is shown

class Viewer {
  constructor(mesh) {
    this.mesh = mesh;
    this.canvas = $("mesh");
    this.camera = new Camera(mesh);
    this.picture = new Picture(this.canvas, mesh, this.camera);
    this.pending = false;
    this.worst = -1;
    new ResizeObserver(() => this.resized()).observe(this.canvas);
    this.resized();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.restyled());
  }

  resized() {
    if (this.canvas.clientWidth === 0) return; // a printed page hides it
    const [, , width, height] = this.camera.bounds;
    const tall = ((this.canvas.clientWidth - 2 * MARGIN) * height) / width + 2 * MARGIN;
    this.canvas.style.height = `${Math.max(tall, LEAST_HEIGHT)}px`; // the style sheet has an upper limit
    // The border is no part of the picture.
    this.camera.resize(this.canvas.clientWidth, this.canvas.clientHeight);
    this.redraw();
  }

  restyled() {
    this.picture.restyle();
    drawScale(this.picture.colouring);
    this.redraw();
  }

  redraw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.picture.draw();
      this.report();
    });
  }

  report() {
    const { drawn, hidden } = this.picture.raster;
    const less = hidden ? `, ${number(hidden)} more are too small for a pixel` : "";
    $("seen").textContent = `${number(drawn)} of ${number(this.mesh.triangles)} triangles drawn${less}`;
    $("zoomed").textContent = `zoom ${(this.camera.scale / this.camera.fitting()).toPrecision(3)}`;
  }

  fit() {
    this.camera.fit();
    this.redraw();
  }

  pan(dx, dy) {
    this.camera.pan(dx, dy);
    this.redraw();
  }

  // Zoom around a place on the screen, by default its middle.
  zoom(factor, ...place) {
    this.camera.zoom(factor, ...place);
    this.redraw();
  }

  recolour(colouring) {
    this.picture.colouring = colouring;
    this.restyled();
  }

  // Let one label stand out, or none again.
  single(label) {
    this.picture.label = this.picture.label === label ? null : label;
    this.redraw();
  }

  toggle(part, shown) {
    this.picture.shows[part] = shown;
    this.redraw();
  }

  // Select a triangle, or none by -1.
  select(t) {
    this.picture.selected = t;
    this.picture.place = null;
    $("selected").replaceChildren(t >= 0 ? facts(this.mesh, t) : $("selected").dataset.empty);
    this.redraw();
  }

  selectMiddle() {
    this.select(this.picture.at(this.camera.width / 2, this.camera.height / 2));
  }

  showWorst(rank) {
    const count = head.worst.length;
    this.worst = (rank + count) % count;
    const t = head.worst[this.worst];
    this.look(...this.camera.toPlane(...this.picture.centre(t)), t);
    this.select(t);
  }

  // Show a place, given by its true coordinates, and mark it.
  showPlace(x, y) {
    const place = [x - head.origin[0], y - head.origin[1]];
    this.look(...place, this.nearest(...place));
    this.select(-1);
    this.picture.place = place;
  }

  // Look at a place so closely that some edges of a triangle go across.
  look(x, y, t) {
    const [i, j] = this.mesh.corners.subarray(3 * t, 3 * t + 2);
    const edge = Math.hypot(this.mesh.x[i] - this.mesh.x[j], this.mesh.y[i] - this.mesh.y[j]);
    this.camera.show(x, y, edge, 1 / EDGES_ACROSS);
    this.canvas.scrollIntoView({ block: "nearest" });
    this.redraw();
  }

  // A triangle near a place.
  nearest(x, y) {
    const { corners, triangles } = this.mesh;
    let [best, least] = [0, Infinity];
    for (let t = 0; t < triangles; t++) {
      const node = corners[3 * t];
      const distance = (this.mesh.x[node] - x) ** 2 + (this.mesh.y[node] - y) ** 2;
      if (distance < least) [best, least] = [t, distance];
    }
    return best;
  }

  // Tell about the triangle at a place on the screen, or nothing any more.
  tell(place) {
    const t = place ? this.picture.at(...place) : -1;
    const tip = $("tip");
    tip.hidden = t < 0;
    if (t < 0) return;
    tip.replaceChildren(facts(this.mesh, t));
    const [x, y] = place;
    const { width, height } = this.camera;
    const left = x + 16 + tip.offsetWidth > width ? x - tip.offsetWidth - 12 : x + 16;
    const top = Math.min(y + 12, height - tip.offsetHeight - 4);
    tip.style.transform = `translate(${Math.max(left, 2)}px, ${Math.max(top, 2)}px)`;
  }
}
