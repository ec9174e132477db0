// Agents and other interventions by name, each with a dose: chosen from a list, a row for each.

import { make } from "./page.js";

const SIZES = { pM: 1e-3, nM: 1, uM: 1e3, mM: 1e6, M: 1e9 };
const SPOKEN = { pM: "picomolar", nM: "nanomolar", uM: "micromolar", mM: "millimolar", M: "molar", "": "times" };
const LIBRARIES = { shipped: "the slow channel, as shipped", l_type_is_fast: "the fast channel" };

const written = (unit) => unit.replace("u", "µ") || "×";
const capital = (name) => name[0].toUpperCase() + name.slice(1);
const steps = ({ low, high, step, logarithmic }) => Math.round((logarithmic ? Math.log10(high / low) : high - low) / step);
const bound = ({ low, high }, value) => Math.min(high, Math.max(low, value));

/** The dose at a place of the slider, of two digits where it goes by decades, and the place of a dose. */
const doseAt = (one, place) =>
  bound(one, Number((one.logarithmic ? one.low * 10 ** (place * one.step) : one.low + place * one.step).toPrecision(2)));
const placeOf = (one, dose) => Math.round((one.logarithmic ? Math.log10(dose / one.low) : dose - one.low) / one.step);

/** A dose as it stands in an address, and back: in the unit of its agent, or null where it is none within bounds. */
export const doseText = (one, dose) => (one.unit ? `${dose} ${one.unit}` : String(dose));
export function doseOf(one, text) {
  const found = /^([0-9.]+(?:e[+-]?[0-9]+)?) ?([a-zA-Z]*)$/.exec(text);
  if (!found || (found[2] !== "" && !Object.hasOwn(SIZES, found[2])) || Boolean(one.unit) !== Boolean(found[2])) return null;
  const dose = Number(found[1]) * (one.unit ? SIZES[found[2]] / SIZES[one.unit] : 1);
  const rounded = Number(dose.toPrecision(12));
  return rounded >= one.low && rounded <= one.high ? rounded : null;
}

export class Drugs {
  /** agents, libraries: of the catalogue. changed: called with ("drug" or "refused", control, value), as for other controls. */
  constructor({ agents, libraries }, changed) {
    Object.assign(this, { agents, changed, state: null });
    this.select = make("select", { id: "drug-name" });
    const add = make("button", { type: "button", id: "drug-add", textContent: "Add" });
    add.addEventListener("click", () => this.add());
    this.library = make("select", { id: "drug-library" }, ...libraries.map((name) => make("option", { value: name, textContent: LIBRARIES[name] ?? name })));
    this.library.addEventListener("change", () => { this.state.library = this.library.value; this.changed("drug", { live: false }); });
    this.list = make("div", { id: "drug-list" });
    this.part = make("details", { className: "group", open: true }, make("summary", { textContent: "Drugs" }),
      make("div", { className: "pick add" }, make("label", { htmlFor: "drug-name", textContent: "Agent" }), this.select, add),
      this.list,
      make("div", { className: "pick" }, make("label", { htmlFor: "drug-library", textContent: "L-type calcium" }), this.library),
      make("div", { className: "help", textContent: "A dose acts from the start of a run. A research model, not medical advice." }));
  }

  /** Show what a run is given; `state` has `drugs`, doses by name, and `library`, and is changed in place. */
  show(state) {
    this.state = state;
    this.library.value = state.library;
    const option = (one) => make("option", { value: one.name, textContent: one.refused ? `${capital(one.name)}: ${one.refused}` : capital(one.name),
      disabled: Boolean(one.refused) || Object.hasOwn(state.drugs, one.name) });
    const group = (label, chosen) => make("optgroup", { label }, ...this.agents.filter(chosen).map(option));
    const before = this.select.value;
    this.select.replaceChildren(make("option", { value: "", textContent: "choose …" }),
      group("Agents", ({ logarithmic }) => logarithmic), group("Other interventions", ({ logarithmic }) => !logarithmic));
    this.select.value = [...this.select.options].some(({ value, disabled }) => value === before && !disabled) ? before : "";
    this.list.replaceChildren(...this.agents.filter(({ name }) => Object.hasOwn(state.drugs, name)).map((one) => this.row(one)));
  }

  idOf({ name }) { return `drug-${this.agents.findIndex((one) => one.name === name)}`; }

  row(one) {
    const id = this.idOf(one);
    const range = make("input", { type: "range", id, min: 0, max: steps(one), step: 1 });
    const number = make("input", { type: "number", min: one.low, max: one.high, step: "any" });
    number.setAttribute("aria-label", `${one.unit ? "Concentration" : "Factor"} of ${one.name} in ${SPOKEN[one.unit]}`);
    const set = (dose) => {
      this.state.drugs[one.name] = dose;
      number.value = String(dose);
      range.value = placeOf(one, dose);
      range.setAttribute("aria-valuetext", `${dose} ${SPOKEN[one.unit]}`);
    };
    range.addEventListener("input", () => { set(doseAt(one, Number(range.value))); number.removeAttribute("aria-invalid"); this.changed("drug", { live: false }); });
    number.addEventListener("change", () => {
      const dose = Number(number.value);
      const valid = number.value !== "" && dose >= one.low && dose <= one.high;
      number.setAttribute("aria-invalid", String(!valid));
      if (valid) { set(dose); this.changed("drug", { live: false }); }
      else this.changed("refused", null, `${capital(one.name)} = ${number.value || "nothing"}: give a number from ${one.low} to ${one.high} ${written(one.unit)}`);
    });
    const remove = make("button", { type: "button", className: "quiet remove", textContent: "Remove" });
    remove.setAttribute("aria-label", `Remove ${one.name}`);
    remove.addEventListener("click", () => {
      delete this.state.drugs[one.name];
      this.show(this.state);
      this.select.focus();
      this.changed("drug", { live: false });
    });
    const help = make("div", { className: "help", id: `${id}-help`, textContent: one.help.replaceAll(" uM", " µM") });
    range.setAttribute("aria-describedby", help.id);
    set(this.state.drugs[one.name]);
    return make("div", { className: "control changed" },
      make("div", { className: "name" }, make("label", { htmlFor: id, textContent: capital(one.name) }),
        make("span", { className: "later", textContent: "next run" }), remove),
      make("div", { className: "set" }, range, number, make("span", { className: "unit", textContent: written(one.unit) })), help);
  }

  add() {
    const one = this.agents.find(({ name }) => name === this.select.value);
    if (!one) { this.select.focus(); return; }
    this.state.drugs[one.name] = one.first;
    this.show(this.state);
    document.getElementById(this.idOf(one)).focus();
    this.changed("drug", { live: false });
  }
}
