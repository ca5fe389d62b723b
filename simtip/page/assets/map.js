// A figure over two factors, with the operating envelope: where every trial has a tip and the
// error is within the limit.

const CRITERIA = { max: "largest error", p95: "95 % of errors", rms: "RMS error" };
const LETTER = 7.1;

class ErrorMap {
  constructor(host, explorer) {
    this.explorer = explorer;
    this.table = explorer.table;
    this.measures = measuresOf(this.table);
    const names = explorer.varying;
    const most = [...names].sort((a, b) => this.rank(b) - this.rank(a));
    const { start } = explorer.settings;
    this.state = {
      x: start.x || most[0], y: start.y ?? most[1] ?? "", measure: start.measure,
      criterion: "max", limit: start.limit, slices: {},
    };
    for (const name of names) this.state.slices[name] = name === "detector" ? "0" : "all";
    this.controls = html("div", { class: "controls" });
    this.said = html("p", { class: "said", "aria-live": "polite" });
    this.chart = html("div", { class: "chart map" });
    host.replaceChildren(this.controls, this.said, this.chart);
    this.draw = drawnIn(this.chart, (width) => this.paint(width));
    explorer.onRows(() => this.update());
    document.addEventListener("themed", () => this.draw());
    this.update();
  }

  rank(name) {
    const column = this.table.column(name);
    return Math.min(column.count, 40) + (column.numbers || !column.coded ? 1000 : 0) - (name === "repeat" ? 2000 : 0);
  }

  set(change) {
    Object.assign(this.state, change);
    this.update();
  }

  update() {
    const { state } = this;
    if (state.x === state.y) state.y = this.explorer.varying.find((name) => name !== state.x) ?? "";
    this.shownControls();
    const rows = this.sliced();
    const columns = [state.x, state.y].filter(Boolean).map((name) => this.table.column(name));
    this.axes = columns.map((column) => axisOf(column, rows)).filter(Boolean);
    this.cells = celled(rows, this.axes);
    const measure = this.measures.find((one) => one.name === state.measure) || this.measures[0];
    const norm = this.table.column(NORM);
    this.measure = measure;
    this.values = this.cells.map((cell) => (cell.length ? measure.of(cell) : NaN));
    this.rates = this.cells.map((cell) => detectionRate(this.table, cell));
    this.judged = this.cells.map((cell) => OF_NUMBERS[state.criterion].of(present(norm, cell)));
    this.inside = this.cells.map((cell, k) =>
      cell.length > 0 && this.rates[k] === 1 && this.judged[k] <= state.limit);
    this.tell(rows.length);
    this.draw();
  }

  // Rows of the chosen levels of all factors that no axis shows.
  sliced() {
    const asked = Object.entries(this.state.slices).filter(
      ([name, level]) => level !== "all" && name !== this.state.x && name !== this.state.y);
    const tests = asked.map(([name, level]) => {
      const column = this.table.column(name);
      return (row) => column.cells[row] === Number(level);
    });
    return this.explorer.rows.filter((row) => tests.every((test) => test(row)));
  }

  shownControls() {
    const { state, table } = this;
    if (this.controls.contains(document.activeElement) && this.asked === this.asking()) return;
    this.asked = this.asking();
    const title = (name) => [name, this.explorer.title(name)];
    const names = this.explorer.varying.map(title);
    const parts = [
      labelled("Across", choice(names, state.x, (x) => this.set({ x }))),
      labelled("Up", choice([...names.filter(([n]) => n !== state.x), ["", "(nothing: a curve)"]], state.y,
        (y) => this.set({ y }))),
      labelled("Colour", choice(this.measures.map((m) => [m.name, m.text]), state.measure,
        (measure) => this.set({ measure }))),
    ];
    for (const name of this.explorer.varying) {
      if (name === state.x || name === state.y) continue;
      const column = table.column(name);
      if (!column.coded || column.levels.length > 200) continue;
      const levels = column.levels.map((text, k) => [k, text]);
      parts.push(labelled(this.explorer.title(name), choice([["all", "all together"], ...levels],
        state.slices[name], (level) => this.set({ slices: { ...state.slices, [name]: level } }))));
    }
    parts.push(labelled("Envelope by", choice(Object.entries(CRITERIA), state.criterion,
      (criterion) => this.set({ criterion }))), this.limitControl());
    this.controls.replaceChildren(...parts);
  }

