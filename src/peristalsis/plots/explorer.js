// Draws every explorer of the page that has not been drawn; its numbers stand in its attribute data-run.
(() => {
  const COLOURS = [[0, 32, 77], [58, 70, 108], [124, 123, 120], [188, 174, 108], [255, 234, 70]];
  const colour = (share) => {
    const at = Math.min(1, Math.max(0, share)) * (COLOURS.length - 1);
    const low = Math.min(Math.floor(at), COLOURS.length - 2);
    return COLOURS[low].map((one, k) => Math.round(one + (at - low) * (COLOURS[low + 1][k] - one)));
  };
  const MARGIN = 8;

  function begin(place) {
    place.dataset.on = "yes";
    const run = JSON.parse(place.dataset.run);
    const [tube, map] = place.querySelectorAll("canvas");
    const slider = place.querySelector("input");
    const clock = place.querySelector("output");
    const count = run.time.length;
    const lower = run.axial.length > 1 ? 1 : 0;
    const down = (k) => (lower ? run.across[1][k] : run.across[0][k].map((one) => -one));
    const widest = Math.max(...run.across.flat(2).map(Math.abs), ...(run.outline ?? []).map(([, out]) => Math.abs(out)));
    slider.max = count - 1;
    slider.value = Math.floor((count - 1) / 3);

    const fresh = (canvas, height) => {
      const width = Math.min(760, place.clientWidth || 640);
      const ratio = window.devicePixelRatio || 1;
      Object.assign(canvas, { width: width * ratio, height: height * ratio });
      Object.assign(canvas.style, { width: `${width}px`, height: `${height}px`, display: "block" });
      const context = canvas.getContext("2d");
      context.scale(ratio, ratio);
      return { context, width, perUnit: (width - 2 * MARGIN) / run.span };
    };

    function drawTube(k) {
      const scale = (Math.min(760, place.clientWidth || 640) - 2 * MARGIN) / run.span;
      const { context, perUnit } = fresh(tube, 2 * widest * scale + 2 * MARGIN);
      const middle = widest * perUnit + MARGIN;
      const ink = getComputedStyle(place).color;
      context.strokeStyle = ink;
      context.lineWidth = 2;
      for (const [axial, across] of [[run.axial[0][k], run.across[0][k]], [run.axial[lower][k], down(k)]]) {
        context.beginPath();
        axial.forEach((one, i) => context[i ? "lineTo" : "moveTo"](MARGIN + perUnit * one, middle - perUnit * across[i]));
        context.stroke();
      }
      if (!run.outline) return;
      context.beginPath();
      for (const [along, out] of run.outline) context.lineTo(MARGIN + perUnit * (run.centre[k] + along), middle - perUnit * out);
      context.closePath();
      context.fillStyle = "#d9a441";
      context.fill();
      context.lineWidth = 1;
      context.stroke();
    }

    /** Diameters at places evenly along the tube, for each time; the widest and the narrowest of all. */
    const columns = 240;
    const diameters = run.time.map((_, k) => {
      const [axial, up, below] = [run.axial[0][k], run.across[0][k], down(k)];
      let i = 0;
      return Array.from({ length: columns }, (_, column) => {
        const z = (run.span * column) / (columns - 1);
        while (i < axial.length - 2 && axial[i + 1] < z) i += 1;
        const share = Math.min(1, Math.max(0, (z - axial[i]) / (axial[i + 1] - axial[i] || 1)));
        return up[i] - below[i] + share * (up[i + 1] - below[i + 1] - up[i] + below[i]);
      });
    });
    const picture = document.createElement("canvas");
    Object.assign(picture, { width: columns, height: count });
    const [low, high] = [Math.min(...diameters.flat()), Math.max(...diameters.flat())];
    const pixels = new ImageData(columns, count);
    diameters.flat().forEach((one, k) => pixels.data.set([...colour((one - low) / (high - low || 1)), 255], 4 * k));
    picture.getContext("2d").putImageData(pixels, 0, 0);

    const HEIGHT = 180;
    function drawMap(k) {
      const { context, width, perUnit } = fresh(map, HEIGHT);
      const row = (n) => (HEIGHT * (n + 0.5)) / count;
      context.drawImage(picture, MARGIN, 0, width - 2 * MARGIN, HEIGHT);
      context.strokeStyle = "#ffffff";
      context.lineWidth = 2;
      context.beginPath();
      (run.centre ?? []).forEach((one, n) => context.lineTo(MARGIN + perUnit * one, row(n)));
      context.stroke();
      context.setLineDash([6, 4]);
      context.beginPath();
      context.moveTo(0, row(k));
      context.lineTo(width, row(k));
      context.stroke();
    }

    const rows = run.numbers.map(({ label, unit }) => {
      const row = place.querySelector("table").insertRow();
      row.insertCell().textContent = label;
      const value = row.insertCell();
      value.style.textAlign = "right";
      row.insertCell().textContent = unit;
      return value;
    });

    function show() {
      const k = Number(slider.value);
      clock.textContent = `${run.time[k].toFixed(2)} s`;
      slider.setAttribute("aria-valuetext", `${run.time[k].toFixed(2)} seconds`);
      rows.forEach((one, n) => { one.textContent = String(run.numbers[n].values[k]).replace("-", "−"); });
      drawTube(k);
      drawMap(k);
    }
    slider.addEventListener("input", show);
    map.addEventListener("click", ({ offsetY }) => {
      slider.value = Math.floor((count * offsetY) / HEIGHT);
      show();
    });
    new ResizeObserver(show).observe(place);
    show();
  }

  document.querySelectorAll(".peristalsis-explorer:not([data-on])").forEach(begin);
})();
