// The transform between the plane of the scene (y up, in its unit of length) and the pixels of the drawing (y down).
// May be changed: margins and limits of the zoom. This is all the geometry that the page does itself.

const MARGIN = 0.14; // of the drawing, on each side
const MOST = 74; // pixels that the margin has at most: rims and their numbers need about that
const CLOSEST = 1e7;

export class View {
  constructor() {
    Object.assign(this, { width: 600, height: 600, x: 0, y: 0, scale: 100, extent: 2 });
  }

  resize(width, height) {
    const factor = Math.min(width, height) / Math.min(this.width, this.height);
    Object.assign(this, { width, height, scale: this.scale * (factor || 1) });
  }

  /** How large marks of a fixed size are drawn: smaller on a phone, larger on a wall. */
  get unit() {
    return Math.max(0.75, Math.min(3, Math.min(this.width, this.height) / 700));
  }

  /** Shows the box of these points whole. */
  fit(points) {
    const finite = points.filter(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
    if (!finite.length) return;
    const xs = finite.map((p) => p[0]);
    const ys = finite.map((p) => p[1]);
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    this.x = (left + right) / 2;
    this.y = (low + high) / 2;
    const wide = Math.max(right - left, 1e-9);
    const tall = Math.max(high - low, 1e-9);
    const margin = Math.min(MOST * this.unit, MARGIN * Math.min(this.width, this.height));
    this.scale = Math.min((this.width - 2 * margin) / wide, (this.height - 2 * margin) / tall);
    this.extent = Math.max(wide, tall);
  }

  /** Pixels of a point of the plane. */
  at(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  /** The transform of a mark of fixed size at a pixel. */
  mark(px, py) {
    return `translate(${px.toFixed(1)} ${py.toFixed(1)}) scale(${this.unit.toFixed(3)})`;
  }

  /** The point of the plane under a pixel. */
  under(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.under(px, py);
    const limits = Math.min(this.width, this.height) / this.extent;
    this.scale = Math.min(limits * CLOSEST, Math.max(limits / 20, this.scale * factor));
    const [newX, newY] = this.under(px, py);
    this.x += x - newX;
    this.y += y - newY;
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }

  /** A polygon or line of points of the plane as the data of an SVG path. */
  path(points, close = false) {
    const parts = points.map(([x, y], k) => {
      const [px, py] = this.at(x, y);
      return `${k ? "L" : "M"}${px.toFixed(1)} ${py.toFixed(1)}`;
    });
    return parts.length ? parts.join("") + (close ? "Z" : "") : "";
  }
}
