() => {
  // Texts within pictures whose colour is too near to what they stand on: 4.5 to 1 is asked for (WCAG 2, 1.4.3).
  const parsed = (colour) => {
    const part = colour.match(/[\d.]+/g).map(Number);
    return { rgb: part.slice(0, 3), alpha: part.length > 3 ? part[3] : 1 };
  };
  const over = (above, alpha, below) => above.map((value, k) => alpha * value + (1 - alpha) * below[k]);
  const light = (rgb) => {
    const [r, g, b] = rgb.map((v) => v / 255).map((v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ratio = (a, b) => {
    const [low, high] = [light(a), light(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  };
  const page = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const { rgb, alpha } = parsed(getComputedStyle(at).backgroundColor);
      if (alpha === 1) return rgb;
    }
    return [255, 255, 255];
  };
  const found = [];
  let seen = 0;
  for (const picture of document.querySelectorAll("svg.drawn")) {
    if (!picture.checkVisibility()) continue;
    const ground = page(picture);
    const areas = [...picture.querySelectorAll("path, rect, circle, ellipse, polygon")].flatMap((shape) => {
      const style = getComputedStyle(shape);
      const { rgb, alpha } = style.fill === "none" ? { alpha: 0 } : parsed(style.fill);
      const seen = alpha * style.fillOpacity * style.opacity;
      const place = shape.getScreenCTM();
      return seen > 0 && place && !shape.closest("defs") ? [{ shape, rgb, seen, back: place.inverse() }] : [];
    });
    for (const text of picture.querySelectorAll("text")) {
      seen += 1;
      const ink = parsed(getComputedStyle(text).fill).rgb;
      const box = text.getBoundingClientRect();
      let worst = 21;
      for (const across of [0.05, 0.25, 0.5, 0.75, 0.95]) {
        for (const down of [0.3, 0.5, 0.7]) {
          const point = new DOMPoint(box.left + across * box.width, box.top + down * box.height);
          let below = ground;
          for (const { shape, rgb, seen: share, back } of areas) {
            if (!(shape.compareDocumentPosition(text) & Node.DOCUMENT_POSITION_FOLLOWING)) continue;
            if (shape.isPointInFill(point.matrixTransform(back))) below = over(rgb, share, below);
          }
          worst = Math.min(worst, ratio(ink, below));
        }
      }
      if (worst < 4.5) found.push(`${text.textContent}: ${worst.toFixed(2)}`);
    }
  }
  return [seen, found];
}
