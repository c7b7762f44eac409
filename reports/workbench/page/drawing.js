// The drawing: one SVG with a layer for each kind of thing, redrawn at most once a frame.
// May be changed: the order of layers (later ones lie on top). Each layer is drawn by a function of draw_*.js.

import { drawCells, drawEdges, drawField, drawFlow, drawMotions, drawRests } from "./draw_cells.js";
import { drawGrid, drawSquare } from "./draw_ground.js";
import { drawBodies, drawEvents, drawPaths, drawStarts } from "./draw_paths.js";
import { drawLevels } from "./draw_system.js";
import { drawWheels } from "./draw_wheels.js";
import { s } from "./dom.js";
import { isSystem, unitOf } from "./scene_document.js";
import { View } from "./view.js";

const LAYERS = [
  "grid", "cells", "levels", "rests", "edges", "square", "flow", "motions", "bodies", "paths", "wheels", "events", "starts", "grid-labels",
];

export class Drawing {
  constructor(element, store, results) {
    Object.assign(this, { element, store, results, view: new View(), time: null, active: 0, hidden: new Set() });
    this.layers = {};
    for (const name of LAYERS) element.append((this.layers[name] = s("g", { class: `layer-${name}` })));
    new ResizeObserver(() => this.resize()).observe(element);
    results.addEventListener("change", ({ detail }) => this.#heard(detail.stage));
    store.addEventListener("change", () => this.#other());
    for (const name of ["change", "select"]) store.addEventListener(name, () => this.request());
    this.wantsFit = true;
  }

  /** Another scene, opened or come back to by undo, is looked at afresh. */
  #other() {
    const { name, system } = this.store.document;
    const scene = `${name} ${Boolean(system)}`;
    if (this.scene !== undefined && this.scene !== scene) this.fitsNext = true;
    this.scene = scene;
  }

  /** It is shown whole as soon as its own geometry is there. */
  #heard(stage) {
    if (stage === "fast" && this.fitsNext) {
      this.fitsNext = false;
      this.fit();
    }
    this.request();
  }

  /** Redraws with the next frame. */
  request() {
    this.pending ??= requestAnimationFrame(() => {
      this.pending = undefined;
      this.draw();
    });
  }

  resize() {
    const { width, height } = this.element.getBoundingClientRect();
    if (!width || !height) return;
    this.view.resize(width, height);
    this.element.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.element.style.setProperty("--unit", this.view.unit);
    if (!this.touched) this.fit();
    this.request();
  }

  /** Shows the whole array: wheels, checked square, body, starts. */
  fit() {
    const { geometry } = this.results;
    if (!geometry) {
      this.wantsFit = true;
      return;
    }
    const { x, y, radius } = geometry.square ?? { x: 0, y: 0, radius: 1 };
    const points = [[x - radius, y - radius], [x + radius, y + radius]];
    for (const wheel of geometry.wheels ?? []) points.push([wheel.x, wheel.y]);
    for (const point of geometry.body?.outline ?? []) points.push(point);
    for (const [a, b] of this.store.now.starts) points.push([a, b]);
    this.view.fit(points);
    this.wantsFit = false;
    this.touched = false;
    this.request();
  }

  /** The wheels where the document has them now: a drag is ahead of the last reply. */
  wheels() {
    const replied = this.results.geometry?.wheels ?? [];
    const stated = this.store.document.wheel;
    if (stated?.length !== replied.length) return replied;
    return replied.map((wheel, k) => ({ ...wheel, ...placeOf(stated[k]), ...rimOf(stated[k]) }));
  }

  draw() {
    const { geometry, paths } = this.results;
    const { view, layers } = this;
    if (geometry && this.wantsFit) this.fit();
    drawGrid(layers.grid, layers["grid-labels"], view, unitOf(this.store.document, "length"));
    if (!geometry) return;
    const system = isSystem(this.store.document);
    const plane = geometry.system ?? {};
    const starts = this.hidden.has("paths") ? [] : this.store.now.starts;
    const followed = this.hidden.has("paths") ? [] : paths;
    drawSquare(layers.square, view, geometry.square);
    const cells = this.hidden.has("cells") ? [] : geometry.cells ?? [];
    drawCells(layers.cells, view, cells);
    drawLevels(layers.levels, view, this.hidden.has("levels") ? {} : plane);
    drawRests(layers.rests, view, this.hidden.has("cells") ? [] : geometry.equilibria ?? []);
    drawEdges(layers.edges, view, this.hidden.has("cells") ? [] : geometry.edges ?? plane.edges ?? []);
    this.#motions(cells, geometry.field ?? plane.field ?? []);
    const body = { outline: geometry.body?.outline, square: geometry.square, paths: followed, time: this.time, isArray: !system };
    drawBodies(layers.bodies, view, body);
    drawPaths(layers.paths, view, followed);
    drawWheels(layers.wheels, view, this.hidden.has("wheels") ? [] : this.wheels(), this.store.selection);
    drawEvents(layers.events, view, followed);
    drawStarts(layers.starts, view, starts, this.active, !system);
  }

  /** Arrows of the cells, or of the samples of rules without cells. */
  #motions(cells, samples) {
    const hidden = this.hidden.has("motions");
    drawFlow(this.layers.flow, this.view, hidden ? [] : cells, this.results.geometry.square);
    if (cells.length || !samples.length) drawMotions(this.layers.motions, this.view, hidden ? [] : cells);
    else drawField(this.layers.motions, this.view, hidden ? [] : samples);
  }
}

function placeOf({ position }) {
  return position.every((value) => typeof value === "number") ? { x: position[0], y: position[1] } : {};
}

function rimOf({ heading }) {
  if (!Array.isArray(heading) || !heading.every((value) => typeof value === "number")) return {};
  const length = Math.hypot(...heading);
  return length ? { rim: [heading[0] / length, heading[1] / length] } : {};
}
