// The tube cut along its axis, with the pellet in it; oral end on the left.

import { FONT, fresh, scale, number } from "./canvas.js";
import { theme } from "./palette.js";

export const LEFT = 52;
export const RIGHT = 16;

/** How strongly a layer is excited, 0 to 1, from its potential [mV] and the one above which it pulls. */
const excitation = (potential, threshold) => Math.min(1, Math.max(0, (potential - threshold + 2) / 22));

export function drawTube(canvas, record, frame, ghost, colour) {
  const { header } = record;
  const inside = Math.max(120, canvas.clientWidth - LEFT - RIGHT);
  const perCm = inside / header.length;
  const tall = Math.max(header.pellet_radius, header.tube_radius) * 1.35 + 0.15;
  const half = Math.max(34, perCm * tall);
  const across = half / tall; // the same as along, unless the window is very narrow
  const { context, width } = fresh(canvas, 2 * half + 46);
  const x = scale(0, header.length, LEFT, width - RIGHT, 10);
  const middle = half + 4;
  const [axial, radius] = [record.field(frame, "axial"), record.field(frame, "radius")];
  const path = (side, from = axial, size = radius) => {
    for (let k = 0; k < from.length; k += 1) {
      context[k ? "lineTo" : "moveTo"](x.to(from[k]), middle + side * across * size[k]);
    }
  };
  // the lumen
  context.beginPath();
  path(-1);
  for (let k = axial.length - 1; k >= 0; k -= 1) context.lineTo(x.to(axial[k]), middle + across * radius[k]);
  context.closePath();
  context.fillStyle = theme("lumen");
  context.fill();
  if (ghost) drawGhost(context, ghost, x, middle, across);
  drawPellet(context, record, frame, x, middle, across);
  // the wall: inner line the circular, outer line the longitudinal layer, thicker and coloured where excited
  const cells = record.header.cells - 1;
  for (const [layer, out] of [["longitudinal", 6.5], ["circular", 2.5]]) {
    const potential = record.field(frame, layer);
    for (const side of [-1, 1]) {
      context.strokeStyle = theme("wall");
      context.lineWidth = 1.5;
      context.beginPath();
      for (let k = 0; k < axial.length; k += 1) {
        context[k ? "lineTo" : "moveTo"](x.to(axial[k]), middle + side * (across * radius[k] + out));
      }
      context.stroke();
      context.strokeStyle = colour;
      for (let k = 0; k < axial.length - 1; k += 1) {
        const cell = Math.round(((k + 0.5) / (axial.length - 1)) * cells);
        const much = excitation(potential[cell], header.thresholds[layer]);
        if (much < 0.03) continue;
        context.globalAlpha = 0.25 + 0.75 * much;
        context.lineWidth = 1.5 + 2.5 * much;
        context.beginPath();
        context.moveTo(x.to(axial[k]), middle + side * (across * radius[k] + out));
        context.lineTo(x.to(axial[k + 1]), middle + side * (across * radius[k + 1] + out));
        context.stroke();
      }
      context.globalAlpha = 1;
    }
  }
  drawContact(context, record, frame, x, middle, across);
  ruler(context, x, 2 * half + 10, width);
}

function drawPellet(context, record, frame, x, middle, across) {
  const outline = record.header.pellet_outline;
  if (!outline.length) return;
  const centre = record.scalar(frame, "pellet_position");
  context.beginPath();
  outline.forEach(([along, out], k) => context[k ? "lineTo" : "moveTo"](x.to(centre + along), middle - across * out));
  [...outline].reverse().forEach(([along, out]) => context.lineTo(x.to(centre + along), middle + across * out));
  context.closePath();
  context.fillStyle = theme("pellet");
  context.strokeStyle = theme("pellet-edge");
  context.lineWidth = 1.2;
  context.fill();
  context.stroke();
}

function drawContact(context, record, frame, x, middle, across) {
  const [axial, radius, contact] = ["axial", "radius", "contact"].map((name) => record.field(frame, name));
  context.strokeStyle = theme("ink");
  context.lineWidth = 2.5;
  for (const side of [-1, 1]) {
    context.beginPath();
    for (let k = 0; k < axial.length - 1; k += 1) {
      if (contact[k] <= 0 || contact[k + 1] <= 0) continue;
      context.moveTo(x.to(axial[k]), middle + side * across * radius[k]);
      context.lineTo(x.to(axial[k + 1]), middle + side * across * radius[k + 1]);
    }
    context.stroke();
  }
}

function drawGhost(context, { record, frame }, x, middle, across) {
  const [axial, radius] = [record.field(frame, "axial"), record.field(frame, "radius")];
  context.save();
  context.setLineDash([4, 4]);
  context.strokeStyle = theme("soft");
  context.lineWidth = 1.2;
  for (const side of [-1, 1]) {
    context.beginPath();
    for (let k = 0; k < axial.length; k += 1) {
      context[k ? "lineTo" : "moveTo"](x.to(axial[k]), middle + side * across * radius[k]);
    }
    context.stroke();
  }
  const centre = record.scalar(frame, "pellet_position");
  const outline = record.header.pellet_outline;
  context.beginPath();
  outline.forEach(([along, out], k) => context[k ? "lineTo" : "moveTo"](x.to(centre + along), middle - across * out));
  [...outline].reverse().forEach(([along, out]) => context.lineTo(x.to(centre + along), middle + across * out));
  context.stroke();
  context.restore();
}

/** The axis below: places in cm, and which end is which. */
export function ruler(context, x, top, width) {
  context.font = FONT;
  context.strokeStyle = theme("soft");
  context.fillStyle = theme("soft");
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(x.to(x.low), top);
  context.lineTo(x.to(x.high), top);
  for (const value of x.ticks) {
    context.moveTo(x.to(value), top);
    context.lineTo(x.to(value), top + 4);
  }
  context.stroke();
  context.textBaseline = "top";
  context.textAlign = "center";
  for (const value of x.ticks) context.fillText(number(value), x.to(value), top + 6);
  context.textAlign = "left";
  context.fillText("oral end", x.to(x.low), top + 21);
  context.textAlign = "right";
  context.fillText("anal end", width - RIGHT, top + 21);
  context.textAlign = "center";
  context.fillText(width > 420 ? "distance from the oral end (cm)" : "cm", (x.to(x.low) + x.to(x.high)) / 2, top + 21);
}
