// Figures of groups of rows.

// Linear between order statistics, as NumPy's default.
function quantile(sorted, share) {
  if (!sorted.length) return NaN;
  const at = share * (sorted.length - 1);
  const low = Math.floor(at);
  const high = Math.min(low + 1, sorted.length - 1);
  return sorted[low] + (at - low) * (sorted[high] - sorted[low]);
}

function present(column, rows) {
  const found = new Float64Array(rows.length);
  let count = 0;
  for (const row of rows) {
    const value = column.number(row);
    if (!Number.isNaN(value)) found[count++] = value;
  }
  return found.slice(0, count);
}

const mean = (x) => (x.length ? x.reduce((sum, v) => sum + v, 0) / x.length : NaN);
const rms = (x) => (x.length ? Math.sqrt(x.reduce((sum, v) => sum + v * v, 0) / x.length) : NaN);
const deviation = (x) => {
  if (x.length < 2) return NaN;
  const middle = mean(x);
  return Math.sqrt(x.reduce((sum, v) => sum + (v - middle) ** 2, 0) / (x.length - 1));
};
const largest = (x) => x.reduce((most, v) => Math.max(most, v), x.length ? -Infinity : NaN);

const OF_NUMBERS = {
  max: { text: "largest", of: largest },
  p95: { text: "95 %", of: (x) => quantile(Float64Array.from(x).sort(), 0.95) },
  rms: { text: "RMS", of: rms },
  mean: { text: "mean", of: mean },
  median: { text: "median", of: (x) => quantile(Float64Array.from(x).sort(), 0.5) },
  std: { text: "SD", of: deviation },
};

const NORM = "error_norm_mm";

function isOk(table) {
  const status = table.column("status");
  const ok = status.levels.indexOf("ok");
  return (row) => status.cells[row] === ok;
}

function detectionRate(table, rows) {
  const ok = isOk(table);
  let count = 0;
  for (const row of rows) if (ok(row)) count++;
  return rows.length ? count / rows.length : NaN;
}

// What a map can show: name, text, unit, kind of colours, and how a group's figure is found.
function measuresOf(table) {
  const found = [{ name: "rate", text: "Detection rate", unit: "%", kind: "good",
    of: (rows) => 100 * detectionRate(table, rows) }];
  const add = (column, hows, title, kind) => {
    const one = table.column(column);
    if (!one || !one.filled) return;
    for (const how of hows)
      found.push({
        name: `${column}:${how}`, text: `${title}: ${OF_NUMBERS[how].text}`, unit: one.unit,
        kind: how === "mean" && kind === "signed" ? "signed" : "error",
        of: (rows) => OF_NUMBERS[how].of(present(one, rows)),
      });
  };
  add(NORM, ["max", "p95", "rms", "median", "mean"], "Error");
  add("refined_norm_mm", ["max", "rms"], "Error, refined");
  for (const axis of ["x", "y", "z"]) add(`error_${axis}_mm`, ["mean", "std"], `Error in ${axis}`, "signed");
  for (const side of ["left", "right"])
    for (const way of ["along", "across"])
      add(`${side}_error_${way}_px`, ["mean", "std"], `${side === "left" ? "Left" : "Right"} view, ${way}`, "signed");
  if (table.column("bound_mm") && table.column("bound_mm").filled)
    found.push({ name: "efficiency", text: "Efficiency (bound / RMS error)", unit: "", kind: "good",
      of: (rows) => efficiencyOf(table, rows) });
  return found;
}

// Root mean square of the bounds over that of the errors, of trials that have both.
function efficiencyOf(table, rows) {
  const bounds = table.column("bound_mm");
  const errors = table.column(NORM);
  let b = 0;
  let e = 0;
  for (const row of rows) {
    const [bound, error] = [bounds.number(row), errors.number(row)];
    if (Number.isNaN(bound) || Number.isNaN(error)) continue;
    b += bound * bound;
    e += error * error;
  }
  return e > 0 && b > 0 ? Math.sqrt(b / e) : NaN;
}
