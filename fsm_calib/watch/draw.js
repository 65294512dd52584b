"use strict";
// Draws the page's figures as SVG. Values in metres and seconds; nothing here knows where they come from.

const SVG = "http://www.w3.org/2000/svg";

function make(name, attributes, text) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes || {})) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  return element;
}

function cssColour(name) {
  return `var(${name})`;  // by name, so that day and night recolour what is drawn already
}

// ---- the plan: what lies in the area, the path in the colours of the phases, the robot
const STYLE = {
  road: ["--road", ""], white: ["#ffffff", ""], yellow: ["#e6b800", ""], tag: ["--tag", ""],
};

function drawArea(svg, run, events, upto) {
  const points = [];
  for (const shape of run.shapes || []) points.push(...shape.outline);
  for (const event of events) if (event.pose) points.push(event.pose);
  if (!points.length) return svg.replaceChildren();
  const xs = points.map(p => p[0]), ys = points.map(p => p[1]), room = 0.12;
  const x0 = Math.min(...xs) - room, x1 = Math.max(...xs) + room;
  const y0 = Math.min(...ys) - room, y1 = Math.max(...ys) + room;
  svg.setAttribute("viewBox", `${x0} ${-y1} ${x1 - x0} ${y1 - y0}`);
  const content = [];
  let board = 0;
  for (const shape of run.shapes || []) {
    const d = "M" + shape.outline.map(p => `${p[0]} ${-p[1]}`).join("L") + "Z";
    if (shape.kind === "board") {
      const colour = run.board_colours[board++ % run.board_colours.length];
      content.push(make("path", { d, fill: colour, "fill-opacity": 0.3, stroke: colour, "stroke-width": 0.012 }));
    } else if (shape.kind === "wall") {
      content.push(make("path", { d, fill: "none", stroke: "#9c6b43", "stroke-width": 0.04 }));
    } else {
      const colour = STYLE[shape.kind][0];
      content.push(make("path", { d, fill: colour.startsWith("--") ? cssColour(colour) : colour }));
    }
  }
  content.push(...pathParts(run, events, upto));
  const now = events[Math.min(upto, events.length - 1)];
  if (now && now.pose) content.push(robot(now.pose));
  svg.replaceChildren(...content);
}

function pathParts(run, events, upto) {
  const parts = [];
  let last = [0, 0], phase = null, d = "";
  const close = () => {
    if (d) parts.push(make("path", { d, fill: "none", stroke: (run.colours || {})[phase] || "#9aa0a6",
      "stroke-width": 0.02, "stroke-linejoin": "round", "stroke-linecap": "round" }));
  };
  for (const event of events.slice(0, upto + 1)) {
    if (!event.pose) continue;
    if (event.phase !== phase) { close(); phase = event.phase; d = `M${last[0]} ${-last[1]}`; }
    d += `L${event.pose[0]} ${-event.pose[1]}`;
    last = event.pose;
  }
  close();
  return parts;
}

function robot(pose) {
  const turn = -pose[2] * 180 / Math.PI;
  const group = make("g", { transform: `translate(${pose[0]} ${-pose[1]}) rotate(${turn})` });
  const ink = cssColour("--lit");
  group.append(make("path", { d: "M-0.08 -0.065L0.06 -0.065L0.13 0L0.06 0.065L-0.08 0.065Z", fill: ink,
    "fill-opacity": 0.85, stroke: "#fff", "stroke-width": 0.012 }));
  return group;
}

