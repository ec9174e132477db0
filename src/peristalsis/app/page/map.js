// The diameter map: place from left to right, time downwards, so that it grows below the tube that makes it.

import { fresh, scale, axes, number } from "./canvas.js";
import { LEFT, RIGHT } from "./tube.js";
import { MAP, theme } from "./palette.js";

const COLUMNS = 240;
const HEIGHT = 300;

export class DiameterMap {
  constructor(canvas) {
    this.canvas = canvas;
    this.picture = document.createElement("canvas");
    this.record = null;
    this.done = 0;
  }

  /** Colour limits [cm]: from nearly closed to a little wider than the pellet. */
  limits({ header: { pellet_radius: pellet, tube_radius: tube } }) {
    return [0.5 * tube, 2.2 * Math.max(pellet, tube)];
  }

  grow(record) {
    if (this.record !== record) {
      Object.assign(this, { record, done: 0 });
      this.picture.width = COLUMNS;
      this.picture.height = 64;
    }
    const context = this.picture.getContext("2d", { willReadFrequently: true });
    while (this.picture.height < record.frames.length) {
      const kept = context.getImageData(0, 0, COLUMNS, Math.max(1, this.done));
      this.picture.height *= 2;
      context.putImageData(kept, 0, 0);
    }
    const rows = record.frames.length - this.done;
    if (rows <= 0) return;
    const image = context.createImageData(COLUMNS, rows);
    const [low, high] = this.limits(record);
    for (let row = 0; row < rows; row += 1) {
      const sizes = record.diameters(record.frames[this.done + row], COLUMNS);
      for (let k = 0; k < COLUMNS; k += 1) {
        const share = Math.min(1, Math.max(0, (sizes[k] - low) / (high - low)));
        const [r, g, b] = MAP[Math.round(255 * share)];
        image.data.set([r, g, b, 255], 4 * (row * COLUMNS + k));
      }
    }
    context.putImageData(image, 0, this.done);
    this.done = record.frames.length;
  }

  draw(record, time, upto, ghost) {
    this.grow(record);
    const { context, width } = fresh(this.canvas, HEIGHT + 92);
    const box = { left: LEFT, top: 8, width: width - LEFT - RIGHT, height: HEIGHT };
    const x = scale(0, record.header.length, box.left, box.left + box.width, 10);
    const y = scale(0, upto, box.top, box.top + box.height, 6);
    context.fillStyle = theme("lumen");
    context.fillRect(box.left, box.top, box.width, box.height);
    if (record.frames.length > 1) {
      context.imageSmoothingEnabled = true;
      context.drawImage(this.picture, 0, 0, COLUMNS, this.done, box.left, box.top, box.width, y.to(record.end) - box.top);
    }
    if (ghost) this.track(context, ghost, x, y, upto, [4, 4]);
    this.track(context, record, x, y, upto, []);
    context.setLineDash([]);
    context.strokeStyle = theme("ink");
    context.lineWidth = 1.2;
    context.beginPath();
    context.moveTo(box.left - 6, y.to(Math.min(time, upto)));
    context.lineTo(box.left + box.width, y.to(Math.min(time, upto)));
    context.stroke();
    axes(context, box, x, y, { x: "distance from the oral end (cm)", y: "time (s)" });
    this.bar(context, box, record);
  }

  track(context, record, x, y, upto, dash) {
    if (!record.header.pellet_outline.length) return;
    const stride = Math.max(1, Math.floor(record.frames.length / 400));
    context.setLineDash(dash);
    for (const [colour, wide] of [["rgba(0,0,0,0.55)", 4], ["#ffffff", 1.8]]) {  // seen on dark and on light
      context.strokeStyle = colour;
      context.lineWidth = wide;
      context.beginPath();
      for (let k = 0; k < record.frames.length; k += stride) {
        const frame = record.frames[k];
        if (frame[0] > upto) break;
        context[k ? "lineTo" : "moveTo"](x.to(record.scalar(frame, "pellet_position")), y.to(frame[0]));
      }
      context.stroke();
    }
  }

  bar(context, box, record) {
    const [low, high] = this.limits(record);
    const top = box.top + box.height + 46;
    const wide = Math.min(220, box.width * 0.6);
    for (let k = 0; k < wide; k += 1) {
      const [r, g, b] = MAP[Math.round((255 * k) / (wide - 1))];
      context.fillStyle = `rgb(${r},${g},${b})`;
      context.fillRect(box.left + k, top, 1.5, 10);
    }
    context.fillStyle = theme("soft");
    context.textBaseline = "top";
    context.textAlign = "left";
    context.fillText(`≤ ${number(low)}`, box.left, top + 14);
    context.textAlign = "right";
    context.fillText(`≥ ${number(high)}`, box.left + wide, top + 14);
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.fillText("diameter (cm)", box.left + wide + 10, top + 5);
  }
}

/** The map as a table: diameters [cm] at eleven places and some twelve times. */
export function mapTable(table, record) {
  const rows = Math.min(12, record.frames.length);
  const places = Array.from({ length: 11 }, (_, k) => (record.header.length * k) / 10);
  const cell = (kind, text, scope) => {
    const made = document.createElement(kind);
    made.textContent = text;
    if (scope) made.scope = scope;
    return made;
  };
  const head = document.createElement("tr");
  head.append(cell("th", "time (s)", "col"), ...places.map((z) => cell("th", `${number(z)} cm`, "col")));
  const body = Array.from({ length: rows }, (_, k) => {
    const frame = record.frames[Math.round((k * (record.frames.length - 1)) / Math.max(1, rows - 1))];
    const row = document.createElement("tr");
    row.append(cell("th", frame[0].toFixed(2), "row"));
    record.diameters(frame, 11).forEach((size) => row.append(cell("td", size.toFixed(2))));
    return row;
  });
  const [thead, tbody] = ["thead", "tbody"].map((kind) => document.createElement(kind));
  thead.append(head);
  tbody.append(...body);
  const caption = document.createElement("caption");
  caption.textContent = "Inner diameter (cm) by time and distance from the oral end";
  table.replaceChildren(caption, thead, tbody);
}
