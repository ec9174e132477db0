// The controls: built from the catalogue, one state for each of both runs, written into the address.

import { doseOf, doseText, Drugs } from "./drugs.js";
import { ask } from "./link.js";
import { make } from "./page.js";

const spoken = { "mN·s/cm": "millinewton seconds per centimetre", cm: "centimetres", mN: "millinewtons",
  kPa: "kilopascals", "%": "per cent", s: "seconds" };
const digits = (step) => Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));

export class Form {
  /** changed: called with ("value" or "switch", control, value) after a change, live where the user made it. */
  constructor(catalogue, changed) {
    Object.assign(this, { catalogue, changed, slot: "a", rows: {}, boxes: {} });
    this.states = { a: this.blank(), b: this.blank() };
    this.fill(document.getElementById("scenario"), catalogue.scenarios.map(({ name, title }) => [name, `${title} (${name})`]));
    this.fill(document.getElementById("reading"), [["", "of the scenario"], ...catalogue.readings.map((name) => [name, name])]);
    this.fill(document.getElementById("grid"), [["shipped", "of the scenario"], ["quick", "quick and coarse"]]);
    for (const name of ["scenario", "reading", "grid"]) {
      document.getElementById(name).addEventListener("change", (event) => this.pick(name, event.target.value));
    }
    this.drugs = new Drugs(catalogue, (...words) => { this.write(); changed(...words); });
    this.build();
    this.read(location.hash);
  }

  blank() { return { scenario: "baseline", reading: "", grid: "shipped", values: {}, switches: {}, drugs: {}, library: "shipped", defaults: null }; }

  get state() { return this.states[this.slot]; }

  fill(select, entries) {
    select.replaceChildren(...entries.map(([value, text]) => make("option", { value, textContent: text })));
  }

  build() {
    const groups = new Map();
    for (const control of this.catalogue.controls) {
      if (!groups.has(control.group)) groups.set(control.group, []);
      groups.get(control.group).push(control);
    }
    const switches = make("div", { className: "group" }, make("div", { className: "group-title", textContent: "Switches" }));
    for (const one of this.catalogue.switches) {
      const box = make("input", { type: "checkbox", id: `switch-${one.name}` });
      box.addEventListener("change", () => this.turn(one, box.checked));
      const later = one.live ? [] : [make("span", { className: "later", textContent: "next run" })];
      switches.append(make("div", { className: "control check", title: one.help }, box,
        make("label", { htmlFor: box.id, textContent: one.label }), ...later));
      this.boxes[one.name] = box;
    }
    const made = [switches];
    for (const [group, controls] of groups) {
      const details = make("details", { className: "group", open: group !== "Channels" }, make("summary", { textContent: group }));
      for (const control of controls) details.append(this.control(control));
      made.push(details);
    }
    made.splice(-1, 0, this.drugs.part); // the length of the run stays last
    document.getElementById("controls").replaceChildren(...made);
  }

  control(control) {
    const id = `control-${control.name}`;
    const range = make("input", { type: "range", id, min: control.low, max: control.high, step: control.step });
    const number = make("input", { type: "number", min: control.low, max: control.high, step: "any" });
    number.setAttribute("aria-label", `${control.label} in ${spoken[control.unit] ?? control.unit}`);
    range.addEventListener("input", () => this.move(control, Number(range.value)));
    number.addEventListener("change", () => {
      const value = Number(number.value);
      const valid = number.value !== "" && value >= control.low && value <= control.high;
      number.setAttribute("aria-invalid", String(!valid));
      if (valid) this.move(control, value);
      else this.changed("refused", control, `${control.label} = ${number.value || "nothing"}: give a number from ${control.low} to ${control.high} ${control.unit}`);
    });
    const later = control.live ? [] : [make("span", { className: "later", textContent: "next run" })];
    const row = make("div", { className: "control" },
      make("div", { className: "name" }, make("label", { htmlFor: id, textContent: control.label }), ...later),
      make("div", { className: "set" }, range, number, make("span", { className: "unit", textContent: control.unit })));
    if (control.help) {
      const help = make("div", { className: "help", id: `${id}-help`, textContent: control.help });
      range.setAttribute("aria-describedby", help.id);
      if (control.group !== "Channels") row.append(help); else row.title = control.help;
      if (control.group === "Channels") range.removeAttribute("aria-describedby");
    }
    this.rows[control.name] = { row, range, number, control };
    return row;
  }

  async choose(slot) {
    this.slot = slot;
    await this.load();
  }

  /** Fetch what the scenario has, where that is not known, and show everything. */
  async load() {
    for (const state of Object.values(this.states)) {
      if (state.defaults) continue;
      const query = new URLSearchParams({ scenario: state.scenario, ...(state.reading ? { reading: state.reading } : {}) });
      const answer = await ask(`/defaults?${query}`);
      if (answer.error) throw new Error(answer.error);
      state.defaults = answer;
    }
    this.show();
  }

