#!/usr/bin/env node
// Draws the fraction of frames in which skin is deeper inside the scene than so many metres, of the tables that
// scripts/results.sh inbetween writes: skin that carries weight on the left, all other skin on the right.
// usage: plot_tolerances.mjs OUT.svg FOLDER     FOLDER has inbetween_supported_DEPTH.json, inbetween_other_DEPTH.json
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { axisTitle, curve, legend, svg, text } from "./svg.mjs";

const [out, folder] = process.argv.slice(2);
const rows = [["real motion", "#059669"], ["linear + slerp", "#dc2626"], ["slerp + detour", "#d97706"], ["ours, raw", "#2563eb"]];
const skins = [["supported", "skin that carries weight", 0.04], ["other", "all other skin", 0.01]];
const panel = 300, height = 300, left = 64, top = 40, bottom = 46, gap = 24, key = 140;
const width = left + 2 * panel + gap + key;
const least = 1e-4, decades = Math.log10(1 / least);  // nothing is drawn at the axis
const y = (v) => height - bottom - (Math.max(0, Math.log10(Math.max(v, least) / least)) / decades) * (height - top - bottom);

function curves(skin) {
  const name = new RegExp(`^inbetween_${skin}_([0-9.]+)\\.json$`);
  const points = readdirSync(folder).filter((file) => name.test(file)).map((file) => {
    const table = JSON.parse(readFileSync(join(folder, file), "utf8"));
    return [Number(file.match(name)[1]), new Map(table.rows.map((r) => [r.method, r.collision_frame_ratio.mean]))];
  });
  return points.sort((a, b) => a[0] - b[0]);
}

let body = "";
for (let decade = -decades; decade <= 0; ++decade)
  body += text(left - 8, y(10 ** decade) + 4, decade === -decades ? "0" : String(+(10 ** decade).toFixed(4)), 'text-anchor="end"');
body += axisTitle(14, (top + height - bottom) / 2, "fraction of frames");
skins.forEach(([skin, title, tolerance], i) => {
  const points = curves(skin), deepest = Math.max(...points.map(([d]) => d)), begin = left + i * (panel + gap);
  const x = (d) => begin + (d / deepest) * panel;
  body += text(begin, 24, title, 'font-size="14" font-weight="bold"');
  for (let decade = -decades; decade <= 0; ++decade) body += `<path d="M${begin} ${y(10 ** decade)}h${panel}" stroke="#ddd"/>`;
  for (let d = 0; d <= deepest + 1e-9; d += 0.02)
    body += text(x(d), height - bottom + 18, (100 * d).toFixed(0), 'text-anchor="middle"');
  body += text(begin + panel / 2, height - 8, "deeper than, cm", 'text-anchor="middle"');
  body += `<path d="M${x(tolerance)} ${top}V${height - bottom}" stroke="#888" stroke-dasharray="4 3"/>` +
    text(x(tolerance) + 4, top + 10, "tolerance", 'fill="#666"');
  for (const [method, colour] of rows) body += curve(points.map(([d, table]) => [x(d), y(table.get(method))]), colour);
});
body += legend(width - key + 14, top, rows);
writeFileSync(out, svg(width, height, body));
