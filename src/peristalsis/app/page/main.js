// The page: what is shown when, and what each button does.

import { number } from "./canvas.js";
import { Form } from "./form.js";
import { Lessons } from "./lessons.js";
import { ask, Link, SILENT } from "./link.js";
import { mapTable } from "./map.js";
import { $, make } from "./page.js";
import { theme } from "./palette.js";
import { pane } from "./panes.js";
import { drawPanels } from "./panels.js";
import { Record } from "./record.js";
import { drawTube } from "./tube.js";

const SLOTS = ["a", "b"];

const kept = JSON.parse(sessionStorage.getItem("peristalsis") ?? "{}");
const page = kept.page ?? [...crypto.getRandomValues(new Uint8Array(16))].map((one) => one.toString(16).padStart(2, "0")).join("");
const records = new Map();
const WORTH = 0.2;  // seconds that a run must have gone to be the ghost of the next: one pressed away at once is none
const shown = { a: kept.a ?? null, b: kept.b ?? null, ghostA: kept.ghostA ?? null, ghostB: kept.ghostB ?? null };
const view = { time: 0, follow: true, playing: false, at: 0, dirty: true };
/** What tests and the measurement read: pictures drawn and what that took [ms], frames received, lags from a slider to its picture [ms]. */
const stats = { drawn: 0, received: 0, lags: [], spent: 0 };
window.peristalsis = { stats, records, shown, hear };
const panes = {};
let [form, lessons, link, changes, up] = [null, null, null, 0, false];

const keep = () => sessionStorage.setItem("peristalsis", JSON.stringify({ page, ...shown }));
keep();
const at = (slot) => records.get(shown[slot]) ?? null;
const ghostOf = (slot) => ($("ghost").checked ? records.get(shown[`ghost${slot.toUpperCase()}`]) ?? null : null);
const present = () => SLOTS.filter((slot) => at(slot)?.header && at(slot).frames.length);
const computing = () => SLOTS.map(at).filter((one) => one?.computing);
const latest = () => Math.max(0, ...present().map((slot) => at(slot).end));
/** Where the newest picture is: that of the runs that compute, or the end of the longest one. */
const newest = () => {
  const moving = present().filter((slot) => at(slot).computing);
  return Math.max(0, ...(moving.length ? moving : present()).map((slot) => at(slot).end));
};

function problem(text) {
  $("problem").hidden = !text;
  $("problem").textContent = text ?? "";
}

// what the server says

function hear(word) {
  const record = records.get(word.run);
  view.dirty = true;
  switch (word.kind) {
    case "started": {
      const { slot } = word;
      if (at(slot)?.frames.length && at(slot).end >= WORTH) shown[`ghost${slot.toUpperCase()}`] = shown[slot];
      shown[slot] = word.run;
      records.set(word.run, records.get(word.run) ?? new Record(word.run, slot));
      Object.assign(view, { follow: true, playing: false });
      forget();
      keep();
      break;
    }
    case "gone":
      records.delete(word.run);
      for (const [slot, name] of Object.entries(shown)) if (name === word.run) shown[slot] = null;
      keep();
      break;
    case "note": if (record) record.note = word.text; break;
    case "remark": record?.remarks.push(word.text); break;
    case "header": record?.begin(word.header); break;
    case "paused": if (record) record.paused = word.paused; break;
    case "changed": changed(record, word); break;
    case "refused": problem(word.text); break;
    case "cut": if (record) record.state = "cut"; break;
    case "failed":
      if (record) Object.assign(record, { state: "failed", error: word.text });
      problem(word.text);
      lessons.ended(SLOTS.map(at));
      break;
    case "ended":
      if (record) Object.assign(record, { state: "over", outcome: word.outcome, remarks: word.outcome.remarks, error: word.outcome.error });
      if (word.outcome.error) problem(word.outcome.error);
      lessons.ended(SLOTS.map(at));
      break;
    case "judged": lessons.told(word); break;
    case "words": showWords(word); break;
    case "export": exported(word); break;
    default:
  }
}

function changed(record, { number: nth, time }) {
  if (!record) return;
  record.changes.push(time);
  const asked = asking.get(nth);
  if (asked !== undefined) waiting.push({ record, time, asked });
  asking.delete(nth);
}
const asking = new Map(); // number of a change to when the slider was moved
const waiting = []; // changes whose first picture has not been drawn

function frames(name, first, list) {
  const record = records.get(name);
  if (!record) return;
  record.add(first, list);
  stats.received += list.length;
  view.dirty = true;
}

