// SPDX-License-Identifier: Apache-2.0
// The charts of a report. Every number and text comes as JSON from the page (report/board.py and
// report/charts.py); this file only cuts the chosen section and profile out of the map.
"use strict";
const place = (id) => document.getElementById(id);
const figures = JSON.parse(place("figures").textContent);
const part = JSON.parse(place("part-data").textContent);
const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
const ink = getComputedStyle(document.body).color; // black on white, or white in the dark
const has3d = Boolean(document.createElement("canvas").getContext("webgl"));

// A chart is drawn into its place, and only then the picture that prints gives way to it.
async function draw(id) {
  const { data, layout } = figures[id];
  layout.font = { color: ink, family: "sans-serif", size: 13 };
  await Plotly.react(id, data, layout, { responsive: true, displaylogo: false });
  place(id).closest(".picture").classList.add("is-alive");
}

function startBoard() {
  const n = part.columns;
  const steps = new Int16Array(bytes(part.error).buffer);
  const error_um = Float64Array.from(steps, (step) => (step === -32768 ? NaN : step * part.error_step_um));
  const radius_mm = new Float32Array(bytes(part.radius).buffer);
  const inColumn = bytes(part.turn); // in 256ths
  const degrees = (k) => (360 * ((k % n) + inColumn[k] / 256)) / n;
  const scaled = (k) => error_um[k] * part.per_um;
  const design_mm = (k) => radius_mm[k] - error_um[k] / 1000;
  const row = (i, of) => Array.from({ length: n }, (_, j) => of(i * n + j));
  const rows = (of) => part.z_mm.map((_, i) => row(i, of));
  const { height, angle } = { height: place("height"), angle: place("angle") };
  const kept = []; // rows that stay in view
  const templates = { section: figures.section.data, unrolled: figures.unrolled.data };
  const colours = ["#56B4E9", "#E69F00", "#CC79A7", "#009E73"];

  // One section: its largest radius becomes 1, so that the taper does not show as shape.
  function ring(i) {
    const largest = row(i, design_mm).reduce((a, b) => (b > a ? b : a), 0);
    const shape = (k) => 1 - part.shape * (1 - design_mm(k) / largest);
    const share = place("magnification").value / 1000 / largest; // of the radius, per um
    const closed = (of) => row(i, of).concat(of(i * n));
    const theta = closed(degrees);
    const line = (off) => ({ theta, r: closed((k) => shape(k) + share * off(k)) });
    const hover = closed((k) => [radius_mm[k], scaled(k)]);
    const ends = [part.tolerance_um, -part.tolerance_um].map((end) => line(() => end));
    return [...ends, line(() => 0), { ...line((k) => error_um[k]), customdata: hover }];
  }

  const label = (i) => `${part.z_mm[i].toFixed(2)} mm`;
  const flat = (i) => ({ x: row(i, degrees), y: row(i, scaled) });
  const asKept = (trace, i, at) => ({ ...trace, name: label(i), line: { color: colours[at % 4], width: 1.2 } });

  function show() {
    const i = Number(height.value), j = Number(angle.value), z_mm = part.z_mm[i];
    const [cut, round] = [templates.unrolled[0], templates.section];
    figures.section.data = [
      ...ring(i).map((line, at) => ({ ...round[at], ...line })),
      ...kept.map((k, at) => asKept({ ...round[3], ...ring(k)[3] }, k, at)),
    ];
    figures.unrolled.data = [
      { ...cut, ...flat(i) }, ...kept.map((k, at) => asKept({ ...cut, ...flat(k) }, k, at)),
    ];
    const column = part.z_mm.map((_, at) => at * n + j);
    Object.assign(figures.profile.data[0], { x: column.map(design_mm), y: part.z_mm });
    Object.assign(figures.profile.data[1], { x: column.map(scaled), y: part.z_mm });
    const x = (360 * (j + 0.5)) / n;
    Plotly.relayout("error-map", {
      "shapes[0].y0": z_mm, "shapes[0].y1": z_mm, "shapes[1].x0": x, "shapes[1].x1": x,
    });
    const found = row(i, scaled).filter((one) => !Number.isNaN(one));
    const [least, most] = found.length ? [Math.min(...found), Math.max(...found)] : [NaN, NaN];
    place("height-value").textContent = label(i);
    place("angle-value").textContent = `${x.toFixed(1)}°`;
    height.setAttribute("aria-valuetext", label(i));
    angle.setAttribute("aria-valuetext", `${x.toFixed(1)} degrees`);
    place("section-text").textContent = found.length
      ? `At ${label(i)} the error runs from ${least.toPrecision(3)} to ${most.toPrecision(3)} ${part.unit}, ` +
        `${(most - least).toPrecision(3)} ${part.unit} peak to peak.`
      : `Nothing was cut at ${label(i)}.`;
    ["section", "unrolled", "profile"].forEach(draw);
  }

  Object.assign(figures["error-map"].data[0], { z: rows(scaled), customdata: rows((k) => radius_mm[k]) });
  return draw("error-map").then(() => {
    place("board").hidden = false; // only now, so that a failure leaves the pictures
    document.documentElement.classList.add("has-board");
    place("error-map").on("plotly_click", ({ points: [{ pointIndex }] }) => {
      [height.value, angle.value] = pointIndex;
      show();
    });
    [height, angle, place("magnification")].forEach((one) => one.addEventListener("input", show));
    place("keep").addEventListener("click", () => (kept.push(Number(height.value)), show()));
    place("forget").addEventListener("click", () => ((kept.length = 0), show()));
    show();
    return has3d ? draw("space") : place("space").closest(".picture").remove();
  });
}

Object.keys(figures).filter((id) => !place(id).closest("#board")).forEach(draw);
if (part.rows) startBoard();
