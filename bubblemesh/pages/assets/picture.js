// Draws the mesh: triangles as pixels, then edges, labelled lines, names and marks upon them.

const EDGES_FROM = 4; // pixels that an edge must have to be drawn
const MOST_EDGES = 60000; // triangles whose edges are drawn
const DASHES = [[], [9, 4], [2, 3], [9, 3, 2, 3]];

class Picture {
  constructor(canvas, mesh, camera) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.mesh = mesh;
    this.camera = camera;
    this.raster = new Raster(mesh);
    this.colouring = "quality";
    this.shows = { edges: true, names: true, worst: false };
    this.label = null; // the label that stands out
    this.selected = -1;
    this.place = null; // in the plane, marked
    this.restyle();
  }

  restyle() {
    const names = ["ink", "mesh-edge", "halo", "mark", ...this.mesh.labels.map((_, k) => `label-${k % 8}`)];
    this.styles = Object.fromEntries(names.map((name) => [name, styleColour(`--${name}`)]));
    this.colours = triangleColours(this.mesh, this.colouring);
  }

  draw() {
    const { canvas, camera, context } = this;
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.raster.fill(camera, this.ratio);
    canvas.width = this.raster.width;
    canvas.height = this.raster.height;
    this.fill();
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.lineJoin = "round";
    this.drawEdges();
    this.drawLines();
    if (this.shows.worst) head.worst.forEach((t, k) => this.mark(this.centre(t), `${k + 1}`));
    if (this.selected >= 0) this.outline(this.selected);
    if (this.place) this.mark(camera.toScreen(...this.place), "");
    if (this.shows.names) this.drawNames();
    if (document.activeElement === canvas && canvas.matches(":focus-visible")) this.crosshair();
    canvas.dataset.drawn = this.raster.drawn;
    canvas.dataset.hidden = this.raster.hidden;
  }

  fill() {
    const { owner, width, height } = this.raster;
    const image = this.context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const { colours } = this;
    for (let k = 0; k < owner.length; k++) if (owner[k] >= 0) pixels[k] = colours[owner[k]];
    this.context.putImageData(image, 0, 0);
  }

  // Each inner edge is a side of two triangles in opposite directions: it is drawn where its nodes ascend. Sides of the
  // boundary are drawn with their labels.
  drawEdges() {
    const { raster, context, mesh } = this;
    const size = this.typicalEdge();
    if (!this.shows.edges || raster.seen > MOST_EDGES || size < EDGES_FROM) return;
    const { sx, sy } = raster;
    context.beginPath();
    for (let n = 0; n < raster.seen; n++) {
      const at = 3 * raster.visible[n];
      for (let side = 0; side < 3; side++) {
        const i = mesh.corners[at + side];
        const j = mesh.corners[at + ((side + 1) % 3)];
        if (i > j || mesh.inQuadrilateral[at + side]) continue;
        context.moveTo(sx[i] / this.ratio, sy[i] / this.ratio);
        context.lineTo(sx[j] / this.ratio, sy[j] / this.ratio);
      }
    }
    context.strokeStyle = this.styles["mesh-edge"];
    context.globalAlpha = Math.min(0.25 + size / 40, 0.8);
    context.lineWidth = Math.min(Math.max(size / 30, 0.4), 1);
    context.setLineDash([]);
    context.stroke();
    context.globalAlpha = 1;
  }

  // Length in pixels of the edges on the screen, by some of them.
  typicalEdge() {
    const { raster, mesh } = this;
    const step = Math.max(1, Math.floor(raster.seen / 200));
    let sum = 0;
    let count = 0;
    for (let n = 0; n < raster.seen; n += step, count++) {
      const at = 3 * raster.visible[n];
      const [i, j] = [mesh.corners[at], mesh.corners[at + 1]];
      sum += Math.hypot(raster.sx[i] - raster.sx[j], raster.sy[i] - raster.sy[j]);
    }
    return count ? sum / count / this.ratio : 0;
  }

  drawLines() {
    this.mesh.labels.forEach((label, k) => {
      const faded = this.label !== null && this.label !== k;
      const width = this.label === k ? 4.5 : 2.4;
      this.trace(label);
      this.context.globalAlpha = faded ? 0.25 : 1;
      this.context.setLineDash([]);
      this.stroke(width + 2.4, this.styles.halo); // keeps it visible upon triangles of any colour
      this.context.setLineDash(DASHES[Math.floor(k / 8) % DASHES.length]);
      this.stroke(width, this.styles[`label-${k % 8}`]);
    });
    this.context.globalAlpha = 1;
    this.context.setLineDash([]);
  }

  // The edges of a label, as long lines where they follow each other.
  trace(label) {
    const { context, raster, mesh } = this;
    const { facets } = mesh;
    const half = facets.length / 2;
    context.beginPath();
    for (let k = label.start, last = -1; k < label.start + label.count; k++) {
      const [i, j] = [facets[k], facets[half + k]];
      if (i !== last) context.moveTo(raster.sx[i] / this.ratio, raster.sy[i] / this.ratio);
      context.lineTo(raster.sx[j] / this.ratio, raster.sy[j] / this.ratio);
      last = j;
    }
  }

  stroke(width, colour) {
    this.context.lineWidth = width;
    this.context.strokeStyle = colour;
    this.context.stroke();
  }

  // Names of labels, regions and points beside what they name, unless they would cover each other.
  drawNames() {
    const taken = [];
    this.context.font = "600 12px system-ui, sans-serif";
    this.context.textAlign = "center";
    this.context.textBaseline = "middle";
    this.mesh.labels.forEach((label, k) => {
      if (this.label !== null && this.label !== k) return;
      const middle = this.besideMiddleOf(label);
      if (middle) this.write(label.name, middle, this.styles[`label-${k % 8}`], taken);
    });
    if (this.colouring === "region") {
      head.regions.forEach((region) => this.write(region.name, this.centre(region.at), this.styles.ink, taken));
    }
    head.points.forEach((point) => {
      const at = this.camera.toScreen(this.mesh.x[point.node], this.mesh.y[point.node]);
      this.context.fillStyle = this.styles.mark;
      this.context.fillRect(at[0] - 3, at[1] - 3, 6, 6);
      this.write(point.name, [at[0], at[1] - 13], this.styles.ink, taken);
    });
  }

  // A place for a label's name: outside, which is on the right of its edges, beside the middle one on the screen.
  besideMiddleOf(label) {
    const { mesh, camera } = this;
    const half = mesh.facets.length / 2;
    const places = [];
    for (let k = label.start; k < label.start + label.count; k++) {
      const [i, j] = [mesh.facets[k], mesh.facets[half + k]];
      const [x, y] = camera.toScreen((mesh.x[i] + mesh.x[j]) / 2, (mesh.y[i] + mesh.y[j]) / 2);
      if (x > 0 && y > 0 && x < camera.width && y < camera.height) places.push([x, y, i, j]);
    }
    if (places.length === 0) return null;
    const [x, y, i, j] = places[Math.floor(places.length / 2)];
    const [dx, dy] = [mesh.x[j] - mesh.x[i], mesh.y[j] - mesh.y[i]];
    const length = Math.hypot(dx, dy);
    const letters = this.context.measureText(label.name).width / 2;
    const away = 6 + (Math.abs(dy) * letters + Math.abs(dx) * 6) / length;
    return [x + (away * dy) / length, y + (away * dx) / length];
  }

  write(text, [x, y], colour, taken) {
    const { context, camera } = this;
    const half = context.measureText(text).width / 2 + 4;
    if (2 * half > camera.width) return;
    const inside = Math.min(Math.max(x, half), camera.width - half);
    const down = Math.min(Math.max(y, 10), camera.height - 10);
    if (Math.abs(inside - x) > half || Math.abs(down - y) > 12) return;
    if (taken.some(([u, v, other]) => Math.abs(u - inside) < half + other && Math.abs(v - down) < 17)) return;
    taken.push([inside, down, half]);
    context.lineWidth = 4;
    context.strokeStyle = this.styles.halo;
    context.strokeText(text, inside, down);
    context.fillStyle = colour;
    context.fillText(text, inside, down);
  }

  centre(t) {
    const { corners, x, y } = this.mesh;
    const nodes = [0, 1, 2].map((k) => corners[3 * t + k]);
    const mean = (values) => nodes.reduce((sum, node) => sum + values[node], 0) / 3;
    return this.camera.toScreen(mean(x), mean(y));
  }

  mark([x, y], text) {
    const { context } = this;
    context.beginPath();
    context.arc(x, y, 10, 0, 2 * Math.PI);
    this.stroke(5, this.styles.halo);
    this.stroke(2.2, this.styles.mark);
    context.font = "600 12px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    if (text) this.write(text, [x + 16, y - 10], this.styles.mark, []);
  }

  outline(t) {
    const { context, raster, mesh } = this;
    context.beginPath();
    for (let k = 0; k < 3; k++) {
      const node = mesh.corners[3 * t + k];
      context.lineTo(raster.sx[node] / this.ratio, raster.sy[node] / this.ratio);
    }
    context.closePath();
    this.stroke(6, this.styles.halo);
    this.stroke(3, this.styles.mark);
  }

  crosshair() {
    const { context, camera } = this;
    const [x, y] = [camera.width / 2, camera.height / 2];
    context.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      context.moveTo(x + 4 * dx, y + 4 * dy);
      context.lineTo(x + 14 * dx, y + 14 * dy);
    }
    this.stroke(2, this.styles.mark);
  }

  // The triangle at a place on the screen, or -1.
  at(x, y) {
    return this.raster.at(x * this.ratio, y * this.ratio);
  }
}
