#!/usr/bin/env node
// Writes a page of cards, each with a live, linked motion page beside it and a paragraph:
//   scripts/demo_index.mjs OUT.html TITLE [INTRO] PAGE.html "HEADING" "PARAGRAPH" [PAGE.html HEADING PARAGRAPH]...
// INTRO is given when the number of further arguments is not a multiple of three. PAGE is relative to OUT.
import { writeFileSync } from 'node:fs';

const [out, title, ...rest] = process.argv.slice(2);
const intro = rest.length % 3 === 1 ? rest.shift() : '';
if (!out || !title || rest.length === 0 || rest.length % 3 !== 0) {
  console.error('demo_index: expected OUT.html TITLE [INTRO] (PAGE HEADING PARAGRAPH)...');
  process.exit(2);
}
const text = (s) => s.replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`);
let cards = '';
for (let i = 0; i < rest.length; i += 3) {
  const [page, heading, paragraph] = rest.slice(i, i + 3);
  const address = text(page.split('/').map(encodeURIComponent).join('/'));
  cards += `<article><a href="${address}"><iframe src="${address}" loading="lazy" tabindex="-1" title="${text(heading)}"></iframe></a>
<h2><a href="${address}">${text(heading)}</a></h2><p>${text(paragraph)}</p></article>\n`;
}
writeFileSync(out, `<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1"><title>${text(title)}</title>
<style>
:root { color-scheme: light dark; --ground: #f1efec; --ink: #24262b; --soft: #5f636c; --card: #fff; font: 16px/1.5 system-ui, sans-serif; }
@media (prefers-color-scheme: dark) { :root { --ground: #16181c; --ink: #eceef2; --soft: #a3a9b4; --card: #202329; } }
body { margin: 0 auto; max-width: 1180px; padding: 48px 24px; background: var(--ground); color: var(--ink); }
h1 { margin: 0 0 8px; letter-spacing: -0.02em; } h2 { margin: 14px 18px 4px; font-size: 18px; } p { color: var(--soft); max-width: 70ch; }
main { display: grid; gap: 24px; margin-top: 32px; grid-template-columns: repeat(auto-fit, minmax(min(100%, 360px), 1fr)); }
article { background: var(--card); border-radius: 16px; overflow: hidden; box-shadow: 0 1px 3px #0002; } article p { margin: 0 18px 18px; }
a { color: inherit; text-decoration: none; } h2 a:hover { text-decoration: underline; }
iframe { display: block; width: 100%; aspect-ratio: 3 / 2; border: 0; pointer-events: none; }
</style></head><body><h1>${text(title)}</h1>${intro ? `<p>${text(intro)}</p>` : ''}
<main>
${cards}</main></body></html>
`);
