"use strict";
/* Charts as inline SVG with hovering, without any library: lines with intervals, stacked bars, maps. */

const SVG = document.querySelector("svg").namespaceURI;
const COLOURS = ["#1b6ca8", "#c8410b", "#2e7d32", "#7b3fa0", "#806000", "#00796b", "#ad1457", "#455a64", "#5d4037", "#283593"];

function h(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) if (value !== null) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

function s(name, attributes = {}, ...children) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

/* A number as text: three or so digits, no long tails. */
function shown(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (typeof value !== "number") return String(value);
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(digits - 1).replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
}

function withInterval(value, half, unit = "") {
  const interval = Number.isFinite(half) && half > 0 ? ` ± ${shown(half, 2)}` : "";
  return shown(value, 4) + interval + (unit && unit !== "1" ? ` ${unit}` : "");
}

/* Bytes packed in the page: base64 of a deflate stream that holds named arrays. */
async function unpack(packed) {
  const bytes = Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const kinds = { f8: Float64Array, f4: Float32Array, u4: Uint32Array, u2: Uint16Array, i4: Int32Array, u1: Uint8Array, i1: Int8Array };
  const found = {};
  for (const [name, [kind, offset, length]] of Object.entries(packed.arrays)) found[name] = new kinds[kind](buffer, offset, length);
  return found;
}

function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= raw * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}

function logTicks(low, high) {
  const found = [];
  if (high < 10 * low) return ticks(low, high, 5);
  for (let p = Math.floor(Math.log10(low)); p <= Math.ceil(Math.log10(high)); p++)
    for (const k of [1, 2, 5]) {
      const value = k * 10 ** p;
      if (value >= low * 0.999 && value <= high * 1.001) found.push(Number(value.toPrecision(6)));
    }
  return found;
}

function extent(values) {
  const known = values.filter((v) => Number.isFinite(v));
  return known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
}

/* Axes of a chart: an SVG as wide as its box, scales X and Y, and the tip. */
function axes(box, { label, x, y, height = 300 }) {
  box.replaceChildren();
  const width = Math.max(260, box.clientWidth || 600);
  const longest = Math.max(0, ...(y.names || []).map((name) => name.length));
  const margin = { left: Math.min(width / 3, Math.max(62, 34 + 7 * longest)), right: 14, top: 12, bottom: 44 };
  const svg = s("svg", { viewBox: `0 0 ${width} ${height}`, height, role: "img", "aria-label": label });
  const inner = { left: margin.left, right: width - margin.right, top: margin.top, bottom: height - margin.bottom };
  const scale = (axis, from, to) => {
    let [low, high] = axis.range;
    if (low === high) [low, high] = [low - (Math.abs(low) / 10 || 1), high + (Math.abs(high) / 10 || 1)];
    const at = axis.log ? (v) => (Math.log(v) - Math.log(low)) / (Math.log(high) - Math.log(low)) : (v) => (v - low) / (high - low);
    const map = (v) => from + at(v) * (to - from);
    map.low = low;
    map.high = high;
    return map;
  };
  const X = scale(x, inner.left, inner.right);
  const Y = scale(y, inner.bottom, inner.top);
  const grid = s("g", { stroke: "#dde3e9", "stroke-width": 1 });
  const words = s("g", {});
  const xs = x.ticks || (x.log ? logTicks(X.low, X.high) : ticks(X.low, X.high, width / 90));
  let last = -Infinity;
  xs.forEach((v, k) => {
    const text = x.names ? x.names[k] : shown(v, 4);
    if (!x.names) grid.append(s("line", { x1: X(v), x2: X(v), y1: inner.top, y2: inner.bottom }));
    const half = 3.6 * text.length;
    if (X(v) - half < last + 6) return;
    last = X(v) + half;
    words.append(s("text", { x: Math.min(X(v), width - half - 1), y: inner.bottom + 17, "text-anchor": "middle" }, text));
  });
  const ys = y.ticks || (y.log ? logTicks(Y.low, Y.high) : ticks(Y.low, Y.high, height / 60));
  ys.forEach((v, k) => {
    const text = y.names ? y.names[k] : shown(v, 4);
    if (!y.names) grid.append(s("line", { x1: inner.left, x2: inner.right, y1: Y(v), y2: Y(v) }));
    words.append(s("text", { x: inner.left - 6, y: Y(v) + 4, "text-anchor": "end" }, text));
  });
  const middle = (inner.top + inner.bottom) / 2;
  words.append(s("text", { x: (inner.left + inner.right) / 2, y: height - 6, "text-anchor": "middle" }, x.label));
  if (y.label) words.append(s("text", { x: 13, y: middle, "text-anchor": "middle", transform: `rotate(-90 13 ${middle})` }, y.label));
  const frame = { x: inner.left, y: inner.top, width: inner.right - inner.left, height: inner.bottom - inner.top };
  const plot = s("g", {});
  svg.append(grid, s("rect", { ...frame, fill: "none", stroke: "#76828f" }), plot, words);
  box.classList.add("chart");
  box.append(svg);
  const tip = h("div", { class: "tip", hidden: "" });
  box.append(tip);
  const say = (at, text) => {
    tip.hidden = text === null;
    if (text === null) return;
    tip.textContent = text;
    const scaled = box.clientWidth / width;
    const left = at[0] * scaled + 14 + tip.offsetWidth > box.clientWidth ? at[0] * scaled - 14 - tip.offsetWidth : at[0] * scaled + 14;
    tip.style.left = `${Math.max(0, left)}px`;
    tip.style.top = `${Math.max(0, Math.min(at[1], height - tip.offsetHeight))}px`;
  };
  const pointer = (event) => {
    const place = svg.getBoundingClientRect();
    return [((event.clientX - place.left) * width) / place.width, ((event.clientY - place.top) * height) / place.height];
  };
  svg.addEventListener("pointerleave", () => say(null, null));
  return { svg, plot, X, Y, inner, say, pointer, width };
}

