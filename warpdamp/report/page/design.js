"use strict";
/* The page of a design: damping over Gamma of the damper chosen, and the front of damping against mass. */

const GREY = "#9aa7b4", STEEL = "#455a64", INK = "#1d2733";

function designPage(design) {
  const find = (name) => document.querySelector(`[data-chart="${name}"]`);

  function curve() {
    const grey = design.curves.flatMap((one) =>
      one.packings.map((values) => ({ name: "", colour: GREY, dots: false, silent: true, points: one.gamma.map((x, k) => ({ x, y: values[k] })) }))
    );
    const means = design.curves.map((one, k) => ({
      name: one.name, colour: COLOURS[k % COLOURS.length], points: one.gamma.map((x, i) => ({ x, y: one.mean[i], half: one.half[i] })),
    }));
    const every = design.curves.flatMap((one) => one.gamma);
    lineChart(find("curve"), {
      label: "damping ratio of the damper chosen over Γ, with 95 % intervals", x: { label: "Γ at the damper [-]", log: true }, y: { label: "damping ratio [%]", zero: true },
      series: [...grey, ...means, ...level(every)], height: 340,
    });
  }

  /* A line at what was wanted, from the smallest to the largest of some values. */
  function level(values) {
    if (design.wanted === null) return [];
    const [low, high] = extent(values);
    return [{ name: "wanted", colour: INK, dash: "7 4", dots: false, silent: true, points: [low, high].map((x) => ({ x, y: design.wanted })) }];
  }

  function front() {
    const series = design.designs.map((group, k) => ({ ...group, colour: COLOURS[k % COLOURS.length] }));
    const points = series.flatMap((one) => one.points);
    const bound = design.bound === null ? [] : [design.bound];
    const top = extent(points.flatMap((p) => [p.y, p.ends[1]]))[1];
    const fence = bound.map((x) => ({ name: "least mass of any damper", colour: STEEL, dash: "2 3", dots: false, silent: true, points: [{ x, y: 0 }, { x, y: top }] }));
    lineChart(find("front"), {
      label: "least damping ratio over the range against the mass of the particles", x: { label: "mass of the particles [g]", log: true },
      y: { label: "least damping over the range [%]", zero: true }, series: [...series, ...fence, ...level([...points.map((p) => p.x), ...bound])], height: 340, joined: false,
    });
  }

  responsive(find("curve"), curve);
  responsive(find("front"), front);
  document.body.dataset.ready = "yes";
}
