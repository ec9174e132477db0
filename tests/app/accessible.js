// What is wrong with the page for people who do not see it, or not well: sentences, none where all is right.
(() => {
  const found = [];
  const seen = (one) => one.checkVisibility({ visibilityProperty: true }) && one.getClientRects().length > 0;
  const about = (one) => `${one.tagName.toLowerCase()}#${one.id} "${one.textContent.trim().slice(0, 30)}"`;
  const channel = (value) => (value <= 0.03928 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
  const parse = (text) => { const all = text.match(/[\d.]+/g).map(Number); return { rgb: all.slice(0, 3), alpha: all[3] ?? 1 }; };
  const luminance = (rgb) => rgb.map((one) => channel(one / 255)).reduce((sum, one, k) => sum + one * [0.2126, 0.7152, 0.0722][k], 0);
  const paper = (one) => {
    for (let at = one; at; at = at.parentElement) {
      const { rgb, alpha } = parse(getComputedStyle(at).backgroundColor);
      if (alpha > 0.99) return rgb;
    }
    return [255, 255, 255];
  };
  for (const one of document.querySelectorAll("body *")) {
    const own = [...one.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    if (!own || !seen(one) || one.closest(":disabled, .skip, option, title")) continue;
    const [ink, back] = [luminance(parse(getComputedStyle(one).color).rgb), luminance(paper(one))];
    const ratio = (Math.max(ink, back) + 0.05) / (Math.min(ink, back) + 0.05);
    if (ratio < 4.5) found.push(`${about(one)} has a contrast of ${ratio.toFixed(2)}`);
  }
  for (const one of document.querySelectorAll("button, input, select, canvas, summary, [role=region]")) {
    if (!seen(one)) continue;
    const name = one.getAttribute("aria-label") || document.getElementById(one.getAttribute("aria-labelledby") ?? "")?.textContent
      || [...(one.labels ?? [])].map((label) => label.textContent).join("") || (one.matches("button, summary") ? one.textContent : "");
    if (!name.trim()) found.push(`${about(one)} has no name`);
    const { width, height } = one.getBoundingClientRect();
    if (one.matches("button, select, input[type=range], input[type=number]") && Math.min(width, height) < 24) {
      found.push(`${about(one)} is only ${width.toFixed(0)} x ${height.toFixed(0)} pixels`);
    }
  }
  for (const range of document.querySelectorAll("input[type=range]")) {
    if (seen(range) && !range.getAttribute("aria-valuetext") && !range.disabled) found.push(`${about(range)} says no value`);
  }
  const names = [...document.querySelectorAll("[id]")].map(({ id }) => id);
  names.filter((id, k) => names.indexOf(id) !== k).forEach((id) => found.push(`${id} is there twice`));
  for (const attribute of ["aria-labelledby", "aria-controls", "aria-describedby", "for"]) {
    for (const one of document.querySelectorAll(`[${attribute}]`)) {
      const meant = one.getAttribute(attribute);
      if (!document.getElementById(meant)) found.push(`${about(one)} means ${meant}, which is not there`);
    }
  }
  const levels = [...document.querySelectorAll("h1, h2, h3")].filter(seen).map((one) => Number(one.tagName[1]));
  if (levels.filter((level) => level === 1).length !== 1) found.push("there is not one h1");
  levels.forEach((level, k) => { if (k && level > levels[k - 1] + 1) found.push(`a heading h${level} follows h${levels[k - 1]}`); });
  if (!document.documentElement.lang) found.push("the language is not said");
  if (document.querySelectorAll("main").length !== 1) found.push("there is not one main part");
  for (const table of document.querySelectorAll("table")) {
    if (seen(table) && table.rows.length && !table.querySelector("th[scope]")) found.push(`${about(table)} has no heads`);
  }
  return found;
})()
