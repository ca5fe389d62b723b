// A column as an axis of cells: its own levels if they are few, else bins of equal width.

const MOST_LEVELS = 32;
const BINS = 16;

function axisOf(column, rows) {
  if (column.coded && column.levels.length <= MOST_LEVELS) return levelsOf(column, rows);
  const values = present(column, rows);
  if (!values.length) return column.coded ? levelsOf(column, rows) : null;
  return binsOf(column, values);
}

// Only levels that occur.
function levelsOf(column, rows) {
  const seen = new Uint8Array(column.levels.length);
  for (const row of rows) seen[column.cells[row]] = 1;
  const kept = [...seen.keys()].filter((k) => seen[k]);
  const cut = kept.slice(0, 60);
  const place = new Map(cut.map((k, at) => [k, at]));
  return {
    column, left: kept.length - cut.length,
    labels: cut.map((k) => column.levels[k]),
    numbers: column.numbers ? cut.map((k) => column.numbers[k]) : null,
    of: (row) => place.get(column.cells[row]) ?? -1,
    condition: (at) => conditionOf(column, cut[at]),
  };
}

function conditionOf(column, level) {
  if (level === column.missing) return null;
  return column.numbers ? `${column.name}==${column.numbers[level]}` : `${column.name}=="${column.levels[level]}"`;
}

function binsOf(column, values) {
  const low = values.reduce((a, b) => Math.min(a, b));
  const high = values.reduce((a, b) => Math.max(a, b));
  const log = low > 0 && high / low > 50;
  const warp = log ? Math.log : (v) => v;
  const back = log ? Math.exp : (v) => v;
  const [a, b] = [warp(low), warp(high)];
  const count = high > low ? BINS : 1;
  const edges = Array.from({ length: count + 1 }, (_, k) => back(a + ((b - a) * k) / count));
  edges[0] = low;
  edges[count] = high;
  return {
    column, left: 0, binned: true,
    labels: Array.from({ length: count }, (_, k) => `${rounded(edges[k])} .. ${rounded(edges[k + 1])}`),
    numbers: Array.from({ length: count }, (_, k) => (edges[k] + edges[k + 1]) / 2),
    of: (row) => {
      const v = column.number(row);
      if (Number.isNaN(v)) return -1;
      return high > low ? Math.min(count - 1, Math.floor(((warp(v) - a) / (b - a)) * count)) : 0;
    },
    condition: (at) => `${column.name}>=${edges[at]} and ${column.name}<${at === count - 1 ? "=" : ""}${edges[at + 1]}`,
  };
}

const rounded = (value) => short(Number(value.toPrecision(3)));

// Rows by cell: arrays of rows, one a cell, cells of the last axis next to each other.
function celled(rows, axes) {
  const sizes = axes.map((axis) => axis.labels.length);
  const cells = Array.from({ length: sizes.reduce((a, b) => a * b, 1) }, () => []);
  for (const row of rows) {
    let at = 0;
    for (let k = 0; k < axes.length && at >= 0; k++) {
      const place = axes[k].of(row);
      at = place < 0 ? -1 : at * sizes[k] + place;
    }
    if (at >= 0) cells[at].push(row);
  }
  return cells;
}
