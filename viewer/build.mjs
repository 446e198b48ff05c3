// Bundles the motion page and the live page into one HTML template each: node build.mjs [FOLDER], default dist.
// inhabit/view/page.cpp puts a title and data where the <!--inhabit:...--> marks stand.
import { build } from 'esbuild';
import { mkdir, readFile, rename, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, 'dist');

async function bundle(entry) {
  const result = await build({
    entryPoints: [join(here, 'src', entry)],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: 'es2022',
    legalComments: 'inline',
    charset: 'utf8',
  });
  return result.outputFiles[0].text.trim();
}

async function write(name, entry, style) {
  const [code, look, html] = await Promise.all([bundle(entry), bundle(style), readFile(join(here, 'src', name), 'utf8')]);
  const inScript = code.replace(/<\/script/gi, '<\\/script').replace(/<!--/g, '<\\!--');
  const page = html.replace('/*style*/', () => look).replace('/*script*/', () => inScript);
  const path = join(out, name);
  await writeFile(path + '.part', page);
  await rename(path + '.part', path);
}

await mkdir(out, { recursive: true });
await Promise.all([write('page.html', 'main.ts', 'page.css'), write('live.html', 'live.ts', 'live.css')]);