function legend(box, items) {
  const node = h("div", { class: "legend" });
  for (const [name, colour] of items) {
    const chip = h("i");
    chip.style.background = colour;
    node.append(h("span", { class: "item" }, chip, name));
  }
  box.append(node);
}

/* Lines of points {x, y, half or ends, hollow, note}: half-width of the interval, or its ends; of a series that is silent nothing is said.  Returns a function that marks an x. */
function lineChart(box, { label, x, y, series, height = 300, joined = true }) {
  const every = series.flatMap((one) => one.points);
  const xr = x.range || extent(every.map((p) => p.x));
  const endsOf = (p) => p.ends || (Number.isFinite(p.half) && p.half > 0 ? [p.y - p.half, p.y + p.half] : null);
  const words = (p) => (p.ends ? `${shown(p.y, 4)} (${shown(p.ends[0], 3)} to ${shown(p.ends[1], 3)})` : withInterval(p.y, p.half)) + (p.note ? `  (${p.note})` : "");
  const spread = every.flatMap((p) => [p.y, ...(endsOf(p) || [])]);
  let [low, high] = extent(spread);
  if (y.zero) low = Math.min(0, low);
  const pad = (high - low) * 0.05 || Math.abs(high) * 0.1 || 1;
  const yr = [y.zero && low === 0 ? 0 : low - pad, high + pad];
  const beyond = 0.02 * (x.log ? Math.log(xr[1] / xr[0]) : xr[1] - xr[0]);
  const edge = x.log ? [xr[0] * Math.exp(-beyond), xr[1] * Math.exp(beyond)] : [xr[0] - beyond, xr[1] + beyond];
  const c = axes(box, { label, height, x: { ...x, range: edge }, y: { ...y, range: yr } });
  series.forEach((one, k) => {
    const colour = one.colour || COLOURS[k % COLOURS.length];
    const points = one.points.filter((p) => Number.isFinite(p.x) && Number.isFinite(p.y));
    if ((joined || one.silent) && points.length > 1) {
      const path = points.map((p, i) => `${i ? "L" : "M"}${c.X(p.x).toFixed(1)} ${c.Y(p.y).toFixed(1)}`).join("");
      c.plot.append(s("path", { d: path, fill: "none", stroke: colour, "stroke-width": one.silent ? 1 : 1.6, "stroke-dasharray": one.dash || "none" }));
    }
    for (const p of points) {
      const ends = endsOf(p);
      if (ends) c.plot.append(s("line", { x1: c.X(p.x), x2: c.X(p.x), y1: c.Y(ends[0]), y2: c.Y(ends[1]), stroke: colour }));
      if (one.dots !== false)
        c.plot.append(s("circle", { cx: c.X(p.x), cy: c.Y(p.y), r: 3.2, fill: p.hollow ? "#fff" : colour, stroke: colour }));
    }
  });
  const rule = s("line", { y1: c.inner.top, y2: c.inner.bottom, stroke: "#1d2733", "stroke-dasharray": "3 3", visibility: "hidden" });
  c.plot.append(rule);
  const spoken = series.filter((one) => !one.silent);
  c.svg.addEventListener("pointermove", (event) => {
    const at = c.pointer(event);
    let best = null;
    spoken.forEach((one) =>
      one.points.forEach((p) => {
        if (!Number.isFinite(p.y)) return;
        const away = joined ? Math.abs(c.X(p.x) - at[0]) : Math.hypot(c.X(p.x) - at[0], c.Y(p.y) - at[1]);
        if (!best || away < best.away) best = { away, p };
      })
    );
    if (!best) return;
    const here = joined ? best.p.x : null;
    const lines = [`${x.label}: ${shown(best.p.x, 5)}`];
    if (joined)
      for (const one of spoken) {
        const p = one.points.find((q) => q.x === here);
        if (p) lines.push(`${one.name ? one.name + ": " : ""}${words(p)}`);
      }
    else lines.push(`${y.label}: ${words(best.p)}`);
    c.say([c.X(best.p.x), at[1]], lines.join("\n"));
  });
  const items = series.map((one, k) => [one.name, one.colour || COLOURS[k % COLOURS.length]]);
  if (series.length > 1) legend(box, items.filter(([name]) => name));
  return (value) => {
    rule.setAttribute("x1", c.X(value));
    rule.setAttribute("x2", c.X(value));
    rule.setAttribute("visibility", "visible");
  };
}

