"use strict";
/* Player of recorded cases, of one moment each: a view that turns, drawn on a canvas without perspective.

A spheroid of semi-axes a along u and b across it has the outline of an ellipse: with w the part of u in the plane of
the picture, sqrt(b^2 + (a^2 - b^2) |w|^2) along w and b across. */

function colourTable(map) {
  return map.map(([r, g, b]) => `rgb(${r},${g},${b})`);
}

/* A shaded ball of every colour, drawn once. */
function balls(map) {
  return map.map(([r, g, b]) => {
    const sprite = document.createElement("canvas");
    sprite.width = sprite.height = 64;
    const pen = sprite.getContext("2d");
    const shade = pen.createRadialGradient(24, 22, 2, 32, 32, 32);
    const mix = (k, to) => `rgb(${[r, g, b].map((c) => Math.round(c + (to - c) * k)).join(",")})`;
    shade.addColorStop(0, mix(0.65, 255));
    shade.addColorStop(0.5, mix(0, 0));
    shade.addColorStop(1, mix(0.45, 0));
    pen.fillStyle = shade;
    pen.beginPath();
    pen.arc(32, 32, 31.5, 0, 2 * Math.PI);
    pen.fill();
    return sprite;
  });
}

/* The canvas of one cavity; what is shared with those beside it are view, state, colours and the size of the picture. */
async function stageOf(film, shared) {
  const arrays = await unpack(film.packed);
  const n = film.particles, cavity = film.cavity;
  const canvas = h("canvas", { role: "img", tabindex: "0", "aria-label": film.alt });

  const place = (f, i) => 3 * (f * n + i);
  const at = (k, axis) => film.low[axis] + (arrays.position[k + axis] / 65535) * (film.high[axis] - film.low[axis]);

  function draw() {
    const { state, view, sprites } = shared;
    const side = Math.round(canvas.clientWidth * (window.devicePixelRatio || 1)) || 480;
    if (canvas.width !== side) canvas.width = canvas.height = side;
    const pen = canvas.getContext("2d");
    const f = state.frame;
    const [ct, st, ce, se] = [Math.cos(view.turn), Math.sin(view.turn), Math.cos(view.tilt), Math.sin(view.tilt)];
    const right = [ct, st, 0], up = [-st * se, ct * se, ce], towards = [st * ce, -ct * ce, se];
    const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    const size = (0.46 * side * view.zoom) / shared.reach;
    const shift = state.moving ? film.displacement[f] : [0, 0, 0];
    const seen = (p) => {
      const q = [p[0] + shift[0], p[1] + shift[1], p[2] + shift[2] - cavity.height / 2];
      return [side / 2 + size * dot(q, right), side / 2 - size * dot(q, up), dot(q, towards)];
    };
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, side, side);

    const outline = () => {
      pen.lineWidth = Math.max(1, side / 500);
      pen.strokeStyle = "#8b97a4";
    };
    const rim = (z) => {
      const [x, y] = seen([0, 0, z]);
      outline();
      pen.beginPath();
      pen.ellipse(x, y, size * cavity.radius, size * cavity.radius * Math.abs(se), 0, 0, 2 * Math.PI);
      pen.stroke();
    };
    outline();
    if (cavity.side) {
      for (const sign of [-1, 1]) {
        const foot = seen([sign * ct * cavity.radius, sign * st * cavity.radius, 0]);
        const head = seen([sign * ct * cavity.radius, sign * st * cavity.radius, cavity.height]);
        pen.beginPath();
        pen.moveTo(foot[0], foot[1]);
        pen.lineTo(head[0], head[1]);
        pen.stroke();
      }
    }
    if (cavity.floor || cavity.side) rim(0);

    const order = [];
    for (let i = 0; i < n; i++) {
      const k = place(f, i);
      const p = seen([at(k, 0), at(k, 1), at(k, 2)]);
      order.push([p[2], p[0], p[1], i]);
    }
    order.sort((one, other) => one[0] - other[0]); // the farthest first
    const values = arrays[state.colour];
    pen.globalAlpha = state.forces ? 0.35 : 1;
    for (const [, x, y, i] of order) {
      const sprite = sprites[Math.min(sprites.length - 1, Math.round((values[f * n + i] / 255) * (sprites.length - 1)))];
      const r = film.radius[i % film.radius.length] * size;
      if (!film.along) {
        pen.drawImage(sprite, x - r, y - r, 2 * r, 2 * r);
        continue;
      }
      const k = place(f, i);
      const a = film.along[i % film.along.length] * size, b = film.across[i % film.across.length] * size;
      const u = [arrays.axis[k] / 127, arrays.axis[k + 1] / 127, arrays.axis[k + 2] / 127];
      const w = [dot(u, right), -dot(u, up)];
      const length = Math.hypot(w[0], w[1]);
      const along = Math.sqrt(Math.max(0, b * b + (a * a - b * b) * length * length));
      const [c, q] = length > 1e-6 ? [w[0] / length, w[1] / length] : [1, 0];
      pen.setTransform(c * along, q * along, -q * b, c * b, x, y);
      pen.drawImage(sprite, -1, -1, 2, 2);
      pen.setTransform(1, 0, 0, 1, 0, 0);
    }
    pen.globalAlpha = 1;
    if (state.forces) drawForces(pen, f, seen, side);
    if (cavity.lid || cavity.side) rim(cavity.height);
  }

  function drawForces(pen, f, seen, side) {
    pen.strokeStyle = "#8b1a1a";
    pen.lineCap = "round";
    for (let k = film.contacts[f]; k < film.contacts[f + 1]; k++) {
      const [i, j] = [arrays.first[k], arrays.second[k]];
      const a = place(f, i), from = [at(a, 0), at(a, 1), at(a, 2)];
      const rho = Math.hypot(from[0], from[1]) || 1;
      const walls = [[(from[0] / rho) * cavity.radius, (from[1] / rho) * cavity.radius, from[2]], [from[0], from[1], 0], [from[0], from[1], cavity.height]];
      const b = place(f, j);
      const to = j >= n ? walls[j - n] : [at(b, 0), at(b, 1), at(b, 2)];
      const [p, q] = [seen(from), seen(to)];
      pen.lineWidth = (0.3 + 6 * (arrays.force[k] / 255)) * (side / 600);
      pen.beginPath();
      pen.moveTo(p[0], p[1]);
      pen.lineTo(q[0], q[1]);
      pen.stroke();
    }
  }

  return { film, canvas, draw };
}

