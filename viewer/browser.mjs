// A headless Chromium without network and with software WebGL, for screenshots and the page's tests.
import { existsSync } from 'node:fs';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

export const findChromium = () => process.env.CHROMIUM ??
  ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find((path) => existsSync(path));

/** Runs `use(context)` with a fresh browser profile that is removed afterwards. */
export async function withBrowser(options, use) {
  const executablePath = findChromium();
  if (!executablePath) throw new Error('chromium was not found (Debian: apt-get install chromium; or set CHROMIUM)');
  const { chromium } = await import('playwright-core');
  const profile = await mkdtemp(join(tmpdir(), 'inhabit-chromium-'));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath,
    headless: true,
    chromiumSandbox: false,
    offline: true,
    // Mesa draws in two thirds of the time of Chromium's own software WebGL, which steps in where there is no Mesa.
    args: ['--use-gl=angle', '--use-angle=gl-egl', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--no-first-run', '--hide-scrollbars', '--force-color-profile=srgb'],
    ...options,
  });
  context.setDefaultTimeout(120_000);  // software WebGL on a busy machine
  try {
    return await use(context);
  } finally {
    await context.close();
    await rm(profile, { recursive: true, force: true });
  }
}

/** Waits until `expression` holds on the page. (Playwright's own waiting evaluates text inside the page, which its policy forbids.) */
export async function until(page, expression, seconds = 120) {
  for (const end = Date.now() + seconds * 1000; !(await page.evaluate(expression));) {
    if (Date.now() > end) throw new Error('waited in vain for ' + expression);
    await page.waitForTimeout(30);
  }
}

/** Opens a page file and waits until it is drawn; throws what the page says when it fails. `listen(page)` comes first. */
export async function openPage(context, url, listen = () => {}) {
  const page = await context.newPage();
  listen(page);
  await page.goto(url);
  await until(page, 'Boolean(window.inhabit && (inhabit.ready || inhabit.error))');
  const error = await page.evaluate('inhabit.error');
  if (error) throw new Error(error);
  return page;
}
