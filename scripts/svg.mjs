// Pieces of the figures that scripts/plot_*.mjs draw, as text of an SVG file.

/// Text at (x, y). @param more attributes
export const text = (x, y, value, more = "") => `<text x="${x}" y="${y}" ${more}>${value}</text>`;
/// Text beside a vertical axis, read from below.
export const axisTitle = (x, y, value) => text(x, y, value, `transform="rotate(-90 ${x} ${y})" text-anchor="middle"`);
/// A curve through points [x, y].
export const curve = (points, colour) =>
  `<path d="${points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("")}" fill="none" stroke="${colour}" stroke-width="2"/>`;
/// Names of curves, [name, colour] each, one below the other from (x, y) on.
export const legend = (x, y, curves) =>
  curves.map(([name, colour], i) => `<path d="M${x} ${y + 18 * i}h18" stroke="${colour}" stroke-width="2"/>` + text(x + 24, y + 18 * i + 4, name)).join("");
/// A whole file.
export const svg = (width, height, body) =>
  `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="white"/>${body}</svg>
`;