/* Stacked bars: layers [{name, values}], one value for each bar; totals are said beside. */
function stackedChart(box, { label, x, y, names, layers, totals, height = 300 }) {
  const sums = names.map((_, k) => layers.reduce((sum, layer) => sum + (layer.values[k] || 0), 0));
  const top = Math.max(...sums.filter(Number.isFinite), 0) || 1;
  const c = axes(box, {
    label, height, y: { ...y, range: [0, top * 1.05] },
    x: { ...x, range: [-0.6, names.length - 0.4], ticks: names.map((_, k) => k), names },
  });
  const wide = Math.min(40, ((c.inner.right - c.inner.left) / names.length) * 0.8);
  const base = names.map(() => 0);
  layers.forEach((layer, i) =>
    layer.values.forEach((value, k) => {
      if (!(value > 0)) return;
      const up = c.Y(base[k] + value);
      c.plot.append(s("rect", { x: c.X(k) - wide / 2, width: wide, y: up, height: Math.max(0, c.Y(base[k]) - up), fill: COLOURS[i % COLOURS.length] }));
      base[k] += value;
    })
  );
  c.svg.addEventListener("pointermove", (event) => {
    const at = c.pointer(event);
    const k = Math.max(0, Math.min(names.length - 1, Math.round(((at[0] - c.inner.left) / (c.inner.right - c.inner.left)) * (names.length - 0.4 + 0.6) - 0.6)));
    if (!Number.isFinite(sums[k])) return c.say(at, `${x.label}: ${names[k]}\nno value`);
    const parts = layers.filter((layer) => layer.values[k] > 0).map((layer) => `${layer.name}: ${shown(layer.values[k])} (${shown((100 * layer.values[k]) / sums[k])} %)`);
    c.say([c.X(k), at[1]], [`${x.label}: ${names[k]}`, ...parts.reverse(), `sum: ${shown(sums[k], 5)}`, `dissipated: ${shown(totals[k], 5)}`].join("\n"));
  });
  legend(box, layers.map((layer, k) => [layer.name, COLOURS[k % COLOURS.length]]));
}

/* Map of cells over two axes of names; colour(value) gives a fill, words(column, row) what is said of a cell. */
function mapChart(box, { label, x, y, xNames, yNames, cells, colour, words, letter = null, height = null }) {
  const tall = height || Math.max(140, 7 * y.label.length + 60, Math.min(420, 24 * yNames.length + 70));
  const c = axes(box, {
    label, height: tall,
    x: { ...x, range: [-0.5, xNames.length - 0.5], ticks: xNames.map((_, k) => k), names: xNames },
    y: { ...y, range: [-0.5, yNames.length - 0.5], ticks: yNames.map((_, k) => k), names: yNames },
  });
  const w = (c.inner.right - c.inner.left) / xNames.length;
  const t = (c.inner.bottom - c.inner.top) / yNames.length;
  cells.forEach((row, j) =>
    row.forEach((value, i) => {
      if (value === null || Number.isNaN(value)) return;
      const [fill, ink] = colour(value);
      c.plot.append(s("rect", { x: c.X(i) - w / 2, y: c.Y(j) - t / 2, width: w + 0.3, height: t + 0.3, fill }));
      if (letter && w > 12 && t > 12) {
        const text = s("text", { x: c.X(i), y: c.Y(j) + 4, "text-anchor": "middle" }, letter(value));
        text.style.fill = ink;
        c.plot.append(text);
      }
    })
  );
  c.svg.addEventListener("pointermove", (event) => {
    const at = c.pointer(event);
    const i = Math.floor((at[0] - c.inner.left) / w);
    const j = Math.floor((c.inner.bottom - at[1]) / t);
    if (i < 0 || j < 0 || i >= xNames.length || j >= yNames.length) return c.say(null, null);
    c.say(at, words(i, j));
  });
}

/* Draw now, and again whenever the box changes its width. */
function responsive(box, draw) {
  let width = 0;
  const again = () => {
    if (box.clientWidth !== width) {
      width = box.clientWidth;
      draw();
    }
  };
  new ResizeObserver(() => requestAnimationFrame(again)).observe(box);
  again();
}
