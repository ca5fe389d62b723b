// What map, distributions and table share: the trials that meet the condition.

class Explorer {
  constructor(table, settings) {
    Object.assign(this, { table, settings, listeners: [] });
    this.varying = settings.varying;
    this.listed = settings.listed;
    this.quantities = settings.quantities;
    this.rows = rowsWith("", table);
  }

  title(name) {
    return this.settings.titles[name] || name;
  }

  onRows(told) {
    this.listeners.push(told);
  }

  filter(text) {
    this.rows = rowsWith(text, this.table);
    for (const told of this.listeners) told();
  }

  filterIn(host) {
    const [first] = this.varying;
    const example = `e.g. ${NORM}<0.5${first ? ` and ${first}==..` : ""}`;
    this.input = html("input", { type: "text", placeholder: example, spellcheck: "false", "aria-label": "Only trials with",
      autocomplete: "off" });
    this.said = html("p", { class: "said", "aria-live": "polite" });
    let waiting = 0;
    this.input.addEventListener("input", () => {
      clearTimeout(waiting);
      waiting = setTimeout(() => this.apply(), 150);
    });
    const clear = html("button", { type: "button", onclick: () => this.look("", false) }, "All trials");
    host.replaceChildren(
      html("div", { class: "controls" }, html("label", { class: "wide" }, "Only trials with (as simtip results --where; joined by and)", this.input), clear), this.said);
    this.apply();
  }

  apply() {
    try {
      this.filter(this.input.value);
      this.said.className = "said";
      const all = this.rows.length === this.table.rows;
      this.said.textContent = `${all ? "All " : ""}${counted(this.rows.length, "trial", "trials")}${all ? "" : ` of ${counted(this.table.rows, "", "").trim()}`}`;
    } catch (error) {
      this.said.className = "said wrong";
      this.said.textContent = error.message;
    }
  }

  // Show the trials of a condition in the table.
  look(condition, go = true) {
    this.input.value = condition;
    this.apply();
    if (go) document.getElementById("trials")?.scrollIntoView();
  }
}

async function startExplorer() {
  const places = document.querySelectorAll(".explorer");
  if (!places.length) return;
  const settings = JSON.parse(document.getElementById("settings").textContent);
  const explorer = new Explorer(await readTable("trials"), settings);
  const made = {
    filter: (host) => explorer.filterIn(host),
    map: (host) => new ErrorMap(host, explorer),
    distributions: (host) => new Distributions(host, explorer),
    trials: (host) => new Trials(host, explorer),
  };
  for (const host of places) made[host.dataset.kind](host);
}
