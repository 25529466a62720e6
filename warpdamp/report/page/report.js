"use strict";
/* The page of a report: what is drawn follows from the dimensions of the results. */

const REGIME_COLOURS = [["#e3e8ee", "#1d2733"], ["#9aa7b4", "#1d2733"], ["#f2c14e", "#1d2733"], ["#1b5e93", "#ffffff"], ["#b3442c", "#ffffff"], ["#ffffff", "#1d2733"]];

async function reportPage(report) {
  const arrays = await unpack(report.packed);
  const find = (kind, name) => document.querySelector(`[data-${kind}="${name}"]`);
  const dims = Object.keys(report.dims);
  const long = dims.filter((dim) => report.dims[dim] > 1);
  const coordinate = (name) => report.coordinates.find((c) => c.name === name);
  const along = (dim) => report.coordinates.find((c) => c.name === dim && c.dim === dim) || report.coordinates.find((c) => c.dim === dim);

  /* Value of an array of the page at an index of dimensions; those that it has not are passed over. */
  function at(held, index) {
    let place = 0;
    for (const dim of held.dims) place = place * report.dims[dim] + (index[dim] || 0);
    return arrays[held.array][place];
  }

  function* grid(names) {
    const sizes = names.map((dim) => report.dims[dim]);
    const total = sizes.reduce((product, size) => product * size, 1);
    for (let k = 0; k < total; k++) {
      const index = {};
      let rest = k;
      for (let d = names.length - 1; d >= 0; d--) {
        index[names[d]] = rest % sizes[d];
        rest = Math.floor(rest / sizes[d]);
      }
      yield index;
    }
  }

  function select(box, label, options, value, change) {
    const node = h("select", {}, ...options.map(([key, text]) => h("option", { value: key }, text)));
    node.value = value;
    node.addEventListener("change", () => change(node.value));
    box.append(h("label", {}, label, node));
    return node;
  }

  /* A select for every dimension that is not drawn; returns the index that they hold. */
  function fixed(box, drawn, kept, change) {
    for (const dim of long.filter((d) => !drawn.includes(d))) {
      const c = along(dim);
      kept[dim] = Math.min(kept[dim] || 0, report.dims[dim] - 1);
      select(box, dimName(dim), c.names.map((name, k) => [k, name]), kept[dim], (value) => { kept[dim] = Number(value); change(); });
    }
    const index = {};
    for (const dim of dims) index[dim] = drawn.includes(dim) ? 0 : kept[dim] || 0;
    return index;
  }

  function dimName(dim) {
    const c = along(dim);
    return dim === "frequency" && c.names[0].startsWith("mode") ? "mode" : c.label;
  }

  const numeric = report.coordinates.filter((c) => c.numeric && report.dims[c.dim] > 1);
  const main = report.variables.damping_ratio ? "damping_ratio" : "effectiveness";
  const firstX = (numeric.find((c) => c.name === "gamma") || numeric.find((c) => c.dim === "case" && c.name !== "case") || numeric[0] || report.coordinates[0]).name;

  function curves() {
    const controls = find("controls", "curves"), box = find("chart", "curves"), table = find("table", "curves");
    const state = { variable: main, x: firstX, lines: "", kept: {} };
    const lines = () => long.filter((dim) => dim !== coordinate(state.x).dim && report.dims[dim] <= 10);
    state.lines = lines().includes("frequency") ? "frequency" : lines()[0] || "";
    function again() {
      controls.replaceChildren();
      const x = coordinate(state.x);
      if (state.lines && !lines().includes(state.lines)) state.lines = lines()[0] || "";
      select(controls, "Curve of", Object.entries(report.variables).map(([key, v]) => [key, v.name]), state.variable, (v) => { state.variable = v; again(); });
      if (numeric.length > 1) select(controls, "over", numeric.map((c) => [c.name, c.label]), state.x, (v) => { state.x = v; again(); });
      if (lines().length) select(controls, "a line for each", [["", "–"], ...lines().map((d) => [d, dimName(d)])], state.lines, (v) => { state.lines = v; again(); });
      const base = fixed(controls, [x.dim, state.lines], state.kept, again);
      const variable = report.variables[state.variable];
      const each = state.lines ? along(state.lines).names : [""];
      const series = each.map((name, k) => {
        const points = x.values.map((value, i) => {
          const index = { ...base, [x.dim]: i };
          if (state.lines) index[state.lines] = k;
          const status = at(report.statuses, index);
          return { x: value, y: at(variable.value, index), half: at(variable.half, index), hollow: status !== 0, note: status !== 0 ? report.statuses.names[status] : "" };
        });
        return { name, points: points.sort((a, b) => a.x - b.x) };
      });
      const joined = x.dim !== "case";
      responsiveOnce(box, () => lineChart(box, {
        label: `${variable.name} over ${x.label}: ${variable.about}`, x: { label: x.label }, y: { label: variable.label, zero: true }, series, joined, height: 340,
      }));
      const head = h("tr", {}, h("th", { scope: "col" }, x.label), ...each.map((name) => h("th", { scope: "col" }, name || variable.label)));
      const rows = series[0].points.map((p, i) => h("tr", {}, h("th", { scope: "row" }, shown(p.x, 5)), ...series.map((one) => h("td", {}, withInterval(one.points[i].y, one.points[i].half)))));
      table.replaceChildren(h("table", {}, h("thead", {}, head), h("tbody", {}, ...rows)));
    }
    again();
  }

  const drawings = new Map();
  function responsiveOnce(box, draw) {
    if (!drawings.has(box)) {
      drawings.set(box, draw);
      responsive(box, () => drawings.get(box)());
      return;
    }
    drawings.set(box, draw);
    draw();
  }

  function heat(t) {
    const table = report.film ? report.film[0].colours : HEAT;
    const [r, g, b] = table[Math.max(0, Math.min(table.length - 1, Math.round(t * (table.length - 1))))];
    return [`rgb(${r},${g},${b})`, "#ffffff"];
  }

  function map() {
    const box = find("chart", "map");
    if (!box) return;
    const controls = find("controls", "map"), scale = find("scale", "map");
    const wide = long.filter((dim) => report.dims[dim] > 2);
    const state = { variable: main, x: wide.includes("frequency") && wide.includes("gamma") ? "frequency" : wide[0], y: "", kept: {} };
    state.y = wide.includes("gamma") && state.x !== "gamma" ? "gamma" : wide.find((d) => d !== state.x);
    function again() {
      controls.replaceChildren();
      select(controls, "Map of", Object.entries(report.variables).map(([key, v]) => [key, v.name]), state.variable, (v) => { state.variable = v; again(); });
      const turn = (key, other) => (v) => { if (v === state[other]) state[other] = state[key]; state[key] = v; again(); };
      if (wide.length > 1) {
        select(controls, "to the right", wide.map((d) => [d, dimName(d)]), state.x, turn("x", "y"));
        select(controls, "upwards", wide.map((d) => [d, dimName(d)]), state.y, turn("y", "x"));
      }
      const base = fixed(controls, [state.x, state.y], state.kept, again);
      const variable = report.variables[state.variable], x = along(state.x), y = along(state.y);
      const index = (i, j) => ({ ...base, [state.x]: i, [state.y]: j });
      const cells = y.names.map((_, j) => x.names.map((_, i) => at(variable.value, index(i, j))));
      const top = Math.max(...cells.flat().filter(Number.isFinite), 1e-300);
      responsiveOnce(box, () => mapChart(box, {
        label: `map of ${variable.name} over ${dimName(state.x)} and ${dimName(state.y)}`, x: { label: dimName(state.x) }, y: { label: dimName(state.y) },
        xNames: x.names.map(short), yNames: y.names.map(short), cells, height: 380, colour: (v) => heat(v / top),
        words: (i, j) => `${x.names[i]}\n${y.name} ${y.names[j]}\n${variable.label}: ${withInterval(cells[j][i], at(variable.half, index(i, j)))}`,
      }));
      scale.children[0].textContent = "0";
      scale.children[1].style.background = `linear-gradient(90deg, ${Array.from({ length: 9 }, (_, k) => heat(k / 8)[0]).join(",")})`;
      scale.children[2].textContent = `${shown(top)} ${variable.unit === "-" ? "" : variable.unit}`;
    }
    again();
  }

  const short = (name) => name.replace(/ Hz$/, "").replace(/^mode (\d+),.*/, "mode $1");

  function energy() {
    const box = find("chart", "energy");
    if (!box) return;
    const controls = find("controls", "energy"), state = { kept: {}, part: "energy" };
    const dim = coordinate(firstX).dim, x = dim === "case" ? along("case") : coordinate(firstX);
    function again() {
      controls.replaceChildren();
      select(controls, "Show", [["energy", "energy per cycle"], ["share", "share of the energy"]], state.part, (v) => { state.part = v; again(); });
      const base = fixed(controls, [dim], state.kept, again);
      const order = x.values.map((_, k) => k);
      if (x.numeric) order.sort((a, b) => x.values[a] - x.values[b]);
      const totals = order.map((k) => at(report.losses.total, { ...base, [dim]: k }));
      const over = (k, i) => (state.part === "share" ? totals[i] / 100 : 1);
      const layers = report.losses.layers.map((layer) => ({ name: layer.name, values: order.map((k, i) => at(layer, { ...base, [dim]: k }) / over(k, i)) }));
      const label = state.part === "share" ? "share [%]" : "energy per cycle [mJ]";
      responsiveOnce(box, () => stackedChart(box, {
        label: `energy per cycle by mechanism over ${x.label}, stacked`, x: { label: x.label }, y: { label }, names: order.map((k) => short(x.names[k])), layers,
        totals: totals.map((total) => (state.part === "share" ? 100 : total)), height: 340,
      }));
    }
    again();
  }

  function regimes() {
    const box = find("chart", "regimes");
    if (!box) return;
    const controls = find("controls", "regimes"), kept = {};
    const x = dims.includes("gamma") && report.dims.gamma > 1 ? "gamma" : long[0] || dims[0];
    const y = long.includes("frequency") && x !== "frequency" ? "frequency" : long.find((d) => d !== x) || null;
    function again() {
      controls.replaceChildren();
      const base = fixed(controls, [x, y], kept, again);
      const across = along(x), up = y ? along(y) : null;
      const rows = up ? up.names : [""];
      const cells = rows.map((_, j) => across.names.map((_, i) => at(report.regimes, { ...base, [x]: i, ...(y ? { [y]: j } : {}) })));
      const there = [...new Set(cells.flat())].sort();
      responsiveOnce(box, () => {
        mapChart(box, {
          label: `regime of motion over ${dimName(x)}${y ? " and " + dimName(y) : ""}`, x: { label: across.label }, y: { label: up ? dimName(y) : "" },
          xNames: across.names.map(short), yNames: rows.map(short), cells, colour: (v) => REGIME_COLOURS[v], letter: (v) => report.regimes.names[v][0].toUpperCase(),
          words: (i, j) => `${across.name === "gamma" ? "Γ" : across.name} ${across.names[i]}\n${rows[j]}\n${report.regimes.names[cells[j][i]]}`.replace("\n\n", "\n"),
        });
        legend(box, there.map((v) => [`${report.regimes.names[v][0].toUpperCase()}: ${report.regimes.names[v]}`, REGIME_COLOURS[v][0]]));
      });
    }
    again();
  }

  function bed() {
    const panels = find("chart", "bed");
    if (!panels) return;
    const controls = find("controls", "bed"), kept = {}, x = coordinate(firstX);
    const boxes = report.bed.map(() => h("div"));
    panels.append(...boxes);
    function again() {
      controls.replaceChildren();
      const base = fixed(controls, [x.dim], kept, again);
      report.bed.forEach((one, k) =>
        responsiveOnce(boxes[k], () => lineChart(boxes[k], {
          label: `${one.label} over ${x.label}: ${one.about}`, x: { label: x.label }, y: { label: one.label }, height: 240, joined: x.dim !== "case",
          series: one.lines.map((line) => ({ name: line.name, points: x.values.map((v, i) => ({ x: v, y: at(line, { ...base, [x.dim]: i }) })).sort((a, b) => a.x - b.x) })),
        }))
      );
    }
    again();
  }

  function modes() {
    const panels = find("chart", "modes");
    if (!panels) return;
    for (const mode of report.modes) {
      const box = h("div"), head = h("h3", {}, mode.name);
      panels.append(h("div", {}, head, box));
      const damper = { name: "damper", colour: "#c8410b", points: [{ x: mode.damper[0], y: mode.damper[2] }] };
      if (mode.y === null) {
        const line = mode.x.map((x, k) => ({ x, y: mode.shape[k] }));
        responsive(box, () => lineChart(box, {
          label: `shape of ${mode.name} along ${mode.across}`, x: { label: mode.across }, y: { label: "φ [kg^-½]" }, height: 200,
          series: [{ name: "shape", points: line, dots: false }, damper],
        }));
        continue;
      }
      const most = Math.max(...mode.shape.map(Math.abs)) || 1;
      responsive(box, () => {
        const c = axes(box, { label: `shape of ${mode.name}, seen over ${mode.across} and ${mode.up}`, height: 220,
          x: { label: mode.across, range: padded(mode.x) }, y: { label: mode.up, range: padded(mode.y) } });
        mode.x.forEach((x, k) => c.plot.append(s("circle", { cx: c.X(x), cy: c.Y(mode.y[k]), r: 3, fill: twoSided(mode.shape[k] / most) })));
        c.plot.append(s("rect", { x: c.X(mode.damper[0]) - 5, y: c.Y(mode.damper[1]) - 5, width: 10, height: 10, fill: "none", stroke: "#1d2733", "stroke-width": 2 }));
        legend(box, [[`φ = ${shown(most)} kg^-½`, twoSided(1)], [`φ = −${shown(most)} kg^-½`, twoSided(-1)]]);
      });
    }
  }

  const padded = (values) => { const [a, b] = extent(values), pad = 0.06 * (b - a) || 1; return [a - pad, b + pad]; };
  function twoSided(t) {
    const end = t > 0 ? [178, 24, 43] : [33, 102, 172], k = Math.abs(t);
    return `rgb(${end.map((c) => Math.round(225 + (c - 225) * k)).join(",")})`;
  }

  function calculator() {
    const form = find("controls", "calculator");
    if (!form) return;
    const c = report.calculator, out = find("result", "calculator"), range = find("range", "calculator"), kept = {};
    form.addEventListener("submit", (event) => event.preventDefault());
    const other = c.dims.slice(0, -2);
    const inputs = {};
    const rounded = (value) => String(Number(value.toPrecision(8)));
    const field = (key, label, value) => {
      inputs[key] = h("input", { type: "number", step: "any", name: key, value: rounded(value) });
      inputs[key].addEventListener("input", compute);
      form.append(h("label", {}, label, inputs[key]));
    };
    const preset = c.modes[0] || { amplitude: 1, frequency: c.frequency[0] };
    if (c.modes.length)
      select(form, "Mode of the study", [...c.modes.map((m, k) => [k, m.name]), ["own", "your own"]], 0, (k) => {
        if (k !== "own") { inputs.phi.value = rounded(c.modes[k].amplitude); inputs.f.value = String(c.modes[k].frequency); }
        compute();
      }).name = "preset";
    for (const dim of other.filter((d) => report.dims[d] > 1)) {
      kept[dim] = 0;
      select(form, dimName(dim), along(dim).names.map((name, k) => [k, name]), 0, (k) => { kept[dim] = Number(k); inputs.m.value = rounded(1e3 * at(c.mass, kept)); compute(); }).name = dim;
    }
    field("m", "m [g]", 1e3 * at(c.mass, kept));
    field("phi", "φ [kg^-½]", preset.amplitude);
    field("f", "f [Hz]", preset.frequency);
    field("gamma", "Γ [-]", c.gamma_start);
    range.textContent = `Run: ${shown(c.frequency[0], 4)} to ${shown(c.frequency[c.frequency.length - 1], 4)} Hz, Γ ${shown(c.gamma[0])} to ${shown(c.gamma[c.gamma.length - 1])}; nothing is extrapolated.`;

    function weights(values, value) {
      const low = values[0], high = values[values.length - 1];
      if (!(value >= low * (1 - 1e-6) && value <= high * (1 + 1e-6))) return [];
      value = Math.min(Math.max(value, low), high);
      if (values.length === 1) return [[0, 1]];
      let k = 0;
      while (k < values.length - 2 && values[k + 1] <= value) k++;
      const part = (value - values[k]) / (values[k + 1] - values[k]);
      return [[k, 1 - part], [k + 1, part]].filter(([, weight]) => weight !== 0);
    }

    function damping(mass, phi, f, gamma) {
      let base = 0;
      for (const dim of other) base = base * report.dims[dim] + (kept[dim] || 0);
      base *= c.frequency.length * c.gamma.length;
      let value = 0, variance = 0, any = false;
      for (const [i, u] of weights(c.frequency, f))
        for (const [j, v] of weights(c.gamma, gamma)) {
          const place = base + i * c.gamma.length + j;
          any = true;
          value += u * v * arrays[c.value.array][place];
          variance += u * v * arrays[c.half.array][place] ** 2;
        }
      const scale = (x) => (any ? (2 / Math.PI) * x * mass * phi ** 2 : NaN);
      return [scale(value), scale(Math.sqrt(variance))];
    }

    function compute() {
      const [m, phi, f, gamma] = ["m", "phi", "f", "gamma"].map((key) => Number(inputs[key].value));
      const [zeta, half] = damping(m / 1e3, phi, f, gamma);
      out.dataset.zeta = String(zeta);
      out.dataset.half = String(half);
      out.textContent = Number.isFinite(zeta)
        ? `ζ = ${shown(100 * zeta, 4)} %` + (Number.isFinite(half) ? ` ± ${shown(100 * half, 2)} % (loss factor η = 2ζ = ${shown(2 * zeta, 3)})` : ", without an interval")
        : "No value: f or Γ lies outside what was run, or the case there failed.";
    }
    compute();
  }

  curves();
  map();
  calculator();
  energy();
  regimes();
  bed();
  modes();
  const film = find("film", "film");
  if (film) await filmPlayer(film, report.film);
  document.body.dataset.ready = "yes";
}

const HEAT = [[68, 1, 84], [71, 39, 119], [62, 73, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137], [53, 183, 121], [109, 205, 89], [180, 222, 44], [253, 231, 37]];
