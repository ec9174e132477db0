// A canvas at the screen's resolution, and axes on it.

import { theme } from "./palette.js";

export const FONT = "12px system-ui, sans-serif";

/** The canvas ready to be drawn on anew: its context, width and height in CSS pixels. */
export function fresh(canvas, height) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
    canvas.style.height = `${height}px`;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  return { context, width, height };
}

/** Round numbers from low to high, at most about `most` of them. */
export function ticks(low, high, most) {
  const span = high - low;
  if (!(span > 0) || !Number.isFinite(span)) return [low];
  const raw = span / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= raw);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; k += 1) found.push(k * step);
  return found;
}

export const number = (value) => {
  const size = Math.abs(value);
  if (size < 1e-12) return "0";
  return size >= 1e5 || size < 1e-3 ? value.toExponential(1) : String(Number(value.toPrecision(3))).replace("-", "−");
};

/** Frame, ticks and labels of a plot whose inside is `box`; x and y turn values into pixels. */
export function axes(context, box, x, y, labels) {
  context.strokeStyle = theme("line");
  context.fillStyle = theme("soft");
  context.lineWidth = 1;
  context.strokeRect(box.left, box.top, box.width, box.height);
  context.textAlign = "center";
  context.textBaseline = "top";
  for (const value of x.ticks) {
    const at = x.to(value);
    context.beginPath();
    context.moveTo(at, box.top + box.height);
    context.lineTo(at, box.top + box.height + 4);
    context.stroke();
    context.fillText(number(value), at, box.top + box.height + 6);
  }
  context.fillText(labels.x, box.left + box.width / 2, box.top + box.height + 22);
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (const value of y.ticks) {
    const at = y.to(value);
    context.beginPath();
    context.moveTo(box.left - 4, at);
    context.lineTo(box.left, at);
    context.stroke();
    context.fillText(number(value), box.left - 7, at);
  }
  context.save();
  context.translate(12, box.top + box.height / 2);
  context.rotate(-Math.PI / 2);
  context.textAlign = "center";
  context.fillText(labels.y, 0, 0);
  context.restore();
}

/** A linear scale with its ticks. */
export function scale(low, high, from, to, most) {
  const span = high - low || 1;
  return { low, high, to: (value) => from + ((value - low) / span) * (to - from), ticks: ticks(low, high, most) };
}
