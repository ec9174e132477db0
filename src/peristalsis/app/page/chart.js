// Lines over time: each told apart by colour and dashes, with a legend above.

import { fresh, scale, axes } from "./canvas.js";
import { DASHES, theme } from "./palette.js";

const HEIGHT = 220;

/** lines: of {label, colour, dash, wide, record, value(frame)}. */
export function drawChart(canvas, lines, { time, upto, label, least, from }) {
  const { context, width } = fresh(canvas, HEIGHT);
  const rows = legend(context, lines, width);
  const box = { left: 66, top: 8 + 18 * rows, width: width - 78, height: HEIGHT - 56 - 18 * rows };
  let [low, high] = from ?? [0, 0];
  const points = lines.map((one) => {
    const { frames } = one.record;
    const stride = Math.max(1, Math.floor(frames.length / 600));
    const found = [];
    for (let k = 0; k < frames.length; k += stride) {
      if (frames[k][0] > upto + 1e-6) break;
      const value = one.value(frames[k]);
      found.push([frames[k][0], value]);
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return found;
  });
  if (high - low < least) high = low + least;
  if (!from) [low, high] = [low - 0.04 * (high - low), high + 0.04 * (high - low)];
  const x = scale(0, upto, box.left, box.left + box.width, Math.max(3, Math.round(box.width / 70)));
  const y = scale(low, high, box.top + box.height, box.top, 5);
  axes(context, box, x, y, { x: "time (s)", y: label });
  context.save();
  context.beginPath();
  context.rect(box.left, box.top, box.width, box.height);
  context.clip();
  if (low < 0) stroke(context, [[0, 0], [upto, 0]], x, y, theme("line"), [], 1);
  lines.forEach((one, k) => stroke(context, points[k], x, y, one.colour, one.dash ?? DASHES[0], one.wide ?? 1.8));
  stroke(context, [[time, low], [time, high]], x, y, theme("soft"), [], 1);
  context.restore();
}

function stroke(context, points, x, y, colour, dash, wide) {
  context.strokeStyle = colour;
  context.setLineDash(dash);
  context.lineWidth = wide;
  context.beginPath();
  points.forEach(([at, value], k) => context[k ? "lineTo" : "moveTo"](x.to(at), y.to(value)));
  context.stroke();
  context.setLineDash([]);
}

/** The legend, in as many rows as it takes; returns how many. */
function legend(context, lines, width) {
  let [at, row] = [66, 0];
  context.textAlign = "left";
  context.textBaseline = "middle";
  for (const one of lines.filter((each) => each.label)) {
    const wide = 30 + context.measureText(one.label).width + 14;
    if (at + wide > width && at > 66) [at, row] = [66, row + 1];
    const y = 9 + 18 * row;
    context.strokeStyle = one.colour;
    context.setLineDash(one.dash ?? []);
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(at, y);
    context.lineTo(at + 24, y);
    context.stroke();
    context.setLineDash([]);
    context.fillStyle = theme("ink");
    context.fillText(one.label, at + 29, y);
    at += wide;
  }
  return row + 1;
}
