"use strict";
// One cursor for all figures of a drive: a moment on the time axes is a place on the maps, and the other way round.
for (const drive of document.querySelectorAll("[data-track]")) {
  const track = JSON.parse(drive.dataset.track);  // rows of time [s], x, y [m]
  const said = drive.querySelector(".cursor");
  const frames = [];
  for (const svg of drive.querySelectorAll("svg[data-axes]")) {
    for (const [kind, left, top, width, height, x0, x1, y0, y1] of JSON.parse(svg.dataset.axes)) {
      const mark = document.createElementNS("http://www.w3.org/2000/svg", kind === "time" ? "path" : "circle");
      mark.setAttribute("class", "cursor-mark");
      mark.style.display = "none";  // until somebody points
      if (kind !== "time") mark.setAttribute("r", 5);
      svg.append(mark);
      frames.push({ kind, svg, left, top, width, height, x0, x1, y0, y1, mark });
    }
  }
  const show = row => {
    const [time, x, y] = row;
    for (const f of frames) {
      const across = ((f.kind === "time" ? time : x) - f.x0) / (f.x1 - f.x0);
      const place = f.left + across * f.width;
      f.mark.style.display = across < 0 || across > 1 ? "none" : "";
      if (f.kind === "time") f.mark.setAttribute("d", `M${place} ${f.top}v${f.height}`);
      else {
        f.mark.setAttribute("cx", place);
        f.mark.setAttribute("cy", f.top + (1 - (y - f.y0) / (f.y1 - f.y0)) * f.height);
      }
    }
    said.textContent = `${time.toFixed(1)} s` + (x === null ? "" : `, x = ${x.toFixed(2)} m, y = ${y.toFixed(2)} m`);
  };
  const nearest = distance => track.reduce((best, row) => distance(row) < distance(best) ? row : best);
  drive.addEventListener("pointermove", event => {
    const svg = event.target.closest && event.target.closest("svg[data-axes]");
    if (!svg) return;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const f = frames.find(f => f.svg === svg && at.x >= f.left && at.x <= f.left + f.width
      && at.y >= f.top && at.y <= f.top + f.height);
    if (!f) return;
    const x = f.x0 + (at.x - f.left) / f.width * (f.x1 - f.x0);
    const y = f.y1 - (at.y - f.top) / f.height * (f.y1 - f.y0);
    show(f.kind === "time" ? nearest(row => Math.abs(row[0] - x)) : nearest(row => Math.hypot(row[1] - x, row[2] - y)));
  });
}
