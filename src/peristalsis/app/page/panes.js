// Tube, map and table of one of both runs.

import { DiameterMap } from "./map.js";
import { make } from "./page.js";

/** What is made for a slot: changed is called when its table is opened. */
export function pane(slot, changed) {
  const name = slot.toUpperCase();
  const [tube, map] = [1, 1].map((height) => make("canvas", { height })); // flat until there is a picture
  [[tube, `Tube and pellet of run ${name}, cut along the axis`], [map, `Diameter map of run ${name}; a table follows`]].forEach(
    ([canvas, label]) => { canvas.setAttribute("role", "img"); canvas.setAttribute("aria-label", label); });
  const heading = () => make("div", { className: `which ${slot}` }, make("i"), `Run ${name}`, make("span"));
  const table = make("table");
  const details = make("details", { className: "table" }, make("summary", { textContent: `Map of run ${name} as a table` }),
    make("div", { className: "scroll", tabIndex: 0 }, table));
  details.lastChild.setAttribute("role", "region");
  details.lastChild.setAttribute("aria-label", `Table of the map of run ${name}`);
  details.addEventListener("toggle", changed);
  const [first, second] = [heading(), heading()];
  const stage = make("div", { className: "tube" }, first, tube);
  const below = make("div", {}, second, map, details);
  return { stage, below, tube, map, drawn: new DiameterMap(map), details, table, words: [first.lastChild, second.lastChild], rows: -1 };
}