  asking() {
    const { x, y } = this.state;
    return `${x}|${y}`;
  }

  // The slider goes by the logarithm over what the errors span.
  limitControl() {
    const [low, high] = this.explorer.settings.span;
    const { limit } = this.state;
    const shareOf = (mm) => (1000 * Math.log(mm / low)) / Math.log(high / low);
    const number = html("input", { type: "number", min: 0, step: "any", value: limit, class: "limit-number",
      "aria-label": "Limit of the error, mm" });
    const slider = html("input", { type: "range", min: 0, max: 1000, step: 1,
      "aria-label": "Limit of the error, by the logarithm" });
    slider.value = String(Math.min(1000, Math.max(0, shareOf(limit))));
    number.addEventListener("input", () => {
      const mm = Number(number.value);
      if (!(mm > 0)) return;
      slider.value = String(Math.min(1000, Math.max(0, shareOf(mm))));
      this.set({ limit: mm });
    });
    slider.addEventListener("input", () => {
      const mm = low * (high / low) ** (slider.value / 1000);
      number.value = String(Number(mm.toPrecision(3)));
      this.set({ limit: Number(number.value) });
    });
    return html("div", { class: "limit" }, labelled("Limit of the error, mm", number), slider);
  }

  tell(rows) {
    const { state } = this;
    const there = this.cells.filter((cell) => cell.length).length;
    const inside = this.inside.filter(Boolean).length;
    const what = state.y ? "cells" : "levels";
    const begun = inside
      ? `Operating envelope: ${inside} of ${there} ${what}`
      : `No operating envelope: in none of ${there} ${what}`;
    const verb = inside ? "has every trial a tip and" : "every trial has a tip with";
    const limit = scaleFor(state.limit, "mm").text(state.limit);
    this.said.textContent = inside
      ? `${begun} (${fixed((100 * inside) / there, 0)} %). In them every trial has a tip and the ${CRITERIA[state.criterion]} is at most ${limit}. ${counted(rows, "trial", "trials")} shown.`
      : `${begun} ${verb} the ${CRITERIA[state.criterion]} at most ${limit}. ${counted(rows, "trial", "trials")} shown.`;
  }

  facts(k) {
    const cell = this.cells[k];
    const errors = present(this.table.column(NORM), cell);
    const scale = scaleFor(errors.length ? largest(errors) : 0, "mm");
    const pairs = [
      ["trials", String(cell.length)],
      ["detected", cell.length ? `${fixed(100 * this.rates[k], this.rates[k] === 1 ? 0 : 1)} %` : "\u2013"],
    ];
    if (errors.length)
      for (const how of ["median", "rms", "p95", "max"])
        pairs.push([OF_NUMBERS[how].text, scale.text(OF_NUMBERS[how].of(errors))]);
    if (!["rate"].includes(this.measure.name) && !this.measure.name.startsWith(`${NORM}:`))
      pairs.push([this.measure.text, this.textOf(this.values[k])]);
    return pairs;
  }

  nameOf(k) {
    const [x, y] = this.axes;
    const rows = y ? y.labels.length : 1;
    const at = [Math.floor(k / rows), k % rows];
    return this.axes.map((axis, n) => `${this.explorer.title(axis.column.name)} ${axis.labels[at[n]]}`).join(", ");
  }

  textOf(value) {
    const known = this.values.filter(Number.isFinite).map(Math.abs);
    return scaleFor(Math.max(...known, 0), this.measure.unit).text(value);
  }

  // Show a cell's trials in the table.
  choose(k) {
    const rows = this.axes[1] ? this.axes[1].labels.length : 1;
    const at = [Math.floor(k / rows), k % rows];
    const slices = Object.entries(this.state.slices)
      .filter(([name, level]) => level !== "all" && name !== this.state.x && name !== this.state.y)
      .map(([name, level]) => conditionOf(this.table.column(name), Number(level)));
    const said = [...this.axes.map((axis, n) => axis.condition(at[n])), ...slices];
    this.explorer.look(said.filter(Boolean).join(" and "));
  }

