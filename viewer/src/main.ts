import { Data } from './data';
import { fail } from './dom';
import { MotionPage } from './motion_page';
import type { Hooks } from './hooks';

const hooks = { ready: false, error: '' } as Hooks;
(window as unknown as { inhabit: Hooks }).inhabit = hooks;

async function start() {
  // In a frame of another page (an index of pages) the motion plays by itself, without controls.
  const framed = window.self !== window.top;
  document.documentElement.classList.toggle('framed', framed);
  const page = new MotionPage(await Data.read(), framed);
  Object.assign(hooks, page.hooks());
  page.begin();
  hooks.ready = true;
}

start().catch((reason: unknown) => fail(hooks, reason));
