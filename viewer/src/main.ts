import { App } from './app';
import { Data } from './data';
import { fail } from './dom';
import type { Hooks } from './hooks';

const hooks = { ready: false, error: '' } as Hooks;
(window as unknown as { inhabit: Hooks }).inhabit = hooks;

async function start() {
  const framed = window.self !== window.top;
  document.documentElement.classList.toggle('framed', framed);
  new App(await Data.read(), framed, hooks);
  hooks.firstPicture = performance.now();
  hooks.ready = true;
}

start().catch((reason: unknown) => fail(hooks, reason));