  paint(width) {
    if (!this.axes.length || !this.cells.length) {
      this.chart.replaceChildren(html("p", { class: "note" }, "Nothing is left to show."));
      return;
    }
    if (!this.axes[1]) paintCurve(this, width);
    else this.paintCells(width);
  }

  paintCells(width) {
    const [x, y] = this.axes;
    const [nx, ny] = [x.labels.length, y.labels.length];
    const cut = (text, most) => (text.length > most ? `${text.slice(0, most - 2)}..` : text);
    const most = width < 520 ? 12 : 26;
    const yLabels = y.labels.map((text) => cut(text, most));
    const left = 34 + LETTER * Math.max(...yLabels.map((text) => text.length));
    const cell = Math.min(64, (width - left - 8) / nx);
    const high = Math.min(44, Math.max(18, Math.min(cell * 0.8, 460 / ny)));
    const xLabels = x.labels.map((text) => cut(text, 20));
    const longest = LETTER * Math.max(...xLabels.map((text) => text.length));
    const words = !x.numbers || x.binned;
    const turned = words && longest > cell - 6;
    const every = words ? 1 : Math.max(1, Math.ceil((longest + 8) / cell));
    const below = turned ? 0.64 * longest + 18 : 22;
    const top = 6;
    const plotted = [nx * cell, ny * high];
    const height = top + plotted[1] + below + 76;
    const colours = colouring(this.measure.kind, this.values);
    const known = this.values.filter(Number.isFinite).map(Math.abs);
    const scale = scaleFor(Math.max(...known, 0), this.measure.unit);
    const longestValue = Math.max(...this.values.filter(Number.isFinite).map((v) => scale.number(v).length), 1);
    const written = longestValue * 6.6 < cell - 4 && high >= 17;
    const svg = shape("svg", { viewBox: `0 0 ${width} ${height}`, role: "application", tabindex: 0,
      "aria-roledescription": "map", "aria-label": `${this.measure.text} over ${this.explorer.title(x.column.name)} and ${this.explorer.title(y.column.name)}; arrow keys go from cell to cell, Enter lists its trials` });
    const at = (k) => [left + Math.floor(k / ny) * cell, top + (ny - 1 - (k % ny)) * high];
    for (let k = 0; k < this.cells.length; k++) {
      const [u, v] = at(k);
      const value = this.values[k];
      const rgb = Number.isFinite(value) ? colours.of(value) : null;
      const rect = shape("rect", { x: u, y: v, width: cell, height: high, class: rgb ? "cell" : "cell none", "data-cell": k });
      if (rgb) rect.setAttribute("fill", inWords(rgb));
      svg.append(rect);
      if (rgb && written)
        svg.append(shape("text", { x: u + cell / 2, y: v + high / 2 + 4, "text-anchor": "middle", "pointer-events": "none", "font-size": 11.5 }, scale.number(value)));
      else if (!rgb && this.cells[k].length)
        svg.append(shape("text", { x: u + cell / 2, y: v + high / 2 + 4, "text-anchor": "middle", class: "soft", "pointer-events": "none" }, "\u00d7"));
      if (rgb && written) svg.lastChild.style.fill = inkOn(rgb);
    }
    const outline = this.outline(at, cell, high, ny);
    svg.append(shape("path", { d: outline, class: "envelope-back", "pointer-events": "none" }), shape("path", { d: outline, class: "envelope", "pointer-events": "none" }));
    yLabels.forEach((text, k) => {
      if (high < 15 && k % 2) return;
      svg.append(shape("text", { x: left - 8, y: top + (ny - 1 - k) * high + high / 2 + 4, "text-anchor": "end" }, text));
    });
    xLabels.forEach((text, k) => {
      if (k % every) return;
      const [u, v] = [left + (k + 0.5) * cell, top + plotted[1] + 17];
      svg.append(turned
        ? shape("text", { transform: `translate(${u + 4} ${v}) rotate(-40)`, "text-anchor": "end" }, text)
        : shape("text", { x: u, y: v, "text-anchor": "middle" }, text));
    });
    const base = top + plotted[1] + below;
    svg.append(shape("text", { x: left + plotted[0] / 2, y: base + 14, "text-anchor": "middle", class: "soft" }, cut(this.explorer.title(x.column.name), 60)));
    svg.append(shape("text", { transform: `translate(13 ${top + plotted[1] / 2}) rotate(-90)`, "text-anchor": "middle", class: "soft" }, cut(this.explorer.title(y.column.name), Math.max(8, Math.floor(plotted[1] / LETTER)))));
    this.legend(svg, left, base + 30, Math.min(280, width - left - 10), colours, scale);
    this.chart.replaceChildren(svg);
    if (x.left + y.left) this.chart.append(html("p", { class: "note" }, `Only the first levels are shown: ${x.left + y.left} more are left out.`));
    this.answer(svg, at, cell, high, ny);
  }

