import { css, roleName } from './colors';
import { element } from './dom';
import type { Person } from './person';

/** A chip per person, or per role where there are many, which shows them and hides them. */
export function makeLegend(people: Person[], onChange: () => void) {
  const roles = [...new Set(people.map((person) => person.data_.role))];
  const groups = people.length <= 8 ? people.map((person) => [person])
    : roles.map((role) => people.filter((person) => person.data_.role === role));
  for (const group of groups) {
    const { name, role } = group[0].data_;
    if (role === 'intention') continue; // named under its figure
    const chip = document.createElement('button');
    const dot = document.createElement('i');
    const label = document.createElement('span');
    chip.type = 'button';
    chip.setAttribute('aria-pressed', 'true');
    dot.style.background = css(group[0].color);
    label.textContent = group.length > 1 ? `${roleName[role]} × ${group.length}` : name || roleName[role];
    chip.append(dot, label);
    chip.onclick = () => {
      const on = !group[0].enabled;
      for (const person of group) person.enabled = on;
      chip.setAttribute('aria-pressed', String(on));
      onChange();
    };
    element('legend').append(chip);
  }
}
