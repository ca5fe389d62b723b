// How a number is spread, group by group: a histogram each on one axis, median, 5 to 95 %.

const MOST_GROUPS = 14;
const MOST_BINS = 60;

class Distributions {
  constructor(host, explorer) {
    this.explorer = explorer;
    this.table = explorer.table;
    const quantities = explorer.quantities;
    const groups = explorer.varying.includes("detector") ? "detector" : "";
    this.state = { quantity: quantities[0][0], by: groups, log: false };
    this.controls = html("div", { class: "controls" },
      labelled("Of", choice(quantities, this.state.quantity, (quantity) => this.set({ quantity }))),
      labelled("By", choice([["", "(all together)"], ...explorer.varying.map((n) => [n, explorer.title(n)])], groups, (by) => this.set({ by }))),
      labelled("Axis", choice([["", "linear"], ["log", "logarithmic"]], "", (log) => this.set({ log: Boolean(log) }))));
    this.said = html("p", { class: "said", "aria-live": "polite" });
    this.chart = html("div", { class: "chart" });
    host.replaceChildren(this.controls, this.said, this.chart);
    this.draw = drawnIn(this.chart, (width) => this.paint(width));
    explorer.onRows(() => this.update());
    this.update();
  }

  set(change) {
    Object.assign(this.state, change);
    this.update();
  }

  update() {
    const column = this.table.column(this.state.quantity);
    const by = this.state.by && axisOf(this.table.column(this.state.by), this.explorer.rows);
    const cells = by ? celled(this.explorer.rows, [by]) : [this.explorer.rows];
    const all = cells.map((rows, k) => ({
      name: by ? by.labels[k] : "all", rows: rows.length,
      sorted: present(column, rows).filter((v) => !this.state.log || v > 0).sort(),
    }));
    this.groups = all.slice(0, MOST_GROUPS);
    this.unit = column.unit;
    const left = all.length - this.groups.length;
    const without = this.groups.reduce((sum, g) => sum + g.rows - g.sorted.length, 0);
    this.said.textContent = [
      left ? `The first ${MOST_GROUPS} groups; ${left} more are not shown.` : "",
      without ? `${counted(without, "trial has", "trials have")} no such number${this.state.log ? " above 0" : ""}: no tip was measured.` : "",
      "Bars: how many trials; line: 5 to 95 %; dot: median.",
    ].filter(Boolean).join(" ");
    this.draw();
  }

  paint(width) {
    const groups = this.groups.filter((g) => g.sorted.length);
    if (!groups.length) {
      this.chart.replaceChildren(html("p", { class: "note" }, "No trial that is shown has such a number."));
      return;
    }
    const low = Math.min(...groups.map((g) => g.sorted[0]));
    const high = Math.max(...groups.map((g) => g.sorted.at(-1)));
    const scale = scaleFor(Math.max(Math.abs(low), Math.abs(high)), this.unit);
    const cut = (text) => (text.length > (width < 520 ? 13 : 24) ? `${text.slice(0, width < 520 ? 11 : 22)}..` : text);
    const left = 14 + LETTER * Math.max(...groups.map((g) => cut(g.name).length));
    const [right, rowHigh, below] = [16, groups.length > 6 ? 46 : 62, 48];
    const warp = this.state.log ? Math.log : (v) => v;
    const [a, b] = low < high ? [warp(low), warp(high)] : [warp(low) - 0.5, warp(low) + 0.5];
    const across = (v) => left + ((warp(v) - a) / (b - a)) * (width - left - right);
    const height = groups.length * rowHigh + below;
    const svg = shape("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `Distribution of ${this.state.quantity}` });
    const marks = this.state.log ? decades(low, high) : ticks(low * scale.factor, high * scale.factor, width < 520 ? 4 : 8).map((t) => t / scale.factor);
    for (const t of marks) {
      svg.append(shape("line", { x1: across(t), x2: across(t), y1: 0, y2: height - below, class: "grid" }),
        shape("text", { x: across(t), y: height - below + 18, "text-anchor": "middle" }, short(t * scale.factor)));
    }
    const bins = Math.max(8, Math.min(MOST_BINS, Math.floor((width - left - right) / 9)));
    groups.forEach((group, k) => this.row(svg, group, k, { left, right, width, rowHigh, bins, a, b, across, warp, scale, cut }));
    svg.append(shape("text", { x: (left + width - right) / 2, y: height - 8, "text-anchor": "middle", class: "soft" },
      `${this.explorer.quantities.find(([name]) => name === this.state.quantity)[1]}${scale.unit ? `, ${scale.unit}` : ""}`));
    this.chart.replaceChildren(svg);
  }

  row(svg, group, k, f) {
    const base = (k + 1) * f.rowHigh - 8;
    const counts = new Array(f.bins).fill(0);
    for (const v of group.sorted) counts[Math.min(f.bins - 1, Math.max(0, Math.floor(((f.warp(v) - f.a) / (f.b - f.a)) * f.bins)))]++;
    const most = Math.max(...counts);
    const step = (f.width - f.left - f.right) / f.bins;
    let path = `M${f.left} ${base}`;
    counts.forEach((count, n) => {
      const v = base - (count / most) * (f.rowHigh - 20);
      path += `L${f.left + n * step} ${v}L${f.left + (n + 1) * step} ${v}`;
    });
    svg.append(shape("path", { d: `${path}L${f.width - f.right} ${base}Z`, class: "ridge" }));
    const [low, middle, high] = [0.05, 0.5, 0.95].map((share) => quantile(group.sorted, share));
    svg.append(
      shape("line", { x1: f.across(low), x2: f.across(high), y1: base, y2: base, class: "whisker" }),
      shape("circle", { cx: f.across(middle), cy: base, r: 3.6, class: "median" }),
      shape("text", { x: f.left - 8, y: base - f.rowHigh / 2 + 14, "text-anchor": "end" }, f.cut(group.name)));
    const target = shape("rect", { x: f.left, y: base - f.rowHigh + 8, width: f.width - f.left - f.right, height: f.rowHigh, fill: "transparent", tabindex: 0,
      "aria-label": `${group.name}: median ${f.scale.text(middle)}` });
    const say = (u, v, n) => {
      const pairs = [["numbers", String(group.sorted.length)], ["median", f.scale.text(middle)], ["5 to 95 %", `${f.scale.number(low)} .. ${f.scale.text(high)}`],
        ["mean", f.scale.text(mean(group.sorted))], ["RMS", f.scale.text(rms(group.sorted))], ["largest", f.scale.text(group.sorted.at(-1))]];
      if (n !== undefined) pairs.push(["in this bar", String(counts[n])]);
      tip.show(group.name, pairs, u, v);
    };
    for (const name of ["pointermove", "pointerdown"])
      target.addEventListener(name, (event) => {
        const place = target.getBoundingClientRect();
        say(event.clientX, event.clientY, Math.min(f.bins - 1, Math.max(0, Math.floor(((event.clientX - place.left) / place.width) * f.bins))));
      });
    target.addEventListener("pointerleave", () => tip.hide());
    target.addEventListener("focus", () => {
      const place = target.getBoundingClientRect();
      say(place.left + 20, place.bottom - 10);
    });
    target.addEventListener("blur", () => tip.hide());
    svg.append(target);
  }
}

function decades(low, high) {
  const found = [];
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; power++)
    for (const k of high / low > 100 ? [1] : [1, 2, 5]) {
      const v = k * 10 ** power;
      if (v >= low && v <= high) found.push(v);
    }
  return found.length ? found : [low, high];
}
