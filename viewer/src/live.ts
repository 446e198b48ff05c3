import { Vector3 } from 'three';
import { Data } from './data';
import { fail } from './dom';
import { LivePage } from './live_page';

/** What tests may use: window.inhabit. */
const hooks: Record<string, unknown> = { ready: false, error: '' };
(window as unknown as { inhabit: typeof hooks }).inhabit = hooks;

async function start() {
  const page = new LivePage(await Data.read());
  page.start();
  Object.assign(hooks, {
    pose: () => page.link.pose && { ...page.link.pose, trans: [...page.link.pose.trans], rotations: undefined },
    joint: (j: number) => page.body.joint(j, new Vector3()).toArray(),
    contacts: () => page.contacts,
    chair: () => page.chair,
    chairs: () => page.hello?.chairs ?? [],
    connected: () => page.hello !== undefined,
    ghosts: (kind: number) => page.ghosts.count(kind),
    ghost: (kind: number, i: number) => page.ghosts.place(kind, i).toArray(),
    handle: (hand: number) => (page.picks.handles[hand].visible ? page.picks.handles[hand].position.toArray() : null),
    file: () => page.file,
    latencies: () => page.link.latencies,
    frames: () => [page.frames, page.link.frames],
    screen: (x: number, y: number, z: number) => page.onScreen(x, y, z),
    setCamera: (x: number, y: number, z: number, target: [number, number, number]) => page.setCamera(x, y, z, target),
    send: (text: string) => page.link.sendRaw(text),
  });
  hooks.ready = true;
}

start().catch((reason: unknown) => fail(hooks, reason));
