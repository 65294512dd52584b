// What is wrong with a page as a browser lays it out: a list of sentences, empty where nothing is.
(() => {
  const found = [];
  const say = (kind, element, more) => found.push(`${kind}: ${(element.textContent || element.tagName).trim().slice(0, 40)} ${more}`);
  const root = document.documentElement;
  if (root.scrollWidth > window.innerWidth) found.push(`scrolls sideways: ${root.scrollWidth} px in ${window.innerWidth}`);

  const isSeen = element => element.checkVisibility({ visibilityProperty: true, contentVisibilityAuto: true });
  const numbers = colour => {
    const parts = (colour.match(/[\d.]+/g) || []).map(Number);
    return parts.length ? [parts[0], parts[1], parts[2], parts.length > 3 ? parts[3] : 1] : [0, 0, 0, 0];
  };
  const over = (top, below) => [0, 1, 2].map(n => top[3] * top[n] + (1 - top[3]) * below[n]).concat(1);
  const light = colour => [0.2126, 0.7152, 0.0722].reduce((sum, share, n) => {
    const c = colour[n] / 255;
    return sum + share * (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  }, 0);
  const behind = element => {  // WCAG speaks of what is behind the text: the nearest backgrounds, laid over each other
    const layers = [];
    for (let at = element; at; at = at.parentElement) {
      const colour = numbers(getComputedStyle(at).backgroundColor);
      if (colour[3] > 0) layers.push(colour);
      if (colour[3] === 1) break;
    }
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    return layers.reverse().reduce((below, top) => over(top, below), dark ? [18, 18, 18, 1] : [255, 255, 255, 1]);
  };
  const words = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const seen = new Set();
  while (words.nextNode()) {
    const element = words.currentNode.parentElement;
    if (!words.currentNode.data.trim() || seen.has(element) || /^(SCRIPT|STYLE|TITLE)$/i.test(element.tagName)) continue;
    seen.add(element);
    if (!isSeen(element)) continue;
    const style = getComputedStyle(element), isDrawn = element instanceof SVGElement;
    const back = behind(element), ink = over(numbers(isDrawn ? style.fill : style.color), back);
    const [high, low] = [light(ink), light(back)].sort((a, b) => b - a);
    const size = parseFloat(style.fontSize), isLarge = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    const ratio = (high + 0.05) / (low + 0.05);
    if (ratio < (isLarge ? 3 : 4.5)) say("faint", element, `${ratio.toFixed(2)}:1 ${style.fill} ${style.color} on ${back}`);
    const box = element.getBoundingClientRect();
    if (isDrawn) {
      const svg = element.ownerSVGElement.getBoundingClientRect();
      if (!element.closest("#diagram") /* zoomed by hand */ && (box.left < svg.left - 1 || box.right > svg.right + 1 || box.top < svg.top - 1 || box.bottom > svg.bottom + 1))
        say("cut by its figure", element, "");
      const group = element.closest("[clip-path]");
      const frame = group && document.querySelector(`${group.getAttribute("clip-path").slice(4, -1)} rect`);
      if (frame) {
        const map = group.getScreenCTM(), left = map.a * frame.x.baseVal.value + map.e;
        const right = left + map.a * frame.width.baseVal.value;
        if (box.left < left - 2 || box.right > right + 2) say("cut by its axes", element, "");
      }
    } else {
      const style = getComputedStyle(element);
      if (style.overflowX === "hidden" && element.scrollWidth > element.clientWidth + 1) say("cut", element, "");
    }
  }
  return found;
})();
