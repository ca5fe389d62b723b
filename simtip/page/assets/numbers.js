// Numbers as people read them. Lengths below 0.1 mm are shown in micrometres.

const MINUS = "\u2212";

function fixed(value, digits) {
  if (value === null || !Number.isFinite(value)) return "\u2013";
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", MINUS);
}

// Three digits of the largest.
function digitsFor(most) {
  if (!(most > 0) || !Number.isFinite(most)) return 0;
  return Math.max(0, Math.min(9, 2 - Math.floor(Math.log10(most))));
}

function scaleFor(most, unit) {
  const small = unit === "mm" && most < 0.1;
  const factor = small ? 1000 : 1;
  const shown = small ? "\u00b5m" : unit;
  const digits = digitsFor(most * factor);
  const number = (value) => fixed(value * factor, digits);
  return {
    factor,
    unit: shown,
    number,
    text: (value) => (Number.isFinite(value) ? `${number(value)}${shown ? ` ${shown}` : ""}` : "\u2013"),
  };
}

function short(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "\u2013";
  if (!Number.isFinite(value)) return value > 0 ? "inf" : `${MINUS}inf`;
  return String(Number(value.toPrecision(6))).replace("-", MINUS);
}

function counted(count, one, many) {
  const text = count.toLocaleString("en").replaceAll(",", "\u202f");
  return `${text} ${count === 1 ? one : many}`;
}

// Round steps between two ends.
function ticks(low, high, most) {
  const raw = (high - low) / Math.max(1, most);
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= raw);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}

// 1, 2, 5 times a power of ten, at or above.
function niceAbove(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const found = [1, 2, 5, 10].find((k) => k * power >= value * (1 - 1e-9));
  return Number((found * power).toPrecision(6));
}
