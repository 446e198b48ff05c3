import { Camera, Vector3 } from 'three';
import { css } from './colors';
import { make } from './dom';
import type { Person } from './person';

/** Names over heads. */
export class Tags {
  on: boolean;
  private readonly labels: HTMLElement[];
  private readonly at = new Vector3();

  constructor(private readonly people: Person[], private readonly place_: HTMLElement) {
    // Truth and prediction stand in one place, where names would hide each other; colours tell them apart.
    this.on = people.every(({ data_ }) => data_.role === 'motion');
    place_.classList.add('tags');
    place_.hidden = false;
    this.labels = people.map((person) => {
      const label = make('span', { textContent: person.data_.name });
      label.style.setProperty('--tone', css(person.color));
      place_.append(label);
      return label;
    });
  }

  place(camera: Camera, visible: (person: Person) => boolean) {
    this.place_.hidden = !this.on;
    this.people.forEach((person, i) => {
      let top = 0; // the highest joint
      for (let j = 1; j < person.parents.length; ++j) if (person.now[j * 3 + 1] > person.now[top * 3 + 1]) top = j;
      this.at.fromArray(person.now, top * 3).add(person.group.position);
      this.at.y += 0.22;
      this.at.project(camera);
      const shown = visible(person) && person.data_.name !== '' && Math.abs(this.at.x) < 1 && Math.abs(this.at.y) < 1 && this.at.z < 1;
      this.labels[i].hidden = !shown;
      if (shown) this.labels[i].style.transform = `translate(-50%, -100%) translate(${((this.at.x + 1) / 2) * innerWidth}px, ${((1 - this.at.y) / 2) * innerHeight}px)`;
    });
  }
}
