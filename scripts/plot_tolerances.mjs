#!/usr/bin/env node
// Draws the fraction of frames in which skin is deeper inside the scene than so many metres, of the tables that
// scripts/results.sh inbetween writes: skin that carries weight on the left, all other skin on the right.
// usage: plot_tolerances.mjs OUT.svg FOLDER     FOLDER has inbetween_supported_DEPTH.json, inbetween_other_DEPTH.json
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const [out, folder] = process.argv.slice(2);
const rows = [["real motion", "#059669"], ["linear + slerp", "#dc2626"], ["slerp + detour", "#d97706"], ["ours, raw", "#2563eb"]];
const skins = [["supported", "skin that carries weight", 0.04], ["other", "all other skin", 0.01]];
const panel = 300, height = 300, left = 58, top = 40, bottom = 46, gap = 24, key = 130;
const width = left + 2 * panel + gap + key;
const least = 1e-4, decades = Math.log10(1 / least);  // nothing is drawn at the axis
const text = (x, y, value, more = "") => `<text x="${x}" y="${y}" ${more}>${value}</text>`;
const y = (v) => height - bottom - (Math.max(0, Math.log10(Math.max(v, least) / least)) / decades) * (height - top - bottom);

function curves(skin) {
  const name = new RegExp(`^inbetween_${skin}_([0-9.]+)\\.json$`);
  const points = readdirSync(folder).filter((file) => name.test(file)).map((file) => {
    const table = JSON.parse(readFileSync(join(folder, file), "utf8"));
    return [Number(file.match(name)[1]), new Map(table.rows.map((r) => [r.method, r.collision_frame_ratio.mean]))];
  });
  return points.sort((a, b) => a[0] - b[0]);
}

let svg = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="white"/>`;
for (let v = least; v <= 1; v *= 10)
  svg += text(left - 8, y(v) + 4, v <= least ? "0" : String(+v.toFixed(4)), 'text-anchor="end"');
svg += text(14, (top + height - bottom) / 2, "fraction of frames", `transform="rotate(-90 14 ${(top + height - bottom) / 2})" text-anchor="middle"`);
skins.forEach(([skin, title, tolerance], i) => {
  const points = curves(skin), deepest = Math.max(...points.map(([d]) => d)), begin = left + i * (panel + gap);
  const x = (d) => begin + (d / deepest) * panel;
  svg += text(begin, 24, title, 'font-size="14" font-weight="bold"');
  for (let v = least; v <= 1; v *= 10) svg += `<path d="M${begin} ${y(v)}h${panel}" stroke="#ddd"/>`;
  for (let d = 0; d <= deepest + 1e-9; d += 0.02)
    svg += text(x(d), height - bottom + 18, (100 * d).toFixed(0), 'text-anchor="middle"');
  svg += text(begin + panel / 2, height - 8, "deeper than, cm", 'text-anchor="middle"');
  svg += `<path d="M${x(tolerance)} ${top}V${height - bottom}" stroke="#888" stroke-dasharray="4 3"/>` +
    text(x(tolerance) + 4, top + 10, "tolerance", 'fill="#666"');
  for (const [method, colour] of rows) {
    const path = points.map(([d, table], k) => `${k ? "L" : "M"}${x(d).toFixed(1)} ${y(table.get(method)).toFixed(1)}`).join("");
    svg += `<path d="${path}" fill="none" stroke="${colour}" stroke-width="2"/>`;
  }
});
rows.forEach(([method, colour], i) => {
  svg += `<path d="M${width - key + 14} ${top + 18 * i}h18" stroke="${colour}" stroke-width="2"/>` +
    text(width - key + 38, top + 18 * i + 4, method);
});
writeFileSync(out, svg + "</svg>\n");
