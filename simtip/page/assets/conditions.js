// Conditions as `simtip results --where` has them, with "and" or ";" between.

function conditionsOf(text) {
  const parts = [];
  let part = "";
  let quote = "";
  for (let k = 0; k < text.length; k++) {
    const sign = text[k];
    const and = /^\s+and\s+/i.exec(text.slice(k, k + 12));
    if (quote) {
      // A text may hold quotes itself: the last one before the next condition ends it.
      if (sign === quote && /^\s*($|;|and\s)/i.test(text.slice(k + 1))) quote = "";
    }
    else if ((sign === '"' || sign === "'") && /[=<>]\s*$/.test(part)) quote = sign;
    else if (sign === ";" || and) {
      parts.push(part);
      part = "";
      k += and ? and[0].length - 1 : 0;
      continue;
    }
    part += sign;
  }
  parts.push(part);
  return parts.map((one) => one.trim()).filter(Boolean);
}

const OPERATORS = {
  "==": (a, b) => a === b, "!=": (a, b) => a !== b, "<": (a, b) => a < b,
  "<=": (a, b) => a <= b, ">": (a, b) => a > b, ">=": (a, b) => a >= b,
};

// Give a test of a row; throw an Error that says what is wrong.
function testOf(condition, table) {
  const match = /^(.*?)\s*(==|!=|<=|>=|<|>)\s*(.*)$/s.exec(condition);
  if (!match || !match[1]) throw new Error(`"${condition}" is not COLUMN OP VALUE, e.g. error_norm_mm<0.1`);
  const [, name, sign, said] = match;
  const column = table.column(name);
  if (!column) throw new Error(`there is no column "${name}"; known: ${[...table.columns.keys()].join(", ")}`);
  const compare = OPERATORS[sign];
  const quoted = said.length > 1 && said[0] === said.at(-1) && `"'`.includes(said[0]);
  const value = quoted ? said.slice(1, -1) : said;
  if (column.coded && !column.numbers) {
    const met = column.levels.map((level, k) => k !== column.missing && compare(level, value));
    return (row) => met[column.cells[row]];
  }
  const number = { true: 1, false: 0 }[value] ?? Number(value);
  if (value === "" || Number.isNaN(number)) throw new Error(`"${said}" is no number, as ${name} is`);
  return (row) => {
    const cell = column.number(row);
    return !Number.isNaN(cell) && compare(cell, number);
  };
}

function rowsWith(text, table) {
  const tests = conditionsOf(text).map((one) => testOf(one, table));
  const rows = new Uint32Array(table.rows);
  let count = 0;
  for (let row = 0; row < table.rows; row++) if (tests.every((test) => test(row))) rows[count++] = row;
  return rows.slice(0, count);
}
