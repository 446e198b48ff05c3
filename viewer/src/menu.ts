import { element, press } from './dom';

/** Buttons and the keys that press them. */
export class Menu {
  private readonly keys = new Map<string, () => void>();

  constructor(private readonly onChange: () => void) {
    addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLSelectElement) return;
      if (event.key === ' ' && event.target instanceof HTMLButtonElement) return;
      const action = this.keys.get(event.key.toLowerCase());
      if (!action) return;
      event.preventDefault();
      action();
    });
  }

  /** What `key` does beside the buttons. */
  on(key: string, action: () => void) {
    this.keys.set(key, action);
  }

  /** The button `id`, which `key` presses too; `set` does it and says whether it is on now. */
  toggle(id: string, key: string, set: () => boolean) {
    const button = element(id);
    const action = () => {
      press(id, set());
      this.onChange();
    };
    button.onclick = action;
    this.keys.set(key, action);
    return button;
  }
}
