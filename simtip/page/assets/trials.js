// All trials as a table: sorted by any column, a page at a time, and as CSV.

const PER_PAGE = 25;

class Trials {
  constructor(host, explorer) {
    this.explorer = explorer;
    this.table = explorer.table;
    this.columns = explorer.listed.map((name) => this.table.column(name));
    this.state = { sort: NORM, down: true, page: 0 };
    host.classList.add("trials");
    this.body = html("tbody");
    this.heads = html("tr");
    this.pages = html("span", { "aria-live": "polite" });
    const button = (text, does) => html("button", { type: "button", onclick: does }, text);
    this.back = button("Back", () => this.go(this.state.page - 1));
    this.on = button("Next", () => this.go(this.state.page + 1));
    host.replaceChildren(
      html("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Trials" },
        html("table", {}, html("thead", {}, this.heads), this.body)),
      html("div", { class: "pager" }, this.back, this.on, this.pages,
        button("Save as CSV", () => saved(this.csv(), "trials.csv", "text/csv"))));
    this.digits = new Map(this.columns.map((c) => [c, this.digitsOf(c)]));
    explorer.onRows(() => this.sort());
    this.sort();
  }

  digitsOf(column) {
    if (column.coded) return 0;
    let most = 0;
    for (const v of column.cells) if (Number.isFinite(v) && Math.abs(v) > most) most = Math.abs(v);
    return column.whole ? 0 : Math.max(3, digitsFor(most));
  }

  // Rows without a number come last, whichever way.
  sort() {
    const column = this.table.column(this.state.sort) || this.columns[0];
    const rows = Array.from(this.explorer.rows);
    const sign = this.state.down ? -1 : 1;
    const key = column.coded && !column.numbers
      ? (row) => column.cells[row]
      : (row) => column.number(row);
    const keys = new Map(rows.map((row) => [row, key(row)]));
    rows.sort((one, other) => {
      const [a, b] = [keys.get(one), keys.get(other)];
      if (Number.isNaN(a) || Number.isNaN(b)) return Number.isNaN(a) - Number.isNaN(b) || one - other;
      return sign * (a - b) || one - other;
    });
    this.sorted = rows;
    this.go(0);
  }

  go(page) {
    const last = Math.max(0, Math.ceil(this.sorted.length / PER_PAGE) - 1);
    this.state.page = Math.min(Math.max(page, 0), last);
    this.show(last);
  }

  show(last) {
    const { sort, down, page } = this.state;
    this.heads.replaceChildren(...this.columns.map((column) => {
      const isKey = column.name === sort;
      const button = html("button", { type: "button", title: column.name,
        onclick: () => {
          this.state.down = isKey ? !down : !column.coded;
          this.state.sort = column.name;
          this.sort();
        } }, `${this.explorer.title(column.name)}${isKey ? (down ? " \u2193" : " \u2191") : ""}`);
      return html("th", { scope: "col", class: this.isNumber(column) ? "number" : null,
        "aria-sort": isKey ? (down ? "descending" : "ascending") : null }, button);
    }));
    const ok = isOk(this.table);
    const shown = this.sorted.slice(page * PER_PAGE, (page + 1) * PER_PAGE);
    this.body.replaceChildren(...shown.map((row) =>
      html("tr", { class: ok(row) ? null : "failed", "data-row": row },
        ...this.columns.map((column) => {
          const text = this.cell(column, row);
          return html("td", { class: this.isNumber(column) ? "number" : null, title: text.length > 40 ? text : null }, text);
        }))));
    this.back.disabled = page === 0;
    this.on.disabled = page === last;
    const count = this.sorted.length;
    this.pages.textContent = count
      ? `${page * PER_PAGE + 1} to ${page * PER_PAGE + shown.length} of ${counted(count, "trial", "trials")}`
      : "No trial meets the condition.";
  }

  isNumber(column) {
    return !column.coded || Boolean(column.numbers);
  }

  cell(column, row) {
    if (column.coded) return column.levels[column.cells[row]];
    return fixed(column.cells[row], this.digits.get(column));
  }

  csv() {
    const quoted = (text) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    // A leading sign would be a formula to a spreadsheet.
    const plain = (text) => quoted(/^[=@\t\r]/.test(text) ? `'${text}` : text);
    const value = (column, row) => {
      if (!this.isNumber(column)) return plain(column.text(row));
      const number = column.number(row);
      return Number.isNaN(number) ? "" : String(Number(number.toPrecision(column.coded || column.whole ? 17 : 7)));
    };
    const lines = [this.columns.map((c) => plain(c.name)), ...this.sorted.map((row) => this.columns.map((c) => value(c, row)))];
    return `${lines.map((cells) => cells.join(",")).join("\n")}\n`;
  }
}
