// SPDX-License-Identifier: Apache-2.0
// The charts of a report. Every number and text comes as JSON from the page (report/board.py and
// report/charts.py); this file only cuts the chosen section and profile out of the map.
"use strict";
const place = (id) => document.getElementById(id);
const [figures, part] = ["figures", "part-data"].map((id) => JSON.parse(place(id).textContent));
const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
const has3d = Boolean(document.createElement("canvas").getContext("webgl"));

const drawn = new Set();
place("no-charts").remove();

// Draws a chart into its element, in the page's colour of text.
function draw(id) {
  const { data, layout } = figures[id];
  const { color } = getComputedStyle(document.body);
  layout.font = { color, family: "sans-serif", size: 13 };
  layout.modebar = { color, activecolor: color, bgcolor: "rgba(0,0,0,0)" };
  drawn.add(id);
  return Plotly.react(id, data, layout, { responsive: true, displaylogo: false, showSendToCloud: false });
}

async function startBoard() {
  // Of each cell of the map, row by row: k counts them.
  const [n, z_mm] = [part.columns, part.z_mm];
  const error_um = Float64Array.from(new Int16Array(bytes(part.error).buffer), (step) => (step === -32768 ? NaN : step * part.error_step_um));
  const radius_mm = new Float32Array(bytes(part.radius).buffer);
  const inColumn = Float64Array.from(new Uint16Array(bytes(part.turn).buffer), (step) => step / 65536);
  const degrees = (k) => (360 * ((k % n) + inColumn[k])) / n;
  const scaled = (k) => error_um[k] * part.per_um;
  const design_mm = (k) => radius_mm[k] - error_um[k] / 1000;
  const row = (i, of) => Array.from({ length: n }, (_, j) => of(i * n + j));
  const [height, angle] = [place("height"), place("angle")];
  const kept = []; // rows that stay in view
  const [round, flat] = [figures.section.data, figures.unrolled.data[0]];

  // One section: its largest radius becomes 1, so that the taper does not show as shape.
  function ring(i) {
    const largest = row(i, design_mm).reduce((a, b) => (b > a ? b : a), 0);
    const share = place("magnification").value / 1000 / largest; // of the radius, per um
    const closed = (of) => row(i, of).concat(of(i * n));
    const off = (um) => closed((k) => 1 - part.shape * (1 - design_mm(k) / largest) + share * um(k));
    const radii = [() => part.tolerance_um, () => -part.tolerance_um, () => 0, (k) => error_um[k]].map(off);
    const customdata = closed((k) => [radius_mm[k], scaled(k)]);
    return radii.map((r, at) => ({ ...round[at], r, theta: closed(degrees), customdata }));
  }

  // The drawing in the middle of a column, between the points of two cells: flanks may be steep.
  function designed(i, j) {
    const [a, b] = [j, inColumn[i * n + j] < 0.5 ? j + 1 : j - 1].map((one) => i * n + ((one + n) % n));
    const apart = (((degrees(b) - degrees(a) + 540) % 360) - 180) / ((180 - 360 * inColumn[a]) / n);
    return design_mm(a) + (Number.isFinite(apart) && apart ? (design_mm(b) - design_mm(a)) / apart : 0);
  }

  function show() {
    const [i, j] = [Number(height.value), Number(angle.value)];
    const [at_mm, at_deg] = [`${z_mm[i].toFixed(2)} mm`, (360 * (j + 0.5)) / n];
    const line = (k) => ({ ...flat, x: row(k, degrees), y: row(k, scaled) });
    const again = kept.map((k, at) => ({ name: `${z_mm[k].toFixed(2)} mm`, line: { color: part.colours[at % part.colours.length], width: 1.2 } }));
    const [band, rim, drawing, cut] = ring(i); // the chosen section lies over the kept ones
    figures.section.data = [band, rim, drawing, ...kept.map((k, at) => ({ ...ring(k)[3], ...again[at] })), cut];
    figures.unrolled.data = [...kept.map((k, at) => ({ ...line(k), ...again[at] })), line(i)];
    const profiles = [z_mm.map((_, k) => designed(k, j)), z_mm.map((_, k) => scaled(k * n + j))];
    const ends = profiles[0].filter(Number.isFinite).sort((a, b) => a - b);
    const room = Math.max(0.005, 0.55 * (ends[ends.length - 1] - ends[0])); // 10 um at least: no noise fills it
    figures.profile.layout.xaxis.range = [-room, room].map((side) => side + (ends[0] + ends[ends.length - 1]) / 2);
    figures.profile.data.forEach((one, at) => Object.assign(one, { x: profiles[at], y: z_mm }));
    const [y, x] = [z_mm[i], at_deg];
    Plotly.relayout("error-map", { "shapes[0].y0": y, "shapes[0].y1": y, "shapes[1].x0": x, "shapes[1].x1": x });
    place("height-value").textContent = at_mm;
    place("angle-value").textContent = `${at_deg.toFixed(1)}°`;
    height.setAttribute("aria-valuetext", at_mm);
    angle.setAttribute("aria-valuetext", `${at_deg.toFixed(1)} degrees`);
    const found = row(i, scaled).filter(Number.isFinite).sort((a, b) => a - b);
    const [least, most] = [found[0], found[found.length - 1]];
    place("section-text").textContent = found.length
      ? `At ${at_mm} the error runs from ${least.toPrecision(3)} to ${most.toPrecision(3)} ${part.unit}, ${(most - least).toPrecision(3)} ${part.unit} peak to peak.`
      : `Nothing was cut at ${at_mm}.`;
    ["section", "unrolled", "profile"].forEach(draw);
  }

  const [z, customdata] = [scaled, (k) => radius_mm[k]].map((of) => z_mm.map((_, i) => row(i, of)));
  Object.assign(figures["error-map"].data[0], { z, customdata });
  place("board").hidden = false; // charts take their width from the page
  await draw("error-map");
  place("error-map").on("plotly_click", (event) => {
    [height.value, angle.value] = event.points[0].pointIndex;
    show();
  });
  [height, angle, place("magnification")].forEach((one) => one.addEventListener("input", show));
  place("keep").addEventListener("click", () => (kept.push(Number(height.value)), show()));
  place("forget").addEventListener("click", () => ((kept.length = 0), show()));
  show();
  const space = place("space").closest(".picture");
  if (!has3d) return space.remove();
  // It takes seconds without a graphics card, so it waits until somebody comes near it.
  new IntersectionObserver(([{ isIntersecting }], observer) => {
    if (!isIntersecting) return;
    observer.disconnect();
    draw("space");
  }, { rootMargin: "300px" }).observe(space);
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach(draw));
Object.keys(figures).filter((id) => !place(id).closest("#board")).forEach(draw);
if (part.rows) startBoard();