// ---- k over the iterations
function drawRatio(svg, events, upto, total) {
  const used = [], told = [], all = [];
  let inUse = 1;
  for (const [number, event] of events.entries()) {
    if (event.wheel_ratio !== undefined) {
      inUse = event.wheel_ratio;
      all.push(inUse);
      if (number <= upto) used.push(inUse);
    } else if (event.k_i !== undefined) {  // one drive tells how far the k in use is off
      all.push(inUse + event.k_i - 1);
      if (number <= upto) told.push([used.length, inUse + event.k_i - 1]);
    }
  }
  if (!all.length) {
    svg.replaceChildren(make("text", { x: 210, y: 130, "text-anchor": "middle" }, "no drive over the tags yet"));
    return;
  }
  const left = 52, right = 408, top = 14, bottom = 222;
  const middle = all.reduce((a, b) => a + b) / all.length;
  const reach = Math.max(...all.map(v => Math.abs(v - middle)), 0.004) * 1.12;
  const count = Math.max(events.filter(e => e.wheel_ratio !== undefined).length, total || 0, 2);
  const x = n => left + (n + 0.5) / (count + 1) * (right - left);
  const y = v => bottom - (v - middle + reach) / (2 * reach) * (bottom - top);
  const ink = cssColour("--ink"), line = cssColour("--line");
  const content = [];
  for (const share of [-0.8, -0.4, 0, 0.4, 0.8]) {
    const value = middle + share * reach;
    content.push(make("path", { d: `M${left} ${y(value)}H${right}`, stroke: line }));
    content.push(make("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, value.toFixed(3)));
  }
  for (const n of [0, Math.round((count - 1) / 2), count - 1]) {
    content.push(make("text", { x: x(n), y: bottom + 17, "text-anchor": "middle" }, n + 1));
  }
  content.push(make("text", { x: 0.5 * (left + right), y: bottom + 35, "text-anchor": "middle" }, "iteration"));
  for (const [n, k] of told) content.push(make("path", { stroke: "#e08214", "stroke-width": 1.6,
    d: `M${x(n) - 4} ${y(k) - 4}l8 8m0 -8l-8 8` }));
  if (used.length) {
    content.push(make("path", { d: "M" + used.map((v, n) => `${x(n)} ${y(v)}`).join("L"), fill: "none", stroke: ink }));
    for (const [n, v] of used.entries()) content.push(make("circle", { cx: x(n), cy: y(v), r: 3.4, fill: ink }));
    content.push(make("text", { x: right, y: top, "text-anchor": "end", "font-weight": 600, style: `fill:${ink}` },
      `k = ${used[used.length - 1].toFixed(4)}`));
  }
  svg.replaceChildren(...content);
}

// ---- time: of the robot by phase, and of the computer by part once the run has ended
function drawTimes(place, run, events, upto) {
  const seconds = {};
  let last = 0;
  for (const event of events.slice(0, upto + 1)) {
    const name = event.phase || "between";
    seconds[name] = (seconds[name] || 0) + Math.max(event.time - last, 0);
    last = event.time;
  }
  place.replaceChildren(bar("robot's time by phase", seconds, name => (run.colours || {})[name] || "#9aa0a6"));
  const parts = run.result && run.result.seconds && run.result.seconds.by_part;
  if (!parts) return;
  const palette = ["#2b7bba", "#e08214", "#2a9d5c", "#c2428a", "#8c6bb1", "#b8860b", "#9aa0a6"];
  const names = Object.keys(parts);
  place.append(bar("computer's time by part", parts, name => palette[names.indexOf(name) % palette.length]));
}

function bar(title, seconds, colourOf) {
  const total = Object.values(seconds).reduce((a, b) => a + b, 0);
  const box = document.createElement("div");
  box.append(Object.assign(document.createElement("p"), { textContent: `${title}: ${total.toFixed(1)} s` }));
  const strip = Object.assign(document.createElement("div"), { className: "bar" });
  const legend = Object.assign(document.createElement("div"), { className: "legend" });
  for (const [name, value] of Object.entries(seconds)) {
    if (value < 0.005 * total) continue;
    const part = document.createElement("div");
    part.style.flex = String(value);
    part.style.background = colourOf(name);
    strip.append(part);
    const entry = document.createElement("span"), dot = document.createElement("i");
    dot.style.background = colourOf(name);
    entry.append(dot, `${name} ${value.toFixed(1)} s`);
    legend.append(entry);
  }
  box.append(strip, legend);
  return box;
}
