// The charts, the numbers and the remarks below the map.

import { drawChart } from "./chart.js";
import { $, make } from "./page.js";
import { number } from "./canvas.js";
import { DASHES, line, theme } from "./palette.js";

const FORCES = { axial_force: "push of the wall", viscous_force: "viscous friction", dry_force: "dry friction", end_reaction: "closed end" };

/** seen: the slots that have pictures, the one that the controls are of, and what gives their records and ghosts. */
export function drawPanels(seen, time, upto) {
  drawChart($("track"), tracks(seen), { time, upto, label: "position (cm)", least: 1 });
  drawChart($("force"), forces(seen), { time, upto, label: "force (mN)", least: 10 });
  drawChart($("current"), currents(seen), { time, upto, label: "current (µA/cm²)", least: 0.1 });
  numbers(seen, time);
  remarks(seen);
}

function tracks({ slots, at, ghostOf }) {
  const found = [];
  for (const slot of slots) {
    const value = (of) => (frame) => of.scalar(frame, "pellet_position");
    const past = ghostOf(slot);
    if (past?.frames.length) found.push({ record: past, value: value(past), colour: theme("soft"), dash: [4, 4], label: `before ${slot.toUpperCase()}` });
    found.push({ record: at(slot), value: value(at(slot)), colour: theme(slot), dash: slot === "b" ? [8, 3] : [], wide: 2.2, label: `run ${slot.toUpperCase()}` });
  }
  return found;
}

function forces({ at, chosen }) {
  const record = at(chosen);
  if (!record) return [];
  return Object.entries(FORCES)
    .filter(([name]) => name !== "end_reaction" || record.scalar(record.frames.at(-1), name) !== 0)
    .map(([name, label], k) => ({ record, label, colour: line(k), dash: DASHES[k], value: (frame) => record.scalar(frame, name) }));
}

function currents({ at, chosen }) {
  const record = at(chosen);
  if (!record) return [];
  const layer = $("layer").value;
  return record.header.currents[layer].map((name, k) => ({ record, label: name.replaceAll("_", " "), colour: line(k), dash: DASHES[k],
    value: (frame) => frame[record.current[layer] + k] }));
}

function numbers({ slots, at }, time) {
  const rows = [];
  const first = at(slots[0]);
  for (const { name, unit, label } of first.header.scalars) {
    rows.push([label, unit, ...slots.map((slot) => number(at(slot).scalar(at(slot).frames[at(slot).at(time)], name)))]);
  }
  const keys = new Map();
  for (const slot of slots) for (const one of at(slot).outcome?.numbers ?? []) keys.set(one.key, one);
  for (const [key, { label, unit }] of keys) {
    rows.push([label, unit, ...slots.map((slot) => { const one = at(slot).outcome?.numbers.find((each) => each.key === key); return one ? number(one.value) : "–"; })]);
  }
  const heads = ["at the time shown, and of the whole run", "unit", ...slots.map((slot) => `run ${slot.toUpperCase()}`)];
  const table = $("numbers");
  const text = JSON.stringify([heads, rows]);
  if (table.dataset.text === text) return;
  table.dataset.text = text;
  const head = make("thead", {}, make("tr", {}, ...heads.map((one) => make("th", { textContent: one, scope: "col" }))));
  table.replaceChildren(head, make("tbody", {}, ...rows.map(([label, ...rest]) => make("tr", {}, make("th", { scope: "row", textContent: label }), ...rest.map((one) => make("td", { textContent: one }))))));
}

function remarks({ slots, at }) {
  const found = [...new Set(slots.flatMap((slot) => at(slot).remarks.map((text) => `Run ${slot.toUpperCase()}: ${text}`)))];
  $("remarks-card").hidden = !found.length;
  if ($("remarks").children.length !== found.length) $("remarks").replaceChildren(...found.map((text) => make("li", { textContent: text })));
}
