#!/usr/bin/env node
// Draws NDMS over time, mean over actions, of tables that `inhabit eval anticipate --json` wrote.
// usage: plot_ndms.mjs OUT.svg TITLE TABLE.json...     a curve is named by its file
import { readFileSync, writeFileSync } from "node:fs";
import { basename } from "node:path";

const [out, title, ...tables] = process.argv.slice(2);
const width = 560, height = 320, left = 48, right = 170, top = 36, bottom = 40;
const colours = ["#2563eb", "#dc2626", "#059669", "#7c3aed", "#d97706"];
const curves = tables.map((file) => {
  const table = JSON.parse(readFileSync(file, "utf8"));
  const ours = table.rows.find((r) => r.action === "mean" && r.method === "ours");
  return { name: basename(file, ".json"), points: table.horizons_seconds.map((t) => [t, ours.ndms[`${t.toFixed(1)}s`]]) };
});
const longest = Math.max(...curves.flatMap((c) => c.points.map(([t]) => t)));
const highest = Math.ceil(10 * Math.max(...curves.flatMap((c) => c.points.map(([, v]) => v)))) / 10;
const x = (t) => left + (t / longest) * (width - left - right);
const y = (v) => height - bottom - (v / highest) * (height - top - bottom);
const text = (px, py, value, more = "") => `<text x="${px}" y="${py}" ${more}>${value}</text>`;
let svg = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="white"/>${text(left, 20, title, 'font-size="14" font-weight="bold"')}`;
for (let v = 0; v <= highest + 1e-9; v += 0.1)
  svg += `<path d="M${left} ${y(v)}H${width - right}" stroke="#ddd"/>` + text(left - 8, y(v) + 4, v.toFixed(1), 'text-anchor="end"');
for (let t = 0; t <= longest + 1e-9; t += longest > 8 ? 5 : 0.8)
  svg += text(x(t), height - bottom + 18, `${+t.toFixed(1)} s`, 'text-anchor="middle"');
svg += text(16, (top + height - bottom) / 2, "NDMS", `transform="rotate(-90 16 ${(top + height - bottom) / 2})" text-anchor="middle"`);
curves.forEach((curve, i) => {
  const path = curve.points.map(([t, v], k) => `${k ? "L" : "M"}${x(t).toFixed(1)} ${y(v).toFixed(1)}`).join("");
  svg += `<path d="${path}" fill="none" stroke="${colours[i % colours.length]}" stroke-width="2"/>`;
  svg += `<path d="M${width - right + 12} ${top + 18 * i}h18" stroke="${colours[i % colours.length]}" stroke-width="2"/>`;
  svg += text(width - right + 36, top + 18 * i + 4, curve.name.replaceAll("_", " "));
});
writeFileSync(out, svg + "</svg>\n");