function forget() {
  const used = new Set(Object.values(shown));
  for (const name of records.keys()) if (!used.has(name)) records.delete(name);
}

// what the user does

function start(slot) {
  problem(null);
  return link.say("start", { slot, asked: form.asked(slot) });
}

const order = (record, word) => link.say("order", { run: record.name, order: word });

let queued = null;
function edited(kind, control, value) {
  if (kind === "refused") { problem(value); return; }
  problem(null);
  const record = at(form.slot);
  if (!control.live || !record?.computing || !record.header) return;
  // Sliders tell more often than a run listens: what is newest of each control goes, some thirty times a second.
  if (!queued) {
    queued = { record, values: {}, switches: {}, since: performance.now() };
    setTimeout(() => {
      const { record: of, values, switches, since } = queued;
      queued = null;
      changes += 1;
      asking.set(changes, since);
      link.say("set", { run: of.name, number: changes, change: { values, switches } });
    }, 30);
  }
  queued[kind === "value" ? "values" : "switches"][control.name] = value;
}

function play() {
  const now = computing();
  if (now.length) {
    const pause = now.some((one) => !one.paused);
    now.forEach((one) => order(one, pause ? "pause" : "resume"));
    if (!pause) view.follow = true;
  } else {
    view.playing = !view.playing;
    if (view.playing && view.time >= latest() - 1e-6) view.time = 0;
    Object.assign(view, { follow: false, at: performance.now() });
  }
  view.dirty = true;
}

function step(way) {
  const paused = computing().filter((one) => one.paused);
  if (way > 0 && view.time >= newest() - 1e-6 && paused.length) {
    view.follow = true;
    paused.forEach((one) => order(one, "step"));
    return;
  }
  computing().filter((one) => !one.paused).forEach((one) => order(one, "pause"));
  const record = at(present()[0]);
  if (!record) return;
  const next = Math.max(0, Math.min(record.frames.length - 1, record.at(view.time) + way));
  Object.assign(view, { time: record.frames[next][0], follow: false, playing: false, dirty: true });
}

function begin(settings) {
  if (!up) { problem(SILENT); return false; }
  settings.forEach(({ asked }, k) => form.set(SLOTS[k], asked));
  for (const slot of SLOTS.slice(settings.length)) {
    if (at(slot)?.computing) order(at(slot), "stop");
    Object.assign(shown, { [slot]: null, [`ghost${slot.toUpperCase()}`]: null });
  }
  const started = form.choose("a").then(() => settings.map((_, k) => start(SLOTS[k])));
  started.catch((error) => problem(error.message));
  document.querySelector('input[name="slot"][value="a"]').checked = true;
  labels();
  return true;
}

function exported({ what, state, text, link: address, name }) {
  const words = { working: `Making the ${what} …`, ready: `The ${what} is ready: `, failed: text };
  $("kept").replaceChildren(words[state]);
  document.querySelectorAll("[data-file]").forEach((button) => { button.disabled = state === "working"; });
  if (state !== "ready") return;
  const anchor = make("a", { href: address, download: name, textContent: name });
  $("kept").append(anchor);
  anchor.click();
}

function showWords({ toml, python }) {
  const text = wanted === "toml" ? toml : python;
  $("words").hidden = false;
  $("words").textContent = text;
  // A run whose controls were moved on the way is another than one that begins with them.
  $("kept").replaceChildren(at(form.slot)?.changes.length ? "Controls were moved while this run computed; here their last values hold from the start. " : "");
  if (wanted === "toml") {
    const blob = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
    $("kept").append(make("a", { href: blob, download: "peristalsis.toml", textContent: "peristalsis.toml" }));
  }
}
let wanted = "toml";

// what is seen

function arrange() {
  const slots = SLOTS.filter((slot) => slot === "a" || at(slot));
  for (const [place, part] of [[$("tubes"), "stage"], [$("maps"), "below"]]) {
    const wantedParts = slots.map((slot) => (panes[slot] ??= pane(slot, () => { view.dirty = true; }))[part]);
    if (place.children.length !== wantedParts.length || wantedParts.some((one, k) => place.children[k] !== one)) {
      place.replaceChildren(...wantedParts);
    }
  }
}

