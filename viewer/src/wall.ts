import * as THREE from 'three';
import type { Person } from './person';

const WIDTH = 1.3; // metres of a cell
const HEIGHT = 2.25;

/** Small figures side by side: rows and columns in a plane that faces the camera, each figure kept in its cell. */
export class Wall {
  readonly middle = new THREE.Vector3();
  readonly labels: HTMLElement[];
  width = WIDTH;
  height = HEIGHT;
  private readonly cells: THREE.Vector3[];
  private readonly v = new THREE.Vector3();

  /** @param toCamera direction (angle about +Y from +Z) from which the wall is seen. */
  constructor(private readonly people: Person[], private readonly toCamera: number, private readonly floors: number[], names: HTMLElement) {
    this.cells = people.map(() => new THREE.Vector3());
    this.labels = people.map((person) => {
      const label = document.createElement('span');
      label.textContent = person.data_.name.replace(/^future /, '').replace(/_/g, ' ');
      names.append(label);
      return label;
    });
  }

  /** Chooses the columns that make cells largest in a view of `aspect`. */
  arrange(aspect: number) {
    const n = this.people.length;
    let columns = 1;
    let best = 0;
    for (let c = 1; c <= n; ++c) {
      const size = Math.min(aspect / (c * WIDTH), 1 / (Math.ceil(n / c) * HEIGHT));
      if (size > best * 1.001) [best, columns] = [size, c];
    }
    const rows = Math.ceil(n / columns);
    this.width = columns * WIDTH;
    this.height = rows * HEIGHT;
    this.middle.set(0, this.height / 2 - 0.25, 0);
    this.cells.forEach((cell, i) => {
      const across = ((i % columns) - (columns - 1) / 2) * WIDTH;
      cell.set(across * Math.cos(this.toCamera), (rows - 1 - Math.floor(i / columns)) * HEIGHT, -across * Math.sin(this.toCamera));
    });
  }

  /** Moves every figure's root over the middle of its cell. */
  place() {
    this.people.forEach((person, i) => {
      const cell = this.cells[i];
      person.group.position.set(cell.x - person.now[0], cell.y - this.floors[i], cell.z - person.now[2]);
    });
  }

  /** Puts the names under the cells; `rect` is the view in pixels. */
  placeLabels(camera: THREE.Camera, width: number, height: number) {
    this.labels.forEach((label, i) => {
      this.v.copy(this.cells[i]).project(camera);
      const shown = this.people[i].enabled && Math.abs(this.v.x) < 1.1 && Math.abs(this.v.y) < 1.1;
      label.hidden = !shown;
      if (shown) label.style.transform = `translate(-50%, 7px) translate(${((this.v.x + 1) / 2) * width}px, ${((1 - this.v.y) / 2) * height}px)`;
    });
  }
}
