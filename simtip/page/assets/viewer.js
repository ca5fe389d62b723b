// Pictures to be zoomed and moved: by wheel, pinch, drag, buttons and keys.

class Viewer {
  constructor(frame) {
    this.frame = frame;
    this.svg = frame.querySelector("svg");
    this.width = Number(frame.dataset.width);
    this.height = Number(frame.dataset.height);
    const [u, v, w, h] = frame.dataset.focus.split(" ").map(Number);
    this.focus = { u, v, w, h };
    this.pointers = new Map();
    this.tools();
    this.listen();
    this.show(this.focus);
    new ResizeObserver(() => this.marks()).observe(this.svg);
  }

  get whole() {
    return { u: -0.5, v: -0.5, w: this.width, h: this.height };
  }

  tools() {
    const button = (text, title, does) =>
      html("button", { type: "button", title, "aria-label": title, onclick: does }, text);
    this.frame.append(
      html("div", { class: "tools" },
        button("+", "Closer", () => this.zoom(1 / 1.6)),
        button(MINUS, "Farther", () => this.zoom(1.6)),
        button("Tip", "To the tip", () => this.show(this.focus)),
        button("All", "The whole picture", () => this.show(this.whole))),
    );
  }

  listen() {
    const svg = this.svg;
    svg.addEventListener("wheel", (event) => {
      // A page that is being scrolled goes on: zooming begins with a click, or with Ctrl.
      if (!event.ctrlKey && !this.frame.contains(document.activeElement)) return;
      event.preventDefault();
      this.zoom(Math.exp(event.deltaY * 0.0016), this.at(event));
    }, { passive: false });
    svg.addEventListener("pointerdown", (event) => {
      svg.focus({ preventScroll: true });
      this.pointers.set(event.pointerId, event);
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => this.moved(event));
    for (const end of ["pointerup", "pointercancel"])
      svg.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    svg.addEventListener("dblclick", (event) => this.zoom(1 / 2, this.at(event)));
    this.frame.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    const step = 0.12 * this.box.w;
    const does = {
      "+": () => this.zoom(1 / 1.4), "=": () => this.zoom(1 / 1.4), "-": () => this.zoom(1.4),
      "0": () => this.show(this.whole), Home: () => this.show(this.focus),
      ArrowLeft: () => this.move(-step, 0), ArrowRight: () => this.move(step, 0),
      ArrowUp: () => this.move(0, -step), ArrowDown: () => this.move(0, step),
    }[event.key];
    if (!does || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    does();
  }

  moved(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    if (this.pointers.size === 1) {
      if (event.pointerType !== "touch" || this.svg.classList.contains("zoomed")) {
        const k = this.pixels;
        this.move((before.clientX - event.clientX) * k, (before.clientY - event.clientY) * k);
      }
    } else if (this.pointers.size === 2) {
      const [other] = [...this.pointers.values()].filter((p) => p.pointerId !== event.pointerId);
      const far = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
      const middle = {
        clientX: (event.clientX + other.clientX) / 2,
        clientY: (event.clientY + other.clientY) / 2,
      };
      if (far(event) > 8) this.zoom(far(before) / far(event), this.at(middle));
    }
    this.pointers.set(event.pointerId, event);
  }

  // Pixels of the picture for one of the screen.
  get pixels() {
    const place = this.svg.getBoundingClientRect();
    if (!place.width || !place.height) return this.box.w / 400;  // not laid out yet
    return Math.max(this.box.w / place.width, this.box.h / place.height);
  }

  at(event) {
    const place = this.svg.getBoundingClientRect();
    const k = this.pixels;
    return {
      u: this.box.u + this.box.w / 2 + (event.clientX - place.left - place.width / 2) * k,
      v: this.box.v + this.box.h / 2 + (event.clientY - place.top - place.height / 2) * k,
    };
  }

  zoom(by, about) {
    const { u, v, w, h } = this.box;
    const centre = about || { u: u + w / 2, v: v + h / 2 };
    const least = 6 / w;
    const most = Math.max(this.width / w, this.height / h, 1);
    const k = Math.min(Math.max(by, least), most);
    this.show({ u: centre.u + (u - centre.u) * k, v: centre.v + (v - centre.v) * k, w: w * k, h: h * k });
  }

  move(du, dv) {
    this.show({ ...this.box, u: this.box.u + du, v: this.box.v + dv });
  }

  show(box) {
    const within = (at, size, whole) => Math.min(Math.max(at, -0.5 - size / 2), whole - 0.5 - size / 2);
    this.box = {
      w: box.w, h: box.h, u: within(box.u, box.w, this.width), v: within(box.v, box.h, this.height),
    };
    const { u, v, w, h } = this.box;
    this.svg.setAttribute("viewBox", `${u} ${v} ${w} ${h}`);
    this.svg.classList.toggle("zoomed", w < 0.95 * this.width);
    this.marks();
  }

  // Marks keep their size on the screen.
  marks() {
    const k = this.pixels;
    for (const mark of this.svg.querySelectorAll(".mark"))
      mark.setAttribute("transform", `translate(${mark.dataset.u} ${mark.dataset.v}) scale(${k})`);
  }
}

function startViewers() {
  for (const frame of document.querySelectorAll(".frame")) new Viewer(frame);
}
