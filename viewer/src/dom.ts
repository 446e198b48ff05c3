export const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

/** The button `id` shows whether it is on. */
export const press = (id: string, on: boolean) => element(id).setAttribute('aria-pressed', String(on));

/** A new element with these properties and children. */
export function make<K extends keyof HTMLElementTagNameMap>(tag: K, properties: object = {}, ...children: (Node | string)[]): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  Object.assign(made, properties);
  made.append(...children);
  return made;
}

export const reasonOf = (reason: unknown) => String(reason instanceof Error ? reason.message : reason).replace(/\s+/g, ' ');

/** Says something in one line, until it is clicked away or something else is said; nothing takes it away. */
export function say(text: string) {
  const message = element('message');
  message.hidden = text === '';
  message.textContent = text;
  message.onclick = () => (message.hidden = true);
}

/** Gives the browser a file to save. */
export function save(name: string, content: Blob) {
  const address = URL.createObjectURL(content);
  make('a', { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** Says that the page could not be shown, to who looks at it and to tests. */
export function fail(hooks: { error?: unknown }, reason: unknown): never {
  const error = reasonOf(reason);
  hooks.error = error;
  say('This page could not be shown: ' + error);
  throw reason;
}
