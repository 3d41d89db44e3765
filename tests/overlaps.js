() => {
  const boxes = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const text = walk.currentNode, element = text.parentElement;
    if (!text.textContent.trim() || element.closest("script, style")) continue;
    if (!element.checkVisibility({ visibilityProperty: true, opacityProperty: true })) continue;
    const drawn = element.closest("svg") !== null;
    const range = document.createRange();
    range.selectNodeContents(text);
    for (const rect of drawn ? [element.getBoundingClientRect()] : range.getClientRects()) {
      let { left, right, top, bottom } = rect;
      for (let above = element; above; above = above.parentElement) {
        if (getComputedStyle(above).overflowX === "visible") continue; // what is scrolled out of sight covers nothing
        const frame = above.getBoundingClientRect();
        left = Math.max(left, frame.left);
        right = Math.min(right, frame.right);
        top = Math.max(top, frame.top);
        bottom = Math.min(bottom, frame.bottom);
      }
      if (right - left > 1 && bottom - top > 1) boxes.push({ left, right, top, bottom, drawn, words: text.textContent.trim() });
    }
  }
  boxes.sort((a, b) => a.top - b.top);
  const found = [];
  boxes.forEach((a, i) => {
    for (let j = i + 1; j < boxes.length && boxes[j].top < a.bottom; j++) {
      const b = boxes[j];
      const width = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const height = Math.min(a.bottom, b.bottom) - b.top;
      // boxes of letters are higher than the letters: lines of a paragraph may share some of that
      if (width > 1 && height > (a.drawn || b.drawn ? 2 : 4)) found.push(`${a.words} | ${b.words}`);
    }
  });
  return found;
}
