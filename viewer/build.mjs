// Bundles the page into one HTML template: node build.mjs [OUT.html], default dist/page.html.
// inhabit/view/page.cpp puts a title and a clip's data where the <!--inhabit:...--> marks stand.
import { build } from 'esbuild';
import { mkdir, readFile, rename, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, 'dist', 'page.html');

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

const [script, style, html] = await Promise.all([
  bundle('main.ts'),
  bundle('page.css'),
  readFile(join(here, 'src', 'page.html'), 'utf8'),
]);
const inScript = script.replace(/<\/script/gi, '<\\/script').replace(/<!--/g, '<\\!--');
const page = html
  .replace('/*style*/', () => style)
  .replace('/*script*/', () => inScript);
await mkdir(dirname(out), { recursive: true });
await writeFile(out + '.part', page);
await rename(out + '.part', out);
