// Triangles as pixels: for each pixel the triangle that its centre is in. Filling by hand takes a tenth of the time that
// the canvas needs for as many paths, leaves no hairlines between triangles, and tells at once what is at a pixel.

class Raster {
  constructor(mesh) {
    this.mesh = mesh;
    this.sx = new Float64Array(mesh.nodes);
    this.sy = new Float64Array(mesh.nodes);
    this.owner = new Int32Array(0);
    this.visible = new Uint32Array(mesh.triangles);
  }

  // Fill the pixels of a camera's view; `ratio` is the number of pixels in one of the camera's.
  fill(camera, ratio) {
    this.width = Math.round(camera.width * ratio);
    this.height = Math.round(camera.height * ratio);
    if (this.owner.length !== this.width * this.height) this.owner = new Int32Array(this.width * this.height);
    this.owner.fill(-1);
    this.place(camera, ratio);
    const { mesh, sx, sy, width, height } = this;
    const { corners } = mesh;
    this.seen = this.drawn = this.hidden = 0;
    for (let t = 0, at = 0; t < mesh.triangles; t++, at += 3) {
      const a = corners[at];
      const b = corners[at + 1];
      const c = corners[at + 2];
      const left = Math.min(sx[a], sx[b], sx[c]);
      const right = Math.max(sx[a], sx[b], sx[c]);
      const top = Math.min(sy[a], sy[b], sy[c]);
      const bottom = Math.max(sy[a], sy[b], sy[c]);
      if (right < 0 || left > width || bottom < 0 || top > height) continue;
      this.visible[this.seen++] = t;
      if (this.fillOne(t, a, b, c, top, bottom)) this.drawn++;
      else if (left >= 0 && right <= width && top >= 0 && bottom <= height) this.hidden++;
    }
  }

  place(camera, ratio) {
    const { mesh, sx, sy } = this;
    const scale = camera.scale * ratio;
    for (let k = 0; k < mesh.nodes; k++) {
      sx[k] = (mesh.x[k] - camera.x) * scale + this.width / 2;
      sy[k] = this.height / 2 - (mesh.y[k] - camera.y) * scale;
    }
  }

  // Rows whose centres are in the triangle, and in each the pixels between its two sides. A pixel centre on a side
  // belongs to the triangle on the right of it, or below.
  fillOne(t, a, b, c, top, bottom) {
    const { sx, sy, width, owner } = this;
    const first = Math.max(Math.ceil(top - 0.5), 0);
    const last = Math.min(Math.ceil(bottom - 0.5), this.height);
    let any = false;
    for (let row = first; row < last; row++) {
      const y = row + 0.5;
      let low = Infinity;
      let high = -Infinity;
      for (let side = 0; side < 3; side++) {
        const i = side === 0 ? a : side === 1 ? b : c;
        const j = side === 0 ? b : side === 1 ? c : a;
        if (sy[i] <= y === sy[j] <= y) continue;
        const x = sx[i] + ((y - sy[i]) / (sy[j] - sy[i])) * (sx[j] - sx[i]);
        if (x < low) low = x;
        if (x > high) high = x;
      }
      const begin = Math.max(Math.ceil(low - 0.5), 0);
      const end = Math.min(Math.ceil(high - 0.5), width);
      for (let k = begin; k < end; k++) {
        owner[row * width + k] = t;
        any = true;
      }
    }
    return any;
  }

  // The triangle at a pixel, or -1.
  at(px, py) {
    const column = Math.floor(px);
    const row = Math.floor(py);
    return column < 0 || row < 0 || column >= this.width || row >= this.height ? -1 : this.owner[row * this.width + column];
  }
}
