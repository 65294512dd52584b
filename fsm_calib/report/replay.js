"use strict";
(() => {
  const told = JSON.parse(document.getElementById("replay-data").textContent);
  const place = id => document.getElementById(`replay-${id}`);
  const slider = place("time"), button = place("play"), seen = place("seen");
  const before = (rows, time) => {  // the last row at or before a time, -1 for none
    let low = -1, high = rows.length;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if ((rows[middle][0] ?? rows[middle]) <= time) low = middle; else high = middle;
    }
    return low;
  };
  let shown = null;
  const show = time => {
    const pose = told.poses[Math.max(before(told.poses, time), 0)];
    place("robot").setAttribute("transform", `translate(${pose[1]} ${pose[2]}) rotate(${pose[3]})`);
    const last = before(told.events, time);
    const now = told.events[Math.min(last + 1, told.events.length - 1)];
    place("state").textContent = now[1].replaceAll("/", " / ");
    place("said").textContent = last < 0 ? "" : told.events[last][2];
    place("clock").textContent = `${time.toFixed(1)} s`;
    slider.setAttribute("aria-valuetext", `${time.toFixed(1)} seconds, ${now[1]}`);
    const frame = Math.max(before(told.frames, time), 0);
    if (frame !== shown && told.frames.length) {
      const picture = document.querySelector(`[data-picture="${frame}"] svg`);
      seen.setAttribute("viewBox", picture.getAttribute("viewBox"));
      seen.replaceChildren(...[...picture.childNodes].map(node => node.cloneNode(true)));
      place("taken").textContent = `seen at ${told.frames[frame].toFixed(1)} s`;
      shown = frame;
    }
  };
  let playing = null, began = 0;
  const stop = () => { cancelAnimationFrame(playing); playing = null; button.textContent = "play"; };
  const step = moment => {
    const end = Number(slider.max);
    const time = Math.min(Number(slider.value) + (moment - began) / 1000 * Math.max(end / 40, 1), end);
    began = moment;
    slider.value = time;
    show(time);
    if (time >= end) stop(); else playing = requestAnimationFrame(step);
  };
  button.addEventListener("click", () => {
    if (playing !== null) return stop();
    if (Number(slider.value) >= Number(slider.max)) slider.value = 0;
    button.textContent = "pause";
    began = performance.now();
    playing = requestAnimationFrame(step);
  });
  slider.addEventListener("input", () => { if (playing !== null) stop(); show(Number(slider.value)); });
  show(Number(slider.value));
})();
