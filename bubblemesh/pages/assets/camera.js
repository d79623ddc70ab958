// Which part of the plane is on the screen.

const MARGIN = 36; // pixels around the whole mesh, for the names of its sides

class Camera {
  constructor(mesh) {
    this.bounds = [0, 0, ...[mesh.x, mesh.y].map((values) => values.reduce((a, b) => Math.max(a, b), 0))];
    this.width = this.height = 1;
    this.x = this.y = 0; // what is in the middle
    this.scale = 1; // pixels of a unit of length
    this.whole = true; // whether it shows the whole mesh, whatever the window's size
  }

  resize(width, height) {
    this.width = width;
    this.height = height;
    if (this.whole) this.fit();
  }

  fit() {
    const [left, bottom, right, top] = this.bounds;
    this.x = (left + right) / 2;
    this.y = (bottom + top) / 2;
    this.scale = this.fitting();
    this.whole = true;
  }

  fitting() {
    const [left, bottom, right, top] = this.bounds;
    const room = (size) => Math.max(size - 2 * MARGIN, size / 2);
    return Math.min(room(this.width) / (right - left), room(this.height) / (top - bottom));
  }

  toScreen(x, y) {
    return [(x - this.x) * this.scale + this.width / 2, this.height / 2 - (y - this.y) * this.scale];
  }

  toPlane(sx, sy) {
    return [this.x + (sx - this.width / 2) / this.scale, this.y + (this.height / 2 - sy) / this.scale];
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.whole = false;
  }

  // Zoom by a factor; what is at the place on the screen stays there.
  zoom(factor, sx = this.width / 2, sy = this.height / 2) {
    const [x, y] = this.toPlane(sx, sy);
    const least = this.fitting() / 4;
    this.scale = Math.min(Math.max(this.scale * factor, least), least * 1e9);
    this.x = x - (sx - this.width / 2) / this.scale;
    this.y = y - (this.height / 2 - sy) / this.scale;
    this.whole = false;
  }

  // Show a place so that a length spans the given share of the window.
  show(x, y, length, share) {
    [this.x, this.y] = [x, y];
    this.scale = (share * Math.min(this.width, this.height)) / length;
    this.whole = false;
  }
}
