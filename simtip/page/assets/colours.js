// Colours of numbers. Viridis is by Smith, van der Walt and Firing (matplotlib, CC0).

const VIRIDIS = [
  [68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140],
  [40, 174, 128], [94, 201, 98], [173, 220, 48], [253, 231, 37],
];
const BLUES = [0, 92, 150];
const ORANGES = [200, 82, 0];

function mixed(one, other, share) {
  return one.map((value, k) => Math.round(value + (other[k] - value) * share));
}

function onScale(stops, share) {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  return mixed(stops[low], stops[low + 1], at - low);
}

function isDark() {
  const theme = document.documentElement.dataset.theme;
  return theme ? theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

const inWords = (rgb) => `rgb(${rgb.join(",")})`;

function inkOn(rgb) {
  const [r, g, b] = rgb.map((c) => (c / 255) ** 2.2);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.3 ? "#111" : "#fff";
}

// Bright is good: a small error, a high rate. Signed numbers go from blue over plain to orange.
function colouring(kind, values) {
  const known = values.filter(Number.isFinite);
  const most = Math.max(...known.map(Math.abs), 1e-12);
  if (kind === "signed") {
    const middle = isDark() ? [44, 50, 57] : [243, 243, 241];
    const of = (v) => mixed(middle, v < 0 ? BLUES : ORANGES, Math.min(1, Math.abs(v) / most));
    return { of, low: -most, high: most, at: (share) => of(most * (2 * share - 1)), log: false };
  }
  if (kind === "good") {
    const high = Math.max(...known, 1e-12) > 1.5 ? 100 : Math.max(1, ...known);
    const of = (v) => onScale(VIRIDIS, v / high);
    return { of, low: 0, high, at: (share) => of(share * high), log: false };
  }
  const sorted = Float64Array.from(known).sort();
  const low = sorted.find((v) => v > 0) || 1e-12;
  const top = Math.max(sorted.at(-1) || 0, low);
  const log = top / low > 30;
  // A few far larger than all others would leave one colour for the rest.
  const usual = quantile(sorted, 0.96);
  const cut = !log && top > 1.8 * usual && usual > low;
  const high = cut ? usual : top;
  const shareOf = log
    ? (v) => Math.log(Math.max(v, low) / low) / Math.log(high / low)
    : (v) => (high > low ? (v - low) / (high - low) : 0);
  return {
    of: (v) => onScale(VIRIDIS, 1 - shareOf(v)),
    low, high, log, cut, at: (share) => onScale(VIRIDIS, 1 - share),
  };
}

const SERIES = ["--blue", "--orange", "--green", "--purple", "--yellow", "--sky"];
