export const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

/** The button `id` shows whether it is on. */
export const press = (id: string, on: boolean) => element(id).setAttribute('aria-pressed', String(on));

/** Says that the page could not be shown, to who looks at it and to tests. */
export function fail(hooks: { error?: unknown }, reason: unknown): never {
  const error = String(reason instanceof Error ? reason.message : reason);
  hooks.error = error;
  const message = element('message');
  message.hidden = false;
  message.textContent = 'This page could not be shown: ' + error;
  throw reason;
}
