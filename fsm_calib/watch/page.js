"use strict";
// What is shown: the run as it stood after one event. Live, that is the newest; else the slider's, or the replay's.

const byId = id => document.getElementById(id);
const asked = new URLSearchParams(location.search);
const page = { run: {}, events: [], pictures: [], at: -1, live: true, playing: null, machine: "", whole: false };
const SETTLED = new Set(["done", "failed", "aborted"]);

async function json(path) {
  const answer = await fetch(path);
  return answer.ok ? answer.json() : {};
}

// ---- the diagram: one machine at a time, the active state lit, the picture drawn up to it
async function showMachine(machine) {
  if (machine === page.machine) return;
  page.machine = machine;
  const answer = await fetch(`diagrams/${machine}.svg`);
  if (page.machine !== machine) return;  // the run went on while the picture was on its way
  const place = byId("diagram");
  if (!answer.ok) { place.replaceChildren(); return; }
  const drawn = new DOMParser().parseFromString(await answer.text(), "image/svg+xml").documentElement;
  drawn.removeAttribute("width");
  drawn.removeAttribute("height");
  page.box = drawn.getAttribute("viewBox").split(" ").map(Number);
  place.replaceChildren(document.importNode(drawn, true));
}

function nodeOf(path) {
  const names = path.split("/").slice(page.machine === "supervisor" ? 0 : 1);
  const titles = new Map();
  for (const title of byId("diagram").querySelectorAll("g.node > title, g.cluster > title")) {
    titles.set(title.textContent.replace(/^cluster_/, ""), title.parentNode);
  }
  for (let length = names.length; length > 0; length--) {
    const found = titles.get(names.slice(0, length).join("__"));
    if (found) return found;
  }
  return null;
}

async function light(path) {
  const phase = path.split("/")[0];
  const machine = (page.run.plan || []).includes(phase) ? phase : "supervisor";
  byId("machine").textContent = machine;
  byId("state").textContent = path;
  await showMachine(machine);
  for (const lit of byId("diagram").querySelectorAll(".lit")) lit.classList.remove("lit");
  const node = nodeOf(path);
  document.body.dataset.lit = node ? node.querySelector("title").textContent : "";
  document.body.dataset.state = path;
  if (node) node.classList.add("lit");
  aim(node);
}

function aim(node) {
  const svg = byId("diagram").querySelector("svg");
  if (!svg || !page.box) return;
  if (page.whole || !node) { svg.setAttribute("viewBox", page.box.join(" ")); return; }
  const graph = svg.querySelector("g.graph").transform.baseVal.consolidate().matrix;
  const box = node.getBBox(), place = byId("diagram");
  const wide = Math.min(Math.max(1.05 * place.clientWidth, box.width + 60), page.box[2]);
  const high = wide * place.clientHeight / Math.max(place.clientWidth, 1);
  const x = box.x + 0.5 * box.width + graph.e, y = box.y + 0.5 * box.height + graph.f;
  const inside = (low, size, whole) => size >= whole ? 0.5 * (whole - size) : Math.min(Math.max(low, 0), whole - size);
  svg.setAttribute("viewBox",
    [inside(x - 0.5 * wide, wide, page.box[2]), inside(y - 0.5 * high, high, page.box[3]), wide, high].join(" "));
}

// ---- the camera: the newest kept frame up to now
function showPicture(time) {
  let picture = null;
  for (const one of page.pictures) if (one.time <= time + 1e-6) picture = one;
  const svg = byId("camera");
  if (!picture) { svg.replaceChildren(); byId("picture-says").textContent = "No frame was kept so far."; return; }
  byId("picture-time").textContent = `${picture.time.toFixed(1)} s · ${picture.path}`;
  byId("picture-says").textContent = picture.sentence;
  if (svg.dataset.file === picture.file) return;
  svg.dataset.file = picture.file;
  svg.setAttribute("viewBox", `0 0 ${picture.width} ${picture.height}`);
  const content = [make("image", { href: picture.file, width: picture.width, height: picture.height })];
  for (const [x, y] of picture.points) content.push(make("circle", { cx: x, cy: y, r: 4 }));
  svg.replaceChildren(...content);
}

function showPlan(phase, isOver) {
  const plan = page.run.plan || [];
  const now = plan.indexOf(phase);
  byId("plan").replaceChildren(...plan.map((name, number) => {
    const entry = document.createElement("li");
    entry.textContent = name;
    entry.style.setProperty("--phase", (page.run.colours || {})[name] || "");
    const reached = page.events.slice(0, page.at + 1).some(event => event.phase === name);
    entry.className = number === now && !isOver ? "now" : reached ? "past" : "";
    if (number === now) entry.setAttribute("aria-current", "step");
    return entry;
  }));
}

function showLog(event) {
  byId("sentence").textContent = [event.sentence, event.cure].filter(Boolean).join(" ");
  byId("log").replaceChildren(...page.events.slice(Math.max(page.at - 12, 0), page.at + 1).reverse().map(one => {
    const entry = document.createElement("li"), time = document.createElement("time");
    const said = document.createElement("span"), name = document.createElement("b");
    time.textContent = `${one.time.toFixed(1)} s`;
    name.textContent = `${one.trigger} `.replaceAll("_", " ");
    said.append(name, one.sentence);
    entry.append(time, said);
    return entry;
  }));
}

