// One run as the page knows it: its header, its frames, how it stands.

export class Record {
  constructor(name, slot) {
    Object.assign(this, { name, slot, header: null, frames: [], state: "preparing", note: "", paused: false,
      outcome: null, remarks: [], error: null, changes: [] });
  }

  get computing() { return this.state === "preparing" || this.state === "computing"; }

  begin(header) {
    this.header = header;
    this.state = "computing";
    const { longitudinal, circular } = header.currents;
    let at = 1;
    this.place = Object.fromEntries(header.scalars.map(({ name }) => [name, at++]));
    this.current = { longitudinal: at, circular: at + longitudinal.length };
    at += longitudinal.length + circular.length;
    this.fields = {};
    for (const name of ["radius", "axial", "contact"]) { this.fields[name] = at; at += header.nodes; }
    for (const name of ["longitudinal", "circular"]) { this.fields[name] = at; at += header.cells; }
    this.unit = Object.fromEntries(header.scalars.map(({ name, unit }) => [name, unit]));
    this.label = Object.fromEntries(header.scalars.map(({ name, label }) => [name, label]));
  }

  add(first, frames) {
    frames.forEach((frame, k) => { this.frames[first + k] = frame; });
  }

  get end() { return this.frames.length ? this.frames[this.frames.length - 1][0] : 0; }

  /** Number of the last frame that is not after a time; 0 before all of them. */
  at(time) {
    let [low, high] = [0, this.frames.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.frames[middle][0] <= time + 1e-6) low = middle; else high = middle - 1;
    }
    return low;
  }

  field(frame, name) {
    const count = name === "longitudinal" || name === "circular" ? this.header.cells : this.header.nodes;
    return frame.subarray(this.fields[name], this.fields[name] + count);
  }

  scalar(frame, name) { return frame[this.place[name]]; }

  currents(frame, layer) {
    return this.header.currents[layer].map((name, k) => [name, frame[this.current[layer] + k]]);
  }

  /** Diameters [cm] at evenly spaced places from the oral to the anal end. */
  diameters(frame, count) {
    const [radius, axial] = [this.field(frame, "radius"), this.field(frame, "axial")];
    const found = new Float32Array(count);
    let k = 0;
    for (let i = 0; i < count; i += 1) {
      const z = (this.header.length * i) / (count - 1);
      while (k < axial.length - 2 && axial[k + 1] < z) k += 1;
      const share = Math.min(1, Math.max(0, (z - axial[k]) / (axial[k + 1] - axial[k] || 1)));
      found[i] = 2 * (radius[k] + share * (radius[k + 1] - radius[k]));
    }
    return found;
  }
}