  show() {
    const { state } = this;
    for (const name of ["scenario", "reading", "grid"]) document.getElementById(name).value = state[name];
    for (const { name } of this.catalogue.controls) this.showControl(name);
    for (const { name } of this.catalogue.switches) this.boxes[name].checked = state.switches[name] ?? state.defaults.switches[name];
    this.drugs.show(state);
    this.write();
  }

  showControl(name) {
    const { row, range, number, control } = this.rows[name];
    const { state } = this;
    const own = state.defaults.values[name];
    row.hidden = own === undefined;
    if (row.hidden) return;
    const value = state.values[name] ?? own;
    const text = String(Number(value.toFixed(digits(control.step) + 1)));
    // A value of the scenario may lie beyond the slider or between its steps; the number box shows it as it is.
    range.value = value;
    number.value = text;
    range.setAttribute("aria-valuetext", `${text} ${spoken[control.unit] ?? control.unit}`);
    row.classList.toggle("changed", name in state.values);
  }

  pick(name, value) {
    const { state } = this;
    const before = { ...state };
    state[name] = value;
    if (name !== "grid") Object.assign(state, { values: {}, switches: {}, defaults: null });
    this.load().catch((error) => {
      Object.assign(state, before);
      this.show();
      this.changed("refused", null, error.message);
    });
  }

  move(control, value) {
    const { state } = this;
    if (value === state.defaults.values[control.name]) delete state.values[control.name];
    else state.values[control.name] = value;
    this.showControl(control.name);
    this.write();
    this.changed("value", control, value);
  }

  turn(one, on) {
    const { state } = this;
    if (on === state.defaults.switches[one.name]) delete state.switches[one.name];
    else state.switches[one.name] = on;
    this.write();
    this.changed("switch", one, on);
  }

  reset() {
    this.states[this.slot] = this.blank();
    return this.load();
  }

  /** Take a run of a lesson into a slot. */
  set(slot, asked) {
    this.states[slot] = { ...this.blank(), ...asked, values: { ...asked.values }, switches: { ...asked.switches } };
  }

  copy(from, to) { this.states[to] = structuredClone(this.states[from]); }

  asked(slot) {
    const { scenario, reading, grid, values, switches, drugs, library } = this.states[slot];
    return { scenario, reading: reading || null, grid, values, switches, drugs, library };
  }

  /** The state in the address: a.scenario=fig3f&a.v.pressure=1&a.d.nifedipine=30+nM&b... */
  address() {
    const query = new URLSearchParams();
    for (const [slot, state] of Object.entries(this.states)) {
      const blank = this.blank();
      for (const name of ["scenario", "reading", "grid", "library"]) if (state[name] !== blank[name]) query.set(`${slot}.${name}`, state[name]);
      for (const [name, value] of Object.entries(state.values)) query.set(`${slot}.v.${name}`, value);
      for (const [name, on] of Object.entries(state.switches)) query.set(`${slot}.s.${name}`, on ? "on" : "off");
      for (const one of this.catalogue.agents) if (Object.hasOwn(state.drugs, one.name)) query.set(`${slot}.d.${one.name}`, doseText(one, state.drugs[one.name]));
    }
    return query.toString();
  }

  write() {
    clearTimeout(this.writing); // browsers refuse an address that is written too often
    this.writing = setTimeout(() => history.replaceState(null, "", `${location.pathname}#${this.address()}`), 150);
  }

  /** Take the states of another address instead of what is here. */
  take(hash) {
    clearTimeout(this.writing);
    this.states = { a: this.blank(), b: this.blank() };
    this.read(hash);
    return this.load();
  }

  /** Take a state from an address; what is not offered is left out. */
  read(hash) {
    const query = new URLSearchParams(hash.replace(/^#/, ""));
    const offered = { scenario: this.catalogue.scenarios.map(({ name }) => name), reading: this.catalogue.readings, grid: this.catalogue.grids, library: this.catalogue.libraries };
    for (const [key, text] of query) {
      const [slot, kind, ...rest] = key.split(".");
      const name = rest.join(".");
      const state = Object.hasOwn(this.states, slot) ? this.states[slot] : null;
      if (!state) continue;
      if (Object.hasOwn(offered, kind) && offered[kind].includes(text)) state[kind] = text;
      const control = this.catalogue.controls.find((one) => one.name === name);
      const value = Number(text);
      if (kind === "v" && control && text !== "" && value >= control.low && value <= control.high) state.values[name] = value;
      const known = this.catalogue.switches.some((one) => one.name === name);
      if (kind === "s" && known && (text === "on" || text === "off")) state.switches[name] = text === "on";
      const agent = this.catalogue.agents.find((one) => one.name === name && !one.refused);
      const dose = kind === "d" && agent ? doseOf(agent, text) : null;
      if (dose !== null) state.drugs[name] = dose;
    }
  }
}
