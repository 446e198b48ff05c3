#!/usr/bin/env node
// Draws NDMS over time, mean over actions, of tables that `inhabit eval anticipate --json` wrote.
// usage: plot_ndms.mjs OUT.svg TITLE TABLE.json...     a curve is named by its file
import { readFileSync, writeFileSync } from "node:fs";
import { basename } from "node:path";
import { axisTitle, curve, legend, svg, text } from "./svg.mjs";

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
let body = text(left, 20, title, 'font-size="14" font-weight="bold"');
for (let v = 0; v <= highest + 1e-9; v += 0.1)
  body += `<path d="M${left} ${y(v)}H${width - right}" stroke="#ddd"/>` + text(left - 8, y(v) + 4, v.toFixed(1), 'text-anchor="end"');
for (let t = 0; t <= longest + 1e-9; t += longest > 8 ? 5 : 0.8)
  body += text(x(t), height - bottom + 18, `${+t.toFixed(1)} s`, 'text-anchor="middle"');
body += axisTitle(16, (top + height - bottom) / 2, "NDMS");
const colour = (i) => colours[i % colours.length];
curves.forEach(({ points }, i) => (body += curve(points.map(([t, v]) => [x(t), y(v)]), colour(i))));
body += legend(width - right + 12, top, curves.map(({ name }, i) => [name.replaceAll("_", " "), colour(i)]));
writeFileSync(out, svg(width, height, body));
