import { css } from './colors';
import { element, make } from './dom';
import type { SceneObject, SceneObjects } from './scene_objects';

/** The panel of what is in the scene: a row each, with a box that hides it and a button that makes it stand out. */
export class ObjectList {
  private readonly rows: { refresh: () => void }[] = [];

  constructor(objects: SceneObjects, changed: (marked?: SceneObject) => void) {
    const panel = element('objects');
    const sorted = [...objects.list].sort((a, b) => a.name.localeCompare(b.name, 'en', { numeric: true }));
    const counted = `${sorted.length} object${sorted.length === 1 ? '' : 's'}`;
    panel.append(make('p', { textContent: counted }));
    const all = make('button', { type: 'button', textContent: 'Hide all' });
    all.onclick = () => {
      const on = objects.list.every(({ shown }) => !shown);
      for (const object of objects.list) objects.show(object, on);
      this.refresh();
      all.textContent = on ? 'Hide all' : 'Show all';
      changed();
    };
    panel.append(all);
    for (const object of sorted) {
      const called = object.name.replace(/_/g, ' ');
      const box = make('input', { type: 'checkbox', checked: true, ariaLabel: `Show ${called}` });
      const dot = make('i');
      dot.style.background = css(object.color);
      const name = make('button', { type: 'button', textContent: called, ariaPressed: 'false', title: `Make ${called} stand out` });
      const row = make('div', { className: 'row' }, box, dot, name);
      const refresh = () => {
        box.checked = object.shown;
        row.classList.toggle('off', !object.shown);
        name.ariaPressed = String(object.marked);
      };
      box.onchange = () => {
        objects.show(object, box.checked);
        refresh();
        changed();
      };
      name.onclick = () => {
        const on = !object.marked;
        for (const other of objects.list) if (other.marked) objects.mark(other, false);
        objects.mark(object, on);
        if (on && !object.shown) objects.show(object, true);
        this.refresh();
        changed(on ? object : undefined);
      };
      this.rows.push({ refresh });
      panel.append(row);
    }
  }

  refresh() {
    for (const row of this.rows) row.refresh();
  }
}