const reachOf = (film) => Math.hypot(film.cavity.radius, film.cavity.height / 2) + Math.hypot(...film.sway);

async function filmPlayer(root, films) {
  const film = films[0], frames = film.frames;
  const view = { turn: 0.6, tilt: 0.25, zoom: 1 };
  const state = { frame: 0, playing: false, colour: film.colour, forces: film.forces, moving: true };
  const shared = { view, state, sprites: balls(film.colours), reach: Math.max(...films.map(reachOf)) };
  const stages = await Promise.all(films.map((one) => stageOf(one, shared)));
  const draw = () => stages.forEach((stage) => stage.draw());

  const play = h("button", { type: "button" }, "Play");
  const slider = h("input", { type: "range", min: 0, max: frames - 1, value: 0, "aria-label": "frame" });
  const which = h("select", {}, ...Object.entries(film.quantities).map(([key, q]) => h("option", { value: key }, q.name)));
  which.value = state.colour;
  const forces = h("input", { type: "checkbox" });
  forces.checked = state.forces;
  const moving = h("input", { type: "checkbox" });
  moving.checked = true;
  const reset = h("button", { type: "button" }, "Reset view");
  const least = h("span", {}, "0"), most = h("span", {}), strip = h("i", {});
  strip.style.background = `linear-gradient(90deg, ${colourTable(film.colours).filter((_, k) => k % 8 === 0).join(",")})`;
  const clock = h("p", { class: "quiet" });
  const dial = h("div", {}), curve = h("div", {});
  root.replaceChildren(
    h("div", {}, h("div", { class: "stages" }, ...stages.map((stage) => h("figure", {}, stage.canvas, ...(films.length > 1 ? [h("figcaption", { class: "quiet" }, stage.film.label)] : [])))),
      h("div", { class: "play" }, play, slider), h("div", { class: "bar" }, least, strip, most),
      h("div", { class: "controls" }, h("label", {}, "Colour by", which), h("label", { class: "check" }, forces, `Contact forces (thickest: ${shown(film.strongest)} N)`),
        h("label", { class: "check" }, moving, "Cavity moves"), reset),
      h("p", { class: "quiet" }, "Drag or use the arrow keys to turn, the wheel or + and − to zoom.")),
    h("div", {}, h("h2", { class: "small" }, "Phase of the drive"), dial, clock, h("h2", { class: "small" }, "Effectiveness, cycle by cycle"), curve,
      h("p", { class: "quiet" }, film.remark))
  );
  root.classList.add("film");
  if (films.length > 1) root.classList.add("several");

  let hand = null, mark = null;
  function drawDial() {
    const name = (one, single) => (films.length > 1 ? `damper ${one.damper}` : single);
    const wave = (one) => {
      const apart = 2 * Math.PI * (one.cycle[0] - film.cycle[0]);
      return Array.from({ length: 61 }, (_, k) => ({ x: k * 6, y: one.drive.displacement * Math.sin((k * Math.PI) / 30 + apart) }));
    };
    hand = lineChart(dial, {
      label: `displacement of the cavity over one cycle of the drive, amplitude ${shown(film.drive.displacement)} mm`,
      x: { label: "phase [°]", ticks: [0, 90, 180, 270, 360] }, y: { label: "cavity [mm]" }, height: 160,
      series: films.map((one) => ({ name: name(one, "displacement"), points: wave(one), dots: false })),
    });
    const cycles = (one) => one.effectiveness.map((y, k) => ({ x: k + 1, y, hollow: k < one.discarded }));
    mark = lineChart(curve, {
      label: `effectiveness of each of ${film.effectiveness.length} cycles`, x: { label: "cycle" }, y: { label: "effectiveness [-]", zero: true }, height: 220,
      series: films.map((one) => ({ name: name(one, "effectiveness"), points: cycles(one), dots: one.effectiveness.length <= 80 })),
    });
    tell();
  }

  function tell() {
    const cycle = film.cycle[state.frame], phase = cycle % 1;
    clock.textContent = `cycle ${cycle.toFixed(2)} of ${film.effectiveness.length}, phase ${(360 * phase).toFixed(0)}°, ${shown(1e3 * cycle / film.drive.frequency, 5)} ms`;
    if (hand) hand(360 * phase);
    if (mark) mark(Math.min(film.effectiveness.length, Math.floor(cycle) + 1));
    slider.setAttribute("aria-valuetext", `frame ${state.frame + 1} of ${frames}`);
  }

  function show(frame) {
    state.frame = (frame + frames) % frames;
    slider.value = state.frame;
    draw();
    tell();
  }

  function scale() {
    const q = film.quantities[state.colour];
    most.textContent = `${shown(q.most)} ${q.unit}`;
    draw();
  }

  let timer = null;
  play.addEventListener("click", () => {
    state.playing = !state.playing;
    play.textContent = state.playing ? "Pause" : "Play";
    clearInterval(timer);
    if (state.playing) timer = setInterval(() => show(state.frame + 1), 50);
  });
  slider.addEventListener("input", () => show(Number(slider.value)));
  which.addEventListener("change", () => { state.colour = which.value; scale(); });
  forces.addEventListener("change", () => { state.forces = forces.checked; draw(); });
  moving.addEventListener("change", () => { state.moving = moving.checked; draw(); });
  reset.addEventListener("click", () => { Object.assign(view, { turn: 0.6, tilt: 0.25, zoom: 1 }); draw(); });
  for (const { canvas } of stages) {
    let held = null;
    canvas.addEventListener("pointerdown", (event) => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointerup", () => { held = null; });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      turnBy(0.01 * (event.clientX - held[0]), 0.01 * (event.clientY - held[1]));
      held = [event.clientX, event.clientY];
    });
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoomBy(event.deltaY < 0 ? 1.1 : 1 / 1.1); }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const keys = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
      if (keys[event.key]) turnBy(...keys[event.key]);
      else if (event.key === "+" || event.key === "-") zoomBy(event.key === "+" ? 1.1 : 1 / 1.1);
      else return;
      event.preventDefault();
    });
  }
  function turnBy(round, over) {
    view.turn -= round;
    view.tilt = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, view.tilt + over));
    draw();
  }
  function zoomBy(factor) {
    view.zoom = Math.max(0.4, Math.min(8, view.zoom * factor));
    draw();
  }
  for (const stage of stages) responsive(stage.canvas, stage.draw);
  responsive(curve, drawDial);
  scale();
  root.dataset.ready = "yes";
}
