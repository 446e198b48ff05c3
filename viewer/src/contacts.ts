import type { Data, ContactsData } from './data';
import { PointSet } from './points';

/** Contact maps of one chosen joint, painted on the scene's points as time goes on. */
export class Contacts {
  readonly names: string[];
  readonly points: PointSet;
  private readonly maps: Uint8Array; // (pairs, keys)
  private readonly first: ArrayLike<number>;
  private readonly index: ArrayLike<number>;
  private readonly source: ContactsData;
  private chosen = -1;

  constructor(data: Data, source: ContactsData) {
    this.source = source;
    this.names = source.names;
    this.points = new PointSet(data.floats(source.points), 0.022, 0.16);
    this.first = data.raw(source.first);
    this.index = data.raw(source.index);
    this.maps = Uint8Array.from(data.raw(source.changes));
    for (let i = 0; i < this.maps.length; ++i) {
      if (i % source.keys !== 0) this.maps[i] = (this.maps[i - 1] + this.maps[i]) & 255;
    }
    this.choose(-1);
  }

  /** The joint that touches most over the clip: what is worth showing first. */
  busiest(): number {
    let best = 0;
    let most = -1;
    for (let j = 0; j < this.names.length; ++j) {
      let sum = 0;
      for (let i = this.first[j] * this.source.keys; i < this.first[j + 1] * this.source.keys; ++i) sum += this.maps[i];
      if (sum > most) [best, most] = [j, sum];
    }
    return best;
  }

  choose(joint: number) {
    this.chosen = joint;
    this.points.object.visible = joint >= 0;
  }

  setTime(t: number) {
    if (this.chosen < 0) return;
    const { keys, rate, start } = this.source;
    const at = Math.min(Math.max((t - start) * rate, 0), keys - 1);
    const i = Math.floor(at);
    const next = Math.min(i + 1, keys - 1);
    const u = at - i;
    const { values } = this.points;
    values.fill(0);
    for (let p = this.first[this.chosen]; p < this.first[this.chosen + 1]; ++p) {
      const from = this.maps[p * keys + i];
      values[this.index[p]] = (from + u * (this.maps[p * keys + next] - from)) / 255;
    }
    this.points.changed();
  }
}