function words(slot) {
  const record = at(slot);
  if (!record) return "";
  if (record.state === "preparing") return record.note || "starting a process, loading the model, inflating the tube …";
  if (record.state === "computing") return `${record.paused ? "paused" : "computing"}, ${record.end.toFixed(2)} of at most ${number(record.header.duration)} s`;
  if (record.state === "cut") return `ended at ${record.end.toFixed(2)} s by another run`;
  if (record.state === "failed") return record.error;
  return record.outcome.stopped ? `stopped at ${record.end.toFixed(2)} s` : record.outcome.words.toLowerCase();
}

function labels() {
  const slot = form.slot.toUpperCase();
  $("run").textContent = `Run ${slot}`;
  const now = computing();
  const paused = now.length > 0 && now.every((one) => one.paused);
  $("play").textContent = now.length ? (paused ? "Continue" : "Pause") : view.playing ? "Pause" : "Play";
  const any = present().length > 0;
  for (const id of ["back", "forward", "scrub"]) $(id).disabled = !any;
  $("play").disabled = !any;
  $("stop").disabled = !now.length;
  $("live").hidden = view.follow || !now.length;
  $("form").classList.toggle("running", Boolean(at(form.slot)?.computing));
  const told = SLOTS.filter(at).map((one) => `Run ${one.toUpperCase()}: ${words(one)}`);
  const text = up ? told.join(" · ") || "Choose, then press Run" : "No connection to the server …";
  if ($("status").textContent !== text) $("status").textContent = text;
  $("keep-of").textContent = `of run ${slot}`;
  document.querySelectorAll("[data-file]").forEach((button) => { if (!at(form.slot)?.frames.length) button.disabled = true; else if (!$("kept").textContent.startsWith("Making")) button.disabled = false; });
  SLOTS.filter((one) => panes[one]).forEach((one) => panes[one].words.forEach((place) => {
    const record = at(one);
    place.textContent = record?.header ? [record.header.scenario, record.header.reading, ...record.header.drugs].join(", ").replaceAll(" uM", " µM") : "";
  }));
}

let [charted, late] = [0, false]; // when charts were drawn last, and whether they are behind

function draw() {
  const upto = Math.max(0.5, ...present().map((slot) => at(slot).end), ...present().map((slot) => (at(slot).computing ? Math.min(at(slot).header.duration, at(slot).end * 1.25) : 0)));
  for (const slot of present()) {
    const record = at(slot);
    const { tube, drawn, details, table } = panes[slot];
    const frame = record.frames[record.at(view.time)];
    const past = ghostOf(slot);
    const ghost = past?.frames.length ? { record: past, frame: past.frames[past.at(view.time)] } : null;
    drawTube(tube, record, frame, ghost, theme(slot));
    drawn.draw(record, view.time, upto, ghost ? past : null);
    if (details.open && panes[slot].rows !== record.frames.length && (!record.computing || record.paused || panes[slot].rows < 0)) {
      mapTable(table, record);
      panes[slot].rows = record.frames.length;
    }
  }
  const now = performance.now();
  const moving = view.playing || computing().some((one) => !one.paused);
  if (moving && now - charted < 150) { late = true; return; } // the tube moves smoothly, charts a little less
  [charted, late] = [now, false];
  const slots = present();
  drawPanels({ slots, at, ghostOf, chosen: slots.includes(form.slot) ? form.slot : slots[0] }, view.time, upto);
}

let [second, counted] = [performance.now(), 0];
function tick(now) {
  requestAnimationFrame(tick);
  if (view.playing) {
    view.time = Math.min(latest(), view.time + (now - view.at) / 1000);
    view.at = now;
    if (view.time >= latest()) view.playing = false;
    view.dirty = true;
  }
  if (view.follow) view.time = newest();
  if (now - second >= 1000) {
    const moving = computing().some((one) => !one.paused) || view.playing;
    $("rate").textContent = moving ? `${Math.round((counted * 1000) / (now - second))} pictures a second` : "";
    [second, counted] = [now, 0];
  }
  if (late && now - charted > 150) view.dirty = true;
  if (!view.dirty) return;
  view.dirty = false;
  $("view").classList.toggle("empty", !present().length); // before the sizes of what is drawn are asked for
  arrange();
  labels();
  const end = latest();
  $("scrub").max = Math.max(end, 0.02);
  $("scrub").value = view.time;
  $("scrub").setAttribute("aria-valuetext", `${view.time.toFixed(2)} seconds of ${end.toFixed(2)}`);
  $("clock").textContent = `${view.time.toFixed(2)} s`;
  if (!present().length) return;
  const begun = performance.now();
  draw();
  stats.spent += performance.now() - begun;
  counted += 1;
  stats.drawn += 1;
  for (const one of waiting.splice(0)) {
    if (one.record.end > one.time) stats.lags.push(performance.now() - one.asked); else waiting.push(one);
  }
}

