// Colours: those of the theme, those of lines, and those of the map.

// Cividis, dark to bright (Nuñez, Anderton and Renslow, PLoS ONE 13, 2018): looks alike with any colour vision.
const CIVIDIS = ("00224e 00285b 002e6a 053371 1a386f 273e6e 32436d 3b496c 434e6c 4b546c 535a6d 5a5f6e 61656f 686a71 " +
  "6f7073 767676 7d7c78 848279 8c8878 938e78 9b9476 a39a74 aba072 b4a76f bcae6c c4b468 cdbb63 d5c25e dec958 e7d150 " +
  "f0d846 f9e03a fee838").split(" ");

/** The map's colours as [r, g, b], 256 of them. */
export const MAP = Array.from({ length: 256 }, (_, k) => {
  const at = (k / 255) * (CIVIDIS.length - 1);
  const low = Math.min(Math.floor(at), CIVIDIS.length - 2);
  const [one, two] = [CIVIDIS[low], CIVIDIS[low + 1]].map((hex) => [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16)));
  return one.map((value, i) => Math.round(value + (at - low) * (two[i] - value)));
});

// Lines by Okabe and Ito, told apart by dashes besides; the second of each pair is for dark paper.
const LINES = [["#0072b2", "#56b4e9"], ["#b3471d", "#f0926b"], ["#00795a", "#2fc79b"], ["#8f4d7a", "#dd9cc5"],
  ["#6b6b00", "#e6d94a"], ["#444444", "#bbbbbb"]];
export const DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3], [1, 3], [12, 4]];

export const dark = () => document.documentElement.dataset.theme === "dark";
export const line = (number) => LINES[number % LINES.length][dark() ? 1 : 0];

/** A colour of the theme by its name in the style sheet. */
export const theme = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
