import { element, make, press } from './dom';

/** Buttons and the keys that press them. */
export class Menu {
  private readonly keys = new Map<string, () => void>();
  private readonly told: [string, string][] = [];

  /** @param signal ends it */
  constructor(private readonly onChange: () => void, signal?: AbortSignal) {
    addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLSelectElement) return;
      if (document.querySelector('dialog[open]')) return;
      // What has the focus keeps the keys that it takes itself.
      if (event.key === ' ' && (event.target instanceof HTMLButtonElement || (event.target instanceof HTMLInputElement && event.target.type !== 'range'))) return;
      const action = this.keys.get(event.key.toLowerCase());
      if (!action) return;
      event.preventDefault();
      action();
    }, { signal });
  }

  /** What `key` does beside the buttons. */
  on(key: string, action: () => void) {
    this.keys.set(key, action);
  }

  /** What the help says of keys, names with blanks between them. */
  tell(keys: string, what: string) {
    this.told.push([keys, what]);
  }

  /** The button `id`, which `key` presses too; `set` does it and says whether it is on now. */
  toggle(id: string, key: string, set: () => boolean) {
    const button = element(id);
    const action = () => {
      press(id, set());
      this.onChange();
    };
    return this.bind(button, key, action);
  }

  /** The same of a button that does something rather than to stay pressed. */
  press(id: string, key: string, action: () => void) {
    return this.bind(element(id), key, action);
  }

  /** A key of a hidden button does nothing. */
  private bind(button: HTMLElement, key: string, action: () => void) {
    button.onclick = action;
    this.keys.set(key, () => {
      if (!button.hidden) action();
    });
    return button;
  }

  /** Lists the keys, and what the pointer does, in `list`: those of buttons by what their titles say, where they are shown. */
  explain(list: HTMLElement, more: [string, string][]) {
    const rows = [...this.told];
    for (const button of document.querySelectorAll<HTMLElement>('#tools button, #files button')) {
      const [, what, key] = /^(.*) \((.)\)$/.exec(button.title) ?? [];
      if (key && !button.hidden) rows.push([key, what]);
    }
    list.replaceChildren(...[...rows, ...more].flatMap(([key, what]) => [
      make('dt', {}, ...key.split(' ').flatMap((one) => [make('kbd', { textContent: one }), ' '])), make('dd', { textContent: what }),
    ]));
  }
}