function colours(theme_) {
  document.documentElement.dataset.theme = theme_;
  $("theme").textContent = theme_ === "dark" ? "Light" : "Dark";
  $("theme").setAttribute("aria-pressed", String(theme_ === "dark"));
  view.dirty = true;
}

function lessonsShown(open) {
  $("lessons").hidden = !open;
  $("open-lessons").setAttribute("aria-expanded", String(open));
  if (open && !lessons.lesson) lessons.choose(lessons.lessons[0]);
  if (open) $("lesson-list").querySelector("button").focus();
}

function wire() {
  $("form").addEventListener("submit", (event) => { event.preventDefault(); start(form.slot); });
  $("run-both").addEventListener("click", () => SLOTS.forEach(start));
  $("reset").addEventListener("click", () => form.reset());
  document.querySelectorAll('input[name="slot"]').forEach((radio) => radio.addEventListener("change", () => {
    if (radio.value === "b" && !at("b") && !form.address().includes("b.")) form.copy("a", "b");
    form.choose(radio.value).then(() => { view.dirty = true; });
  }));
  $("play").addEventListener("click", play);
  $("back").addEventListener("click", () => step(-1));
  $("forward").addEventListener("click", () => step(1));
  $("stop").addEventListener("click", () => computing().forEach((one) => order(one, "stop")));
  $("live").addEventListener("click", () => Object.assign(view, { follow: true, dirty: true }));
  $("scrub").addEventListener("input", () => Object.assign(view, { time: Number($("scrub").value), follow: false, playing: false, dirty: true }));
  for (const id of ["ghost", "layer"]) $(id).addEventListener("change", () => { view.dirty = true; });
  $("theme").addEventListener("click", () => {
    const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    localStorage.setItem("peristalsis-theme", next);
    colours(next);
  });
  $("open-lessons").addEventListener("click", () => lessonsShown($("lessons").hidden));
  $("close-lessons").addEventListener("click", () => { lessonsShown(false); $("open-lessons").focus(); });
  document.querySelectorAll("[data-file]").forEach((button) => button.addEventListener("click", () => {
    problem(null);
    if (at(form.slot)) link.say("export", { run: at(form.slot).name, what: button.dataset.file });
  }));
  for (const id of ["toml", "python"]) $(id).addEventListener("click", () => { wanted = id; link.say("words", { asked: form.asked(form.slot) }); });
  $("permalink").addEventListener("click", () => {
    const address = `${location.origin}/#${form.address()}`;
    $("words").hidden = false;
    $("words").textContent = address;
    navigator.clipboard?.writeText(address).then(() => { $("kept").textContent = "The address is in the clipboard"; }, () => {});
  });
  window.addEventListener("hashchange", () => {
    if (location.hash === "#view") form.write(); // the link that skips to the picture
    else form.take(location.hash).then(() => { view.dirty = true; }, (error) => problem(error.message));
  });
  new ResizeObserver(() => { view.dirty = true; }).observe($("view"));
}

async function main() {
  $("more").open = !window.matchMedia("(max-width: 56rem)").matches; // the picture comes first on a telephone
  const preferred = window.matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  colours(localStorage.getItem("peristalsis-theme") ?? preferred);
  const catalogue = await ask("/catalogue");
  form = new Form(catalogue, edited);
  lessons = new Lessons(catalogue.lessons, begin, (lesson, runs) => link.say("judge", { lesson, runs }));
  wire();
  await form.load();
  for (const [slot, name] of Object.entries(shown)) if (name) records.set(name, new Record(name, slot.slice(-1).toLowerCase()));
  link = new Link(document.querySelector('meta[name="token"]').content, page, { on: hear, frames, up: (stands) => {
    up = stands;
    view.dirty = true;
    if (!stands) {
      if ($("kept").textContent.startsWith("Making")) $("kept").textContent = "The connection was lost before the file was made; ask for it again";
      return;
    }
    if ($("problem").textContent === SILENT) problem(null);
    for (const [name, record] of records) {
      // The server tells everything from the start, so what was told before is left.
      records.set(name, new Record(name, record.slot));
      link.say("attach", { run: name });
    }
  }, silent: () => problem(SILENT) });
  requestAnimationFrame(tick);
  document.documentElement.dataset.ready = "yes";
}

main().catch((error) => problem(error.message));
