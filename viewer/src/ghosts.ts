import type { Scene } from 'three';
import { Data } from './data';
import { Bodies, Person, Shape } from './person';

/** Still, see-through copies of each person along the path, made when they are first asked for. */
export class Ghosts {
  on = false;
  private readonly copies: { of: Person; ghost: Person; at: number }[] = [];

  constructor(private readonly data: Data, private readonly bodies: Bodies, private readonly people: Person[],
    private readonly scene: Scene, private readonly seconds: number) {}

  setOn(on: boolean, shape: Shape) {
    this.on = on;
    if (!on || this.copies.length > 0) return;
    const gap = Math.max(0.5, this.seconds / 12);
    for (const person of this.people) {
      for (let t = Math.ceil((person.start + 1e-6) / gap) * gap; t <= person.end + 1e-6; t += gap) {
        const ghost = new Person(this.data, this.bodies, person.data_, person.color, 0.42);
        ghost.group.traverse((part) => (part.castShadow = false));
        this.scene.add(ghost.group);
        this.copies.push({ of: person, ghost, at: t });
      }
    }
    this.show(shape);
  }

  show(shape: Shape) {
    for (const { ghost, at } of this.copies) {
      ghost.show(shape);
      ghost.setTime(at);
    }
  }

  /** They are where their people have been moved to. */
  follow() {
    for (const { of, ghost } of this.copies) {
      ghost.group.visible = this.on && of.enabled;
      ghost.group.position.copy(of.group.position);
    }
  }
}
