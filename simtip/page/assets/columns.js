// The table that the page carries, column by column.

const ARRAYS = { f4: Float32Array, f8: Float64Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };

async function unpacked(name) {
  const text = document.getElementById(`data-${name}`).textContent;
  const binary = atob(text.trim());
  const bytes = new Uint8Array(binary.length);
  for (let k = 0; k < bytes.length; k++) bytes[k] = binary.charCodeAt(k);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

class Column {
  constructor(said, buffer, rows) {
    Object.assign(this, said);
    this.cells = new ARRAYS[said.type](buffer, said.offset, rows);
    this.coded = Boolean(said.levels);
  }

  number(row) {
    if (!this.coded) return this.cells[row];
    const value = this.numbers ? this.numbers[this.cells[row]] : null;
    return value === null ? NaN : value;
  }

  text(row) {
    return this.coded ? this.levels[this.cells[row]] : short(this.cells[row]);
  }

  get count() {
    return this.coded ? this.levels.length : this.cells.length;
  }
}

async function readTable(name) {
  const buffer = await unpacked(name);
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const columns = new Map();
  for (const said of head.columns) columns.set(said.name, new Column(said, buffer, head.rows));
  return { rows: head.rows, columns, factors: head.factors, column: (name) => columns.get(name) };
}