  // Around all cells inside: the edges that only one of two neighbours has.
  outline(at, cell, high, ny) {
    const nx = this.axes[0].labels.length;
    const inside = (i, j) => i >= 0 && j >= 0 && i < nx && j < ny && this.inside[i * ny + j];
    const parts = [];
    for (let i = 0; i < nx; i++)
      for (let j = 0; j < ny; j++) {
        if (!inside(i, j)) continue;
        const [u, v] = at(i * ny + j);
        if (!inside(i - 1, j)) parts.push(`M${u} ${v}v${high}`);
        if (!inside(i + 1, j)) parts.push(`M${u + cell} ${v}v${high}`);
        if (!inside(i, j + 1)) parts.push(`M${u} ${v}h${cell}`);
        if (!inside(i, j - 1)) parts.push(`M${u} ${v + high}h${cell}`);
      }
    return parts.join("") || "M0 0";
  }

  legend(svg, u, v, width, colours, scale) {
    const steps = 48;
    for (let k = 0; k < steps; k++)
      svg.append(shape("rect", { x: u + (k * width) / steps, y: v, width: width / steps + 0.6, height: 10, fill: inWords(colours.at((k + 0.5) / steps)) }));
    const ends = [[0, colours.low, "start"], [1, colours.high, "end"]];
    const middle = colours.log ? Math.sqrt(colours.low * colours.high) : (colours.low + colours.high) / 2;
    ends.push([0.5, middle, "middle"]);
    for (const [share, value, anchor] of ends)
      svg.append(shape("text", { x: u + share * width, y: v + 24, "text-anchor": anchor, class: "soft" }, `${colours.cut && share === 1 ? "\u2265 " : ""}${scale.number(value)}`));
    const unit = scale.unit ? `, ${scale.unit}` : "";
    svg.append(shape("text", { x: u, y: v + 41, class: "soft" }, `${this.measure.text}${unit}${colours.log ? " (logarithmic)" : ""}`));
  }

  answer(svg, at, cell, high, ny) {
    const frame = shape("rect", { class: "active", width: cell, height: high, visibility: "hidden", "pointer-events": "none" });
    svg.append(frame);
    let active = null;
    const point = (k, u, v) => {
      active = k;
      const [x, y] = at(k);
      filled(frame, { x, y, visibility: "visible" }, []);
      const place = frame.getBoundingClientRect();
      tip.show(this.nameOf(k), this.facts(k), u ?? place.right, v ?? place.bottom);
    };
    const leave = () => {
      frame.setAttribute("visibility", "hidden");
      tip.hide();
    };
    const cellOf = (event) => event.target.getAttribute && event.target.getAttribute("data-cell");
    svg.addEventListener("pointermove", (event) => (cellOf(event) !== null ? point(Number(cellOf(event)), event.clientX, event.clientY) : leave()));
    svg.addEventListener("pointerdown", (event) => cellOf(event) !== null && point(Number(cellOf(event)), event.clientX, event.clientY));
    svg.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && leave());
    svg.addEventListener("blur", leave);
    svg.addEventListener("dblclick", (event) => cellOf(event) !== null && this.choose(Number(cellOf(event))));
    svg.addEventListener("keydown", (event) => {
      const step = { ArrowRight: ny, ArrowLeft: -ny, ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (step) {
        event.preventDefault();
        const next = active === null ? 0 : active + step;
        const stays = Math.abs(step) === ny || Math.floor(next / ny) === Math.floor((active ?? next) / ny);
        if (next >= 0 && next < this.cells.length && stays) point(next);
      } else if (event.key === "Enter" && active !== null) this.choose(active);
      else if (event.key === "Escape") leave();
    });
  }
}
