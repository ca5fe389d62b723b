// A figure over one factor: a line a detector, its levels in order.

function paintCurve(map, width) {
  const [x] = map.axes;
  const count = x.labels.length;
  const series = seriesOf(map);
  const all = series.flatMap((one) => one.values).filter(Number.isFinite);
  const scale = scaleFor(Math.max(...all.map(Math.abs), 0), map.measure.unit);
  const signed = map.measure.kind === "signed";
  const shownLimit = map.measure.name.startsWith(`${NORM}:`) ? map.state.limit : null;
  const top = map.measure.unit === "%" ? 100 : Math.max(...all, signed ? -Infinity : 0, 0) || 1;
  const low = signed ? Math.min(...all, 0) : 0;
  const marks = ticks(low * scale.factor, top * scale.factor, 5);
  const left = 26 + LETTER * Math.max(...marks.map((t) => short(t).length));
  const [right, above, below] = [14, 28 + 20 * Math.ceil(series.length / Math.max(1, Math.floor(width / 190))), 48];
  const high = Math.min(360, Math.max(220, width * 0.5));
  const numeric = x.numbers && x.numbers.every((n) => n !== null && Number.isFinite(n)) && count > 1;
  const log = numeric && Math.min(...x.numbers) > 0 && Math.max(...x.numbers) / Math.min(...x.numbers) > 8
    && isGeometric(x.numbers);
  const warp = log ? Math.log : (v) => v;
  const at = (k) => numeric
    ? left + 8 + ((warp(x.numbers[k]) - warp(x.numbers[0])) / (warp(x.numbers[count - 1]) - warp(x.numbers[0]))) * (width - left - right - 16)
    : left + ((k + 0.5) / count) * (width - left - right);
  const up = (v) => above + high - ((v - low) / (top - low || 1)) * high;
  const svg = shape("svg", { viewBox: `0 0 ${width} ${above + high + below}`, role: "application", tabindex: 0,
    "aria-label": `${map.measure.text} over ${map.explorer.title(x.column.name)}; arrow keys go from level to level, Enter lists its trials` });
  const edges = [...Array(count).keys()].map((k) => [k ? (at(k - 1) + at(k)) / 2 : left, k < count - 1 ? (at(k) + at(k + 1)) / 2 : width - right]);
  edges.forEach(([a, b], k) => {
    if (map.inside[k]) svg.append(shape("rect", { x: a, y: above, width: b - a, height: high, class: "band" }));
  });
  for (const t of marks) {
    const v = up(t / scale.factor);
    svg.append(shape("line", { x1: left, x2: width - right, y1: v, y2: v, class: "grid" }),
      shape("text", { x: left - 8, y: v + 4, "text-anchor": "end" }, short(t)));
  }
  if (shownLimit !== null && shownLimit <= top * 1.001) {
    const v = up(shownLimit);
    svg.append(shape("line", { x1: left, x2: width - right, y1: v, y2: v, class: "limit-line" }));
  }
  series.forEach((one, k) => drawSeries(svg, one, `var(${SERIES[k % SERIES.length]})`, at, up));
  series.forEach((one, k) => {
    const perLine = Math.max(1, Math.floor(width / 190));
    const [u, v] = [left + (k % perLine) * 190, 14 + 20 * Math.floor(k / perLine)];
    svg.append(shape("line", { x1: u, x2: u + 22, y1: v - 4, y2: v - 4, "stroke-width": 2.4, stroke: `var(${SERIES[k % SERIES.length]})` }),
      shape("text", { x: u + 28, y: v }, one.name.length > 22 ? `${one.name.slice(0, 20)}..` : one.name));
  });
  const widest = LETTER * Math.max(...x.labels.map((text) => Math.min(text.length, 18))) + 10;
  let last = -Infinity;
  x.labels.forEach((text, k) => {
    if (at(k) - last < widest) return;
    last = at(k);
    svg.append(shape("text", { x: at(k), y: above + high + 18, "text-anchor": "middle" }, text.slice(0, 18)));
  });
  const unit = scale.unit ? `, ${scale.unit}` : "";
  svg.append(shape("text", { x: (left + width) / 2, y: above + high + 40, "text-anchor": "middle", class: "soft" }, `${map.explorer.title(x.column.name)}${log ? " (logarithmic)" : ""}`),
    shape("text", { x: left, y: above - 10, class: "soft" }, `${map.measure.text}${unit}`));
  map.chart.replaceChildren(svg);
  answerCurve(map, svg, edges, above, high);
}

function isGeometric(numbers) {
  const ratios = numbers.slice(1).map((n, k) => n / numbers[k]);
  return ratios.every((r) => Math.abs(r / ratios[0] - 1) < 0.05);
}

// One a detector, where several are shown together; else one.
function seriesOf(map) {
  const column = map.table.column("detector");
  const together = column && map.state.x !== "detector" && column.levels.length > 1
    && map.state.slices.detector === "all";
  if (!together) return [{ name: "all shown", values: map.values }];
  return column.levels.slice(0, 6).map((name, code) => ({
    name,
    values: map.cells.map((cell) => {
      const own = cell.filter((row) => column.cells[row] === code);
      return own.length ? map.measure.of(own) : NaN;
    }),
  }));
}

function drawSeries(svg, one, colour, at, up) {
  const points = one.values.map((v, k) => [at(k), up(v), Number.isFinite(v)]);
  let path = "";
  points.forEach(([u, v, known], k) => {
    if (known) path += `${k && points[k - 1][2] ? "L" : "M"}${u} ${v}`;
  });
  svg.append(shape("path", { d: path || "M0 0", fill: "none", stroke: colour, "stroke-width": 2 }));
  if (points.length <= 80)
    for (const [u, v, known] of points)
      if (known) svg.append(shape("circle", { cx: u, cy: v, r: 3.6, fill: colour, stroke: "var(--paper)" }));
}

function answerCurve(map, svg, edges, above, high) {
  const cursor = shape("line", { class: "cursor", y1: above, y2: above + high, visibility: "hidden" });
  svg.append(cursor);
  let active = null;
  const point = (k, u, v) => {
    active = k;
    const middle = (edges[k][0] + edges[k][1]) / 2;
    filled(cursor, { x1: middle, x2: middle, visibility: "visible" }, []);
    const place = cursor.getBoundingClientRect();
    tip.show(map.nameOf(k), map.facts(k), u ?? place.right, v ?? place.top + 40);
  };
  const leave = () => {
    cursor.setAttribute("visibility", "hidden");
    tip.hide();
  };
  edges.forEach(([a, b], k) => {
    const target = shape("rect", { x: a, y: above, width: b - a, height: high, fill: "transparent", "data-cell": k });
    for (const name of ["pointermove", "pointerdown"])
      target.addEventListener(name, (event) => point(k, event.clientX, event.clientY));
    target.addEventListener("dblclick", () => map.choose(k));
    svg.append(target);
  });
  svg.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && leave());
  svg.addEventListener("blur", leave);
  svg.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step) {
      event.preventDefault();
      point(Math.min(edges.length - 1, Math.max(0, active === null ? 0 : active + step)));
    } else if (event.key === "Enter" && active !== null) map.choose(active);
    else if (event.key === "Escape") leave();
  });
}
