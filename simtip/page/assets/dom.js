"use strict";

// Elements and the one tooltip. Texts are set as text: nothing here reads HTML.

const SVG = "http://www.w3.org/2000/svg";

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children) if (child !== null && child !== undefined) element.append(child);
  return element;
}

function html(name, attributes, ...children) {
  return filled(document.createElement(name), attributes, children);
}

function shape(name, attributes, ...children) {
  return filled(document.createElementNS(SVG, name), attributes, children);
}

const tip = {
  show(title, pairs, x, y) {
    const box = document.getElementById("tip");
    const list = html("dl");
    for (const [name, value] of pairs) list.append(html("dt", {}, name), html("dd", {}, value));
    box.replaceChildren(html("b", {}, title), list);
    box.hidden = false;
    const place = box.getBoundingClientRect();
    const left = x + 16 + place.width > innerWidth ? x - 16 - place.width : x + 16;
    const top = y + 16 + place.height > innerHeight ? y - 16 - place.height : y + 16;
    box.style.left = `${Math.max(6, Math.min(left, innerWidth - place.width - 6))}px`;
    box.style.top = `${Math.max(6, top)}px`;
  },
  hide() {
    document.getElementById("tip").hidden = true;
  },
};

// The label's own name would have all options of a choice in it.
function labelled(text, control) {
  if (!control.hasAttribute("aria-label")) control.setAttribute("aria-label", text);
  return html("label", {}, text, control);
}

function choice(options, chosen, changed) {
  const select = html("select", { onchange: () => changed(select.value) });
  for (const [value, text] of options) {
    const option = html("option", { value }, text.length > 60 ? `${text.slice(0, 58)}..` : text);
    option.selected = String(value) === String(chosen);
    select.append(option);
  }
  return select;
}

// Draw again whenever the place has another width.
function drawnIn(host, draw) {
  let width = 0;
  const again = () => {
    const now = host.clientWidth;
    if (now && now !== width) {
      width = now;
      draw(now);
    }
  };
  new ResizeObserver(again).observe(host);
  return () => {
    width = host.clientWidth || 600;
    draw(width);
  };
}