function showStatus(path) {
  const end = path.split("/")[0], pill = byId("status");
  const state = SETTLED.has(end) ? end : page.live && !page.run.result.outcome ? "running" : "replay";
  pill.textContent = state === "failed" ? path.split("/").slice(1).join(" ").replaceAll("_", " ") || "failed" : state;
  pill.className = `pill ${state}`;
  byId("live").classList.toggle("on", page.live);
  byId("live").hidden = Boolean(page.run.result.outcome);
  byId("stop").hidden = !page.run.can_stop || Boolean(page.run.result.outcome);
}

function show(at) {
  const slider = byId("slider");
  slider.max = Math.max(page.events.length - 1, 0);
  if (!page.events.length) { showStatus(""); return; }
  page.at = Math.max(0, Math.min(at, page.events.length - 1));
  slider.value = page.at;
  const event = page.events[page.at], path = event.dest || event.path;
  byId("clock").textContent = `${event.time.toFixed(1)} s`;
  showStatus(path);
  showPlan(path.split("/")[0], SETTLED.has(path.split("/")[0]));
  showPicture(event.time);
  showLog(event);
  drawArea(byId("area"), page.run, page.events, page.at);
  drawRatio(byId("ratio"), page.events, page.at);
  drawTimes(byId("times"), page.run, page.events, page.at);
  light(path);
}

// ---- replay: at the speed asked for, by the robot's clock
function play(isOn) {
  cancelAnimationFrame(page.playing);
  page.playing = null;
  byId("play").textContent = isOn ? "❚❚" : "▶";
  if (!isOn) return;
  page.live = false;
  if (page.at >= page.events.length - 1) show(0);
  let before = performance.now(), time = page.events[page.at].time;
  const step = now => {
    time += (now - before) / 1000 * Number(byId("speed").value);
    before = now;
    let at = page.at;
    while (at + 1 < page.events.length && page.events[at + 1].time <= time) at++;
    if (at !== page.at) show(at);
    if (at >= page.events.length - 1) { play(false); return; }
    page.playing = requestAnimationFrame(step);
  };
  page.playing = requestAnimationFrame(step);
}

byId("play").onclick = () => play(page.playing === null);
byId("slider").oninput = () => { play(false); page.live = false; show(Number(byId("slider").value)); };
byId("live").onclick = () => { play(false); page.live = true; show(page.events.length - 1); };
byId("zoom").onclick = () => {
  page.whole = !page.whole;
  byId("zoom").textContent = page.whole ? "close" : "whole";
  show(page.at);
};
byId("stop").onclick = () => fetch("stop", { method: "POST", headers: { "X-Token": page.run.token } });
addEventListener("resize", () => show(page.at));
document.addEventListener("keydown", key => {
  if (key.target.matches("input, select, button")) return;
  if (key.key === " ") { play(page.playing === null); key.preventDefault(); }
  if (key.key === "ArrowRight") { play(false); page.live = false; show(page.at + 1); }
  if (key.key === "ArrowLeft") { play(false); page.live = false; show(page.at - 1); }
});

// ---- news: events as they come; a page that is behind asks for what it missed, and draws the newest only
async function catchUp() {
  if (page.catching) return;
  page.catching = true;
  try {
    while (page.live && page.at < page.events.length - 1) {
      page.pictures = await json("pictures.json");
      await new Promise(requestAnimationFrame);
      if (page.live) show(page.events.length - 1);
    }
  } finally {
    page.catching = false;
  }
}

function listen() {
  const news = new EventSource("stream");
  news.addEventListener("events", async message => {
    const { from, total, events } = JSON.parse(message.data);
    if (from > page.events.length) page.events = await json("events.json");
    else page.events = page.events.slice(0, from).concat(events);
    byId("slider").max = total - 1;
    if (page.live) catchUp();
  });
  news.addEventListener("again", () => location.reload());
  news.addEventListener("result", message => {
    page.run.result = JSON.parse(message.data);
    news.close();
    show(page.live ? page.events.length - 1 : page.at);
  });
  news.onerror = () => {
    const last = page.events[page.events.length - 1];
    if (last && SETTLED.has(last.dest.split("/")[0])) news.close();
    else byId("status").textContent = "waiting for the run";
  };
}

async function begin() {
  page.run = await json("run.json");
  page.run.result = page.run.result || {};
  page.events = await json("events.json");
  page.pictures = await json("pictures.json");
  byId("name").textContent = page.run.name ? `${page.run.name} · ${page.run.robot}` : page.run.folder;
  document.title = `${page.run.name || page.run.folder} · fsm-calib`;
  if (asked.has("at")) {
    page.live = false;
    show(Number(asked.get("at")));
    return;
  }
  if (page.run.result.outcome) { page.live = false; show(page.events.length - 1); return; }
  listen();
}

begin();
